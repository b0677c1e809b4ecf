"""One law book for every wavelet in the table, in exact arithmetic."""

from dataclasses import replace
from fractions import Fraction

import pytest
import sympy

from remesh.errors import InputError
from remesh.multires.wavelets import WAVELETS, Wavelet, check, filter_moment, get_wavelet

NAMES = list(WAVELETS)


def test_the_table_holds_the_seven_families():
    assert NAMES == ["2.0", "2.2", "4.0", "4.2", "4.4", "6.0", "6.2"]
    for name, wavelet in WAVELETS.items():
        assert wavelet.name == name == f"{wavelet.order}.{wavelet.moments}"
        assert wavelet.source
        check(wavelet)


@pytest.mark.parametrize("name", NAMES)
def test_polynomials_below_the_order_have_no_details_and_no_more_do(name):
    wavelet = WAVELETS[name]
    x = sympy.Symbol("x")  # the even node of the detail, anywhere on the line
    for degree in range(wavelet.order + 1):
        detail = sympy.expand(
            sum(sympy.Rational(w) * (x + j) ** degree for j, w in wavelet.g_dual().items())
        )
        assert (detail == 0) == (degree < wavelet.order)


@pytest.mark.parametrize("name", NAMES)
def test_the_wavelet_has_the_vanishing_moments_it_claims_and_no_more(name):
    wavelet = WAVELETS[name]
    for degree in range(wavelet.moments):
        assert filter_moment(wavelet.g(), degree, 1) == 0
    assert filter_moment(wavelet.g(), wavelet.moments, 1) != 0


@pytest.mark.parametrize("name", NAMES)
def test_scaling_functions_refine_into_polynomials(name):
    wavelet = WAVELETS[name]
    x = sympy.Symbol("x")
    for degree in range(wavelet.order):
        for parity in (0, 1):
            # sum over coarse nodes k of k^degree h_{j - 2k} at fine node j = 2x + parity
            refined = sum(
                sympy.Rational(w) * (x + sympy.Rational(parity - j, 2)) ** degree
                for j, w in wavelet.h().items()
                if j % 2 == parity
            )
            assert sympy.expand(refined - (x + sympy.Rational(parity, 2)) ** degree) == 0


@pytest.mark.parametrize("name", NAMES)
def test_scaling_functions_interpolate_and_coarse_values_keep_their_sum(name):
    wavelet = WAVELETS[name]
    assert {j: w for j, w in wavelet.h().items() if j % 2 == 0} == {0: 1}
    assert sum(wavelet.h().values()) == 2
    if wavelet.moments:
        assert sum(wavelet.h_dual().values()) == 1


def shifted(taps, k):
    return {j + 2 * k: w for j, w in taps.items()}


def paired(a, b):
    return sum((w * b[j] for j, w in a.items() if j in b), Fraction(0))


@pytest.mark.parametrize("name", NAMES)
def test_primal_and_dual_filters_are_biorthogonal(name):
    wavelet = WAVELETS[name]
    primal = {"c": wavelet.h(), "d": wavelet.g()}
    dual = {"c": wavelet.h_dual(), "d": wavelet.g_dual()}
    for i, a in dual.items():
        for j, b in primal.items():
            for k in range(-8, 9):
                assert paired(a, shifted(b, k)) == (i == j and k == 0)


@pytest.mark.parametrize("name", NAMES)
def test_a_fine_scaling_function_is_the_sum_of_its_coarse_parts(name):
    # zeta_k^{l+1} = sum_j h~ zeta_j^l + sum_j g~ psi_j^l, written on level l + 1
    wavelet = WAVELETS[name]
    for k in (0, 1):
        total = {}
        for analysis, synthesis in (
            (wavelet.h_dual(), wavelet.h()),
            (wavelet.g_dual(), wavelet.g()),
        ):
            for j in range(-12, 13):
                weight = analysis.get(k - 2 * j, 0)
                for node, value in shifted(synthesis, j).items():
                    total[node] = total.get(node, 0) + weight * value
        assert {node: value for node, value in total.items() if value} == {k: 1}


@pytest.mark.parametrize("name", NAMES)
def test_supports_follow_from_the_filters(name):
    wavelet = WAVELETS[name]
    scaling, lifted = wavelet.support
    # a fixed point: the support of zeta is the reach of h plus half of itself
    assert scaling == Fraction(max(wavelet.h()), 2) + Fraction(scaling) / 2
    assert lifted == Fraction(max(wavelet.g()) - 1, 2) + Fraction(scaling) / 2


def test_2_2_is_the_spline_pair_of_cohen_daubechies_and_feauveau():
    wavelet = WAVELETS["2.2"]
    eighths = {j: 8 * w for j, w in wavelet.h_dual().items()}
    assert eighths == {-2: -1, -1: 2, 0: 6, 1: 2, 2: -1}


def test_a_claim_that_is_not_true_is_refused():
    with pytest.raises(InputError, match="claims order 6 but degree 4"):
        get_wavelet(replace(WAVELETS["4.2"], name="mine", order=6))
    with pytest.raises(InputError, match="claims moments 4 but degree 2"):
        get_wavelet(replace(WAVELETS["4.2"], name="mine", moments=4))
    with pytest.raises(InputError, match="more than its order"):
        get_wavelet(replace(WAVELETS["2.2"], name="mine", moments=4))
    with pytest.raises(InputError, match="even number of weights"):
        get_wavelet(replace(WAVELETS["2.2"], name="mine", update=(Fraction(1, 2),)))


def test_an_unknown_wavelet_is_refused_with_the_names_there_are():
    with pytest.raises(InputError, match=r"unknown wavelet .haar."):
        get_wavelet("haar")
    with pytest.raises(InputError, match="one of"):
        get_wavelet(4.4)


def test_a_users_own_wavelet_works_after_its_claims_were_checked():
    dubuc = WAVELETS["6.0"].predict
    mine = Wavelet("6.6", 6, 6, dubuc, tuple(w / 2 for w in dubuc), "own")
    assert get_wavelet(mine) is mine
    assert get_wavelet("4.4") is WAVELETS["4.4"]
