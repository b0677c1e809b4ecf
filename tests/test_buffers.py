"""Arrays that a step takes and gives back."""

from __future__ import annotations

import numpy as np

from pmesh.vortex.buffers import Buffers


def test_what_was_given_back_is_taken_again():
    buffers = Buffers()
    one = buffers.take((3, 4, 5, 6), np.float64)
    buffers.give(one)
    assert buffers.take((3, 4, 5, 6), "float64") is one
    assert buffers.take((3, 4, 5, 6), "float64") is not one


def test_shape_and_precision_are_those_asked_for():
    buffers = Buffers()
    buffers.give(buffers.take((4, 6), np.float64))
    assert buffers.take((4, 6), np.float32).dtype == np.float32
    assert buffers.take((2, 4, 6), np.float64).shape == (2, 4, 6)


def test_an_array_given_back_twice_is_held_by_one_only():
    buffers = Buffers()
    one = buffers.take((4, 6), np.float64)
    buffers.give(one)
    buffers.give(one)
    buffers.give(None)
    first, second = (buffers.take((4, 6), np.float64) for _ in range(2))
    assert first is one
    assert second is not one


def test_arrays_of_another_mesh_are_let_go():
    buffers = Buffers()
    for old, new in (((4, 6), (4, 8)), ((4, 6), (5, 6)), ((3, 4, 5, 6), (3, 8, 5, 6))):
        buffers.give(buffers.take(old, np.float64))
        buffers.take(new, np.float64)
        assert not buffers._spare


def test_fields_and_velocities_of_one_plane_mesh_are_kept_together():
    buffers = Buffers()
    field, velocity = buffers.take((4, 6), float), buffers.take((2, 4, 6), float)
    buffers.give(field)
    buffers.give(velocity)
    assert buffers.take((2, 4, 6), float) is velocity
    assert buffers.take((4, 6), float) is field
