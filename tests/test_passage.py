"""Flows past bodies that move: exact laws of slow motion, momentum, symmetry, contact, restarts."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from levelset.shapes import Disk, Ellipse, Ellipsoid, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.gaps import contacts
from pmesh.bodies.motion import Fixed, Free, Prescribed, Spring
from pmesh.bodies.penalise import Penalisation
from pmesh.cases.unsteady_stokes import friction_of_acceleration, history, inverse_laplace
from pmesh.run import tree
from pmesh.run.loop import run
from pmesh.run.watchers import Forces
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

AREA = math.pi / 4  # of a disk of diameter 1


def disk(motion, center=(0.0, 0.0)):
    return RigidBody(Disk(0.5).moved(center), motion=motion)


def made(*bodies, nodes=24, viscosity=0.02, reach=0.75, **options):
    """A flow in free space on a small mesh around the origin, which lies between nodes."""
    h = 1 / nodes
    cells = 8 * math.ceil(reach / h / 8)
    grid = Grid((2 * cells,) * 2, h, ((0.5 - cells) * h,) * 2)
    return VortexFlow(
        grid=grid, viscosity=viscosity, bodies=bodies, domain="follow", threads=1, **options
    )


def go(flow, until, dt=0.04, state=None):
    """The state at the end, and the columns of all steps."""
    state, rows = state or flow.start(), []
    while state.time < until - 1e-9:
        state = flow.step(state, min(dt, until - state.time))
        rows.append({"time": state.time, **flow.forces(state), **flow.ledger(state)})
    return state, {name: np.array([row[name] for row in rows]) for name in rows[0]}


@pytest.mark.parametrize("viscosity", [0.0025, 0.01])
def test_an_accelerated_disk_feels_its_added_mass_and_friction(viscosity):
    """Force over pi rho R^2 a: 1 and the friction of unsteady Stokes flow, within 2 % of the 1."""
    gain = 0.05

    def shift(t):
        return -0.5 * gain * t * t, 0.0

    flow = made(disk(Prescribed(shift=shift)), viscosity=viscosity)
    _, found = go(flow, 1.0)
    middle = found["time"] - 0.02
    late = middle > 0.2
    friction = friction_of_acceleration(middle, viscosity=viscosity, radius=0.5)
    added = found["body0_force_x"] / (AREA * gain) - friction
    assert added[late].mean() == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(found["impulse_force_x"], found["body0_force_x"], atol=1e-9)
    power = -found["body0_force_x"] * found["body0_u"]
    np.testing.assert_allclose(found["body0_power"][late], power[late], rtol=0.2)


@pytest.mark.parametrize("density", [0.1, 1.0, 3.0])
def test_a_launched_disk_is_slowed_as_unsteady_stokes_flow_says(density):
    """Light, neutrally buoyant and heavy; the impulse that its added mass took is not counted."""
    speed, viscosity = 0.02, 0.02
    flow = made(disk(Free(density=density, velocity=(speed, 0.0))), viscosity=viscosity)
    _, found = go(flow, 1.0)

    def law(s):
        return (density + 1) / (s * (density + 1 + history(s, viscosity, 0.5)))

    exact = speed * inverse_laplace(law, found["time"])
    late = found["time"] > 0.15
    np.testing.assert_allclose(found["body0_u"][late], exact[late], rtol=0.015)
    assert np.abs(found["body0_v"]).max() < 1e-4 * speed
    assert np.abs(found["body0_spin"]).max() < 1e-3 * speed


def test_a_disk_on_a_spring_swings_and_decays_as_unsteady_stokes_flow_says():
    """Frequency with the added mass: omega^2 = k / (m + m_added), but for the friction."""
    density, viscosity, rate = 2.0, 0.02, 2 * math.pi
    stiffness = rate**2 * (density + 1) * AREA
    speed = 0.02 * rate
    motion = Free(density=density, velocity=(0.0, speed), spring=Spring(stiffness=(stiffness,) * 2))
    _, found = go(made(disk(motion), viscosity=viscosity), 2.0, 0.02)

    def law(s):
        pull = stiffness / AREA / s
        return (density + 1) / (s * (density + 1 + history(s, viscosity, 0.5)) + pull)

    exact = inverse_laplace(law, found["time"])
    assert np.abs(found["body0_v"] / speed - exact).max() < 0.04
    crossing = zeros(found["time"], found["body0_v"])
    assert np.diff(crossing) == pytest.approx(np.diff(zeros(found["time"], exact)), rel=0.02)
    assert 2 * np.diff(crossing).mean() == pytest.approx(1.0, rel=0.12)


def zeros(time, value):
    """Times at which a record changes sign."""
    at = np.flatnonzero(np.diff(np.sign(value)))
    return time[at] - value[at] * (time[at + 1] - time[at]) / (value[at + 1] - value[at])


@pytest.mark.parametrize("density", [0.2, 1.0, 4.0])
def test_a_disk_that_goes_with_a_uniform_stream_leaves_it_uniform(density):
    stream = (0.8, -0.3)
    flow = made(disk(Free(density=density, velocity=stream)), freestream=stream)
    state, found = go(flow, 0.4, 0.1)
    assert np.abs(state.vorticity).max() < 1e-10
    assert state.poses[0].center == pytest.approx((0.32, -0.12), abs=1e-12)
    assert np.abs(found["body0_force_x"]).max() < 1e-10


def test_a_neutrally_buoyant_disk_goes_round_with_fluid_that_turns_like_a_solid():
    """In the middle of a wide vortex: place and spin to 1 %, and the vorticity is let be."""
    rate = 0.5  # of turning; the vorticity is twice that

    def vorticity(points):
        return 2 * rate * np.exp(-((np.hypot(*points) / 2.0) ** 12))

    start = (0.6, 0.0)
    motion = Free(density=1.0, velocity=(0.0, rate * start[0]), spin=rate)
    flow = made(disk(motion, start), nodes=16, reach=2.75, viscosity=1e-3)
    state, found = go(flow, 1.0, 0.1, flow.start(vorticity=vorticity))
    turned = rate * 1.0
    place = 0.6 * math.cos(turned), 0.6 * math.sin(turned)
    assert state.poses[0].center == pytest.approx(place, abs=0.006)
    assert found["body0_spin"] == pytest.approx(rate, rel=0.01)
    assert found["body0_angle"][-1] == pytest.approx(turned, rel=0.01)
    inner = np.hypot(*state.grid.points()) < 1.3
    assert np.abs(state.vorticity[inner] / (2 * rate) - 1).max() < 0.15


def test_a_neutrally_buoyant_disk_is_let_be_by_gravity():
    flow = made(disk(Free(density=1.0, gravity=(0.0, -9.81))))
    state, _ = go(flow, 0.2, 0.1)
    assert np.abs(state.vorticity).max() < 1e-12
    assert state.poses[0].center == pytest.approx((0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize("density", [0.5, 2.0])
def test_newtons_law_holds_to_round_off_and_both_force_routes_agree(density):
    """Mass times acceleration is weight less buoyancy and the force of the fluid, x, y and spin."""
    body = RigidBody(
        Ellipse((0.5, 0.3)).moved((0.0, 0.0), 0.4),
        motion=Free(density=density, gravity=(0.3, -1.0), velocity=(0.2, 0.1), spin=0.5),
    )
    _, found = go(made(body, reach=0.9), 0.4, 0.02)
    volume, inertia = body.measure.volume, body.measure.inertia
    for axis, speed, pull in (("x", "u", 0.3), ("y", "v", -1.0)):
        force = found[f"body0_force_{axis}"][1:]
        gain = density * volume * np.diff(found[f"body0_{speed}"]) / 0.02
        np.testing.assert_allclose(force, gain - (density - 1) * volume * pull, atol=1e-11)
        np.testing.assert_allclose(found[f"impulse_force_{axis}"][1:], force, atol=1e-6)
    turn = density * inertia * np.diff(found["body0_spin"]) / 0.02
    np.testing.assert_allclose(found["body0_torque"][1:], turn, atol=1e-11)


def test_bodies_without_gravity_only_exchange_momentum_with_the_fluid():
    """Impulse of the vorticity, plus the bodies' mass beyond the fluid's: one sum for ever."""
    bodies = (
        disk(Free(density=2.0, velocity=(0.5, 0.1)), (-0.7, 0.1)),
        disk(Free(density=0.5, velocity=(-0.4, 0.0), spin=1.0), (0.7, 0.0)),
    )
    flow = made(*bodies, reach=1.4)
    _, found = go(flow, 0.3, 0.02)
    for axis, speed in (("x", "u"), ("y", "v")):
        own = sum(
            (body.motion.density - 1) * AREA * found[f"body{k}_{speed}"]
            for k, body in enumerate(bodies)
        )
        total = found[f"impulse_{axis}"] + own
        assert np.abs(total - total[0]).max() < 1e-7
        both = found[f"body0_force_{axis}"] + found[f"body1_force_{axis}"]
        np.testing.assert_allclose(found[f"impulse_force_{axis}"], both, atol=1e-6)


def test_the_mirrored_flow_is_the_mirror_of_the_flow():
    """Of a spinning, falling ellipse: places, spin and vorticity."""

    def falling(sign):
        shape = Ellipse((0.5, 0.3)).moved((0.0, 0.0), 0.5 * sign)
        motion = Free(density=1.5, gravity=(0.0, -1.0), velocity=(0.3 * sign, 0.0))
        return go(made(RigidBody(shape, motion=motion), reach=0.9), 0.5, 0.025)

    state, one = falling(1)
    other_state, other = falling(-1)
    for name, sign in (("x", -1), ("y", 1), ("angle", -1), ("u", -1), ("v", 1), ("spin", -1)):
        np.testing.assert_allclose(
            other[f"body0_{name}"], sign * one[f"body0_{name}"], atol=2e-4, err_msg=name
        )
    assert state.grid.shape == other_state.grid.shape
    flipped = -other_state.vorticity[::-1]
    assert np.abs(flipped - state.vorticity).max() < 5e-3 * np.abs(state.vorticity).max()


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_bodies_on_a_collision_course_never_overlap_and_the_run_goes_on(dtype):
    """A heavy one falls on a neutrally buoyant one, head on but for a little."""
    nodes = 20
    bodies = (
        disk(Free(density=3.0, velocity=(0.02, -1.0)), (0.0, 0.7)),
        disk(Free(density=1.0), (0.0, -0.7)),
    )
    flow = made(*bodies, nodes=nodes, reach=1.4, dtype=dtype)
    state, least, touched = flow.start(), math.inf, 0
    for _ in range(40):
        state = flow.step(state, min(flow.limit(state).dt, 0.03))
        first, second = state.poses
        gap = math.dist(first.center, second.center) - 1.0
        near = contacts(bodies, state.poses, 2.0 / nodes)
        touched += bool(near)
        least = min(least, gap * nodes)
        assert np.isfinite(state.vorticity).all()
    assert touched > 3, "they met"
    assert least > 0.0, "spacings between them"
    assert second.velocity[1] < -0.1, "the lower one is pushed along"


def two_bodies():
    """A free body and a led one, side by side."""
    law = Prescribed(shift=lambda t: (0.1 * math.sin(3 * t), 0.0), angle=lambda t: t)
    return made(
        disk(Free(density=0.6, gravity=(0.0, -1.0)), (-0.65, 0.0)),
        RigidBody(Ellipse((0.4, 0.3)).moved((0.65, 0.0)), motion=law),
        nodes=20, reach=1.3,
    )  # fmt: skip


def interrupt(moment):
    if moment.step == 5:
        raise KeyboardInterrupt


def test_a_run_with_moving_bodies_that_is_resumed_is_the_unbroken_run(tmp_path):
    """Bit for bit: poses, the poses before, loads, vorticity and the series."""
    first, second, third = (two_bodies() for _ in range(3))
    whole = run(first, first.start(), until=0.3, watch=[Forces()], out=tmp_path / "whole")
    parts = tmp_path / "parts"
    with pytest.raises(KeyboardInterrupt):
        run(second, second.start(), until=0.3, watch=[Forces(), interrupt], out=parts)
    end = run(third, third.start(), until=0.3, watch=[Forces()], out=parts, resume=True)
    assert end.step > 6
    assert tree.same(end, whole)
    series = [(folder / "series.csv").read_bytes() for folder in (tmp_path / "whole", parts)]
    assert series[0] == series[1]


@pytest.mark.parametrize(
    ("spring", "slowest"),
    [(Spring(stiffness=(5e3, 5e3)), 1.0), (Spring(damping=(200.0, 200.0), torsion=1e3), 1e-3)],
    ids=["stiff", "damped"],
)
def test_stiff_springs_and_strong_dampers_hold_a_disk_at_any_step(spring, slowest):
    """Launched, it never gets faster nor farther than the energy allows: steps of omega dt = 2."""
    speed = 0.5
    motion = Free(density=2.0, velocity=(0.0, speed), spin=0.5, spring=spring)
    _, found = go(made(disk(motion)), 1.2)
    assert np.abs(found["body0_v"]).max() <= speed
    assert np.abs(found["body0_v"][-10:]).max() <= slowest * speed
    reach = speed * math.sqrt(3 * AREA / 5e3) if spring.stiffness else 0.5 * 0.04 * speed * 3
    assert np.abs(found["body0_y"]).max() <= 1.05 * reach
    assert np.abs(found["body0_spin"]).max() <= 0.5


BALL = math.pi / 6  # volume of a ball of diameter 1
SHARP = Penalisation(strength=1e4)


def solid(shape, motion, *, viscosity=0.02, **options):
    """A flow around a solid in free space, 12 nodes a unit of length."""
    h, cells = 1 / 12, 16
    grid = Grid((2 * cells,) * 3, h, ((0.5 - cells) * h,) * 3)
    body = RigidBody(shape, motion=motion)
    return VortexFlow(
        grid=grid, viscosity=viscosity, bodies=(body,), domain="follow", threads=1,
        freestream=options.pop("freestream", (0.0,) * 3), **options,
    )  # fmt: skip


def stokes(s, viscosity, radius=0.5):
    """Drag over the velocity of a ball, without its added mass: G. G. Stokes (1851)."""
    return 6 * math.pi * radius * (viscosity + radius * np.sqrt(viscosity * s))


def stokes_torque(s, viscosity, radius=0.5):
    """Torque over the spin of a ball: L. D. Landau, E. M. Lifshitz, *Fluid Mechanics*, sec. 24."""
    z = radius * np.sqrt(s / viscosity)
    return 8 * math.pi / 3 * viscosity * radius**3 * (3 + 3 * z + z * z) / (1 + z)


@pytest.mark.parametrize("density", [0.3, 2.0])
def test_a_ball_let_go_takes_half_of_its_fluid_with_it(density):
    """Basset's equation: (rho + 1/2) V dw/dt = (rho - 1) V g less friction and its history.

    To a few per cent at 12 nodes a diameter, where the layer is as thin as a spacing at first.
    """
    gravity, viscosity = 0.1, 0.02
    motion = Free(density=density, gravity=(0.0, 0.0, -gravity))
    flow = solid(Sphere(0.5), motion, viscosity=viscosity, penalisation=SHARP)
    state, pull = flow.start(), (density - 1) * BALL * gravity

    def law(s):
        return pull / s / ((density + 0.5) * BALL * s + stokes(s, viscosity))

    for _ in range(3):
        speed = state.poses[0].velocity[2]
        state = flow.step(state, 0.03)
        found = flow.forces(state)
        gained = density * BALL * (state.poses[0].velocity[2] - speed) / 0.03
        assert gained == pytest.approx(found["body0_force_z"] - pull, rel=1e-12)
        assert found["impulse_force_z"] == pytest.approx(found["body0_force_z"], rel=1e-3)
    exact = float(inverse_laplace(law, state.time))
    assert -state.poses[0].velocity[2] == pytest.approx(exact, rel=0.04)
    assert np.abs(state.poses[0].velocity[:2]).max() < 1e-6
    assert np.abs(state.poses[0].spin).max() < 1e-6


def test_a_ball_held_at_once_in_a_stream_is_dragged_as_basset_says():
    """6 pi nu R U (1 + R / sqrt(pi nu t)): so slow that its inertia is not felt."""
    viscosity, speed = 0.04, 0.02
    flow = solid(Sphere(0.5), Fixed(), viscosity=viscosity, freestream=(speed, 0.0, 0.0))
    state = flow.start()
    for _ in range(8):
        state = flow.step(state, 0.025)
    found = flow.forces(state)
    layer = math.sqrt(math.pi * viscosity * (state.time - 0.0125))
    exact = 3 * math.pi * viscosity * speed * (1 + 0.5 / layer)
    assert found["body0_force_x"] == pytest.approx(exact, rel=0.02)
    assert found["impulse_force_x"] == pytest.approx(found["body0_force_x"], rel=0.01)
    for name in ("force_y", "force_z", "torque_x", "torque_y", "torque_z"):
        assert abs(found[f"body0_{name}"]) < 1e-3 * exact


def test_a_ball_that_spins_freely_is_slowed_as_unsteady_stokes_flow_says():
    """rho I dW/dt = T about a leaning axis; nothing else is set in motion."""
    axis, viscosity, density = np.array([1.0, -2.0, 2.0]) / 3, 0.02, 3.0
    motion = Free(density=density, spin=tuple(axis))
    flow = solid(Sphere(0.5), motion, viscosity=viscosity, penalisation=SHARP)
    state, inertia = flow.start(), density * BALL / 10

    def law(s):
        return inertia / (inertia * s + stokes_torque(s, viscosity))

    for _ in range(4):
        state = flow.step(state, 0.04)
    exact = float(inverse_laplace(law, state.time))
    assert exact < 0.8
    np.testing.assert_allclose(state.poses[0].spin, exact * axis, atol=0.02)
    assert np.abs(state.poses[0].velocity).max() < 1e-3
    assert np.dot(state.poses[0].angle, axis) == pytest.approx(0.16 * 0.5 * (1 + exact), rel=0.05)


def test_a_ball_that_goes_with_a_stream_leaves_it_uniform():
    flow = solid(
        Sphere(0.5), Free(density=1.0, velocity=(1.0, 0.5, -0.2)), freestream=(1.0, 0.5, -0.2)
    )
    state = flow.step(flow.step(flow.start(), 0.02), 0.02)
    assert np.abs(state.vorticity).max() < 1e-9
    assert state.poses[0].center == pytest.approx((0.04, 0.02, -0.008))
    assert np.abs(state.loads[0].force).max() < 1e-9


EGG, LEAN = (0.5, 0.42, 0.36), (0.3, 0.5, -0.4)


def tumbling(shift):
    """An egg that tumbles in a wind, all axes moved on by a number of places."""
    axes = tuple(np.roll(EGG, shift))
    lean, spin, wind = (tuple(np.roll(v, shift)) for v in (LEAN, (1.0, 2.0, -1.0), (0.5, 0.2, 0.0)))
    motion = Free(density=3.0, spin=spin)
    flow = solid(Ellipsoid(axes).moved(None, lean), motion, freestream=wind)
    states = [flow.start()]
    for _ in range(2):
        states.append(flow.step(states[-1], 0.03))
    return flow, states


def test_no_axis_of_space_is_unlike_another_and_an_egg_keeps_newtons_and_eulers_laws():
    """Cyclic exchange of the axes exchanges all; momenta change by the told loads to round-off."""
    (flow, states), (_, others) = tumbling(0), tumbling(1)
    body = flow.bodies[0]
    for old, new in itertools.pairwise(states):
        load, before, after = new.loads[0], old.poses[0], new.poses[0]
        gained = 3.0 * body.measure.volume * np.subtract(after.velocity, before.velocity)
        np.testing.assert_allclose(gained / 0.03, load.force, atol=1e-11)
        turned = body.inertia(after) @ after.spin - body.inertia(before) @ before.spin
        np.testing.assert_allclose(3.0 * turned / 0.03, load.torque, atol=1e-11)
    here, there = states[-1].poses[0], others[-1].poses[0]
    for name in ("velocity", "spin", "center", "angle"):
        ours, theirs = getattr(here, name), getattr(there, name)
        np.testing.assert_allclose(np.roll(ours, 1), theirs, atol=1e-5)
    assert np.abs(here.velocity).min() > 1e-4
