"""Lines of nodes: what their splits keep, ends included."""

import numpy as np
import pytest

from remesh.multires.lines import halvings, node_ages, split_line
from remesh.multires.wavelets import WAVELETS

NAMES = list(WAVELETS)
LENGTHS = (5, 6, 9, 12, 13, 33, 40, 64, 66, 97)


def dense(split):
    """Coarse nodes, details' nodes, and the two steps as matrices."""
    last = [split.nodes - 1] if split.coarse > (split.nodes + 1) // 2 else []
    kept = [*range(0, split.nodes, 2), *last]
    details = [i for i in range(split.nodes) if i not in kept]
    predict = split.predict.matrix(split.details, split.coarse)
    update = split.update.matrix(split.coarse, split.details)
    return kept, details, predict, update


def lines(wavelet, periodic=False):
    for nodes in LENGTHS:
        levels = halvings(wavelet, nodes, periodic)
        if levels:
            yield nodes, levels, split_line(wavelet, nodes, periodic, levels)


def wavelets_of(nodes, splits):
    """All wavelets, (finest nodes, details), level by level, and the coarsest functions."""
    functions = np.eye(nodes)
    found = []
    for split in splits:
        kept, details, predict, update = dense(split)
        coarse = functions[:, kept] + functions[:, details] @ predict
        found.append(functions[:, details] - coarse @ update)
        functions = coarse
    return found, functions


@pytest.mark.parametrize("name", NAMES)
def test_polynomials_below_the_order_have_no_details_up_to_the_ends(name):
    wavelet = WAVELETS[name]
    for nodes, _, splits in lines(wavelet):
        x = np.linspace(-1, 1, nodes)
        for split in splits:
            kept, details, predict, _ = dense(split)
            for degree in range(wavelet.order):
                detail = x[details] ** degree - predict @ x[kept] ** degree
                assert np.abs(detail).max() <= 1e-13
            x = x[kept]


@pytest.mark.parametrize("name", NAMES)
def test_all_wavelets_of_a_line_with_ends_have_their_vanishing_moments(name):
    wavelet = WAVELETS[name]
    for nodes, _, splits in lines(wavelet):
        x = np.linspace(0, 1, nodes)
        for level in wavelets_of(nodes, splits)[0]:
            for degree in range(wavelet.moments):
                assert np.abs(x**degree @ level).max() <= 1e-12


@pytest.mark.parametrize("name", NAMES)
def test_all_wavelets_of_a_periodic_line_have_no_mean(name):
    wavelet = WAVELETS[name]
    for nodes, _, splits in lines(wavelet, periodic=True):
        for level in wavelets_of(nodes, splits)[0]:
            if wavelet.moments:
                assert np.abs(level.sum(axis=0)).max() <= 1e-13


@pytest.mark.parametrize("name", NAMES)
def test_wavelets_near_the_ends_are_not_larger_than_elsewhere(name):
    wavelet = WAVELETS[name]
    for nodes, _, splits in lines(wavelet):
        found, coarsest = wavelets_of(nodes, splits)
        assert max(np.abs(level).max() for level in found) <= 1.3
        assert np.abs(coarsest).sum(axis=1).max() <= 3.2


def test_updates_away_from_the_ends_are_the_wavelets_own():
    wavelet = WAVELETS["4.4"]
    for split in split_line(wavelet, 257, False, 3):
        assert split.update.last - split.update.first >= split.coarse - 18
        assert split.predict.last - split.predict.first >= split.details - 3


def test_long_lines_are_split_in_little_time_and_memory():
    splits = split_line(WAVELETS["4.4"], 5000, False, 10)
    assert max(len(split.update.special) for split in splits) <= 20


def test_end_nodes_stay_to_the_coarsest_level():
    for nodes in (33, 40, 64):
        ages = node_ages(nodes, False, 3)
        assert ages[0] == ages[-1] == 3
        assert ages[1] == 0
        assert ages[2] == 1
    assert node_ages(16, True, 2).tolist() == [2, 0, 1, 0] * 4


def test_a_line_is_split_as_often_as_its_nodes_allow():
    wavelet = WAVELETS["4.4"]
    assert halvings(wavelet, 64, True) == 4  # 64 32 16 8 4
    assert halvings(wavelet, 48, True) == 3  # 48 24 12 6, and 3 are too few
    assert halvings(wavelet, 50, True) == 1  # 25 is odd
    assert halvings(wavelet, 33, True) == 0
    assert halvings(wavelet, 65, False) == 4  # 65 33 17 9 5
    assert halvings(wavelet, 64, False) == 4
    assert halvings(wavelet, 5, False) == 0
    assert halvings(WAVELETS["2.0"], 4, False) == 1  # 4 3
