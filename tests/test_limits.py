"""The rules that bound a step past bodies: one test each."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Ellipse, Ellipsoid, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.motion import Fixed, Free, Prescribed, Spring
from pmesh.bodies.swimmer import Swimmer
from pmesh.vortex.limits import body_limits, ratio, thickness
from pmesh.vortex.state import State
from remesh.grid import Grid

GRID = Grid((16, 16), 1 / 32)
SPEED, VISCOSITY = 2.0, 0.01


def steps(*bodies, step=1, speed=SPEED, turned=0.0):
    """The step of each rule."""
    poses = tuple(replace(body.start(), angle=(turned,)) for body in bodies)
    state = State(
        time=0.0, step=step, grid=GRID, vorticity=np.zeros(GRID.shape), gradient=0.0,
        speed=speed, poses=poses,
    )  # fmt: skip
    found = {}
    for limit in body_limits(bodies, state, VISCOSITY):
        found[limit.rule] = min(limit.dt, found.get(limit.rule, math.inf))
    return found


def test_no_bodies_limit_nothing():
    assert steps() == {}


def test_nothing_passes_more_than_a_tenth_of_a_disk_nor_spreads_further():
    found = steps(RigidBody(Disk(radius=0.5)))
    assert found["body"] == pytest.approx(0.1 / SPEED)
    assert found["diffusion"] == pytest.approx(0.01 / VISCOSITY)
    assert found["motion"] == math.inf


def test_the_smallest_body_counts():
    pair = RigidBody(Disk(radius=0.5)), RigidBody(Disk(radius=0.1, center=(2.0, 0.0)))
    assert steps(*pair)["body"] == pytest.approx(0.02 / SPEED)


def test_a_flow_at_rest_does_not_pass_a_body():
    assert steps(RigidBody(Disk(radius=0.5)), speed=0.0)["body"] == math.inf


def test_an_ellipse_is_as_thick_as_its_short_axis():
    assert thickness(RigidBody(Ellipse((1.0, 0.05)))) == pytest.approx(0.1, rel=1e-6)
    assert thickness(RigidBody(Ellipse((0.3, 0.3)))) == pytest.approx(0.6, rel=1e-6)


@pytest.mark.parametrize("angle", [0.4, math.pi / 4, math.pi / 2])
def test_a_thin_plate_allows_the_same_step_however_it_is_turned(angle):
    """Its box is 7 times as thick at 45 degrees; the plate is not."""
    plate = Box((1.0, 0.1))
    flat = steps(RigidBody(plate))
    assert flat["body"] == pytest.approx(0.1 * 0.1 / SPEED, rel=0.15)
    assert steps(RigidBody(plate), turned=angle) == flat
    shape = steps(RigidBody(plate.moved((0.0, 0.0), angle)))
    assert shape["body"] == pytest.approx(flat["body"], rel=1e-12)
    assert shape["diffusion"] == pytest.approx(flat["diffusion"], rel=1e-12)


def test_a_law_of_motion_is_resolved_over_its_scale():
    led = RigidBody(Disk(0.5), motion=Prescribed(shift=lambda t: (t, 0.0), scale=0.3))
    assert steps(led)["motion"] == pytest.approx(0.05 * 0.3)


def test_a_swimmer_takes_a_hundred_steps_a_period():
    fish = Swimmer.carling(period=0.7, motion=Fixed())
    assert steps(fish)["motion"] == pytest.approx(0.007)


@pytest.mark.parametrize("density", [0.5, 2.0])
def test_a_body_falls_a_quarter_of_a_spacing_from_rest_and_less_at_first(density):
    """A disk in an ideal fluid: acceleration g (d - 1) / (d + 1)."""
    body = RigidBody(Disk(0.5), motion=Free(density=density, gravity=(0.0, -3.0)))
    pull = 3.0 * abs(density - 1) / (density + 1)
    assert pull / 2 * steps(body)["motion"] ** 2 == pytest.approx(GRID.spacing / 4)
    assert pull / 2 * steps(body, step=0)["motion"] ** 2 == pytest.approx(GRID.spacing / 16)


def test_a_neutrally_buoyant_body_does_not_fall():
    body = RigidBody(Disk(0.5), motion=Free(density=1.0, gravity=(0.0, -3.0)))
    assert steps(body)["motion"] == math.inf


def test_springs_swing_half_a_radian_in_a_step():
    """omega^2 = k / (m + m_added), and that of torsion with the disk's own moment of inertia."""
    area = math.pi / 4
    for spring, omega in (
        (Spring(stiffness=(0.0, 40.0)), math.sqrt(40.0 / (3 * area))),
        (Spring(torsion=9.0), math.sqrt(9.0 / (2 * area / 8))),
    ):
        body = RigidBody(Disk(0.5), motion=Free(density=2.0, spring=spring))
        assert steps(body)["motion"] == pytest.approx(0.5 / omega)


def test_a_rate_of_zero_allows_any_step():
    assert (ratio(0.5, 0.0), ratio(0.5, 2.0)) == (math.inf, 0.25)


def test_an_ellipsoid_is_as_thick_as_its_shortest_axis_however_it_is_turned():
    assert thickness(RigidBody(Sphere(0.5))) == pytest.approx(1.0, rel=1e-12)
    shape = Ellipsoid((1.0, 0.2, 0.6))
    assert thickness(RigidBody(shape)) == pytest.approx(0.4, rel=1e-9)
    assert thickness(RigidBody(shape.moved(None, (0.3, 0.5, -0.2)))) == pytest.approx(0.4, rel=1e-9)
    assert thickness(RigidBody(Box((2.0, 3.0, 0.1)))) == pytest.approx(0.1, rel=0.3)


def test_a_ball_falls_with_half_of_its_fluid():
    """A ball in an ideal fluid: acceleration g (d - 1) / (d + 1/2)."""
    body = RigidBody(Sphere(0.5), motion=Free(density=2.0, gravity=(0.0, 0.0, -3.0)))
    grid = Grid((8, 8, 8), 1 / 32)
    state = State(
        time=0.0, step=1, grid=grid, vorticity=np.zeros((3, 8, 8, 8)), gradient=0.0,
        speed=0.0, poses=(body.start(),),
    )  # fmt: skip
    dt = min(limit.dt for limit in body_limits([body], state, 1e-9) if limit.rule == "motion")
    assert 0.5 * 3.0 / 2.5 * dt**2 == pytest.approx(grid.spacing / 4)
