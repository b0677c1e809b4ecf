"""Active nodes of several levels in snapshots."""

import numpy as np
import pytest

from pmesh.cases.active import active_nodes


@pytest.mark.parametrize("ndim", [2, 3])
def test_each_level_has_the_nodes_of_its_own_spacing_and_no_others(ndim):
    known = np.full((8,) * ndim, -1)
    known[4:] = 0  # of levels 0, 1, 2: every fourth, every second and every node
    known[2:4] = 1
    known[:2] = 2
    nodes, levels = active_nodes(known.astype(np.float32), 2)
    side = {0: 2, 1: 4, 2: 8}  # nodes along the other axes
    assert np.bincount(levels).tolist() == [
        side[0] ** (ndim - 1), side[1] ** (ndim - 1), 2 * side[2] ** (ndim - 1),
    ]  # fmt: skip
    assert set(nodes[levels == 0, 0]) == {4}
    assert set(nodes[levels == 1, 0]) == {2}
    assert set(nodes[levels == 2, 0]) == {0, 1}
    assert set(nodes[levels == 1, -1]) == {0, 2, 4, 6}


def test_where_a_finer_level_is_told_there_is_none():
    nodes, levels = active_nodes(np.array([[3, 1], [1, 1]]), 1)
    assert nodes.tolist() == [[0, 1], [1, 0], [1, 1]]
    assert levels.tolist() == [1, 1, 1]
