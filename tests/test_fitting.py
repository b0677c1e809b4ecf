"""Cases that do not fit are refused with the size that would."""

from dataclasses import replace
from pathlib import Path

import pytest

from pmesh.cases import fitting
from pmesh.cases.fitting import finest, forecast, refuse_too_large
from pmesh.cases.lamb_oseen import LambOseenCase
from pmesh.cases.registry import find
from pmesh.cases.runner import run_case
from pmesh.cases.taylor_green import TaylorGreenCase
from pmesh.run.forecast import predicted
from remesh.errors import InputError
from remesh.machine import size_text


def size(case: TaylorGreenCase | LambOseenCase) -> int:
    return max(predicted(case.recipe(), case.watchers()).values())


def test_the_finest_nodes_that_fit_are_found() -> None:
    case = TaylorGreenCase(nodes=4096)
    free = size(replace(case, nodes=1000)) + 10
    assert finest(case, free) == (1000, free - 10)


def test_the_finest_spacing_that_fits_is_found() -> None:
    case = LambOseenCase(spacing=1 / 600)
    free = size(case) // 7
    found = finest(case, free)
    assert found is not None
    spacing, held = found
    assert held == size(replace(case, spacing=spacing)) <= free
    assert size(replace(case, spacing=spacing / 1.03)) > free


def test_where_nothing_fits_nothing_is_advised() -> None:
    assert finest(TaylorGreenCase(), 1000) is None


def test_a_run_that_does_not_fit_is_refused_before_anything_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = size(TaylorGreenCase(nodes=192))
    monkeypatch.setattr(fitting, "free_memory", lambda: free)
    monkeypatch.setattr(TaylorGreenCase, "build", None)
    case = TaylorGreenCase(nodes=4000)
    with pytest.raises(InputError) as refusal:
        run_case("taylor-green", case, tmp_path / "out")
    assert str(refusal.value) == (
        f"the run needs {size_text(size(case))} of memory, {size_text(free)} are free\n"
        f"  try: --nodes 192 ({size_text(free)})"
    )
    assert not list(tmp_path.iterdir())


def test_a_case_that_fits_or_cannot_be_predicted_is_let_through() -> None:
    refuse_too_large(TaylorGreenCase())
    refuse_too_large(find("zalesak-disk")())


def test_a_forecast_takes_steps_of_the_case() -> None:
    told = forecast(TaylorGreenCase(nodes=32, until=0.2))
    assert told.grid.shape == (32, 32)
    assert told.seconds is not None
    assert told.steps is not None
