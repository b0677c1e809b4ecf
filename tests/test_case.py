from __future__ import annotations

import json
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from toy import ToyCase

from pmesh.cases import runner
from pmesh.cases.options import closest, option, options, spelt
from pmesh.cases.registry import CASES, find
from pmesh.cases.runner import read_case, run_case
from pmesh.run.series import read_series
from remesh.errors import BlowUpError, InputError


def test_options_know_their_default_kind_unit_and_help() -> None:
    known = options(ToyCase)
    assert list(known)[:3] == ["until", "rate", "nodes"]
    rate = known["rate"]
    assert (rate.kind, rate.default, rate.unit, rate.help) == (float, 1.0, "1/T", "rate of decay")
    assert known["breaks_at"].optional
    assert known["breaks_at"].flag == "--breaks-at"
    assert known["scheme"].word == "midpoint|euler"


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("rate", "2", 2.0),
        ("rate", "1/64", 1 / 64),
        ("rate", "-1e-3", -1e-3),
        ("nodes", "12", 12),
        ("breaks_at", "none", None),
        ("breaks_at", "3", 3),
        ("noisy", "yes", True),
        ("noisy", "false", False),
        ("origin", "1,-2", (1.0, -2.0)),
        ("origin", "1/2 3", (0.5, 3.0)),
        ("scheme", "euler", "euler"),
    ],
)
def test_text_becomes_a_value_of_the_right_type(name: str, text: str, value: object) -> None:
    found = options(ToyCase)[name].parse(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("value", "text"),
    [(1 / 12, "1/12"), (0.25 / 3, "1/12"), (1 / 3.523, "1000/3523"), (-1 / 24, "-1/24"),
     (1 / 40, "0.025"), (1e-10, "1e-10"), (0.0, "0"), (1000.0, "1000"), (0.1 + 0.2, "0.3"),
     (np.pi, "3.14159265359"), ((0.5, 1 / 3), "0.5,1/3"), ("", '""'), (None, "auto")],
)  # fmt: skip
def test_a_number_is_spelt_as_short_as_it_can_be_read(value: object, text: str) -> None:
    assert spelt(value) == text
    if isinstance(value, float) and "/" in text:
        assert options(ToyCase)["rate"].parse(text) == pytest.approx(value, rel=4e-16)


def test_literal_types_are_choices() -> None:
    @dataclass
    class Any:
        order: Literal["RK2", "RK3"] = option("RK2", "scheme")

    Any.__annotations__["order"] = Literal["RK2", "RK3"]
    assert options(Any)["order"].choices == ("RK2", "RK3")


def test_values_of_python_and_toml_take_the_type_of_the_option() -> None:
    case = ToyCase.make({"rate": 2, "origin": [1, 2]})
    assert (case.rate, type(case.rate)) == (2.0, float)
    assert case.origin == (1.0, 2.0)


def test_quick_shortens_but_what_is_given_wins() -> None:
    assert ToyCase.make({}, quick=True).nodes == 8
    assert ToyCase.make({"nodes": 4}, quick=True).nodes == 4
    assert ToyCase.make({}).nodes == 16


def test_misspelt_names_find_the_closest_known_one() -> None:
    assert closest("viscosty", ["viscosity", "spacing"]) == "viscosity"
    assert closest("xyz", ["viscosity", "spacing"]) is None


@pytest.mark.parametrize("name", list(CASES))
def test_every_named_case_loads_documents_itself_and_can_be_quick(name: str) -> None:
    cls = find(name)
    case = cls.make({}, quick=True)
    assert case.title
    assert cls.__doc__
    assert all(known.help for known in options(cls).values())
    common = {"out", "resume", "overwrite", "quick", "checkpoint_every"}
    assert not common & set(options(cls))


def test_a_run_leaves_all_the_files_of_the_contract(tmp_path: Path) -> None:
    report = run_case("toy", ToyCase.make({"rate": 0.5}, quick=True), tmp_path / "r")
    assert {path.name for path in (tmp_path / "r").iterdir()} == {
        *("case.toml", "series.csv", "fields.vtkhdf", "fields", "checkpoint.h5"),
        *("figure.png", "summary.json"),
    }
    assert (tmp_path / "r/figure.png").read_bytes().startswith(b"\x89PNG")
    summary = json.loads((tmp_path / "r/summary.json").read_text())
    assert summary["case"] == "toy"
    assert [metric["pass"] for metric in summary["metrics"]] == [True, None]
    assert summary["cost"]["steps"] == report.outcome.state.step == report.cost.steps
    kept = tomllib.loads((tmp_path / "r/case.toml").read_text())
    assert kept["version"] == runner.version()
    assert kept["parameters"] == {
        **{"until": 0.5, "rate": 0.5, "nodes": 8, "grows": 0, "scheme": "midpoint"},
        **{"origin": [0.0, -0.5], "noisy": False, "pause": 0.0},
    }


def test_a_figure_that_cannot_be_drawn_costs_neither_the_numbers_nor_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    heard: list[object] = []

    def refuse(case: ToyCase, outcome: object) -> None:
        assert heard  # the numbers come first
        raise InputError("the field is zero", hint="another one")

    case = ToyCase.make({}, quick=True)
    run_case("toy", case, tmp_path)
    monkeypatch.setattr(ToyCase, "draw", refuse)
    report = run_case(
        "toy", case, tmp_path, resume=True, told=lambda metrics, cost: heard.append((metrics, cost))
    )
    assert heard == [(report.metrics, report.cost)]
    assert "no figure could be drawn: the field is zero" in caplog.text
    assert (tmp_path / "summary.json").exists()
    assert not (tmp_path / "figure.png").exists()


def test_stages_are_the_closest_snapshots_each_once_and_the_start_only_if_alone(
    tmp_path: Path,
) -> None:
    outcome = run_case("toy", ToyCase.make({}, quick=True), tmp_path / "r").outcome
    times = [shot.time for shot in outcome.snapshots()]
    assert len(times) > 2
    found = [shot.time for shot in outcome.stages([0.0, times[1], times[1], times[-1]])]
    assert found == [times[1], times[-1]]
    for later in sorted((tmp_path / "r/fields").iterdir())[1:]:
        later.unlink()
    assert [shot.time for shot in outcome.stages([0.1, 0.5])] == [0.0]


def test_the_parameters_of_case_toml_are_the_case_again(tmp_path: Path) -> None:
    case = ToyCase.make({"rate": 0.1 + 0.2, "nodes": 8, "until": 1 / 3})
    (tmp_path / "case.toml").write_text(runner.case_text("toy", case))
    name, values = read_case(tmp_path / "case.toml")
    assert (name, ToyCase.make(values)) == ("toy", case)


def test_a_case_that_broke_goes_on_with_the_same_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = ToyCase.make({"nodes": 8, "grows": 1})
    run_case("toy", case, tmp_path / "whole")

    def kill(moment: object) -> None:
        if moment.step == 11:  # type: ignore[attr-defined]
            raise MemoryError

    with pytest.raises(MemoryError):
        run_case("toy", case, tmp_path / "cut", watch=[kill])
    assert not (tmp_path / "cut/summary.json").exists()
    report = run_case("toy", case, tmp_path / "cut", resume=True)
    assert report.cost.steps == report.outcome.state.step
    for name in ("series.csv", "case.toml"):
        assert (tmp_path / "cut" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_a_resumed_case_keeps_its_parameters_but_may_go_further(tmp_path: Path) -> None:
    run_case("toy", ToyCase.make({}, quick=True), tmp_path)
    with pytest.raises(InputError, match=r"keeps its parameters, but rate was 1\.0 and is now 2"):
        run_case("toy", ToyCase.make({"rate": 2.0}, quick=True), tmp_path, resume=True)
    with pytest.raises(InputError, match="asked to resume 'other'"):
        run_case("other", ToyCase.make({}, quick=True), tmp_path, resume=True)
    longer = ToyCase.make({"until": 0.75}, quick=True)
    report = run_case("toy", longer, tmp_path, resume=True)
    assert report.outcome.state.time == 0.75
    np.testing.assert_array_equal(
        read_series(tmp_path)["step"], np.arange(report.outcome.state.step + 1)
    )


def test_a_directory_with_a_run_is_kept_unless_overwritten(tmp_path: Path) -> None:
    run_case("toy", ToyCase.make({}, quick=True), tmp_path)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    with pytest.raises(InputError, match="already holds a run"):
        run_case("toy", ToyCase.make({}, quick=True), tmp_path)
    assert before == {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    run_case("toy", ToyCase.make({"until": 0.25}, quick=True), tmp_path, overwrite=True)
    assert read_series(tmp_path)["time"][-1] == 0.25
    assert len(list((tmp_path / "fields").iterdir())) == 2


def test_a_run_that_breaks_keeps_its_last_good_state_and_series(tmp_path: Path) -> None:
    case = ToyCase.make({"breaks_at": 6}, quick=True)
    with pytest.raises(BlowUpError, match="after step 6"):
        run_case("toy", case, tmp_path)
    assert (tmp_path / "checkpoint.h5").exists()
    assert read_series(tmp_path)["step"][-1] == 5
    assert not (tmp_path / "summary.json").exists()
