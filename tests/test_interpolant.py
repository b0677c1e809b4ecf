"""The cubic interpolant of nodal values: exactness, joining, edges, gaps, kinks."""

import math

import numpy as np
import pytest

from levelset import _interpolant as law
from levelset._kinks import SEEN, find_kinks

N = 9


def _nodes(ndim, function, dtype=np.float64):
    axes = np.meshgrid(*[np.arange(N, dtype=float)] * ndim, indexing="ij")
    return np.ascontiguousarray(function(*axes), dtype).reshape(-1)


def _gradient(flat, point, *, wraps=False, gaps=False, kinds=None):
    ndim = len(point)
    call = law.gradient2 if ndim == 2 else law.gradient3
    return call(flat, (N,) * ndim, (wraps,) * ndim, gaps, *point, kinds)


def _hessian(flat, point):
    ndim = len(point)
    call = law.hessian2 if ndim == 2 else law.hessian3
    return call(flat, (N,) * ndim, (False,) * ndim, False, *point)


def _cubic2(x, y):
    return 1 + x - 2 * y + 0.1 * x**3 * y**2 - 0.02 * y**3 * x


def _cubic3(x, y, z):
    return x**3 * z + y**2 * z**2 - 0.1 * x * y * z**3


@pytest.mark.parametrize(("dtype", "digits"), [(np.float64, 1e-12), (np.float32, 2e-6)])
def test_cubics_are_reproduced_with_their_derivatives(dtype, digits):
    rng = np.random.default_rng(0)
    plane, space = _nodes(2, _cubic2, dtype), _nodes(3, _cubic3, dtype)
    for x, y, z in rng.uniform(0, N - 1, (20, 3)):
        told = (*_gradient(plane, (x, y)), *_hessian(plane, (x, y)))
        asked = (
            _cubic2(x, y),
            1 + 0.3 * x**2 * y**2 - 0.02 * y**3,
            -2 + 0.2 * x**3 * y - 0.06 * y**2 * x,
            0.6 * x * y**2,
            0.6 * x**2 * y - 0.06 * y**2,
            0.2 * x**3 - 0.12 * y * x,
        )
        np.testing.assert_allclose(told, asked, rtol=0, atol=digits * abs(plane).max())
        told = (*_gradient(space, (x, y, z)), *_hessian(space, (x, y, z)))
        asked = (
            _cubic3(x, y, z),
            3 * x**2 * z - 0.1 * y * z**3,
            2 * y * z**2 - 0.1 * x * z**3,
            x**3 + 2 * y**2 * z - 0.3 * x * y * z**2,
            6 * x * z,
            2 * z**2,
            2 * y**2 - 0.6 * x * y * z,
            -0.1 * z**3,
            3 * x**2 - 0.3 * y * z**2,
            4 * y * z - 0.3 * x * z**2,
        )
        np.testing.assert_allclose(told, asked, rtol=0, atol=digits * abs(space).max())


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("wraps", [False, True])
def test_values_join_from_cell_to_cell(ndim, wraps):
    rng = np.random.default_rng(1)
    flat = rng.normal(size=N**ndim)
    for point in rng.uniform(0, N - 1, (20, ndim)):
        for axis in range(ndim):
            for face in (0.0, 1.0, 4.0, N - 2.0):
                below, above = point.copy(), point.copy()
                below[axis], above[axis] = face - 1e-11, face + 1e-11
                low = _gradient(flat, tuple(below), wraps=wraps)[0]
                assert low == pytest.approx(_gradient(flat, tuple(above), wraps=wraps)[0], abs=1e-8)


@pytest.mark.parametrize("ndim", [2, 3])
def test_periodic_axes_wrap(ndim):
    flat = np.random.default_rng(2).normal(size=N**ndim)
    point = np.array([0.3, 8.6, -0.2])[:ndim]
    here = _gradient(flat, tuple(point), wraps=True)
    np.testing.assert_allclose(_gradient(flat, tuple(point + N), wraps=True), here, atol=1e-12)
    np.testing.assert_allclose(_gradient(flat, tuple(point - 2 * N), wraps=True), here, atol=1e-12)


@pytest.mark.parametrize("ndim", [2, 3])
def test_beyond_an_unbounded_edge_the_interpolant_goes_on_straight(ndim):
    flat = _nodes(ndim, _cubic2 if ndim == 2 else _cubic3)
    edge = np.array([N - 1.0, 3.3, 4.4][:ndim])
    value, *gradient = _gradient(flat, tuple(edge))
    beyond = edge + [2.5, 0.0, 0.0][:ndim]
    assert _gradient(flat, tuple(beyond))[0] == pytest.approx(value + 2.5 * gradient[0], rel=1e-12)


@pytest.mark.parametrize("ndim", [2, 3])
def test_the_error_is_of_fourth_order_and_that_of_the_gradient_of_third(ndim):
    point = np.array([4.37, 4.61, 4.23][:ndim])
    errors = []
    for step in (0.1, 0.05):
        flat = _nodes(ndim, lambda *x, h=step: np.sin((sum(x) - point.sum()) * h + 0.7))
        value, slope, *_ = _gradient(flat, tuple(point))
        errors.append((abs(value - math.sin(0.7)), abs(slope / step - math.cos(0.7))))
    value, gradient = np.log2(np.array(errors[0]) / errors[1])
    assert 3.8 < value < 4.3
    assert 2.8 < gradient < 3.3


@pytest.mark.parametrize("ndim", [2, 3])
def test_beside_unset_nodes_cells_are_multilinear_and_without_corners_nothing_is_told(ndim):
    flat = _nodes(ndim, lambda *x: 1 + x[0] + 2 * x[0] * x[1] - x[-1])
    field = flat.reshape((N,) * ndim)
    point = np.array([3.4, 3.7, 3.2][:ndim])
    asked = 1 + point[0] + 2 * point[0] * point[1] - point[-1]
    field[5] = 0.0  # unset
    told = _gradient(flat, tuple(point), gaps=True)
    assert told[0] == pytest.approx(asked, rel=1e-12)
    assert told[2] == pytest.approx(2 * point[0] - (ndim == 2), rel=1e-12)
    field[4] = 0.0
    assert np.isnan(_gradient(flat, tuple(point), gaps=True)[0])


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_kink_in_the_next_cell_is_left_out(ndim):
    flat = _nodes(ndim, lambda *x: np.abs(x[0] - 4.6) - 0.9)  # zero in the cells 3 and 5
    kinds = np.zeros(N**ndim, np.uint8)
    shape = (N, N, N) if ndim == 3 else (N, 1, N)
    nodes = np.flatnonzero(np.abs(flat) < 1)
    find_kinks(0, 1, 1, len(nodes), flat, shape, (False,) * 3, False, 1.0, nodes, kinds)
    inner = np.array([0.0, 4.3, 4.6][:ndim])
    for x in (3.7, 5.5):
        point = (x, *inner[1:])
        exact = abs(x - 4.6) - 0.9
        assert _gradient(flat, point, kinds=kinds)[0] == pytest.approx(exact, abs=1e-12)
        assert abs(_gradient(flat, point)[0] - exact) > 0.01


def test_smooth_cells_are_marked_as_seen_and_nothing_else():
    flat = _nodes(2, lambda x, y: np.hypot(x - 4, y - 12) - 8)
    kinds = np.zeros(N**2, np.uint8)
    nodes = np.flatnonzero(np.abs(flat) < 1)
    find_kinks(0, 1, 1, len(nodes), flat, (N, 1, N), (False,) * 3, False, 1.0, nodes, kinds)
    assert set(kinds) == {0, SEEN}
