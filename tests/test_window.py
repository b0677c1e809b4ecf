"""The window of a long run: its reach, its fading, and what stands for the wake beyond."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from levelset.shapes import Disk, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.motion import Prescribed
from pmesh.vortex.budget import Moments
from pmesh.vortex.domain import Shift
from pmesh.vortex.exact import VortexRing
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.state import Wake
from pmesh.vortex.window import FADING, MEMORY, Gone, Window, let_go
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.stencils import divergence, max_gradient_norm

DISK = RigidBody(Disk(radius=0.5))
POSE = DISK.start()
EAST = (1.0, 0.0)
WINDOW = Window(lower=(2.0, 2.0), upper=(6.0, 2.0), fade=1.0)
GRID = Grid((64, 40), 0.1, (-2.0, -1.95))


def test_a_window_is_given_in_body_lengths_around_the_bodies():
    double = RigidBody(Disk(radius=1.0, center=(3.0, 1.0)))
    low, high = WINDOW.corners((double,), (double.start(),))
    np.testing.assert_allclose(low, [-1.0, -3.0], atol=1e-6)
    np.testing.assert_allclose(high, [15.0, 5.0], atol=1e-6)


def test_a_mesh_stays_within_the_window_and_is_cut_to_it():
    grown = WINDOW.clipped(Shift((16, 16), (64, 16)), GRID, (DISK,), (POSE,))
    inside = grown.grid(GRID)
    ends = np.add(inside.origin, np.multiply(np.subtract(inside.shape, 1), 0.1))
    assert inside.origin[0] >= -2.0 - 1.6  # a stride
    assert inside.origin[1] >= -2.0 - 1.6
    assert ends[0] <= 6.0 + 1.6
    assert ends[1] <= 2.0 + 1.6
    assert ends[0] > 5.85
    large = Grid((128, 40), 0.1, (-4.0, -1.95))
    cut = WINDOW.clipped(Shift((0, 0), (0, 0)), large, (DISK,), (POSE,))
    assert cut.before[0] == -16


def test_a_mesh_that_fills_its_window_to_less_than_a_spacing_does_not_grow():
    full = WINDOW.clipped(Shift((16, 16), (16, 16)), GRID, (DISK,), (POSE,))
    assert full.before == (0, 0)
    assert full.after == (16, 0)
    wide = Grid((64, 44), 0.1, (-2.0, -2.15))  # reaches out by 1.5 spacings: less than a stride
    assert WINDOW.clipped(Shift((0, 0), (0, 0)), wide, (DISK,), (POSE,)).after[1] == 0
    wider = Grid((64, 60), 0.1, (-2.0, -2.35))  # reaches out by 15.5 spacings
    assert WINDOW.clipped(Shift((0, 0), (0, 0)), wider, (DISK,), (POSE,)).after[1] == 0


def test_vorticity_fades_to_nothing_on_its_way_through_the_zone():
    """What crosses the zone at the wind's speed keeps exp(-FADING / 3) of itself."""
    step, kept = 0.01, 1.0
    for x in np.arange(5.0 + step / 2, 6.0, step):
        grid = Grid((4, 4), 1e-6, (x, 0.0))
        factor = WINDOW.faded(grid, (DISK,), (POSE,), step)
        kept *= 1.0 if factor is None else factor[0, 0]
    assert kept == pytest.approx(math.exp(-FADING / 3), rel=0.2)


def test_nothing_fades_near_the_body():
    factor = WINDOW.faded(GRID, (DISK,), (POSE,), 0.1)
    x, y = GRID.points()
    inner = (x < 5.0) & (x > -1.0) & (np.abs(y) < 1.0)
    assert (factor[inner] == 1.0).all()
    assert WINDOW.faded(Grid((8, 8), 0.1), (DISK,), (POSE,), 0.1) is None


def test_the_wake_beyond_is_a_source_at_the_downwind_end():
    """Its flux through a circle around the end is the deficit; at the body it is q / (2 pi L)."""
    flux = 0.7
    place = np.array([5.5, 0.0])
    angle = 2 * np.pi * np.arange(400) / 400
    radius = 300.0
    total = 0.0
    for a in angle:
        x, y = place + radius * np.array([math.cos(a), math.sin(a)])
        u = WINDOW.beyond(Grid((4, 4), 1e-6, (x, y)), (DISK,), (POSE,), Wake(flux=flux, way=EAST))[
            :, 0, 0
        ]
        total += float(u @ [math.cos(a), math.sin(a)]) * 2 * np.pi * radius / 400
    assert total == pytest.approx(flux, rel=1e-3)
    here = WINDOW.beyond(
        Grid((4, 4), 1e-6, (0.0, 0.0)), (DISK,), (POSE,), Wake(flux=flux, way=EAST)
    )[:, 0, 0]
    assert here[0] == pytest.approx(-flux / (2 * np.pi * 5.5), rel=0.05)
    assert abs(here[1]) < 1e-6


def test_the_deficit_follows_the_momentum_that_leaves():
    """A steady wake of flux q takes impulse -q W with it per unit of time (W the wind)."""
    wind, q, wake = np.array([0.0, -1.5]), 0.4, Wake()
    gone = Gone(-q * wind * 0.01, 0.0)
    for _ in range(2000):
        wake = WINDOW.remembered(wake, gone, (DISK,), wind, 0.01)
    assert wake.flux == pytest.approx(q, rel=1e-3)
    assert wake.way == pytest.approx((0.0, -1.0))
    silent = Window(lower=(2, 2), upper=(6, 2), wake=False)
    assert silent.remembered(Wake(), gone, (DISK,), wind, 0.01) == Wake()


def test_a_wake_stays_where_the_wind_stops_and_turns_gently_with_it():
    full = Wake(flux=0.5, circulation=0.2, way=EAST)
    calm = Gone(np.zeros(2), 0.0)
    assert WINDOW.remembered(full, calm, (DISK,), np.zeros(2), 0.1) == full
    turned = WINDOW.remembered(full, calm, (DISK,), np.array([-1.0, 0.0]), 0.01)
    assert turned.way[0] == pytest.approx(1.0, abs=0.02)
    assert WINDOW.beyond(GRID, (DISK,), (POSE,), Wake(flux=1.0)) is None


def test_the_eddies_beyond_are_a_vortex_at_the_downwind_end():
    """Its circulation is what left, anticlockwise if positive; at the body it is a gust."""
    gone = 0.7
    place, radius, total = np.array([5.5, 0.0]), 300.0, 0.0
    for a in 2 * np.pi * np.arange(400) / 400:
        way = np.array([math.cos(a), math.sin(a)])
        grid = Grid((4, 4), 1e-6, tuple(place + radius * way))
        u = WINDOW.beyond(grid, (DISK,), (POSE,), Wake(circulation=gone, way=EAST))[:, 0, 0]
        total += float(u @ [-way[1], way[0]]) * 2 * np.pi * radius / 400
    assert total == pytest.approx(gone, rel=1e-3)
    here = WINDOW.beyond(
        Grid((4, 4), 1e-6, (0.0, 0.0)), (DISK,), (POSE,), Wake(circulation=gone, way=EAST)
    )
    assert here[1, 0, 0] == pytest.approx(-gone / (2 * np.pi * 5.5), rel=0.05)
    assert abs(here[0, 0, 0]) < 1e-6


def test_a_street_of_eddies_beyond_is_felt_as_if_it_went_on():
    """Eddies of +-1 leave every 3 D/U: the velocity that they induce at the body, to a tenth."""
    wind, dt, far = np.array([1.0, 0.0]), 0.1, 5.5
    circulation, errors, sizes = 0.0, [], []
    for step in range(3000):
        gone = (-1.0) ** (step // 30) / 30
        wake = WINDOW.remembered(
            Wake(circulation=circulation, way=EAST), Gone(np.zeros(2), gone), (DISK,), wind, dt
        )
        circulation = wake.circulation
        ages = dt * np.arange(step + 1)
        left = (-1.0) ** ((step - np.arange(step + 1)) // 30) / 30
        exact = float(np.sum(left / (far + ages)))
        if step > 2000:
            errors.append(circulation / far - exact)
            sizes.append(exact)
    assert np.std(errors) < 0.1 * np.std(sizes)
    silent = Window(lower=(2, 2), upper=(6, 2), wake=False)
    assert silent.remembered(Wake(), Gone(np.zeros(2), 1.0), (DISK,), wind, 0.1) == Wake()


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"lower": (1.0, 3.0), "upper": (6.0, 3.0)}, "lower must reach beyond"),
        ({"lower": (3.0, 3.0), "upper": (6.0, math.nan)}, "upper must reach beyond"),
        ({"lower": (3.0, 3.0), "upper": (6.0, 3.0), "fade": 0.0}, "fade must be positive"),
        ({"lower": (3.0, 3.0), "upper": (6.0, 3.0), "fade": math.nan}, "fade must be positive"),
        ({"lower": 3.0, "upper": (6.0, 3.0)}, "lower must hold one reach per axis"),
    ],
)
def test_a_window_without_room_is_refused(options, text):
    with pytest.raises(InputError, match=text):
        Window(**options)


@pytest.mark.parametrize("towed", [False, True])
def test_a_mesh_travels_with_the_body_and_keeps_its_size(towed):
    """A wake leaves: both routes of the force agree all the while, also when the body moves."""
    motion = Prescribed(shift=lambda t: (-t, 0.0), velocity=lambda t: (-1.0, 0.0))
    body = RigidBody(Disk(radius=0.5), motion=motion) if towed else DISK
    cells = 24
    flow = VortexFlow(
        grid=Grid((cells, cells), 1 / 12, ((0.5 - cells / 2) / 12,) * 2),
        viscosity=1 / 40,
        freestream=(0.0, 0.0) if towed else (1.0, 0.0),
        bodies=(body,),
        domain="follow",
        window=Window(lower=(2, 2), upper=(4, 2)),
        deformation=0.5,
    )
    state = flow.start()
    while state.time < 8.0:
        state = flow.step(state, min(flow.limit(state).dt, 0.1))
        low, high = flow.window.corners(flow.bodies, state.poses)
        span = np.multiply(np.subtract(state.grid.shape, 1), state.grid.spacing)
        assert (span <= high - low + 17 / 12).all()
    drag = abs(state.loads[0].force[0])
    assert 0.3 * drag < state.wake.flux < drag  # which it becomes when all of the wake has arrived
    forces = flow.forces(state)
    assert forces["impulse_force_x"] == pytest.approx(forces["body0_force_x"], rel=2e-3)
    assert abs(state.lost_circulation) < 1e-6


def test_what_stands_for_the_wake_does_not_depend_on_the_origin():
    wakes = []
    for shift in (0.0, 10.0):
        body = RigidBody(Disk(radius=0.5, center=(shift, 2 * shift)))
        grid = Grid((24, 24), 1 / 12, (shift - 11.5 / 12, 2 * shift - 11.5 / 12))
        flow = VortexFlow(
            grid=grid, viscosity=1 / 40, freestream=(1.0, 0.2), bodies=(body,), domain="follow",
            window=Window(lower=(2, 2), upper=(3, 2)), deformation=0.5, largest_step=0.1,
        )  # fmt: skip
        state = flow.start()
        for _ in range(60):
            state = flow.step(state, min(flow.limit(state).dt, 0.1))
        wakes.append(state.wake)
    assert wakes[0].flux > 0.05
    assert wakes[1].flux == pytest.approx(wakes[0].flux, rel=1e-3)
    assert wakes[1].circulation == pytest.approx(wakes[0].circulation, abs=1e-3)


FLOW = {"grid": Grid((40, 40), 0.1, (-2.0, -2.0)), "viscosity": 0.02, "bodies": (DISK,)}


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"window": (3, 3)}, "must be a Window"),
        ({"window": Window(lower=(3,), upper=(3, 3, 3))}, "2 reaches on each side"),
        ({"window": WINDOW, "bodies": ()}, "there are none"),
        ({"window": WINDOW, "domain": "fixed"}, "the domain is fixed"),
        (
            {
                "window": WINDOW,
                "grid": Grid((40, 40), 0.1, (-2.0, -2.0), ("unbounded", "periodic")),
            },
            "an axis is periodic",
        ),
        ({"contact": 1.0}, "must be a ContactLaw"),
    ],
)
def test_a_flow_refuses_a_window_that_cannot_be(options, text):
    with pytest.raises(InputError, match=text):
        VortexFlow(**{**FLOW, **options})


@pytest.mark.parametrize("axis", [0, 1])
def test_a_body_that_leaves_a_fixed_mesh_or_crosses_a_seam_is_told_of(axis):
    led = Prescribed(shift=lambda t: (2.0 * t, 0.0) if axis == 0 else (0.0, 2.0 * t))
    grid = Grid((40, 40), 0.1, (-2.0, -2.0), ("unbounded", "periodic"))
    flow = VortexFlow(
        grid=grid, viscosity=0.05, domain="fixed",
        bodies=(RigidBody(Disk(radius=0.5), motion=led),),
    )  # fmt: skip
    states = [flow.start()]

    def advance() -> None:
        for _ in range(60):
            states.append(flow.step(states[-1], 0.04))

    with pytest.raises(BlowUpError, match=rf"body 0 reaches .* axis {axis} .* out of the mesh"):
        advance()
    assert 0.2 < states[-1].time < 0.8


BALL = RigidBody(Sphere(0.5))
ROOM = Window(lower=(2.0, 2.0, 2.0), upper=(4.0, 2.0, 2.0))


def source_beyond(nodes: int) -> tuple[Grid, np.ndarray]:
    """The velocity of a wake's source in space, on a box around it, 3.5 lengths downwind."""
    grid = Grid((nodes,) * 3, 4.0 / nodes, (1.5, -2.0, -2.0))
    wake = Wake(flux=0.7, way=(1.0, 0.0, 0.0))
    velocity = ROOM.beyond(grid, [BALL], [BALL.start()], wake)
    assert velocity is not None
    return grid, velocity


def test_the_source_beyond_a_window_in_space_is_smooth_at_its_middle():
    slopes = [max_gradient_norm(velocity, grid) for grid, velocity in map(source_beyond, (20, 40))]
    assert slopes[1] == pytest.approx(slopes[0], rel=0.05)


def test_the_source_beyond_a_window_in_space_gives_what_faded():
    """Its divergence is a Gaussian of three core lengths' reach, whose sum is the flux."""
    grid, velocity = source_beyond(60)
    assert divergence(velocity, grid).sum() * grid.cell_volume == pytest.approx(0.7, rel=0.06)
    far = velocity[:, 0, 30, 30]  # 2 lengths before it
    x = grid.points()[:, 0, 30, 30] - [3.5, 0.0, 0.0]
    r = np.linalg.norm(x)
    np.testing.assert_allclose(far, 0.7 * x / (4 * np.pi * r**3), rtol=0.08)


def test_a_window_in_space_lets_vorticity_go_and_knows_its_impulse():
    grid = Grid((70, 48, 48), 0.12, (-2.0, -2.9, -2.9))
    ring = VortexRing(radius=0.8, core=0.35, center=(3.6, 0.0, 0.0), axis=(1.0, 0.0, 0.0))
    flow = VortexFlow(
        grid=grid,
        viscosity=0.01,
        freestream=(1.0, 0.0, 0.0),
        bodies=(BALL,),
        window=ROOM,
        domain="follow",
    )
    state = dataclasses.replace(flow.start(), vorticity=ring.vorticity(grid.points()), grid=grid)
    end = let_go(ROOM, state, (BALL,), np.array([1.0, 0.0, 0.0]), 0.05)
    assert np.abs(end.vorticity).sum() < np.abs(state.vorticity).sum()
    before, after = (Moments(one.vorticity, grid).impulse[0] for one in (state, end))
    assert after < before
    share = -math.expm1(-0.05 / MEMORY)
    assert end.wake.flux == pytest.approx(-share * (before - after) / 0.05, rel=1e-6)
    assert end.wake.way == (1.0, 0.0, 0.0)
