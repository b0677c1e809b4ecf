"""Kernels matched to scaling functions are convolutions with them, and point kernels far away."""

import numpy as np
import pytest

from pmesh.spectral.matched import (
    kernel_values,
    matched_kernel,
    point_kernel,
)
from remesh.errors import InputError

# interpolation midway between nodes: Deslauriers & Dubuc, Constr. Approx. 5 (1989) 49
MIDWAY = {
    2: np.array([1, 1]) / 2,
    4: np.array([-1, 9, 9, -1]) / 16,
    6: np.array([3, -25, 150, 150, -25, 3]) / 256,
    8: np.array([-5, 49, -245, 1225, 1225, -245, 49, -5]) / 2048,
}


def scaling_function(order, halvings):
    """Values at multiples of 2^-halvings, from -order + 1 on, by the refinement relation."""
    half = order - 1
    values = np.zeros(2 * half + 1)
    values[half] = 1.0
    for _ in range(halvings):
        finer = np.zeros(2 * values.size - 1)
        finer[::2] = values
        wide = np.pad(values, order // 2)
        finer[1::2] = sum(w * wide[1 + k : values.size + k] for k, w in enumerate(MIDWAY[order]))
        values = finer
    return values


def by_quadrature(order, offset, halvings):
    """The integral of K(offset - y) zeta(y) over dyadic points."""
    line = scaling_function(order, halvings)
    step = 0.5**halvings
    y = step * np.arange(line.size) - (order - 1)
    ndim = len(offset)
    nodes = np.meshgrid(*(n - y for n in offset), indexing="ij", sparse=True)
    weights = line if ndim == 1 else np.multiply.outer(line, line)
    if ndim == 3:
        weights = np.multiply.outer(weights, line)
    return float((point_kernel(nodes) * weights).sum() * step**ndim)


@pytest.mark.parametrize("order", [2, 4, 6, 8])
def test_the_kernel_outside_the_scaling_function_is_its_convolution_in_the_plane(order):
    known = matched_kernel(order, 2)
    middle = known.shape[0] // 2
    for offset in ((order + 1, 0), (order, 3), (order + 3, -order)):
        value = known[middle + offset[0], middle + offset[1]]
        tolerance = 1e-9 if order > 2 else 1e-6
        assert value == pytest.approx(by_quadrature(order, offset, 6), abs=tolerance)


@pytest.mark.parametrize("offset", [(1, 0), (1, 1), (2, -1)])
def test_the_kernel_inside_the_scaling_function_is_its_convolution_too(offset):
    known = matched_kernel(4, 2)
    middle = known.shape[0] // 2
    value = known[middle + offset[0], middle + offset[1]]
    assert value == pytest.approx(by_quadrature(4, offset, 8), abs=2e-5)


def test_the_kernel_in_space_is_the_convolution_with_the_scaling_function():
    known = matched_kernel(4, 3)
    middle = known.shape[0] // 2
    for offset in ((5, 0, 0), (4, 2, -1)):
        value = known[tuple(middle + n for n in offset)]
        assert value == pytest.approx(by_quadrature(4, offset, 4), abs=1e-7)


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("order", [2, 4, 8])
def test_the_kernel_refines_like_the_scaling_function(order, ndim):
    known = matched_kernel(order, ndim)
    middle, half = known.shape[0] // 2, order - 1
    taps = np.zeros(2 * half + 1)
    taps[half] = 1.0
    taps[::2] = MIDWAY[order]
    for offset in ((1, 0, 0), (2, 1, 1), (3, 0, 2)):
        parts = known[tuple(slice(middle + 2 * n - half, middle + 2 * n + half + 1)
                            for n in offset[:ndim])]  # fmt: skip
        for _ in range(ndim):
            parts = parts @ taps
        value = known[tuple(middle + n for n in offset[:ndim])]
        assert value == pytest.approx(parts / 2, abs=1e-14)


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("order", [4, 8])
def test_the_kernel_nears_the_point_kernel_with_the_moments_of_the_scaling_function(order, ndim):
    known = matched_kernel(order, ndim)
    middle = known.shape[0] // 2
    near, far = 8, 16
    apart = []
    for n in (near, far):
        offset = (np.array(float(n)), *(np.array(0.0),) * (ndim - 1))
        place = (middle + n, *(middle,) * (ndim - 1))
        apart.append(abs(known[place] - point_kernel(offset)))
    assert np.log2(apart[0] / apart[1]) == pytest.approx(ndim - 1 + order, abs=0.5)


@pytest.mark.parametrize("ndim", [2, 3])
def test_the_kernel_is_odd_along_its_axis_and_even_along_others(ndim):
    values = kernel_values(4, ndim, 6)
    assert np.allclose(values, -values[::-1], atol=1e-15)
    assert np.allclose(values, values[:, ::-1], atol=1e-15)
    assert np.allclose(values, np.swapaxes(values, 1, ndim - 1), atol=1e-15)


def test_values_go_on_beyond_the_table_as_the_point_kernel():
    values = kernel_values(4, 2, 140)
    assert values.shape == (281, 281)
    assert values[-1, 140] == pytest.approx(-1 / (2 * np.pi * 140), rel=1e-14)
    assert np.array_equal(values[12:-12, 12:-12], matched_kernel(4, 2))


def test_orders_that_are_not_there_are_refused():
    with pytest.raises(InputError, match="order must be one of"):
        matched_kernel(5, 2)
