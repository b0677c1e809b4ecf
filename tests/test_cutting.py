"""Cutting: what is removed is what was swept, in bodies at rest and on the move."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import pmesh
from levelset.cutting import Cut, Cutting
from levelset.laws import Rotation, SingleVortex, Uniform
from levelset.shapes import Box, Disk, Sphere
from levelset.tool import Tool
from levelset.transport import ParticleLevelSet
from levelset.triangle_mesh import TriangleMesh
from remesh.errors import InputError
from remesh.grid import Grid

RADIUS, SIDES = 0.12, (1.2, 0.8, 0.6)
STILL = Uniform(velocity=(0.0, 0.0))
BORED = 0.24 * 0.7 + 0.5 * math.pi * RADIUS**2  # a disk driven to a depth of 0.7 and half a disk


def plane(cells: int = 40, half: float = 0.8) -> Grid:
    count = round(2 * half * cells) + 1
    return Grid((count, count), 1 / cells, (-half, -half))


def bore(time: float) -> tuple[float, float]:
    return -0.8 + 0.9 * time, 0.03


def turned(x: tuple[float, float], angle: float) -> tuple[float, float]:
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]


def carried(recipe: Cutting, state: Cut, steps: int, until: float = 1.0) -> Cut:
    for _ in range(steps):
        state = recipe.step(state, until / steps)
    return state


@pytest.mark.parametrize("steps", [1, 3, 20])
def test_a_disk_driven_into_a_block_removes_what_it_sweeps_for_any_step(steps: int) -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=STILL)
    recipe = Cutting(carrier=carrier, tools=Tool(shape=Disk(RADIUS), shift=bore))
    start = recipe.start(Box(SIDES[:2]))
    end = carried(recipe, start, steps)
    assert end.removed == pytest.approx(BORED, rel=1e-3)
    assert end.volume + end.removed == pytest.approx(start.volume, rel=1e-12)
    whole = Box(SIDES[:2]) - Disk(RADIUS, center=bore(1.0)) - Box((0.9, 0.24), center=(-0.35, 0.03))
    points = recipe.carrier.grid.points()
    exact = whole.distance(points)
    clear = np.abs(exact) > 1e-3 * carrier.grid.spacing
    ours = recipe.fields(end)["level_set"]
    assert np.array_equal((ours < 0)[clear], (exact < 0)[clear])


@pytest.mark.parametrize("remeshing", ["never", "always", 3, "distorted"])
@pytest.mark.parametrize("steps", [5, 24])
def test_a_body_that_turns_is_cut_as_one_at_rest(remeshing: str | int, steps: int) -> None:
    """The tool turns with the body: the cut is the same one, for any remeshing and step."""
    carrier = ParticleLevelSet(
        grid=plane(), velocity=Rotation(center=(0.0, 0.0), rate=2.0), remeshing=remeshing
    )
    tool = Tool(shape=Disk(RADIUS), shift=lambda t: turned(bore(t), 2.0 * t))
    recipe = Cutting(carrier=carrier, tools=tool)
    start = recipe.start(Box(SIDES[:2]))
    end = carried(recipe, start, steps)
    assert end.removed == pytest.approx(BORED, rel=2e-3)
    assert end.volume + end.removed == pytest.approx(start.volume, rel=2e-3)
    if remeshing in ("never", "distorted"):
        assert end.body.remeshings == 0, "rigid motion needs none"


def test_a_body_that_is_not_remeshed_is_cut_to_its_time_integration() -> None:
    """Turned back, the particles hold the values of the same cut at rest."""
    grid, block = plane(), Box(SIDES[:2])
    spin = Rotation(center=(0.0, 0.0), rate=2.0)
    moving = Cutting(
        carrier=ParticleLevelSet(grid=grid, velocity=spin, remeshing="never"),
        tools=Tool(shape=Disk(RADIUS), shift=lambda t: turned(bore(t), 2.0 * t)),
    )
    still = Cutting(
        carrier=ParticleLevelSet(grid=grid, velocity=STILL),
        tools=Tool(shape=Disk(RADIUS), shift=bore),
    )
    ours = carried(moving, moving.start(block), 40).body
    rest = carried(still, still.start(block), 40).body
    _, a, b = np.intersect1d(ours.nodes, rest.nodes, return_indices=True)
    near = np.abs(rest.values[b]) < 2.5 * grid.spacing
    assert near.sum() > 1000
    assert np.abs(ours.values[a] - rest.values[b])[near].max() < 1e-5


def test_a_ball_driven_into_a_block_in_space() -> None:
    grid = Grid((40, 33, 27), 1 / 28, (-19.5 / 28, -16 / 28, -13 / 28))
    still = ParticleLevelSet(grid=grid, velocity=Uniform(velocity=(0.0, 0.0, 0.0)))
    ball = Tool(shape=Sphere(0.13), shift=lambda t: (-0.8 + 0.9 * t, 0.02, -0.01))
    recipe = Cutting(carrier=still, tools=ball)
    start = recipe.start(Box((1.0, 0.7, 0.5)))
    end = carried(recipe, start, 3)
    exact = math.pi * 0.13**2 * 0.6 + 2 / 3 * math.pi * 0.13**3
    assert end.removed == pytest.approx(exact, rel=5e-3)
    assert end.volume + end.removed == pytest.approx(start.volume, rel=1e-12)
    assert recipe.ledger(end)["pieces"] == 1


def test_bodies_and_tools_may_be_triangle_meshes() -> None:
    """A brick cut by a plate, both of twelve triangles: the kerf is known."""

    def brick(sides: tuple[float, float, float]) -> TriangleMesh:
        corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * sides
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return TriangleMesh(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])

    grid = Grid((34, 28, 26), 1 / 24, (-16.5 / 24, -13.5 / 24, -12.5 / 24))
    still = ParticleLevelSet(grid=grid, velocity=Uniform(velocity=(0.0, 0.0, 0.0)))
    plate = Tool(shape=brick((0.15, 0.9, 0.4)), shift=lambda t: (0.1, 0.0, 0.7 - 1.4 * t))
    recipe = Cutting(carrier=still, tools=plate)
    end = carried(recipe, recipe.start(brick((0.9, 0.6, 0.5))), 2)
    assert end.removed == pytest.approx(0.15 * 0.6 * 0.5, rel=1e-2)
    assert recipe.ledger(end)["pieces"] == 2


def test_a_blade_through_a_block_leaves_two_pieces_and_takes_a_kerf() -> None:
    blade = Tool(shape=Box((0.1, 0.5)), shift=lambda t: (0.15, 1.0 - 2.0 * t))
    carrier = ParticleLevelSet(grid=plane(), velocity=STILL)
    recipe = Cutting(carrier=carrier, tools=blade)
    state = recipe.start(Box(SIDES[:2]))
    counts = []
    for _ in range(10):
        state = recipe.step(state, 0.1)
        counts.append(recipe.ledger(state)["pieces"])
    assert counts[0] == 1
    assert counts[-1] == 2
    assert counts == sorted(counts)
    assert state.removed == pytest.approx(0.1 * SIDES[1], rel=5e-3)


def test_a_blade_that_turns_about_its_end_removes_a_sector() -> None:
    """From the middle of a disk of radius 0.5: half a turn takes half of it, and half the blade."""
    blade = Box((0.7, 0.1), center=(0.35, 0.0))
    turn = Tool(shape=blade, angle=lambda t: math.pi * t)
    carrier = ParticleLevelSet(grid=plane(60, 0.7), velocity=STILL)
    recipe = Cutting(carrier=carrier, tools=turn)
    end = carried(recipe, recipe.start(Disk(0.5)), 4)
    h, r = 0.05, 0.5  # below y = 0 there is half the blade, at both ends of its way
    half = 0.5 * (h * math.sqrt(r * r - h * h) + r * r * math.asin(h / r))
    assert end.removed == pytest.approx(0.5 * math.pi * r * r + 2.0 * half, rel=3e-3)


@pytest.mark.parametrize("steps", [1, 2, 4])
@pytest.mark.parametrize("beats", [1, 2])
def test_strokes_that_return_within_a_step_are_cut(steps: int, beats: int) -> None:
    """The tool is where it was at the ends and in the middle of a step: it moved all the same."""
    tool = Tool(shape=Disk(0.1), shift=lambda t: (0.25 * math.sin(2 * math.pi * beats * t), 0.0))
    recipe = Cutting(carrier=ParticleLevelSet(grid=plane(), velocity=STILL), tools=tool)
    end = carried(recipe, recipe.start(Box(SIDES[:2])), steps)
    assert end.removed == pytest.approx(math.pi * 0.01 + 0.5 * 0.2, rel=2e-3)


def test_a_blade_that_turns_twice_in_a_step_removes_a_disk() -> None:
    tool = Tool(shape=Box((0.6, 0.1)), angle=lambda t: 4 * math.pi * t)
    recipe = Cutting(carrier=ParticleLevelSet(grid=plane(), velocity=STILL), tools=tool)
    end = carried(recipe, recipe.start(Box(SIDES[:2])), 1)
    assert end.removed == pytest.approx(math.pi * (0.3**2 + 0.05**2), rel=5e-3)


@pytest.mark.parametrize("dt", [0.7, 1.0, 1.2])
def test_a_step_beyond_the_limit_that_loses_volume_is_refused(dt: float) -> None:
    """RK4 shrinks a body that turns by more than a radian in a step."""
    carrier = ParticleLevelSet(
        grid=plane(half=1.2), velocity=Rotation(center=(0.0, 0.0), rate=2.0), remeshing="never"
    )
    recipe = Cutting(carrier=carrier, tools=Tool(shape=Disk(RADIUS), shift=bore))
    start = recipe.start(Box(SIDES[:2]))
    assert dt > 2 * recipe.limit(start).dt
    with pytest.raises(InputError, match="particles do not follow the velocity") as error:
        recipe.step(start, dt)
    assert "dt=0.125 at most" in str(error.value)


def test_a_cut_that_adds_to_the_body_is_refused(monkeypatch) -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=Rotation(center=(0.0, 0.0), rate=2.0))
    recipe = Cutting(carrier=carrier, tools=Tool(shape=Disk(RADIUS), shift=lambda t: (-0.5, 0.0)))
    start = recipe.start(Box(SIDES[:2]))
    moved, cut = 0.9, 0.95  # what is measured where the particles' map is beyond repair
    volumes = iter([cut, moved])
    monkeypatch.setattr(Cutting, "_volume", lambda self, body: next(volumes))
    with pytest.raises(InputError, match=r"to 0\.9, and by the cut to 0\.95"):
        recipe.step(start, 0.1)


@pytest.mark.parametrize(
    "bad", [lambda t, x: x[:1], lambda t, x: np.where(t > 0.05, np.nan, 0 * x)]
)
def test_velocities_that_cannot_be_used_are_refused(bad) -> None:
    """Those at the end of a step too, which only the particles' ways need."""

    class Law:
        def max_gradient(self, time: float) -> float:
            return 0.0

        def __call__(self, time: float, positions: np.ndarray) -> np.ndarray:
            return bad(time, positions)

    carrier = ParticleLevelSet(grid=plane(), velocity=Law(), remeshing="never", time_scheme="RK2")
    recipe = Cutting(carrier=carrier, tools=Tool(shape=Disk(RADIUS), shift=lambda t: (-0.4, 0.0)))
    told = r"velocity (must return real numbers of shape|is not finite at t = 0\.1)"
    with pytest.raises(InputError, match=told):
        recipe.step(recipe.start(Disk(0.4)), 0.1)


def test_several_tools_cut_at_once_and_what_both_touch_counts_once() -> None:
    tools = [
        Tool(shape=Disk(0.2), shift=lambda t: (0.0, 0.1 * t)),
        Tool(shape=Disk(0.2), shift=lambda t: (0.0, -0.1 * t)),
    ]
    carrier = ParticleLevelSet(grid=plane(), velocity=STILL)
    recipe = Cutting(carrier=carrier, tools=tools)
    end = carried(recipe, recipe.start(Box(SIDES[:2])), 2)
    assert end.removed == pytest.approx(math.pi * 0.04 + 0.4 * 0.2, rel=2e-3)


def test_a_body_that_deforms_is_cut_and_keeps_the_rest() -> None:
    carrier = ParticleLevelSet(grid=Grid((97, 97), 1 / 96), velocity=SingleVortex(period=4.0))
    tool = Tool(shape=Disk(0.06), shift=lambda t: (0.38, 1.0 - 1.2 * t))
    recipe = Cutting(carrier=carrier, tools=tool)
    start = recipe.start(Disk(0.15, center=(0.5, 0.75)))
    end = carried(recipe, start, 10, until=0.2)
    assert end.removed > 0.005
    assert end.volume + end.removed == pytest.approx(start.volume, rel=1e-3)


def test_a_tool_that_misses_changes_nothing() -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=STILL)
    far = Tool(shape=Disk(0.1), shift=lambda t: (5.0 + t, 0.0))
    recipe = Cutting(carrier=carrier, tools=far)
    start = recipe.start(Disk(0.4))
    end = carried(recipe, start, 3)
    assert end.removed == 0.0
    assert np.isin(end.body.nodes, start.body.nodes).all()
    assert end.volume == start.volume


@pytest.mark.parametrize("law", [STILL, Rotation(center=(0.0, 0.0), rate=1.0)])
def test_a_body_can_be_cut_away_whole(law: Uniform | Rotation) -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=law)
    recipe = Cutting(carrier=carrier, tools=Tool(shape=Disk(0.5), shift=lambda t: (t - 1.1, 0.0)))
    start = recipe.start(Disk(0.3))
    end = carried(recipe, start, 11, until=1.1)
    end = recipe.step(end, 0.1)
    assert end.volume == 0.0
    assert end.removed == pytest.approx(math.pi * 0.09, rel=3e-3)
    assert recipe.ledger(end)["pieces"] == 0


def test_a_run_is_resumed_bit_for_bit(tmp_path) -> None:
    def recipe() -> Cutting:
        carrier = ParticleLevelSet(
            grid=plane(), velocity=Rotation(center=(0.0, 0.0), rate=2.0), remeshing="distorted"
        )
        return Cutting(
            carrier=carrier, tools=Tool(shape=Disk(RADIUS), shift=bore), largest_step=0.1
        )

    shape = Box(SIDES[:2])
    whole = pmesh.run(recipe(), recipe().start(shape), until=1.0)

    def stop(moment) -> None:
        if moment.step == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pmesh.run(recipe(), recipe().start(shape), until=1.0, out=tmp_path, watch=[stop])
    end = pmesh.run(recipe(), recipe().start(shape), until=1.0, out=tmp_path, resume=True)
    assert end.removed == whole.removed
    assert np.array_equal(end.body.positions, whole.body.positions)
    assert np.array_equal(end.body.values, whole.body.values)


def test_a_step_leaves_the_state_before_as_it_was() -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=Rotation(center=(0.0, 0.0), rate=2.0))
    recipe = Cutting(carrier=carrier, tools=Tool(shape=Disk(RADIUS), shift=bore))
    start = recipe.start(Box(SIDES[:2]))
    values, places = start.body.values.copy(), start.body.positions.copy()
    recipe.step(start, 0.3)
    assert np.array_equal(start.body.values, values)
    assert np.array_equal(start.body.positions, places)


def test_the_tools_set_no_limit_and_the_user_may() -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=STILL)
    tool = Tool(shape=Disk(RADIUS), shift=bore)
    recipe = Cutting(carrier=carrier, tools=tool)
    state = recipe.start(Disk(0.4))
    assert recipe.limit(state).dt == math.inf
    assert replace(recipe, largest_step=0.2).limit(state).rule == "largest_step"
    assert recipe.forces(state) == {}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"tools": ()}, "tools must be a Tool or several"),
        ({"tools": Disk(0.1)}, "tools must be a Tool or several"),
        ({"tools": Tool(shape=Sphere(0.1))}, "a tool has 3 dimensions, the grid 2"),
        ({"tools": Tool(shape=Disk(0.02))}, "1.6 spacings thick: the mesh does not see its cut"),
        (
            {"tools": Tool(shape=Box((0.01, 0.5)).moved(angle=0.7))},
            "0.4 spacings thick: the mesh does not see its cut",
        ),
        ({"tools": Tool(shape=Disk(0.2)), "largest_step": 0.0}, "largest_step must be positive"),
        ({"tools": Tool(shape=Disk(0.2)), "largest_step": "a"}, "largest_step must be a number"),
        ({"tools": Tool(shape=Disk(0.2)), "carrier": "x"}, "carrier must be a ParticleLevelSet"),
    ],
)
def test_cuts_that_make_no_sense_are_refused(options, said: str) -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=STILL)
    with pytest.raises(InputError, match=said):
        Cutting(**{"carrier": carrier, **options})


@pytest.mark.parametrize("dt", [-0.1, 0.0, math.inf, "a"])
def test_steps_that_are_none_are_refused(dt) -> None:
    carrier = ParticleLevelSet(grid=plane(), velocity=STILL)
    recipe = Cutting(carrier=carrier, tools=Tool(shape=Disk(RADIUS), shift=bore))
    with pytest.raises(InputError, match="dt must be"):
        recipe.step(recipe.start(Disk(0.4)), dt)
