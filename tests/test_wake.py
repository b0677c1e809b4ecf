"""Pictures of a wake: what they show, and in which colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from made_run import shot
from matplotlib.figure import Figure

from pmesh.cases.style import show_field
from pmesh.cases.wake import (
    colour_limit,
    depth,
    draw_vorticity,
    dye_figure,
    ftle_figure,
    indicator,
    plane,
    wake_figure,
    window,
)
from pmesh.run.snapshots import write_snapshot
from remesh.errors import InputError
from remesh.grid import Grid

GRID = Grid((40, 30), 0.1, (-2.0, -1.5))


def test_the_depth_of_the_indicator_grows_straight_from_its_edge() -> None:
    edge = np.linspace(0.0, 0.35, 50)  # part of the half width, from the outer edge
    chi = 0.5 * (edge - np.sin(np.pi * edge) / np.pi)
    assert depth(chi) == pytest.approx(edge, abs=8e-3)


@pytest.mark.parametrize("bodies", [True, False])
def test_the_window_holds_bodies_and_what_is_seen_and_little_more(
    tmp_path: Path, bodies: bool
) -> None:
    one = shot(tmp_path / "1.vtkhdf", 0.0, bodies=bodies)
    part = window([one])
    seen = np.abs(one["vorticity"]) > 0.03 * colour_limit([one])
    x = one.grid.axes()[0][seen.any(axis=1)]
    left = min(x[0], -0.5) if bodies else x[0]
    assert left - 0.4 < part.left < left
    assert x[-1] < part.right < x[-1] + 0.4
    assert part.bottom == pytest.approx(-part.top, abs=0.13)  # to the mesh, which begins at -2
    assert part.size == (part.right - part.left, part.top - part.bottom)


def test_a_periodic_axis_is_shown_whole(tmp_path: Path) -> None:
    grid = Grid((16, 16), 0.25, (0.0, -2.0), ("periodic", "unbounded"))
    field = np.exp(-4 * sum((grid.points() - np.array([2.0, 0.0])[:, None, None]) ** 2))
    one = write_snapshot(tmp_path / "1.vtkhdf", grid, {"vorticity": field}, 0, 0.0)
    part = window([one])
    assert (part.left, part.right) == (0.0, 4.0)
    assert -2.0 < part.bottom < part.top < 1.9


def test_colours_saturate_where_little_is_left_beyond(tmp_path: Path) -> None:
    free = shot(tmp_path / "1.vtkhdf", 0.0, bodies=False)
    top = float(np.abs(free["vorticity"]).max())
    assert 0.8 * top < colour_limit([free]) <= 1.05 * top
    held = shot(tmp_path / "2.vtkhdf", 0.0)
    assert 0.2 * top < colour_limit([held]) < 0.9 * top
    assert colour_limit([]) == 1.0


def test_a_vector_is_seen_by_its_length_and_fields_in_space_are_refused(tmp_path: Path) -> None:
    one = shot(tmp_path / "1.vtkhdf", 0.0)
    assert plane(one, "velocity") == pytest.approx(np.full(one.grid.shape, 2.0))
    cube = Grid((4, 4, 4), 1.0)
    deep = write_snapshot(tmp_path / "2.vtkhdf", cube, {"vorticity": np.zeros(cube.shape)}, 0, 0.0)
    with pytest.raises(InputError, match="show plane fields"):
        plane(deep, "vorticity")


def test_vorticity_is_drawn_to_one_scale_with_bodies_by_outline_or_indicator(
    tmp_path: Path,
) -> None:
    one = shot(tmp_path / "1.vtkhdf", 0.0)
    by_line, by_chi = Figure().subplots(1, 2)
    ring = np.stack([np.cos(np.arange(9)), np.sin(np.arange(9))], axis=1)
    draw_vorticity(by_line, one["vorticity"], one.grid, 1.5, outlines=[ring])
    draw_vorticity(by_chi, one["vorticity"], one.grid, 1.5, chi=indicator(one))
    for panel in (by_line, by_chi):
        (picture,) = panel.images
        assert (picture.norm.vmin, picture.norm.vmax) == (-1.5, 1.5)
        assert pytest.approx(one["vorticity"]) == picture.get_array().T
    assert len(by_line.patches) == 1
    assert not by_line.collections
    (fill, line) = by_chi.collections
    (ends,) = (np.concatenate([p.vertices for p in line.get_paths()]),)
    radius = np.hypot(*ends.T)
    assert radius == pytest.approx(0.55, abs=0.04)  # 0.35 of the half width inside the edge, 0.6
    assert fill.get_paths()


def test_figures_are_drawn_for_wakes_ftle_and_dye(tmp_path: Path) -> None:
    one = shot(tmp_path / "1.vtkhdf", 1.25)
    wake = wake_figure(one)
    assert wake.axes[0].get_title() == "t = 1.25"
    assert wake.axes[1].get_ylabel() == "vorticity"
    values = np.linspace(-1, 1, GRID.size).reshape(GRID.shape)
    for span, word in ((-2.0, "attracting"), (2.0, "repelling")):
        figure = ftle_figure(values, GRID, time=1.0, span=span, chi=indicator(one), on=one.grid)
        assert figure.axes[0].get_title() == f"{word} structures at t = 1, over 2"
    line = np.array([[-1.0, -1.0], [-1.0, 1.0]])
    dye = dye_figure(one, np.zeros((5, 30, 2)), line=line, part=window([one]))
    assert len(dye.axes[0].lines) == 31
    few = dye_figure(one, np.zeros((5, 3, 2)), line=line, part=window([one]))
    assert len({curve.get_color() for curve in few.axes[0].lines}) == 4
    for figure in (wake, dye):
        figure.savefig(tmp_path / "seen.png", dpi=40)


def test_a_field_that_is_zero_is_drawn() -> None:
    panel = Figure().subplots()
    show_field(panel, np.zeros(GRID.shape), GRID, limit=1.0)
    assert panel.images
