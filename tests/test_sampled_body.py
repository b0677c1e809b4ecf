"""Level sets as bodies in a flow: what particles carry acts as the shape it stands for."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pmesh
from levelset.contour import contour
from levelset.laws import Rotation
from levelset.measure import measure
from levelset.sampled import Sampled
from levelset.shape import Shape
from levelset.shapes import Disk
from levelset.transport import ParticleLevelSet
from pmesh.run.watchers import Forces
from remesh.grid import Grid

DISK = Disk(0.5)
OWN = Grid((61, 61), 1 / 40, (-0.75, -0.75))  # of the level set


def on_particles() -> Sampled:
    """The disk as particles hold it, after a quarter of a turn about a point beside it."""
    spin = Rotation(center=(0.1, 0.0), rate=math.pi / 2)
    level_set = ParticleLevelSet(grid=OWN, velocity=spin, remeshing="distorted", width=12.0)
    state = level_set.start(DISK)
    for _ in range(10):
        state = level_set.step(state, 0.1)
    return level_set.shape(state)


def started(shape: Shape) -> tuple[dict[str, np.ndarray], pmesh.State]:
    """The first steps of a body set in motion at once at Re = 100."""
    grid = Grid((81, 65), 1 / 20, (-1.5, -1.6))
    flow = pmesh.VortexFlow(
        grid=grid, viscosity=0.01, freestream=(1.0, 0.0), bodies=(pmesh.RigidBody(shape),),
        largest_step=0.02,
    )  # fmt: skip
    forces = Forces()
    end = pmesh.run(flow, flow.start(), until=0.2, watch=[forces])
    return dict(forces.series), end


@pytest.fixture(scope="module")
def exact() -> tuple[dict[str, np.ndarray], pmesh.State]:
    return started(DISK)


def test_drag_of_a_sampled_disk_is_that_of_the_disk(exact) -> None:
    ours, end = started(Sampled(DISK.distance(OWN.points()), OWN))
    drag = exact[0]["body0_force_x"][1:]
    assert np.abs(ours["body0_force_x"][1:] / drag - 1.0).max() < 1e-3
    apart = np.abs(end.vorticity - exact[1].vorticity).max()
    assert apart < 1e-3 * np.abs(exact[1].vorticity).max()


def test_a_level_set_carried_by_particles_is_a_body(exact) -> None:
    """The disk turned by a quarter about (0.1, 0) is a disk at (0.1, -0.1)."""
    shape = on_particles()
    ours, _ = started(shape.moved((-0.1, 0.1)))
    drag = exact[0]["body0_force_x"][1:]
    assert np.abs(ours["body0_force_x"][1:] / drag - 1.0).max() < 2e-3


def test_a_level_set_carried_by_particles_can_be_measured_and_drawn() -> None:
    shape = on_particles()
    found = measure(shape)
    assert found.volume == pytest.approx(math.pi / 4, rel=1e-4)
    assert found.center == pytest.approx((0.1, -0.1), abs=1e-5)
    (ring,) = contour(shape)
    radius = np.hypot(ring[:, 0] - 0.1, ring[:, 1] + 0.1)
    assert np.abs(radius - 0.5).max() < 1e-4
