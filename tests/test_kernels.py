"""One law book for every kernel in the table."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from remesh.errors import InputError
from remesh.kernels import KERNELS, Kernel, check, get_kernel, moment, table

NAMES = list(KERNELS)


def derivative_at(piece, x, degree):
    """Exact derivative of a polynomial with coefficients from low to high order."""
    for _ in range(degree):
        piece = tuple(k * c for k, c in enumerate(piece))[1:]
    return sum((c * x**k for k, c in enumerate(piece)), Fraction(0))


@pytest.mark.parametrize("name", NAMES)
def test_every_kernel_keeps_the_moments_it_claims_and_no_more(name):
    kernel = KERNELS[name]
    check(kernel)
    offset = Fraction(1, 3)
    for power in range(kernel.moments + 1):
        assert moment(kernel, power, offset) == (power == 0)
    assert moment(kernel, kernel.moments + 1, offset) != 0


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 2e-5)])
@pytest.mark.parametrize("name", NAMES)
def test_evaluated_moments_are_kept_in_both_precisions(name, dtype, tolerance):
    kernel = KERNELS[name]
    for offset in np.linspace(0, 1, 33).astype(dtype):
        x = offset - np.arange(1 - kernel.half_width, kernel.half_width + 1).astype(dtype)
        weights = kernel(x)
        assert weights.dtype == dtype
        for power in range(kernel.moments + 1):
            # lengths in half widths, so that high moments are of the size of the weights
            found = np.sum(weights.astype(float) * (x.astype(float) / kernel.half_width) ** power)
            assert abs(found - (power == 0)) <= tolerance


@pytest.mark.parametrize("name", NAMES)
def test_every_kernel_has_the_regularity_it_claims_and_no_more(name):
    kernel = KERNELS[name]
    pieces = (*kernel.pieces, (Fraction(0),))
    jumps = []
    for degree in range(kernel.regularity + 2):
        at_nodes = [
            derivative_at(a, Fraction(i + 1), degree) - derivative_at(b, Fraction(i + 1), degree)
            for i, (a, b) in enumerate(pairwise(pieces))
        ]
        at_nodes.append(derivative_at(pieces[0], Fraction(0), degree) * (degree % 2))  # W is even
        jumps.append(any(jump != 0 for jump in at_nodes))
    assert not any(jumps[:-1])
    assert jumps[-1]


@pytest.mark.parametrize("name", NAMES)
def test_interpolating_kernels_are_one_at_zero_and_zero_at_other_nodes(name):
    kernel = KERNELS[name]
    values = [derivative_at(kernel.pieces[0], Fraction(0), 0)]
    values += [derivative_at(p, Fraction(i + 1), 0) for i, p in enumerate(kernel.pieces)]
    assert (values == [1] + [0] * kernel.half_width) == kernel.interpolating
    assert kernel.interpolating == (name != "M8'")


@pytest.mark.parametrize("name", NAMES)
def test_float_values_follow_the_exact_rationals(name):
    kernel = KERNELS[name]
    x = [Fraction(k, 16) for k in range(-16 * kernel.half_width - 16, 16 * kernel.half_width + 17)]
    exact = [
        float(derivative_at(kernel.pieces[int(abs(v))], abs(v), 0))
        if abs(v) < kernel.half_width
        else 0.0
        for v in x
    ]
    points = np.array([float(v) for v in x])
    np.testing.assert_allclose(kernel(points), exact, atol=2e-15)
    np.testing.assert_allclose(kernel(points.astype(np.float32)), exact, atol=2e-6)


def test_published_polynomials_are_in_the_table():
    # Monaghan 1985: M4' = 1 - 5/2 x^2 + 3/2 x^3, then (2 - x)^2 (1 - x) / 2
    x = np.linspace(0, 2, 41)
    near, far = 1 - 2.5 * x**2 + 1.5 * x**3, (2 - x) ** 2 * (1 - x) / 2
    np.testing.assert_allclose(KERNELS["M4'"](x), np.where(x < 1, near, far), atol=1e-15)
    assert KERNELS["M4'"].pieces == KERNELS["L2,1"].pieces
    assert KERNELS["M6'"].pieces == KERNELS["L4,2"].pieces
    assert KERNELS["M8'"].pieces[0][0] == Fraction(151, 168)


@pytest.mark.parametrize("name", NAMES)
def test_even_and_odd_halves_rebuild_the_taps(name):
    kernel = KERNELS[name]
    halves = table(kernel, np.dtype(np.float64))
    s = np.linspace(-0.5, 0.5, 9)[:-1]
    for i in range(kernel.half_width):
        even = np.polynomial.polynomial.polyval(s**2, halves[i, 0])
        odd = s * np.polynomial.polynomial.polyval(s**2, halves[i, 1])
        np.testing.assert_allclose(even + odd, kernel(i + 0.5 + s), atol=1e-14)
        np.testing.assert_allclose(even - odd, kernel(i + 0.5 - s), atol=1e-14)


def hat(**changes):
    """The linear interpolation kernel, as a user would write it."""
    given = {
        "name": "hat",
        "half_width": 1,
        "moments": 1,
        "regularity": 0,
        "pieces": ((1.0, -1.0),),
        "interpolating": True,
        "source": "linear interpolation",
    }
    return Kernel(**(given | changes))


def test_a_kernel_of_the_users_own_is_accepted_by_name_or_value():
    assert get_kernel(hat()).degree == 1
    assert get_kernel("M4'") is KERNELS["M4'"]
    assert get_kernel(KERNELS["L6,4"]) is KERNELS["L6,4"]


@pytest.mark.parametrize(
    ("kernel", "message"),
    [
        (hat(pieces=((0.75, -1.0),)), "weights do not sum to 1"),
        (hat(moments=2), "moment 2 is not kept"),
        (hat(half_width=2), "has 1 pieces"),
        (hat(pieces=((Fraction(1, 2),),), moments=0), "claims to interpolate"),
        (replace(KERNELS["M4'"], pieces=((1, 0, -2.5, 1.4), (2, -4, 2.5, -0.5))), "sum to 1"),
    ],
)
def test_a_kernel_that_is_not_what_it_claims_is_refused(kernel, message):
    with pytest.raises(InputError, match=message):
        get_kernel(kernel)


def test_unknown_names_are_refused_with_the_known_ones():
    with pytest.raises(InputError, match="unknown kernel 'M5'\n  try: one of \"M4'\", \"M6'\""):
        get_kernel("M5")
    with pytest.raises(InputError, match="unknown kernel 4"):
        get_kernel(4)
