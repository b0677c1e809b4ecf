"""The law that carries vorticity particles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex.schemes import Carried, carry, on_mesh
from remesh.grid import Grid
from remesh.paths import SCHEMES

GRID = Grid((32, 32), 1 / 8, (-2.0, -2.0))


def spots(dtype: type = np.float64) -> np.ndarray:
    x, y = GRID.points()
    return np.exp(-((x - 0.2) ** 2 + y**2) / 0.2).astype(dtype)


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("moved", [False, True])
def test_particles_in_a_uniform_flow_go_along_with_it(scheme, moved):
    velocity = np.ones((2, *GRID.shape)) * np.array([0.3, -0.7])[:, None, None]
    base = 0.01 * np.ones((2, *GRID.shape)) if moved else None
    gone = carry(Carried(spots(), base), velocity, lambda *_: velocity, GRID, 0.5, scheme, "M6'")
    expected = velocity * 0.5 + (0.01 if moved else 0.0)
    np.testing.assert_allclose(gone, expected, atol=1e-14)


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=lambda scheme: scheme.name)
def test_particles_in_rigid_rotation_turn_with_the_order_of_the_scheme(scheme):
    x, y = GRID.points()
    turning = np.stack([-y, x])
    inner = np.hypot(x, y) < 1
    errors = []
    for dt in (0.2, 0.1):
        gone = carry(Carried(spots(), None), turning, lambda *_: turning, GRID, dt, scheme, "M6'")
        z = (x + 1j * y) * np.exp(1j * dt)
        exact = np.stack([z.real - x, z.imag - y])
        errors.append(np.abs(gone - exact)[:, inner].max())
    assert math.log2(errors[0] / errors[1]) == pytest.approx(scheme.order + 1, abs=0.2)


def test_every_stage_asks_for_the_velocity_of_the_particles_where_they_then_are():
    asked = []

    def velocity_of(vorticity: np.ndarray, part: float = 0.0) -> np.ndarray:
        asked.append(vorticity)
        return np.ones((2, *GRID.shape))

    carry(
        Carried(spots(), None), velocity_of(spots()), velocity_of, GRID, 0.25, SCHEMES["RK3"], "M6'"
    )
    x, _ = GRID.points()
    places = [(x * w).sum() / w.sum() for w in asked]
    np.testing.assert_allclose(np.subtract(places, 0.2), [0, 0.125, 0.1875], atol=1e-6)


def test_particles_on_their_nodes_are_their_own_mesh():
    field, dropped = on_mesh(Carried(spots(), None), GRID, "M6'")
    np.testing.assert_array_equal(field, spots())
    assert dropped == 0


def test_what_leaves_the_mesh_is_dropped_and_counted():
    far = np.full((2, *GRID.shape), 10.0)
    field, dropped = on_mesh(Carried(spots(), far), GRID, "M6'")
    assert not field.any()
    assert dropped == pytest.approx(spots().sum() * GRID.cell_volume, rel=1e-12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("threads", [1, 2])
def test_precision_is_kept_and_threads_change_no_bit(dtype, threads):
    x, y = GRID.points().astype(dtype)
    turning = np.stack([-y, x])
    gone = [
        carry(
            Carried(spots(dtype), None), turning, lambda *_: turning, GRID, np.float64(0.1),
            SCHEMES["RK3"], "M6'", n,
        )
        for n in (1, threads)
    ]  # fmt: skip
    assert gone[0].dtype == dtype
    np.testing.assert_array_equal(*gone)
