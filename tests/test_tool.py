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
        (
            lambda: Tool(shape=Disk(0.1), shift=lambda t: (t, 0.0)).sweep(0.0, 1e9, 1e-3),
            "takes more than 100000 poses",
        ),
    ],
)
def test_tools_that_make_no_sense_are_refused(make, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()
