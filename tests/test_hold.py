"""The one system by which bodies hold the fluid, whatever carries the force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.bodies.forced_wall import calibrated
from pmesh.bodies.forcing import DirectForcing, force
from pmesh.bodies.hold import Held, Imposed, check_settings
from pmesh.bodies.markers import markers_of
from pmesh.bodies.mask import box_around, mask_of
from pmesh.bodies.penalise import Penalisation, penalise
from pmesh.bodies.wall import wall_law
from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.stencils import derivative

H = 1 / 16
DISK = RigidBody(Disk(radius=1.0, center=(0.01, -0.02)))
POSES = (DISK.start(),)
GRID = Grid((64, 64), H, (-2.0, -2.0))
STRENGTH, SPREAD = 1000.0, 0.5 * H**2
WALL = calibrated(STRENGTH, 8, 2.0)
NEAR = box_around((DISK,), POSES, GRID, 4 * H)


def asked(sharp: bool | None) -> Held:
    """Penalisation, plain or sharp, or (None) direct forcing."""
    if sharp is None:
        mask = mask_of((DISK,), POSES, NEAR, DirectForcing().width * H, WALL.retraction * H)
        blur = -WALL.sharpening
    else:
        width = 2.5 if sharp else 1.5
        law = wall_law(width, STRENGTH, 8, 2.0, sharp=sharp)
        mask, blur = mask_of((DISK,), POSES, NEAR, width * H, law.offset * H, sharp), law.blur
    rate = STRENGTH * SPREAD / H**2
    return Held(mask=mask, solver=VelocitySolver(NEAR), rate=rate, spread=SPREAD, blur=blur)


def held(sharp: bool | None, stream: np.ndarray) -> Imposed:
    question = asked(sharp)
    if sharp is None:
        markers = markers_of((DISK,), POSES, GRID, 1.0, WALL.retraction * H)
        return force(stream, markers, question, speed=1.0, settings=DirectForcing(tolerance=1e-8))
    settings = Penalisation(tolerance=1e-8, sharp=sharp, width=2.5 if sharp else 1.5)
    return penalise(stream, question, speed=1.0, settings=settings)


WAYS = pytest.mark.parametrize("sharp", [False, True, None], ids=["plain", "sharp", "forcing"])


@WAYS
def test_the_answer_is_linear_in_the_stream(sharp):
    x, y = NEAR.points()
    one, other = np.stack([1 + 0 * x, 0.3 * x]), np.stack([0.2 * y, x * y])
    both = held(sharp, one + 2 * other)
    parts = held(sharp, one).impulse + 2 * held(sharp, other).impulse
    np.testing.assert_allclose(both.impulse, parts, atol=2e-5)


@WAYS
def test_all_ways_take_the_same_momentum_from_a_stream(sharp):
    """A disk held at once in a uniform stream: the added mass and the mass of the fluid in it."""
    stream = np.zeros((2, *NEAR.shape))
    stream[0] = 1.0
    taken = -held(sharp, stream).impulse[0].sum() * H**2
    layer = 2 * np.sqrt(SPREAD / np.pi)  # of Stokes's first problem, times the perimeter
    assert taken == pytest.approx(2 * np.pi + 2 * np.pi * layer, rel=0.06)


@WAYS
def test_the_slip_is_that_of_the_velocity_that_is_left(sharp):
    x, y = NEAR.points()
    stream = np.stack([1 + 0.3 * y, 0.2 * x])
    done, question = held(sharp, stream), asked(sharp)
    weight = question.mask.root if sharp is not None else (
        np.where(question.mask.chi > 0.5, question.mask.root, 0.0)
    )  # fmt: skip
    left = stream + question.induced(done.impulse)
    np.testing.assert_allclose(done.slip, weight * left, atol=1e-5)


def test_what_is_felt_is_the_velocity_and_its_blur():
    x, y = NEAR.points()
    field = np.stack([np.sin(2 * x) * y, np.cos(x + y)])
    got = Held(
        mask=asked(True).mask, solver=VelocitySolver(NEAR), rate=1.0, spread=0.0, blur=0.3
    ).blurred(field)
    lap = sum(derivative(derivative(field, NEAR, a, order=6), NEAR, a, order=6) for a in (0, 1))
    inner = (slice(None), slice(6, -6), slice(6, -6))
    np.testing.assert_allclose((got - field)[inner], 0.3 * H**2 * lap[inner], atol=2e-5)


@dataclass(frozen=True)
class Settings:
    """Two settings."""

    size: float = 1.0
    iterations: int = 5


@pytest.mark.parametrize(
    ("given", "text"),
    [
        (Settings(size=9.0), "law size must be a number from 0 to 2, got 9"),
        (Settings(iterations=2.5), "law iterations must be a whole number from 1 to 9"),
        (Settings(size=float("nan")), "law size must be"),
    ],
)
def test_settings_out_of_range_are_told_with_their_default(given, text):
    with pytest.raises(InputError, match=text) as caught:
        check_settings("law", given, {"size": (0.0, 2.0), "iterations": (1, 9)})
    assert "=" in caught.value.hint
