"""The connected pieces of what lies inside a level set, at a cost that follows its surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.rows import runs

Nodes = NDArray[np.int64]


def pieces(band: Band) -> Nodes:
    """The number of nodes in each connected piece of the inside, largest first.

    ``len(pieces(band))`` is how many there are. Nodes are joined along the axes; what lies beyond
    the band belongs to the side that it is on. Periodic axes join. Cost: that of the band's nodes
    and of the grid's rows. Refuses a band with a hole where the side changes.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, stop = _stretches(band)
    if not len(first):
        return np.empty(0, np.int64)
    here, there = _touching(first, stop, band)
    links = coo_array((np.ones(len(here), bool), (here, there)), shape=(len(first),) * 2)
    count, label = connected_components(links, directed=False)
    sizes = np.bincount(label, weights=stop - first, minlength=count).astype(np.int64)
    return np.sort(sizes)[::-1]


def _stretches(band: Band) -> tuple[Nodes, Nodes]:
    """First node and the one after the last of all that is inside in one go along a row."""
    length = band.grid.shape[-1]
    beyond = runs(band.nodes, band.values, band.grid)
    far = beyond.inside & (beyond.stop > beyond.first)
    near = band.nodes[band.values < 0]
    first = np.concatenate([near, beyond.row[far] * length + beyond.first[far]])
    stop = np.concatenate([near + 1, beyond.row[far] * length + beyond.stop[far]])
    order = np.argsort(first)
    first, stop = first[order], stop[order]
    apart = np.ones(len(first), bool)
    apart[1:] = (first[1:] != stop[:-1]) | (first[1:] % length == 0)
    ends = np.roll(apart, -1) if len(first) else apart
    return first[apart], stop[ends]


def _touching(first: Nodes, stop: Nodes, band: Band) -> tuple[Nodes, Nodes]:
    """Pairs of stretches that touch: in neighbouring rows, or across a periodic seam."""
    shape, wraps = band.grid.shape, band.grid.periodic
    length, own = shape[-1], np.arange(len(first))
    pairs = []
    rows = first // length
    for axis, size in enumerate(shape[:-1]):
        stride = int(np.prod(shape[axis + 1 : -1], dtype=np.int64))
        place = (rows // stride) % size
        step = np.where(place + 1 < size, stride, -stride * (size - 1)) * length
        kept = own[(place + 1 < size) | wraps[axis]]
        low = np.searchsorted(stop, first[kept] + step[kept], side="right")
        high = np.searchsorted(first, stop[kept] + step[kept], side="left")
        pairs.append((np.repeat(kept, high - low), _ranges(low, high)))
    if wraps[-1]:  # the last of a row touches the first
        ends = own[stop % length == 0]
        begin = np.searchsorted(first, rows[ends] * length)
        found = first[begin] == rows[ends] * length
        pairs.append((ends[found], begin[found]))
    here, there = (np.concatenate(part) for part in zip(*pairs, strict=True))
    return here, there


def _ranges(low: Nodes, high: Nodes) -> Nodes:
    """All of range(low[i], high[i]), one after the other."""
    counts = high - low
    every: Nodes = np.arange(counts.sum()) + np.repeat(low - np.cumsum(counts) + counts, counts)
    return every
