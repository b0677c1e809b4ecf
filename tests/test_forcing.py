"""Direct forcing: what its impulses obey, and what bodies that it moves get."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.bodies.forced_wall import calibrated
from pmesh.bodies.forcing import DirectForcing, force
from pmesh.bodies.hold import Freedom, Held, Imposed
from pmesh.bodies.markers import KERNEL, markers_of
from pmesh.bodies.mask import Mask, box_around, mask_of
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.stencils import curl
from remesh.transfer import m2p

H = 1 / 8
GRID = Grid((64, 64), H, (-4.0, -4.0))
DISK = RigidBody(Disk(radius=1.0, center=(0.03, -0.05)))
SETTINGS = DirectForcing(tolerance=1e-9)
WALL = calibrated(SETTINGS.strength, 8, 2.0)
SPREAD = 0.5 * H**2
RATE = SETTINGS.strength * SPREAD / H**2
POSES = (DISK.start(),)
NEAR = box_around((DISK,), POSES, GRID, SETTINGS.width * H)
MARKERS = markers_of((DISK,), POSES, GRID, SETTINGS.spacing, WALL.retraction * H)


def mask() -> Mask:
    return mask_of((DISK,), POSES, NEAR, SETTINGS.width * H, WALL.retraction * H)


def stream(grid: Grid) -> np.ndarray:
    """A free stream with some shear [L/T]."""
    x, y = grid.points()
    return np.stack([1.0 + 0.3 * y, 0.2 * x])


def held(velocity: np.ndarray | None = None, **options: object) -> Imposed:
    velocity = stream(NEAR) if velocity is None else velocity
    given = {"settings": SETTINGS, "markers": MARKERS, **options}
    asked = question(velocity.dtype, freedom=given.pop("freedom", None))
    return force(velocity, given.pop("markers"), asked, speed=1.0, **given)


def question(dtype: object = np.float64, **options: object) -> Held:
    return Held(
        **{
            "mask": mask(), "solver": VelocitySolver(NEAR, dtype=dtype), "rate": RATE,
            "spread": SPREAD, "blur": -WALL.sharpening, **options,
        }
    )  # fmt: skip


def after(impulse: np.ndarray, grid: Grid = NEAR) -> np.ndarray:
    """The stream and what an impulse density induces on a mesh."""
    created = curl(impulse, grid, order=4, edge="zero")
    return stream(grid) + VelocitySolver(grid).velocity(created, smoothing=("phi1", SPREAD))


def test_the_slip_at_the_markers_is_the_force_over_lambda_on_a_mesh_four_times_as_large():
    """Least squares finds the markers' strengths anew from the impulse density on the mesh."""
    few = DirectForcing(tolerance=1e-9, spacing=1.5)
    markers = markers_of((DISK,), POSES, GRID, few.spacing, WALL.retraction * H)
    done = held(markers=markers, settings=few)
    big = Grid((128, 128), H, (NEAR.origin[0] - 40 * H, NEAR.origin[1] - 40 * H))
    inner = (slice(None), slice(40, 40 + NEAR.shape[0]), slice(40, 40 + NEAR.shape[1]))
    impulse = np.zeros((2, *big.shape))
    impulse[inner] = done.impulse
    u = after(impulse, big)
    around = sum(np.roll(u, shift, axis) for shift in (-1, 1) for axis in (1, 2))
    felt = m2p(u + WALL.sharpening * (4 * u - around), markers.positions, big, KERNEL)
    nodes = big.points().reshape(2, -1)
    kernel = weights(markers.positions, nodes)
    strengths, *_ = np.linalg.lstsq(kernel, impulse.reshape(2, -1).T, rcond=None)
    density = strengths / markers.weight[:, None]
    np.testing.assert_allclose(felt, -density / RATE, atol=1e-6)
    assert np.abs(felt).max() > 1e-4


def weights(positions: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Kernel of every marker at every node, a product over the axes."""
    from remesh.kernels import get_kernel

    one = [get_kernel(KERNEL)((nodes[a][:, None] - positions[:, a]) / H) for a in (0, 1)]
    return one[0] * one[1]


def test_the_fluid_inside_stands_still_to_a_hundredth_of_the_stream():
    done = held()
    inside = mask().chi > 0.5
    assert np.sqrt(np.mean(after(done.impulse)[:, inside] ** 2)) < 0.01
    np.testing.assert_allclose(
        done.slip, np.where(inside, mask().root, 0.0) * after(done.impulse), atol=1e-9
    )


def test_the_answer_does_not_depend_on_the_guess():
    done = held()
    again = held(guess=0.9 * done.impulse)
    np.testing.assert_allclose(again.impulse, done.impulse, atol=1e-5)
    assert again.iterations < done.iterations


def test_a_force_that_already_holds_the_body_takes_no_iteration():
    done = held()
    assert held(guess=done.impulse, settings=DirectForcing(tolerance=1e-4)).iterations <= 1


def test_single_precision_finds_the_same_impulse():
    done = held(settings=DirectForcing(tolerance=1e-4))
    single = held(stream(NEAR).astype(np.float32), settings=DirectForcing(tolerance=1e-4))
    assert single.impulse.dtype == np.float32
    total = done.impulse.sum(axis=(1, 2))
    np.testing.assert_allclose(single.impulse.sum(axis=(1, 2)), total, rtol=2e-3, atol=1e-2)


@pytest.mark.parametrize("inertia", [-0.9, 0.0, 3.0])
def test_a_free_coordinate_gets_the_momentum_that_the_force_takes(inertia):
    modes = np.zeros((1, 2, *NEAR.shape))
    modes[0, 0] = 1.0
    push = 3.0
    freedom = Freedom(
        modes, np.array([[inertia * mask().chi.sum()]]), np.array([push]), np.zeros(1)
    )
    done = held(freedom=freedom)
    balance = freedom.inertia[0, 0] * done.values[0] + done.impulse[0].sum()
    assert balance == pytest.approx(push, abs=1e-9 * (1 + abs(freedom.inertia[0, 0])))


def test_a_free_body_as_heavy_as_the_fluid_goes_with_the_stream():
    modes = np.zeros((1, 2, *NEAR.shape))
    modes[0, 0] = 1.0
    given = np.stack([np.ones(NEAR.shape), np.zeros(NEAR.shape)])
    done = held(given, freedom=Freedom(modes, np.zeros((1, 1)), *np.zeros((2, 1))))
    assert done.values[0] == pytest.approx(1.0, abs=1e-7)
    assert np.abs(done.impulse).max() < 1e-5


def test_a_body_that_moves_like_the_fluid_feels_no_force():
    pose = replace(POSES[0], velocity=(0.4, -0.2), spin=(0.7,))
    moving = mask_of((DISK,), (pose,), NEAR, SETTINGS.width * H, WALL.retraction * H)
    given = pose.rigid(NEAR.points())
    asked = question(mask=moving._replace(velocity=given))
    done = force(given, MARKERS, asked, speed=1.0, settings=SETTINGS)
    assert np.abs(done.impulse).max() < 1e-7


def test_a_slip_that_stays_is_refused():
    with pytest.raises(BlowUpError, match="after 1 iterations"):
        held(settings=DirectForcing(tolerance=1e-9, iterations=1))


@pytest.mark.parametrize(
    "options",
    [{"strength": 1.0}, {"spacing": 3.0}, {"tolerance": 0.0}, {"iterations": 2.5}],
)
def test_settings_that_cannot_hold_a_body_are_refused(options):
    with pytest.raises(InputError, match=next(iter(options))):
        DirectForcing(**options)
