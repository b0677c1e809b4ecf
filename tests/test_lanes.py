"""What loops do with a few neighbouring values at once."""

import numpy as np
import pytest
from numba import njit

from remesh._lanes import dot, load, none, plus, store, times


@njit
def _moved(values, factors, out, lanes):
    total = none(values, lanes)
    for k in range(3):
        total = plus(total, load(values, k, lanes), factors[k])
    store(times(total, factors[3]), out, 2)
    return dot(total, load(values, 0, lanes))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("count", [2, 8])
def test_lanes_are_loaded_multiplied_summed_and_stored_where_they_belong(dtype, count):
    values = np.arange(1, 13).astype(dtype)
    factors = np.array([2, -3, 5, 7], dtype)
    out = np.full(12, -1, dtype)
    found = _moved(values, factors, out, (0,) * count)
    expected = sum(factors[k] * values[k : k + count] for k in range(3))
    assert found == (expected * values[:count]).sum()
    np.testing.assert_array_equal(out[2 : 2 + count], 7 * expected)
    assert (out[:2] == -1).all()
    assert (out[2 + count :] == -1).all()
