"""Flow maps: on flows whose paths, maps and exponents are known exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from pmesh.vortex.flowmap import VelocityHistory, flow_map, ftle, streaklines, tracers
from remesh.errors import InputError
from remesh.grid import Grid

RATE = 0.7
SPIN = 1.3


@dataclass
class Shot:
    time: float
    grid: Grid
    velocity: np.ndarray

    def __getitem__(self, name: str) -> Any:
        return {"velocity": self.velocity}[name]


def history(law: Any, grid: Grid, times: Any, dtype: Any = np.float64) -> VelocityHistory:
    """Snapshots of velocity = law(points, time)."""
    return VelocityHistory([Shot(t, grid, np.asarray(law(grid.points(), t), dtype)) for t in times])


def saddle(time: float, x: np.ndarray) -> np.ndarray:
    return x * np.array([RATE, -RATE, 0.0][: x.shape[1]])


def rotation(time: float, x: np.ndarray) -> np.ndarray:
    return np.stack([-SPIN * x[:, 1], SPIN * x[:, 0], *np.zeros((x.shape[1] - 2, len(x)))], 1)


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("span", [1.5, -1.5])
def test_the_exponent_of_a_saddle_is_its_rate_of_strain(ndim: int, span: float) -> None:
    grid = Grid((9,) * ndim, 0.25, (-1.0,) * ndim)
    assert ftle(saddle, grid, 0.3, span, steps=40) == pytest.approx(RATE, rel=1e-6)


@pytest.mark.parametrize("ndim", [2, 3])
def test_the_exponent_of_a_rigid_rotation_is_zero(ndim: int) -> None:
    grid = Grid((9,) * ndim, 0.25, (-1.0,) * ndim)
    assert np.abs(ftle(rotation, grid, 0.0, 4.0, steps=200)).max() < 1e-7


def test_the_exponent_of_a_shear_is_the_exact_one_of_its_finite_time() -> None:
    """u = s y: sigma^2 is the larger root of q^2 - (2 + (s T)^2) q + 1."""
    s, span = 0.8, 2.5
    grid = Grid((8, 8), 0.5, (-2.0, -2.0), ("periodic", "unbounded"))
    found = ftle(lambda t, x: np.stack([s * x[:, 1], 0 * x[:, 0]], 1), grid, 0.0, span, steps=3)
    b = 2 + (s * span) ** 2
    assert found == pytest.approx(0.5 * math.log(0.5 * (b + math.sqrt(b * b - 4))) / span)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_linear_flow_is_exact_through_snapshots_too(dtype: Any) -> None:
    grid = Grid((33, 33), 0.25, (-4.0, -4.0))
    shots = history(lambda x, t: RATE * np.stack([x[0], -x[1]]), grid, [0.0, 0.4, 0.9, 1.0], dtype)
    small = Grid((5, 7), 0.2, (-0.4, -0.6))
    accuracy = 1e-5 if dtype == np.float32 else 1e-6
    assert ftle(shots, small, 0.0, 1.0) == pytest.approx(RATE, rel=accuracy)
    moved = flow_map(shots, small, 1.0, 0.0)
    x, y = small.points()
    assert moved[0] == pytest.approx(x * math.exp(-RATE), abs=accuracy)
    assert moved[1] == pytest.approx(y * math.exp(RATE), abs=accuracy)


def test_a_flow_map_in_space_is_exact_for_a_rotation() -> None:
    grid = Grid((5, 5, 5), 0.25)
    x, y, z = grid.points()
    moved = flow_map(rotation, grid, 0.0, 2.0, steps=100)
    c, s = math.cos(2 * SPIN), math.sin(2 * SPIN)
    assert moved == pytest.approx(np.stack([c * x - s * y, s * x + c * y, z]), abs=1e-7)


def test_paths_go_the_way_of_the_velocity_and_back() -> None:
    """Handedness: a positive rotation carries (1, 0) to (0, 1) in a quarter turn."""
    quarter = 0.5 * math.pi / SPIN
    path = tracers(rotation, [(1.0, 0.0)], [0.0, quarter, 2 * quarter, 0.0], steps=100)
    assert path[:, 0] == pytest.approx(np.array([(1, 0), (0, 1), (-1, 0), (1, 0)]), abs=1e-7)


def test_paths_are_of_fourth_order_in_the_steps() -> None:
    errors = [
        np.abs(tracers(rotation, [(1.0, 0.0)], [0, 2], steps=n)[-1, 0]
               - [math.cos(2 * SPIN), math.sin(2 * SPIN)]).max()
        for n in (20, 40)
    ]  # fmt: skip
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)


def test_velocity_between_snapshots_is_of_fourth_order_in_their_time() -> None:
    grid = Grid((8, 8), 1.0)
    errors = []
    for n in (11, 21):
        shots = history(
            lambda x, t: np.stack([np.sin(t) + 0 * x[0], 0 * x[0]]), grid, np.linspace(0, 5, n)
        )
        asked = np.linspace(0.5, 4.5, 97)
        point = np.array([[3.3, 4.4]])
        errors.append(max(abs(shots(t, point)[0, 0] - math.sin(t)) for t in asked))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_velocity_between_nodes_is_of_third_order_in_the_mesh() -> None:
    errors = []
    for n in (16, 32, 64):
        grid = Grid((n, n), 2 * math.pi / n, boundary="periodic")
        shots = history(lambda x, t: np.stack([np.sin(x[1]), np.cos(x[0])]), grid, [0.0, 1.0])
        points = np.random.default_rng(4).random((500, 2)) * 30 - 15  # wraps
        exact = np.stack([np.sin(points[:, 1]), np.cos(points[:, 0])], axis=1)
        errors.append(np.abs(shots(0.5, points) - exact).max())
    assert math.log2(errors[1] / errors[2]) == pytest.approx(3.0, abs=0.2)


def test_meshes_that_move_between_snapshots_give_one_flow() -> None:
    shots = []
    for k, t in enumerate(np.linspace(0, 1, 5)):
        grid = Grid((24 + 2 * k, 24), 0.25, (-3.0 + 0.5 * k, -3.0))
        x, y = grid.points()
        shots.append(Shot(t, grid, RATE * np.stack([x, -y])))
    positions = np.array([(0.7, 0.3), (1.1, -0.4)])
    ends = tracers(VelocityHistory(shots), positions, [0, 1])[-1]
    assert ends == pytest.approx(positions * [math.exp(RATE), math.exp(-RATE)], rel=1e-6)


def test_beyond_the_mesh_the_velocity_is_that_of_its_nearest_point() -> None:
    grid = Grid((8, 8), 0.5)
    shots = history(lambda x, t: np.stack([1 + x[0], x[1]]), grid, [0.0, 1.0])
    assert shots(0.5, np.array([[9.0, 1.25], [2.0, -7.0]])) == pytest.approx(
        np.array([[4.5, 1.25], [3.0, 0.0]])
    )


def test_dye_in_a_steady_stream_lies_on_the_streamline_oldest_farthest() -> None:
    dye = streaklines(
        lambda t, x: np.full_like(x, 2.0) * [1, 0], [(0.0, 0.5)], 1.0, 3.0, releases=5, steps=1
    )
    assert dye.released == pytest.approx([1, 1.5, 2, 2.5, 3])
    assert dye.positions[:, 0, 0] == pytest.approx([4, 3, 2, 1, 0])
    assert dye.positions[:, 0, 1] == pytest.approx(0.5)


def test_dye_in_an_unsteady_stream_is_its_streakline_not_a_path() -> None:
    """v = (1, cos t): dye that left the origin at s is at (t - s, sin t - sin s)."""
    dye = streaklines(
        lambda t, x: np.stack([np.ones(len(x)), np.full(len(x), math.cos(t))], 1),
        [(0.0, 0.0)], 0.0, 5.0, releases=21, steps=4,
    )  # fmt: skip
    s = dye.released
    assert dye.positions[:, 0, 0] == pytest.approx(5 - s)
    assert dye.positions[:, 0, 1] == pytest.approx(math.sin(5) - np.sin(s), abs=2e-8)


def test_what_cannot_be_followed_is_refused() -> None:
    grid = Grid((8, 8), 0.5)
    shots = history(lambda x, t: x, grid, [0.0, 1.0])
    with pytest.raises(InputError, match=r"span t = 0 to 1, asked for 1\.5"):
        shots(1.5, np.zeros((1, 2)))
    with pytest.raises(InputError, match="two snapshots"):
        history(lambda x, t: x, grid, [0.0])
    with pytest.raises(InputError, match="span must be a time other than 0"):
        ftle(saddle, grid, 0.0, 0.0)
    with pytest.raises(InputError, match="needs a number of steps"):
        flow_map(saddle, grid, 0.0, 1.0)
    with pytest.raises(InputError, match="steps must be at least 1"):
        flow_map(saddle, grid, 0.0, 1.0, steps=0)
    with pytest.raises(InputError, match="must be finite and have shape"):
        tracers(saddle, np.zeros((2, 5)), [0.0, 1.0], steps=1)
    with pytest.raises(InputError, match="two releases"):
        streaklines(saddle, [(0.0, 0.0)], 1.0, 0.0)
