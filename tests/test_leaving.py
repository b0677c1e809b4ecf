"""Laws of what leaves an adaptive mesh: sums of the coarsest level, and where more is asked."""

import numpy as np
import pytest
from nested_blocks import nested, recipe

from remesh.multires.leaving import at_ends, coarsest_sums, matter


@pytest.mark.parametrize("ndim", [2, 3])
def test_sums_are_those_of_the_coarsest_level_in_double_precision(ndim):
    blocks = nested(recipe(64, ndim, 1), (0.5,) * ndim, 0.1)
    values = np.full((2, *blocks.shape), 0.1, np.float32)
    values[:, blocks.starts[1] :] = 7
    found = coarsest_sums(values, blocks)
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, 32**ndim * float(np.float32(0.1)), rtol=1e-12)
    assert coarsest_sums(values[0], blocks).shape == (1,)


@pytest.mark.parametrize("place", [0.0, 1.0])
@pytest.mark.parametrize(("ndim", "nodes"), [(2, 256), (3, 64)])
def test_blocks_at_ends_are_those_with_the_first_or_the_last_nodes(ndim, nodes, place):
    mesh = recipe(nodes, ndim, 2, ("periodic", *("unbounded",) * (ndim - 1)), 8)
    blocks = nested(mesh, (place, place, 0.5)[:ndim], 0.05)
    counts = np.array([mesh.counts(level) for level in range(3)])[blocks.levels]
    first_or_last = (blocks.places == 0) | (blocks.places == counts - 1)
    assert (at_ends(blocks) == first_or_last[:, 1:].any(axis=1)).all()
    assert not at_ends(nested(recipe(nodes, ndim, 2, "periodic", 8), (0.0,) * ndim, 0.05)).any()


def test_a_component_matters_beyond_the_tolerance_on_refined_blocks_alone():
    mesh = recipe(256, 2, 2, "unbounded", tolerance=1e-2)
    blocks = nested(mesh, (0.0, 0.5), 0.05)
    values = np.zeros((5, *blocks.shape))
    values[:, 0, 8, 8] = 1.0, 1.0, -1.0, 1.0, 0.0
    values[:, -1, 3, 3] = 0.011, 0.009, -0.011, 0.0, 0.0
    some = np.zeros(blocks.size, bool)
    some[[0, -1]] = True
    assert matter(values, blocks, some).tolist() == [True, False, True, False, False]
    some[-1] = False
    assert not matter(values, blocks, some).any()
