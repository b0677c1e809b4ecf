"""Integrals of the vorticity against exact ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex import ledger
from pmesh.vortex.exact.patches import PerlmanPatch
from pmesh.vortex.exact.viscous import LambOseen, TaylorGreen
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

GRID = Grid((96, 80), 1 / 16, (-2.6, -2.1))
VORTEX = LambOseen(circulation=1.7, core=0.3, center=(0.4, -0.2))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_integrals_of_a_gaussian_vortex_are_exact(dtype):
    w = VORTEX.vorticity(GRID.points()).astype(dtype)
    close = 1e-6 if dtype == np.float32 else 1e-12
    gamma, a2 = 1.7, 0.3**2
    assert ledger.circulation(w, GRID) == pytest.approx(gamma, rel=close)
    assert ledger.impulse(w, GRID) == pytest.approx((-0.2 * gamma, -0.4 * gamma), rel=close)
    assert ledger.angular_moment(w, GRID) == pytest.approx(gamma * (a2 + 0.2), rel=close)
    assert ledger.enstrophy(w, GRID) == pytest.approx(gamma**2 / (2 * math.pi * a2), rel=close)


def test_the_integrals_of_perlmans_patch_are_exact():
    patch = PerlmanPatch(p=7)
    w = patch.vorticity(GRID.points())
    assert ledger.circulation(w, GRID) == pytest.approx(math.pi / 8, rel=1e-8)
    assert ledger.angular_moment(w, GRID) == pytest.approx(patch.angular_moment, rel=1e-6)
    assert ledger.enstrophy(w, GRID) == pytest.approx(patch.enstrophy, rel=1e-8)


def test_the_impulse_of_a_pair_is_its_circulation_times_its_distance_along_its_way():
    """A vortex pair moves to where its impulse points: counter-clockwise below a clockwise one."""
    low = LambOseen(circulation=2.0, core=0.2, center=(0.0, 0.5))
    high = LambOseen(circulation=-2.0, core=0.2, center=(0.0, -0.5))
    points = GRID.points()
    w = low.vorticity(points) + high.vorticity(points)
    assert ledger.impulse(w, GRID) == pytest.approx((2.0, 0.0), abs=1e-9)
    flow = VortexFlow(grid=GRID)
    u, _ = flow.velocity(flow.start(vorticity=w))
    x, y = points
    assert u[np.argmin(np.hypot(x, y)) // 80, np.argmin(np.hypot(x, y)) % 80] > 0


def test_the_enstrophy_of_taylor_and_greens_vortices_is_exact():
    grid = Grid((32, 32), 1 / 32, boundary="periodic")
    exact = TaylorGreen()
    assert ledger.enstrophy(exact.vorticity(grid.points()), grid) == pytest.approx(
        exact.enstrophy(), rel=1e-12
    )


def test_a_row_of_the_ledger_holds_finite_numbers():
    flow = VortexFlow(grid=GRID)
    row = flow.ledger(flow.start(vorticity=VORTEX.vorticity))
    assert list(row) == [
        "circulation", "impulse_x", "impulse_y", "angular_moment", "enstrophy",
        "lost_circulation", "nodes",
    ]  # fmt: skip
    assert all(math.isfinite(value) for value in row.values())
    assert row["nodes"] == 96 * 80


def test_moments_about_a_periodic_coordinate_are_no_numbers():
    channel = Grid((32, 32), 1 / 16, boundary=("periodic", "unbounded"))
    w = np.ones(channel.shape)
    along, across = ledger.impulse(w, channel)
    assert math.isfinite(along)  # its lever is y, which is unbounded
    assert math.isnan(across)
    assert math.isnan(ledger.angular_moment(w, channel))
