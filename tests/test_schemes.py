"""The law that carries vorticity particles."""

from __future__ import annotations

import dataclasses
import math
from contextlib import nullcontext

import numpy as np
import pytest

from pmesh.vortex.buffers import Buffers
from pmesh.vortex.schemes import Carriage, Carried, brought_home
from remesh.grid import Grid
from remesh.paths import SCHEMES
from remesh.stretching import stretched

GRID = Grid((32, 32), 1 / 8, (-2.0, -2.0))


def carriage(
    scheme="RK2", grid=GRID, threads=None, stretching="conservative", dtype=np.float64
) -> Carriage:
    return Carriage(
        grid=grid, kernel="M6'", scheme=SCHEMES[scheme], stretching=stretching, threads=threads,
        buffers=Buffers(), scratch=lambda shape: nullcontext(np.empty(shape, dtype)),
    )  # fmt: skip


def spots(dtype: type = np.float64) -> np.ndarray:
    x, y = GRID.points()
    return np.exp(-((x - 0.2) ** 2 + y**2) / 0.2).astype(dtype)


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("moved", [False, True])
def test_particles_in_a_uniform_flow_go_along_with_it(scheme, moved):
    velocity = np.ones((2, *GRID.shape)) * np.array([0.3, -0.7])[:, None, None]
    base = 0.01 * np.ones((2, *GRID.shape)) if moved else None
    gone = carriage(scheme.name).carry(
        Carried(spots(), base), velocity.copy(), lambda *_: velocity.copy(), 0.5
    )
    expected = velocity * 0.5 + (0.01 if moved else 0.0)
    np.testing.assert_allclose(gone, expected, atol=1e-14)


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=lambda scheme: scheme.name)
def test_particles_in_rigid_rotation_turn_with_the_order_of_the_scheme(scheme):
    x, y = GRID.points()
    turning = np.stack([-y, x])
    inner = np.hypot(x, y) < 1
    errors = []
    for dt in (0.2, 0.1):
        gone = carriage(scheme.name).carry(
            Carried(spots(), None), turning.copy(), lambda *_: turning.copy(), dt
        )
        z = (x + 1j * y) * np.exp(1j * dt)
        exact = np.stack([z.real - x, z.imag - y])
        errors.append(np.abs(gone - exact)[:, inner].max())
    assert math.log2(errors[0] / errors[1]) == pytest.approx(scheme.order + 1, abs=0.2)


def test_every_stage_asks_for_the_velocity_of_the_particles_where_they_then_are():
    asked = []

    def velocity_of(vorticity: np.ndarray, part: float = 0.0) -> np.ndarray:
        asked.append(vorticity.copy())
        return np.ones((2, *GRID.shape))

    first = velocity_of(spots())
    carriage("RK3").carry(Carried(spots(), None), first, velocity_of, 0.25)
    x, _ = GRID.points()
    places = [(x * w).sum() / w.sum() for w in asked]
    np.testing.assert_allclose(np.subtract(places, 0.2), [0, 0.125, 0.1875], atol=1e-6)


def test_particles_on_their_nodes_are_their_own_mesh():
    field, dropped = carriage().on_mesh(Carried(spots(), None))
    np.testing.assert_array_equal(field, spots())
    assert dropped == 0


def test_what_leaves_the_mesh_is_dropped_and_counted():
    far = np.full((2, *GRID.shape), 10.0)
    field, dropped = carriage().on_mesh(Carried(spots(), far))
    assert not field.any()
    assert dropped == pytest.approx(spots().sum() * GRID.cell_volume, rel=1e-12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("threads", [1, 2])
def test_precision_is_kept_and_threads_change_no_bit(dtype, threads):
    x, y = GRID.points().astype(dtype)
    turning = np.stack([-y, x])
    gone = [
        carriage("RK3", threads=n, dtype=dtype).carry(
            Carried(spots(dtype), None), turning.copy(), lambda *_: turning.copy(), np.float64(0.1)
        )
        for n in (1, threads)
    ]
    assert gone[0].dtype == dtype
    np.testing.assert_array_equal(*gone)


BOX = Grid((16, 18, 20), 0.2, (-1.6, -1.8, -2.0), "periodic")


def wavy() -> tuple[np.ndarray, np.ndarray]:
    """Strengths and a displacement in space."""
    x, y, z = BOX.points()
    k = [2 * math.pi / length for length in BOX.length]
    strengths = np.stack([np.cos(k[1] * y), np.sin(k[2] * z), np.cos(k[0] * x + k[1] * y)])
    return strengths, 0.1 * np.stack([np.sin(k[1] * y), np.sin(k[2] * z), np.sin(k[0] * x)])


def test_stretched_particles_keep_the_sum_of_their_strengths_in_the_conservative_form():
    strengths, displacement = wavy()
    field, _ = carriage(grid=BOX).on_mesh(Carried(strengths, displacement))
    np.testing.assert_allclose(field.sum((1, 2, 3)), strengths.sum((1, 2, 3)), atol=1e-10)


def test_strengths_brought_home_are_stretched_to_what_they_were():
    strengths, displacement = wavy()
    home = brought_home(strengths, displacement, BOX)
    law = carriage(grid=BOX, stretching="classical")
    there, _ = law.on_mesh(Carried(home, displacement))
    plain, _ = law._advected(strengths, displacement, None)  # moved, not stretched
    np.testing.assert_allclose(there, plain, atol=1e-12)


@pytest.mark.parametrize("scheme", ["RK2", "RK3", "RK4"])
def test_a_solid_rotation_in_space_turns_strengths_with_the_particles(scheme):
    """Of w = (1, 0, 0) and a turn about z by an angle: (cos, sin, 0), to the scheme's order."""
    grid = Grid((12, 12, 8), 0.25, (-1.375, -1.375, -1.0))
    x, y, _ = grid.points()
    turning = np.stack([-y, x, 0 * x])
    errors = []
    for dt in (0.2, 0.1):
        start = np.zeros_like(turning)
        start[0] = 1.0
        law = carriage(scheme, grid, stretching="classical")
        gone = law.carry(Carried(start, None), turning.copy(), lambda *_: turning.copy(), dt)
        middle = stretched(start, gone, grid, "classical")[:, 6, 6, 4]
        errors.append(np.abs(middle - [math.cos(dt), math.sin(dt), 0.0]).max())
    order = SCHEMES[scheme].order
    assert math.log2(errors[0] / errors[1]) > order + 0.8


def test_the_conservative_form_is_the_same_in_a_stream():
    """Strengths with divergence, carried by a drift many cells on: stretched as at rest."""
    strengths, displacement = wavy()
    strengths[0] += np.sin(2 * math.pi / BOX.length[0] * BOX.points()[0])
    drift = 5 * BOX.spacing * np.array([1.0, -1.0, 2.0])
    law = carriage(grid=BOX)
    rest, _ = law.on_mesh(Carried(strengths, displacement.copy()))
    stream = dataclasses.replace(law, drift=tuple(drift))
    there = displacement + drift[:, None, None, None]
    moved, _ = stream.on_mesh(Carried(strengths, there), time=1.0)
    back = np.roll(moved, (-5, 5, -10), axis=(1, 2, 3))
    np.testing.assert_allclose(back, rest, atol=1e-12)
