"""Planes through a flow in space."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from vortex_shots import CORE, GRID, PEAK, RADIUS, shot

from pmesh.cases.slices import Plane, plane_of, show_slice
from pmesh.cases.style import panels
from pmesh.run.snapshots import write_snapshot
from remesh.errors import InputError
from remesh.grid import Grid


@pytest.mark.parametrize(("axis", "place"), [(0, -0.25), (1, 0.03), (2, 1.0), (2, -1.0)])
def test_a_plane_is_exact_for_what_is_straight_across_it(
    tmp_path: Path, axis: int, place: float
) -> None:
    x, y, z = points = GRID.points()
    law = {"heat": lambda x, y, z: 1 + x - 2 * y + 3 * z}
    one = write_snapshot(
        tmp_path / "1.vtkhdf", GRID, {"heat": law["heat"](x, y, z), "u": points}, 0, 0.5
    )
    cut = Plane(one, axis, place)
    there: list[Any] = list(cut.grid.points())
    there.insert(axis, place)
    assert cut["heat"] == pytest.approx(law["heat"](*there), abs=1e-12)
    assert cut[f"u_{cut.across}"] == pytest.approx(np.full(cut.grid.shape, place))
    assert (cut.time, cut.grid.ndim, cut.across) == (0.5, 2, "xyz"[axis])
    assert "".join(cut.labels) == "xyz".replace(cut.across, "")


def test_a_plane_wraps_on_a_periodic_axis(tmp_path: Path) -> None:
    grid = Grid((8, 6, 4), 0.25, boundary="periodic")
    field = np.arange(8.0)[:, None, None] * np.ones((8, 6, 4))
    one = write_snapshot(tmp_path / "1.vtkhdf", grid, {"heat": field}, 0, 0.0)
    for place, value in ((0.25, 1.0), (1.875, 3.5), (2.25, 1.0), (-0.25, 7.0)):
        assert Plane(one, 0, place)["heat"] == pytest.approx(np.full((6, 4), value))


def test_a_plane_across_a_ring_cuts_two_cores_of_opposite_sign(tmp_path: Path) -> None:
    cut = Plane(shot(tmp_path, 1), 1, 0.0)
    x, z = cut.grid.points()
    exact = PEAK * np.sign(x) * np.exp(-((np.abs(x) - RADIUS) ** 2 + z**2) / CORE**2)
    assert cut["vorticity_y"] == pytest.approx(exact, abs=1e-9)
    assert cut["vorticity"] == pytest.approx(np.abs(exact), abs=1e-9)
    assert {"vorticity", "vorticity_x", "lambda2"} <= set(cut.names)


def test_a_panel_shows_the_vorticity_across_a_plane_with_the_body_on_top(tmp_path: Path) -> None:
    figure, axes = panels(1, 1, (3.0, 3.0))
    limit = show_slice(axes[0, 0], shot(tmp_path, 1, chi=True), "y=0")
    assert limit == pytest.approx(PEAK, rel=0.01)
    assert (axes[0, 0].get_xlabel(), axes[0, 0].get_ylabel()) == ("$x$", "$z$")
    assert figure.axes[1].get_ylabel() == "vorticity_y"
    assert len(axes[0, 0].collections) == 2  # the body and its rim


def test_what_is_no_plane_of_the_mesh_is_refused(tmp_path: Path) -> None:
    assert plane_of(" y = -0.5") == (1, -0.5)
    for text in ("", "z", "w=0", "z=inf", "0.3", "=1", "xy=1"):
        with pytest.raises(InputError, match="a slice is a plane such as z=0"):
            plane_of(text)
    with pytest.raises(InputError, match=r"the plane z = 1\.2 is not in the mesh"):
        Plane(shot(tmp_path, 1), 2, 1.2)
    flat = write_snapshot(tmp_path / "1.vtkhdf", Grid((8, 8), 0.1), {"w": np.ones((8, 8))}, 0, 0.0)
    with pytest.raises(InputError, match="a slice is of flows in space"):
        Plane(flat, 0, 0.1)
