"""FTLE and dye of a run: from its snapshots to the picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_run import make
from PIL import Image

from pmesh.cases import structures
from pmesh.cases.structures import dye_picture, ftle_picture
from pmesh.cases.wake import Window
from remesh.errors import InputError


def caught(monkeypatch: pytest.MonkeyPatch, name: str) -> dict[str, Any]:
    """What a law of figures is given."""
    seen: dict[str, Any] = {}
    draw = getattr(structures, name)

    def spy(*given: Any, **more: Any) -> Any:
        seen.update(more, given=given)
        return draw(*given, **more)

    monkeypatch.setattr(structures, name, spy)
    return seen


def test_the_ftle_of_a_uniform_stream_is_zero(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = caught(monkeypatch, "ftle_figure")
    folder = make(tmp_path / "run")
    path = ftle_picture(folder, nodes=24)
    exponent, grid = seen["given"]
    assert np.abs(exponent).max() < 1e-6
    assert (seen["time"], seen["span"]) == (3.0, -0.75)
    assert max(grid.shape) == 24
    assert path == folder / "ftle.png"
    with Image.open(path) as picture:
        assert picture.format == "PNG"
    part = Window(-1.0, 1.0, -0.5, 0.5)
    ftle_picture(folder, tmp_path / "x.png", span=1.0, nodes=32, part=part)
    assert (seen["time"], seen["span"]) == (0.0, 1.0)
    assert seen["given"][1].shape == (32, 16)
    assert (tmp_path / "x.png").exists()


def test_dye_leaves_the_line_before_the_body_and_goes_with_the_stream(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = caught(monkeypatch, "dye_figure")
    folder = make(tmp_path)
    assert dye_picture(folder, sources=3, releases=4) == folder / "dye.png"
    one, dye = seen["given"]
    assert one.time == 3.0
    assert dye.shape == (4, 3, 2)
    assert seen["line"][0, 0] < -0.5
    assert dye[:, 1, 0] - seen["line"][0, 0] == pytest.approx([1.5, 1.0, 0.5, 0.0])  # speed 2
    dye_picture(folder, line=[0, -1, 0, 1], start=1.0, time=2.1, sources=1, releases=3)
    one, dye = seen["given"]
    assert one.time == 2.0
    assert dye[:, 0] == pytest.approx(np.array([(2.0, 0), (1.0, 0), (0, 0)]), abs=1e-6)


def test_without_bodies_dye_leaves_the_middle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = caught(monkeypatch, "dye_figure")
    dye_picture(make(tmp_path, bodies=False), sources=2, releases=2)
    assert seen["line"][0, 0] == seen["line"][1, 0]


def test_what_cannot_be_drawn_is_refused(tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    with pytest.raises(InputError, match="nodes must be"):
        ftle_picture(folder, nodes=2)
    with pytest.raises(InputError, match="the snapshots span t = 0 to 3"):
        ftle_picture(folder, time=1.0, span=5.0, nodes=16)
    with pytest.raises(InputError, match="a line is x0 y0 x1 y1"):
        dye_picture(folder, line=[1, 2, 3])
    with pytest.raises(InputError, match="sources must be"):
        dye_picture(folder, sources=0)
    with pytest.raises(InputError, match="holds no snapshots"):
        ftle_picture(tmp_path)
    assert not list(folder.glob("*.png"))
