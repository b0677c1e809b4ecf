"""The window of a long run: its reach, its fading, and what stands for the wake beyond."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.bodies.motion import Prescribed
from pmesh.vortex.domain import Shift
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.window import FADING, Window
from remesh.errors import InputError
from remesh.grid import Grid

DISK = RigidBody(Disk(radius=0.5))
POSE = DISK.start()
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
    assert inside.origin[0] >= -2.0 - 1e-9
    assert inside.origin[1] >= -2.0 - 1e-9
    assert ends[0] <= 6.0 + 1e-9
    assert ends[1] <= 2.0 + 1e-9
    assert ends[0] > 5.85
    large = Grid((128, 40), 0.1, (-4.0, -1.95))
    cut = WINDOW.clipped(Shift((0, 0), (0, 0)), large, (DISK,), (POSE,))
    assert cut.before[0] == -20


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
    wind, flux = np.array([2.0, 0.0]), 0.7
    place = np.array([5.5, 0.0])
    angle = 2 * np.pi * np.arange(400) / 400
    radius = 300.0
    total = 0.0
    for a in angle:
        x, y = place + radius * np.array([math.cos(a), math.sin(a)])
        u = WINDOW.beyond(Grid((4, 4), 1e-6, (x, y)), (DISK,), (POSE,), flux, wind)[:, 0, 0]
        total += float(u @ [math.cos(a), math.sin(a)]) * 2 * np.pi * radius / 400
    assert total == pytest.approx(flux, rel=1e-3)
    here = WINDOW.beyond(Grid((4, 4), 1e-6, (0.0, 0.0)), (DISK,), (POSE,), flux, wind)[:, 0, 0]
    assert here[0] == pytest.approx(-flux / (2 * np.pi * 5.5), rel=0.05)
    assert abs(here[1]) < 1e-6


def test_the_deficit_follows_the_momentum_that_leaves():
    """A steady wake of flux q takes impulse -q W with it per unit of time (W the wind)."""
    wind, q, deficit = np.array([0.0, -1.5]), 0.4, 0.0
    for _ in range(2000):
        deficit = WINDOW.remembered(deficit, -q * wind * 0.01, (DISK,), wind, 0.01)
    assert deficit == pytest.approx(q, rel=1e-3)
    silent = Window(lower=(2, 2), upper=(6, 2), wake=False)
    assert silent.remembered(0.0, -q * wind, (DISK,), wind, 0.01) == 0.0


def test_the_eddies_beyond_are_a_vortex_at_the_downwind_end():
    """Its circulation is what left, anticlockwise if positive; at the body it is a gust."""
    wind, gone = np.array([2.0, 0.0]), 0.7
    place, radius, total = np.array([5.5, 0.0]), 300.0, 0.0
    for a in 2 * np.pi * np.arange(400) / 400:
        way = np.array([math.cos(a), math.sin(a)])
        grid = Grid((4, 4), 1e-6, tuple(place + radius * way))
        u = WINDOW.beyond(grid, (DISK,), (POSE,), 0.0, wind, gone)[:, 0, 0]
        total += float(u @ [-way[1], way[0]]) * 2 * np.pi * radius / 400
    assert total == pytest.approx(gone, rel=1e-3)
    here = WINDOW.beyond(Grid((4, 4), 1e-6, (0.0, 0.0)), (DISK,), (POSE,), 0.0, wind, gone)
    assert here[1, 0, 0] == pytest.approx(-gone / (2 * np.pi * 5.5), rel=0.05)
    assert abs(here[0, 0, 0]) < 1e-6


def test_a_street_of_eddies_beyond_is_felt_as_if_it_went_on():
    """Eddies of +-1 leave every 3 D/U: the velocity that they induce at the body, to a tenth."""
    wind, dt, far = np.array([1.0, 0.0]), 0.1, 5.5
    circulation, errors, sizes = 0.0, [], []
    for step in range(3000):
        gone = (-1.0) ** (step // 30) / 30
        circulation = WINDOW.departed(circulation, gone, (DISK,), wind, dt)
        ages = dt * np.arange(step + 1)
        left = (-1.0) ** ((step - np.arange(step + 1)) // 30) / 30
        exact = float(np.sum(left / (far + ages)))
        if step > 2000:
            errors.append(circulation / far - exact)
            sizes.append(exact)
    assert np.std(errors) < 0.1 * np.std(sizes)
    silent = Window(lower=(2, 2), upper=(6, 2), wake=False)
    assert silent.departed(0.0, 1.0, (DISK,), wind, 0.1) == 0.0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"lower": (1.0, 3.0), "upper": (6.0, 3.0)}, "lower must reach beyond"),
        ({"lower": (3.0, 3.0), "upper": (6.0, math.nan)}, "upper must reach beyond"),
        ({"lower": (3.0, 3.0), "upper": (6.0, 3.0), "fade": 0.0}, "fade must be positive"),
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
    assert 0.3 * drag < state.deficit < drag  # which it becomes when all of the wake has arrived
    forces = flow.forces(state)
    assert forces["impulse_force_x"] == pytest.approx(forces["body0_force_x"], rel=2e-3)
    assert abs(state.lost_circulation) < 1e-6
