"""Q and lambda-2: flows whose answer is known, what leaves them unchanged, what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import pmesh
from pmesh.vortex._criteria import middle_eigenvalue
from remesh.errors import InputError
from remesh.grid import Grid

SMALL = Grid((6, 5, 7), 0.25, (-0.5, 0.3, 1.0))
numbers = st.floats(-2.0, 2.0, allow_subnormal=False)
tensors = st.lists(numbers, min_size=9, max_size=9).map(lambda x: np.array(x).reshape(3, 3))


def linear(gradient: NDArray[Any], grid: Grid = SMALL, dtype: str = "float64") -> NDArray[Any]:
    """A velocity u_i = sum_j G_ij x_j."""
    return np.einsum("ij,j...->i...", gradient, grid.points()).astype(dtype)


def eigenvalue(gradient: NDArray[Any]) -> NDArray[Any]:
    """lambda-2 by LAPACK, of gradients (..., 3, 3)."""
    turned = np.swapaxes(gradient, -1, -2)
    strain, spin = 0.5 * (gradient + turned), 0.5 * (gradient - turned)
    return np.asarray(np.linalg.eigvalsh(strain @ strain + spin @ spin)[..., 1])


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_a_rigid_rotation_has_its_squared_rate_as_q_and_less_it_as_lambda2(dtype: str) -> None:
    rate = np.array([0.3, -0.5, 0.8])
    spin = np.cross(np.eye(3), rate)  # G x = rate x x
    assert spin @ np.array([1.0, 0, 0]) == pytest.approx(np.cross(rate, [1.0, 0, 0]))
    velocity = linear(spin, dtype=dtype)
    q, least = pmesh.q_criterion(velocity, SMALL), pmesh.lambda2(velocity, SMALL)
    assert (q.dtype, least.dtype) == (np.dtype(dtype), np.dtype(dtype))
    close = 1e-12 if dtype == "float64" else 1e-5
    assert q == pytest.approx(np.full(SMALL.shape, rate @ rate), rel=close)
    assert least == pytest.approx(np.full(SMALL.shape, -rate @ rate), rel=close)


def test_a_pure_strain_has_less_half_its_squared_rates_as_q_and_their_middle_one_as_lambda2() -> (
    None
):
    velocity = linear(np.diag([1.0, -1.5, 0.5]))
    assert pmesh.q_criterion(velocity, SMALL) == pytest.approx(np.full(SMALL.shape, -1.75))
    assert pmesh.lambda2(velocity, SMALL) == pytest.approx(np.full(SMALL.shape, 1.0))


def test_in_the_plane_q_is_less_a_quarter_of_okubo_weiss() -> None:
    grid = Grid((6, 8), 0.5)
    x, y = grid.points()
    velocity = np.stack([0.7 * x + 0.2 * y, 1.3 * x - 0.7 * y])
    weiss = (0.7 + 0.7) ** 2 + (1.3 + 0.2) ** 2 - (1.3 - 0.2) ** 2
    assert pmesh.q_criterion(velocity, grid) == pytest.approx(np.full(grid.shape, -weiss / 4))


@settings(max_examples=60, deadline=None)
@given(tensors)
def test_lambda2_of_any_gradient_is_the_middle_eigenvalue(gradient: NDArray[Any]) -> None:
    found = pmesh.lambda2(linear(gradient), SMALL)
    scale = max(1.0, float(np.abs(gradient).max()) ** 2)
    assert found == pytest.approx(np.full(SMALL.shape, eigenvalue(gradient)), abs=1e-11 * scale)


@settings(max_examples=30, deadline=None)
@given(
    tensors, st.lists(numbers, min_size=4, max_size=4), st.lists(numbers, min_size=3, max_size=3)
)
def test_a_turn_and_a_steady_motion_of_the_observer_change_nothing(
    gradient: NDArray[Any], quaternion: list[float], stream: list[float]
) -> None:
    turn, _ = np.linalg.qr(np.outer(quaternion[:3], quaternion[1:]) + np.diag([3.0, 4.0, 5.0]))
    here = linear(gradient)
    there = linear(turn @ gradient @ turn.T) + np.reshape(stream, (3, 1, 1, 1))
    for law in (pmesh.q_criterion, pmesh.lambda2):
        assert law(there, SMALL) == pytest.approx(law(here, SMALL), abs=1e-10)


@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_eigenvalues_that_nearly_agree_are_found_to_round_off(gap: float, side: float) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        turn, _ = np.linalg.qr(rng.standard_normal((3, 3)))
        known = np.array([1.0, 1.0 + gap, 1.0 + 0.8 * side])
        a = turn @ np.diag(known) @ turn.T
        found = middle_eigenvalue(a[0, 0], a[1, 1], a[2, 2], a[0, 1], a[0, 2], a[1, 2])
        assert found == pytest.approx(np.sort(known)[1], abs=4e-15)


def test_three_equal_eigenvalues_and_none_at_all() -> None:
    assert middle_eigenvalue(2.0, 2.0, 2.0, 0.0, 0.0, 0.0) == 2.0
    assert middle_eigenvalue(0.0, 0.0, 0.0, 0.0, 0.0, 0.0) == 0.0
    assert math.isnan(middle_eigenvalue(math.nan, 0.0, 0.0, 0.0, 0.0, 0.0))


def column(nodes: int) -> tuple[float, float]:
    """Largest errors of both criteria of a Lamb-Oseen column along a slanted periodic axis."""
    grid = Grid((nodes, 8, nodes), 6.0 / nodes, (-3.0, 0.0, -3.0),
                ("unbounded", "periodic", "unbounded"))  # fmt: skip
    x, _, z = grid.points()
    square = x**2 + z**2 + 1e-300
    turning = -np.expm1(-square) / square  # u_theta / r of circulation 2 pi, core 1
    velocity = np.stack([turning * z, 0 * x, -turning * x])  # about +y
    slope = 2 * np.exp(-square) - turning  # d u_theta / d r
    inner = (np.abs(x) < 2.5) & (np.abs(z) < 2.5)
    errors = (
        np.abs(found - exact)[inner].max()
        for found, exact in (
            (pmesh.q_criterion(velocity, grid), turning * slope),
            (pmesh.lambda2(velocity, grid), -turning * slope),
        )
    )
    return tuple(errors)  # type: ignore[return-value]


def test_a_lamb_oseen_column_is_known_in_closed_form_and_approached_at_order_four() -> None:
    coarse, fine = column(48), column(96)
    assert max(fine) < 2e-4
    for a, b in zip(coarse, fine, strict=True):
        assert math.log2(a / b) == pytest.approx(4.0, abs=0.2)


def abc(nodes: int) -> tuple[float, float]:
    """Largest errors of both criteria of the ABC flow with A, B, C = 1, 0.7, 0.4."""
    grid = Grid((nodes,) * 3, 2 * math.pi / nodes, boundary="periodic")
    a, b, c = 1.0, 0.7, 0.4
    x, y, z = grid.points()
    velocity = np.stack(
        [
            a * np.sin(z) + c * np.cos(y),
            b * np.sin(x) + a * np.cos(z),
            c * np.sin(y) + b * np.cos(x),
        ]
    )
    zero = 0 * x
    gradient = np.array(
        [
            [zero, -c * np.sin(y), a * np.cos(z)],
            [b * np.cos(x), zero, -a * np.sin(z)],
            [-b * np.sin(x), c * np.cos(y), zero],
        ]
    )
    square = np.einsum("ij...,ji...->...", gradient, gradient)
    least = eigenvalue(np.moveaxis(gradient, (0, 1), (-2, -1)))
    return (
        float(np.abs(pmesh.q_criterion(velocity, grid) + 0.5 * square).max()),
        float(np.abs(pmesh.lambda2(velocity, grid) - least).max()),
    )


def test_the_abc_flow_is_approached_at_order_four() -> None:
    for coarse, fine in zip(abc(24), abc(48), strict=True):
        assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.2)


def test_the_sum_of_q_over_a_periodic_box_is_zero_where_there_is_no_divergence() -> None:
    """Q is the divergence of -u . grad u / 2 then."""
    grid = Grid((16, 16, 16), 2 * math.pi / 16, boundary="periodic")
    x, y, z = grid.points()
    velocity = np.stack([np.sin(y + z), np.sin(x - z), np.cos(x + 2 * y)])
    q = pmesh.q_criterion(velocity, grid)
    assert abs(q.mean()) < 1e-14 * np.abs(q).max()


def test_threads_change_no_bit() -> None:
    velocity = np.random.default_rng(0).standard_normal((3, 9, 10, 11)).astype(np.float32)
    grid = Grid((9, 10, 11), 0.1, boundary=("periodic", "unbounded", "periodic"))
    for law in (pmesh.q_criterion, pmesh.lambda2):
        np.testing.assert_array_equal(
            law(velocity, grid, threads=1), law(velocity, grid, threads=2)
        )


def test_what_has_another_shape_is_refused() -> None:
    with pytest.raises(InputError, match=r"velocity must have shape \(3, 6, 5, 7\)"):
        pmesh.lambda2(np.zeros((6, 5, 7)), SMALL)
    with pytest.raises(InputError, match="lambda2 is of flows in space"):
        pmesh.lambda2(np.zeros((2, 6, 8)), Grid((6, 8), 0.5))
