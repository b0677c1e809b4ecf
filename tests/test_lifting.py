"""Rows of lifting steps as matrices and as tables."""

from fractions import Fraction

import numpy as np

from remesh.multires.lifting import Rows, whole, wrapped

HALF = Fraction(1, 2)


def test_wrapped_rows_are_circulant():
    rows = wrapped((Fraction(1, 4), Fraction(3, 4)), -1, 5)
    matrix = rows.matrix(5, 5)
    expected = [np.roll([0.75, 0, 0, 0, 0.25], i) for i in range(5)]
    np.testing.assert_array_equal(matrix, expected)


def test_wrapped_rows_longer_than_the_line_add_up():
    matrix = wrapped((Fraction(1),) * 4, -1, 2).matrix(2, 2)
    np.testing.assert_array_equal(matrix, [[2, 2], [2, 2]])


def test_tables_hold_the_special_rows_in_order():
    rows = Rows((HALF, HALF), 0, 0, 2, {3: {2: Fraction(1), 0: Fraction(-1)}, 2: {1: HALF}})
    weights, shift, first, last, index, starts, columns, values = rows.arguments(
        np.dtype(np.float32)
    )
    assert (shift, first, last) == (0, 0, 2)
    assert weights.dtype == values.dtype == np.float32
    assert index.tolist() == [2, 3]
    assert starts.tolist() == [0, 1, 3]
    assert columns.tolist() == [1, 0, 2]
    assert values.tolist() == [0.5, -1, 1]


def test_whole_rows_have_all_their_taps_on_the_line():
    assert whole(4, -1, 10, 11) == (1, 9)
    assert whole(4, -1, 2, 3) == (1, 1)
