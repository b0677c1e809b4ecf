"""The active parts of an adaptive mesh as boxes: what a picture of it draws."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.multires.blocks import ABSENT, Blocks


class Boxes(NamedTuple):
    """Boxes (m): level of each, and its lower and upper corners ``(m, ndim)`` [L]."""

    level: NDArray[np.int8]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def leaf_boxes(blocks: Blocks) -> Boxes:
    """The quadrants of blocks that no finer block lies over, whole blocks where all are active.

    A box begins at its first node and ends where the next block of its level begins: all together
    tile the domain of ``grid.shape * spacing`` once. O(blocks).
    """
    mesh = blocks.mesh
    edge = mesh.block * blocks.spacings[:, None]
    corner = np.array(mesh.grid.origin) + blocks.places * edge
    free = blocks.children == ABSENT
    whole = free.all(axis=1)
    size = np.broadcast_to(edge, corner.shape)
    level, low, high = [blocks.levels[whole]], [corner[whole]], [(corner + size)[whole]]
    for k, quadrant in enumerate(product((0, 1), repeat=mesh.ndim)):
        some = free[:, k] & ~whole
        start = (corner + 0.5 * size * np.array(quadrant))[some]
        level.append(blocks.levels[some])
        low.append(start)
        high.append(start + 0.5 * size[some])
    return Boxes(np.concatenate(level), np.concatenate(low), np.concatenate(high))
