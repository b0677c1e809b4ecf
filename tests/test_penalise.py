"""Implicit penalisation: a symmetric system whose residual is what it says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.bodies.hold import Freedom, Held, Imposed
from pmesh.bodies.mask import Mask, box_around, mask_of
from pmesh.bodies.penalise import Penalisation, penalise
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.stencils import curl

H = 1 / 8
GRID = Grid((64, 64), H, (-4.0, -4.0))
DISK = RigidBody(Disk(radius=1.0, center=(0.03, -0.05)))
NEAR = box_around((DISK,), (DISK.start(),), GRID, 1.5 * H)
SPREAD = 0.5 * H**2
RATE = 500.0


def penalised(
    velocity: np.ndarray, disk: Mask, solver: VelocitySolver, *, rate: float, spread: float,
    freedom: Freedom | None = None, **options: Any,
) -> Imposed:  # fmt: skip
    held = Held(mask=disk, solver=solver, rate=rate, spread=spread, freedom=freedom)
    return penalise(velocity, held, **options)


def mask(*bodies: RigidBody, grid: Grid = NEAR) -> Mask:
    bodies = bodies or (DISK,)
    return mask_of(bodies, tuple(body.start() for body in bodies), grid, 1.5 * H, 0.0)


def induced(impulse: np.ndarray, spread: float = SPREAD) -> np.ndarray:
    """Velocity that an impulse density leaves behind."""
    solver = VelocitySolver(NEAR)
    created = curl(impulse, NEAR, order=4, edge="zero")
    return solver.velocity(created, smoothing=("phi1", spread) if spread else None)


def after(given: np.ndarray, done: Imposed) -> np.ndarray:
    return given + induced(done.impulse)


def stream(grid: Grid) -> np.ndarray:
    """A free stream with some shear [L/T]."""
    x, y = grid.points()
    return np.stack([1.0 + 0.3 * y, 0.2 * x])


def held(**options: object) -> tuple[np.ndarray, object]:
    given = stream(NEAR)
    settings = Penalisation(**{"tolerance": 1e-8, **options})  # type: ignore[arg-type]
    return given, penalised(
        given, mask(), VelocitySolver(NEAR), rate=RATE, spread=SPREAD, speed=1.0, settings=settings
    )


@pytest.mark.parametrize("spread", [0.0, SPREAD, 20 * SPREAD])
def test_the_operator_is_symmetric_and_positive(spread):
    rng = np.random.default_rng(7)
    disk = mask()
    a, b = rng.standard_normal((2, 2, *NEAR.shape))
    image_a, image_b = (disk.root * induced(disk.root * g, spread) for g in (a, b))
    scale = np.linalg.norm(a) * np.linalg.norm(image_b)
    assert abs((a * image_b).sum() - (b * image_a).sum()) < 5e-4 * scale
    assert (a * image_a).sum() > 0
    assert (b * image_b).sum() > 0


def test_the_residual_is_that_of_the_law_on_a_mesh_four_times_as_large():
    """f = lambda chi (u_s - u) with the velocity u that f itself leaves, computed anew."""
    given, done = held()
    big = Grid((128, 128), H, (NEAR.origin[0] - 40 * H, NEAR.origin[1] - 40 * H))
    inner = (slice(None), slice(40, 40 + NEAR.shape[0]), slice(40, 40 + NEAR.shape[1]))
    impulse = np.zeros((2, *big.shape))
    impulse[inner] = done.impulse
    solver = VelocitySolver(big)
    created = solver.smoothed(curl(impulse, big, order=4, edge="zero"), SPREAD, "phi1")
    left = given + solver.velocity(created)[inner]
    disk = mask()
    np.testing.assert_allclose(done.slip, disk.root * left, atol=1e-6)
    wrong = disk.root * (0.0 - left) - done.impulse / np.maximum(disk.root, 1e-30) / RATE
    rms = np.sqrt((wrong**2).sum() / disk.chi.sum())
    assert done.residual <= 1e-8
    assert rms < 1e-6


@pytest.mark.parametrize("speed", [1.0, 2.5])
def test_the_residual_is_the_rms_of_the_law_over_the_body_relative_to_the_speed(speed):
    given, disk, solver = stream(NEAR), mask(), VelocitySolver(NEAR)
    done = penalised(
        given, disk, solver, rate=RATE, spread=SPREAD, speed=speed,
        settings=Penalisation(tolerance=1e-3),
    )  # fmt: skip
    g = np.divide(done.impulse, disk.root, out=np.zeros_like(given), where=disk.root > 0)
    wrong = disk.root * (disk.velocity - after(given, done)) - g / RATE
    rms = np.sqrt((wrong**2).sum() / disk.chi.sum())
    assert done.residual == pytest.approx(rms / speed, rel=1e-6)


def test_a_moving_body_in_fluid_at_rest_feels_the_same_as_a_body_at_rest_in_a_stream():
    """In the frame of the body nothing changes but the sign of the stream (Galileo)."""
    disk, solver, settings = mask(), VelocitySolver(NEAR), Penalisation(tolerance=1e-8)
    motion = np.stack([np.full(NEAR.shape, 0.7), np.full(NEAR.shape, -0.4)])
    moving = disk._replace(velocity=motion)
    options = {"rate": RATE, "spread": SPREAD, "speed": 1.0, "settings": settings}
    there = penalised(stream(NEAR), moving, solver, **options)
    here = penalised(stream(NEAR) - motion, disk, solver, **options)
    np.testing.assert_allclose(there.impulse, here.impulse, atol=1e-12)
    np.testing.assert_allclose(there.slip, here.slip, atol=1e-12)
    assert np.abs(there.slip[:, disk.chi == 1]).max() < 0.02


def test_the_fluid_inside_is_held_and_the_impulse_is_inside():
    given, done = held()
    disk = mask()
    deep = disk.chi == 1
    assert np.abs(after(given, done)[:, deep]).max() < 0.02
    assert np.abs(given[:, deep]).max() > 0.5
    assert (done.impulse[:, disk.chi == 0] == 0).all()


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-7])
def test_a_smaller_tolerance_costs_iterations_and_is_met(tolerance):
    _, done = held(tolerance=tolerance)
    assert 0 < done.residual <= tolerance
    assert done.iterations <= held(tolerance=0.5 * tolerance)[1].iterations


def test_a_good_guess_costs_no_iteration():
    given, done = held(tolerance=1e-6)
    again = penalised(
        given, mask(), VelocitySolver(NEAR), rate=RATE, spread=SPREAD, speed=1.0,
        settings=Penalisation(tolerance=2e-6), guess=done.impulse,
    )  # fmt: skip
    assert again.iterations == 0
    np.testing.assert_allclose(again.impulse, done.impulse, atol=1e-12)


def test_too_few_iterations_are_a_blow_up_with_advice():
    with pytest.raises(BlowUpError, match=r"slip residual of .* after 3 iterations") as caught:
        held(iterations=3)
    assert "tolerance" in caught.value.hint


def test_velocities_that_are_not_finite_are_a_blow_up():
    with pytest.raises(BlowUpError, match="slip residual of nan"):
        penalised(
            np.full((2, *NEAR.shape), np.nan), mask(), VelocitySolver(NEAR), rate=RATE,
            spread=SPREAD, speed=1.0, settings=Penalisation(),
        )  # fmt: skip


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_both_precisions_hold_the_same_body(dtype):
    solver = VelocitySolver(NEAR, dtype=dtype)
    done = penalised(
        stream(NEAR).astype(dtype), mask(), solver, rate=RATE, spread=SPREAD, speed=1.0,
        settings=Penalisation(),
    )  # fmt: skip
    assert done.impulse.dtype == dtype
    assert done.slip.dtype == dtype
    np.testing.assert_allclose(done.impulse, held(tolerance=1e-5)[1].impulse, atol=2e-3)


@pytest.mark.parametrize("name", ["strength", "width", "tolerance", "iterations", "thinnest"])
@pytest.mark.parametrize("value", [0, -1, np.nan, np.inf])
def test_a_penalisation_that_cannot_hold_is_refused(name, value):
    with pytest.raises(InputError, match=f"penalisation {name} must be a"):
        Penalisation(**{name: value})


@pytest.mark.parametrize("inertia", [-2.0, 0.0, 1e-9, 5.0, 1e4])
def test_a_free_coordinate_gets_the_momentum_that_the_force_takes(inertia):
    """Lighter, as heavy and heavier than the fluid; M U + impulse on the fluid = push."""
    disk, push = mask(), 3.0
    modes = np.zeros((1, 2, *NEAR.shape))
    modes[0, 0] = 1.0
    excess = np.array([[inertia * disk.chi.sum()]])
    freedom = Freedom(modes, excess, np.array([push]), np.zeros(1))
    done = penalised(
        stream(NEAR), disk, VelocitySolver(NEAR), rate=RATE, spread=SPREAD, speed=1.0,
        settings=Penalisation(tolerance=1e-8), freedom=freedom,
    )  # fmt: skip
    (value,) = done.values
    balance = freedom.inertia[0, 0] * value + done.impulse[0].sum()
    assert balance == pytest.approx(push, abs=1e-9 * (1 + abs(freedom.inertia[0, 0])))
    slip = disk.root * (after(stream(NEAR), done) - value * modes[0])
    np.testing.assert_allclose(done.slip, slip, atol=1e-6)


def test_a_free_body_as_heavy_as_the_fluid_goes_with_the_stream():
    disk = mask()
    modes = np.zeros((1, 2, *NEAR.shape))
    modes[0, 0] = 1.0
    given = np.stack([np.ones(NEAR.shape), np.zeros(NEAR.shape)])
    done = penalised(
        given, disk, VelocitySolver(NEAR), rate=RATE, spread=SPREAD, speed=1.0,
        settings=Penalisation(tolerance=1e-8),
        freedom=Freedom(modes, np.zeros((1, 1)), *np.zeros((2, 1))),
    )  # fmt: skip
    assert done.values[0] == pytest.approx(1.0, abs=1e-7)
    assert np.abs(done.impulse).max() < 1e-5
