"""Moments of scaling functions near the ends, exactly."""

from fractions import Fraction

import pytest

from remesh.multires.ends import Moments
from remesh.multires.lines import coarser, leaning_predict
from remesh.multires.wavelets import WAVELETS


@pytest.mark.parametrize("nodes", [24, 33])
@pytest.mark.parametrize("name", ["2.2", "4.2", "4.4", "6.2"])
def test_moments_are_those_of_the_summed_scaling_functions(name, nodes):
    wavelet = WAVELETS[name]
    moments = Moments(wavelet.moments, nodes, Fraction(nodes - 1))
    functions = [{i: Fraction(1)} for i in range(nodes)]
    for _ in range(2):
        coarse = coarser(len(functions), False)
        predict = leaning_predict(wavelet, len(functions) - coarse, coarse, moments.end)
        last = len(functions) - 1
        grown = [dict(functions[min(2 * k, last)]) for k in range(coarse)]
        for i in range(len(functions) - coarse):
            row = predict.special.get(i) or {
                i + predict.shift + m: w for m, w in enumerate(predict.weights)
            }
            for k, weight in row.items():
                for node, value in functions[2 * i + 1].items():
                    grown[k][node] = grown[k].get(node, Fraction(0)) + weight * value
        moments = moments.coarser(wavelet, predict, coarse)
        functions = grown
        for k, function in enumerate(functions):
            for a in range(wavelet.moments):
                assert moments[k][a] == sum(node**a * value for node, value in function.items())


def test_only_functions_near_the_ends_are_irregular():
    wavelet = WAVELETS["4.4"]
    moments = Moments(4, 400, Fraction(399))
    predict = leaning_predict(wavelet, 199, 201, moments.end)
    above = moments.coarser(wavelet, predict, 201)
    assert all(k < 6 or k > 194 for k in above.near)
    assert above.near
    assert above.end == Fraction(399, 2)
