"""Tools that move: where they are, and what they sweep."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Sphere
from levelset.solids import Capsule
from levelset.tool import Swept, Tool
from remesh.errors import InputError


def points(ndim: int, count: int = 4000, reach: float = 1.5) -> np.ndarray:
    return np.random.default_rng(3).uniform(-reach, reach, (ndim, count))


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_tool_is_where_its_laws_say(ndim: int) -> None:
    shape = Box((0.4, 0.2, 0.3)[:ndim])
    turn = (lambda t: t) if ndim == 2 else (lambda t: (0.0, 0.3 * t, t))
    tool = Tool(shape=shape, shift=lambda t: (t, -t, 2 * t)[:ndim], angle=turn)
    x = points(ndim)
    expected = shape.moved((0.7, -0.7, 1.4)[:ndim], turn(0.7))
    assert np.array_equal(tool.at(0.7).distance(x), expected.distance(x))


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_ball_moved_straight_sweeps_a_capsule(ndim: int) -> None:
    ball = Disk(0.3) if ndim == 2 else Sphere(0.3)
    start, end = np.array([-0.5, 0.1, 0.2])[:ndim], np.array([0.6, -0.4, 0.3])[:ndim]
    tool = Tool(shape=ball, shift=lambda t: tuple(start + 0.5 * t * (end - start)))
    x = points(ndim)
    exact = Capsule(tuple(start), tuple(end), 0.3).distance(x)
    found = Swept(tool, 0.0, 2.0).distance(x)
    assert found == pytest.approx(exact, abs=2e-4)  # near the axis, where there is a kink
    surface = exact > -0.2
    assert found[surface] == pytest.approx(exact[surface], abs=2e-7)


def test_the_pace_decides_no_more_than_the_last_digits() -> None:
    """The closest moment is searched for between poses: no ridges are left between them."""
    tool = Tool(shape=Disk(0.2), shift=lambda t: (math.cos(t), math.sin(t)))
    x = points(2)
    ring = np.abs(np.hypot(*x) - 1.0) - 0.2  # of a whole turn
    x, ring = x[:, ring > -0.1], ring[ring > -0.1]
    for pace in (0.2, 0.05):
        found = Swept(tool, 0.0, 2 * math.pi, pace=pace).distance(x)
        assert np.abs(found - ring).max() < 0.02 * pace**2


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_turning_bar_sweeps_a_disk(ndim: int) -> None:
    """A bar that makes half a turn about its middle touches all within its half length."""
    bar = Box((1.6, 0.2, 0.4)[:ndim])
    angle = (lambda t: math.pi * t) if ndim == 2 else (lambda t: (0.0, 0.0, math.pi * t))
    swept = Swept(Tool(shape=bar, angle=angle), 0.0, 1.0)
    x = points(ndim)
    radius, height = np.hypot(x[0], x[1]), np.abs(x[2]) if ndim == 3 else np.zeros(x.shape[1])
    reach = math.hypot(0.8, 0.1)
    inside = (radius < reach) & (height < 0.2)
    clear = np.abs(radius - reach) > 1e-4
    assert np.array_equal((swept.distance(x) < 0)[clear], inside[clear])


@pytest.mark.parametrize("ndim", [2, 3])
def test_turning_agrees_with_moved_shapes(ndim: int) -> None:
    """The least distance over a thousand poses, each a moved shape of its own."""
    shape = Box((0.5, 0.2, 0.3)[:ndim])
    angle = (lambda t: 2 * t) if ndim == 2 else (lambda t: (t, 2 * t, -t))
    tool = Tool(shape=shape, shift=lambda t: (t, t * t, -t)[:ndim], angle=angle)
    x = points(ndim, 300)
    poses = np.min([tool.at(t).distance(x) for t in np.linspace(0.0, 1.0, 1001)], axis=0)
    found = Swept(tool, 0.0, 1.0).distance(x)
    assert found == pytest.approx(poses, abs=2e-3)
    assert np.all(found <= poses + 1e-4)


def test_a_tool_at_rest_sweeps_itself() -> None:
    x = points(2)
    swept = Swept(Tool(shape=Disk(0.3, center=(0.1, 0.2))), 0.0, 1.0)
    assert np.array_equal(swept.distance(x), Disk(0.3, center=(0.1, 0.2)).distance(x))


@pytest.mark.parametrize("beats", [1, 2, 3, 4, 8, 16])
def test_a_tool_that_is_back_at_every_even_look_sweeps_its_whole_way(beats: int) -> None:
    """Strokes that are over in halves, quarters, ... of the time: no look at rest is believed."""
    tool = Tool(shape=Disk(0.1), shift=lambda t: (0.5 * math.sin(2 * math.pi * beats * t), 0.0))
    low, high = Swept(tool, 0.0, 1.0).bounds()
    assert low[0] == pytest.approx(-0.6, abs=0.02)
    assert high[0] == pytest.approx(0.6, abs=0.02)
    x = points(2, 300, 0.7)
    exact = Capsule((-0.5, 0.0), (0.5, 0.0), 0.1).distance(x)
    found = Swept(tool, 0.0, 1.0).distance(x)
    assert found[exact > -0.05] == pytest.approx(exact[exact > -0.05], abs=2e-4)


@pytest.mark.parametrize("turns", [1, 2])
@pytest.mark.parametrize("ndim", [2, 3])
def test_whole_turns_are_seen(ndim: int, turns: int) -> None:
    """A bar that is back after whole turns touched all within its half length."""
    bar = Box((1.6, 0.2, 0.4)[:ndim])
    rate = 2 * math.pi * turns
    angle = (lambda t: rate * t) if ndim == 2 else (lambda t: (0.0, 0.0, rate * t))
    swept = Swept(Tool(shape=bar, angle=angle), 0.0, 1.0)
    x = points(ndim, 600)
    radius, height = np.hypot(x[0], x[1]), np.abs(x[2]) if ndim == 3 else np.zeros(x.shape[1])
    reach = math.hypot(0.8, 0.1)
    inside = (radius < reach) & (height < 0.2)
    clear = np.abs(radius - reach) > 1e-3
    assert np.array_equal((swept.distance(x) < 0)[clear], inside[clear])


@pytest.mark.parametrize("ndim", [2, 3])
def test_angles_may_jump_by_whole_turns(ndim: int) -> None:
    """atan2 jumps from pi to -pi where the tool just goes on."""
    bar = Box((0.6, 0.1, 0.2)[:ndim], center=(0.5, 0.0, 0.0)[:ndim])

    def wrapped(t: float) -> float | tuple[float, ...]:
        angle = math.atan2(math.sin(2.0 + 2 * t), math.cos(2.0 + 2 * t))
        return angle if ndim == 2 else (0.0, 0.0, angle)

    def whole(t: float) -> float | tuple[float, ...]:
        return 2.0 + 2 * t if ndim == 2 else (0.0, 0.0, 2.0 + 2 * t)

    x = points(ndim, 400, 1.0)
    ours = Swept(Tool(shape=bar, angle=wrapped), 0.0, 1.0).distance(x)
    assert ours == pytest.approx(
        Swept(Tool(shape=bar, angle=whole), 0.0, 1.0).distance(x), abs=1e-9
    )


def test_the_pace_follows_the_thickness_of_a_leaning_plate() -> None:
    plate = Box((0.02, 1.0)).moved(angle=0.7)
    tool = Tool(shape=plate, shift=lambda t: (t, 0.0))
    across = 0.5 * math.cos(0.7) * np.array([-math.tan(0.7), 1.0])
    ends = np.outer(np.linspace(-0.9, 0.9, 20), across)
    shifts = np.outer(np.linspace(0.0, 1.0, 301), (1.0, 0.0))
    x = (ends[:, None] + shifts).reshape(-1, 2).T
    assert np.all(Swept(tool, 0.0, 1.0).distance(x) < -0.5 * 0.02 + 1e-4)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_what_is_swept_is_a_shape(dtype: type) -> None:
    tool = Tool(shape=Disk(0.2), shift=lambda t: (t, 0.0))
    cut = Box((1.0, 1.0)) - Swept(tool, -1.0, 0.0)
    x = points(2).astype(dtype)
    assert cut.distance(x).dtype == dtype
    assert cut.distance(np.array([[-0.3, 0.4], [0.0, 0.0]], dtype)).tolist()[0] > 0
    low, high = Swept(tool, -1.0, 0.0).bounds()
    assert low[0] <= -1.2
    assert high[0] >= 0.2


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Tool(shape="knife"), "a tool needs a shape, got str"),
        (lambda: Tool(shape=Disk(0.1), shift=(1.0, 0.0)), "shift must be a law of time"),
        (
            lambda: Tool(shape=Disk(0.1), shift=lambda t: (t,)).at(0.0),
            r"Tool: shift\(0\) must hold",
        ),
        (
            lambda: Tool(shape=Disk(0.1), angle=lambda t: math.nan).at(1.0),
            r"Tool: angle\(1\) must hold 1 finite",
        ),
        (lambda: Swept(Tool(shape=Disk(0.1)), 1.0, 1.0), "start must come before stop"),
        (lambda: Swept(Tool(shape=Disk(0.1)), 0.0, 1.0, pace=0.0), "pace must be a positive"),
        (lambda: Tool(shape=Disk(0.1), shift=lambda t: "a").at(0.0), r"shift\(0\)\[0\] must be"),
        (lambda: Tool(shape=Disk(0.1), angle=lambda t: "a").at(0.0), "must be a number, got 'a'"),
        (lambda: Tool(shape=Disk(0.1), shift=lambda t: ((1, 2), (3,))).at(0.0), "must be a number"),
        (lambda: Tool(shape=Disk(0.1)).at("noon"), "time must be a number, got 'noon'"),
        (lambda: Tool(shape=Disk(0.1)).sweep(1.0, 0.0, 0.1), "a sweep goes on in time"),
        (lambda: Tool(shape=Disk(0.1)).sweep(0.0, 1.0, 0.0), "at a positive pace"),
        (lambda: Swept(Disk(0.1), 0.0, 1.0), "tool must be a Tool, got Disk"),
        (lambda: Swept(Tool(shape=Disk(0.1)), 0.0, 1.0, pace="a"), "pace must be a number"),
        (
            lambda: Tool(shape=Disk(0.1), shift=lambda t: (float(t > 0.3), 0.0)).sweep(0, 1, 0.01),
            "takes more than 100000 poses",
        ),
        (
            lambda: Tool(shape=Disk(0.1), shift=lambda t: (t, 0.0)).sweep(0.0, 1e9, 1e-3),
            "takes more than 100000 poses",
        ),
    ],
)
def test_tools_that_make_no_sense_are_refused(make, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()
