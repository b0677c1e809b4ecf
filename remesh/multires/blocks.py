"""The blocks of an adaptive mesh at one instant: which there are, and who is whose neighbour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.multires.mesh import AdaptiveMesh

Places = NDArray[np.int64]
Numbers = NDArray[np.int32]
ABSENT, OUTSIDE = -1, -2  # in tables of blocks: not there; beyond an unbounded end


class Table(NamedTuple):
    """Hashed keys of blocks and their numbers, see `_hashing`."""

    keys: NDArray[np.int64]
    numbers: Numbers
    bits: int


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of all levels, coarse ones under fine ones included: a pyramid of nested regions.

    Block ``places[n]`` of level l holds the nodes ``place * block + (0 ... block - 1)`` of that
    level; node 2k of a level is node k of the next coarser one. Blocks come level by level
    (level l: ``starts[l]`` to ``starts[l + 1]`` - 1), in C order of their places. Level 0 is
    complete; under each block and under each of its neighbours' places there is a coarser block
    (2:1 balance, corners included). Fields on blocks are arrays ``(n, *(block,) * ndim)`` or
    ``(c, n, ...)``: what a level holds where it is refined is the restriction of the finer values.
    """

    mesh: AdaptiveMesh
    places: Places  # (n, ndim)
    starts: tuple[int, ...]

    @classmethod
    def around(cls, mesh: AdaptiveMesh, wanted: Sequence[Places]) -> Blocks:
        """These blocks of levels 0, 1, ... (m, ndim each), and those that the balance asks for."""
        return cls.of_keys(mesh, keys_of(mesh, wanted))

    @classmethod
    def of_keys(cls, mesh: AdaptiveMesh, wanted: NDArray[np.int64]) -> Blocks:
        """The blocks of these keys, see `keys`, and those that the balance asks for."""
        from remesh.multires import _hashing

        counts, periodic, offsets = layout(mesh)
        keys, starts = _hashing.balance(np.sort(wanted), offsets, counts, periodic)
        places = _hashing.places(keys, starts, offsets, counts)
        result = cls(mesh, places, tuple(starts.tolist()))
        result.__dict__["keys"] = keys
        return result

    @classmethod
    def uniform(cls, mesh: AdaptiveMesh, level: int = 0) -> Blocks:
        """All blocks up to a level."""
        axes = [np.arange(n) for n in mesh.counts(level)]
        everywhere = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, mesh.ndim)
        none = np.empty((0, mesh.ndim), np.int64)
        return cls.around(mesh, [none] * level + [everywhere])

    def joined(self, level: int, places: Places) -> Blocks:
        """The same mesh with more blocks of a level, and those that the balance asks for."""
        if (self.numbers_of(level, places) != ABSENT).all():
            return self
        wanted = [self.places[self.of(k)] for k in range(self.mesh.levels + 1)]
        wanted[level] = np.concatenate([wanted[level], places])
        return Blocks.around(self.mesh, wanted)

    @property
    def size(self) -> int:
        """Number of blocks."""
        return len(self.places)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a scalar field on the blocks."""
        return (self.size, *(self.mesh.block,) * self.mesh.ndim)

    @cached_property
    def active(self) -> int:
        """Number of active nodes: each place counts once, on its finest level."""
        mesh = self.mesh
        finer = self.size - self.starts[1]
        return int(self.size * mesh.block**mesh.ndim - finer * (mesh.block // 2) ** mesh.ndim)

    @property
    def compression(self) -> float:
        """Nodes of the finest grid per active node."""
        return self.mesh.grid.size / self.active

    def of(self, level: int) -> slice:
        """The blocks of a level."""
        return slice(self.starts[level], self.starts[level + 1])

    @cached_property
    def levels(self) -> NDArray[np.int8]:
        """Level of each block."""
        return np.repeat(np.arange(self.mesh.levels + 1, dtype=np.int8), np.diff(self.starts))

    @cached_property
    def spacings(self) -> NDArray[np.float64]:
        """Spacing of each block [L]."""
        mesh = self.mesh
        return mesh.grid.spacing * 2.0 ** (mesh.levels - self.levels.astype(np.float64))

    @cached_property
    def finest(self) -> int:
        """The finest level that has blocks."""
        return int(self.levels[-1])

    @cached_property
    def keys(self) -> NDArray[np.int64]:
        """A number for each block by its level and place, the same on every mesh; ascending."""
        offsets = layout(self.mesh)[2]
        parts = [
            _keys(self.mesh, level, self.places[self.of(level)]) + offsets[level]
            for level in range(self.mesh.levels + 1)
        ]
        return np.concatenate(parts)

    @cached_property
    def table(self) -> Table:
        """Where each block is found by its key."""
        from remesh.multires import _hashing

        bits = max(4, int(2 * self.size - 1).bit_length())
        keys = np.full(2**bits, _hashing.EMPTY, np.int64)
        numbers = np.zeros(2**bits, np.int32)
        _hashing.insert(self.keys, keys, numbers, bits)
        return Table(keys, numbers, bits)

    @cached_property
    def neighbours(self) -> Numbers:
        """Numbers of the 3^ndim blocks around each of its own level, in C order; see `ABSENT`."""
        return self._links[0]

    @cached_property
    def coarser(self) -> Numbers:
        """Numbers of the coarser blocks under the 3^ndim places around each block.

        Block ``places // 2`` of the next coarser level; ``OUTSIDE`` for those of level 0.
        """
        return self._links[1]

    @cached_property
    def children(self) -> Numbers:
        """Numbers of the 2^ndim blocks that are finer, in C order; see `ABSENT`."""
        return self._links[2]

    @cached_property
    def sides(self) -> NDArray[np.int8]:
        """Which half of the coarser block each block lies on, x y z; in 2-D the first is 0."""
        result = np.zeros((self.size, 3), np.int8)
        result[:, 3 - self.mesh.ndim :] = self.places & 1
        return result

    def numbers_of(self, level: int, places: Places) -> Numbers:
        """Numbers of the blocks of a level at these places (..., ndim); see `ABSENT`."""
        from remesh.multires import _hashing

        keys = _keys(self.mesh, level, places.reshape(-1, self.mesh.ndim))
        keys[keys >= 0] += layout(self.mesh)[2][level]
        found = np.empty(keys.size, np.int32)
        _hashing.find_all(keys, *self.table, found)
        return found.reshape(places.shape[:-1])

    def found_in(self, other: Blocks) -> Numbers:
        """The number that each of these blocks has in another mesh; see `ABSENT`."""
        from remesh.multires import _hashing

        found = np.empty(self.size, np.int32)
        _hashing.find_all(self.keys, *other.table, found)
        return found

    def axes(self) -> tuple[NDArray[np.float64], ...]:
        """Where the nodes of each block are along each axis (n, block) [L]."""
        mesh = self.mesh
        local = np.arange(mesh.block)
        return tuple(
            start + self.spacings[:, None] * (place[:, None] * mesh.block + local)
            for start, place in zip(mesh.grid.origin, self.places.T, strict=True)
        )

    def points(self) -> NDArray[np.float64]:
        """Where all nodes are, ``(ndim, n, *(block,) * ndim)`` [L]."""
        ndim, result = self.mesh.ndim, np.empty((self.mesh.ndim, *self.shape))
        for axis, along in enumerate(self.axes()):
            shape = [self.size, *(1,) * ndim]
            shape[1 + axis] = self.mesh.block
            result[axis] = along.reshape(shape)
        return result

    def leaves(self) -> NDArray[np.bool_]:
        """Which nodes are active, ``(n, *(block,) * ndim)``: no finer block lies over them."""
        half, ndim = self.mesh.block // 2, self.mesh.ndim
        result = np.empty(self.shape, bool)
        for k, quadrant in enumerate(product((0, 1), repeat=ndim)):
            part = tuple(slice(q * half, (q + 1) * half) for q in quadrant)
            free = self.children[:, k] == ABSENT
            result[(slice(None), *part)] = free.reshape(-1, *(1,) * ndim)
        return result

    @cached_property
    def _links(self) -> tuple[Numbers, Numbers, Numbers]:
        """Neighbours, coarser blocks and children of each block."""
        from remesh.multires import _hashing

        counts, periodic, offsets = layout(self.mesh)
        links: tuple[Numbers, Numbers, Numbers] = _hashing.link(
            self.places, np.array(self.starts), *self.table, counts, periodic, offsets
        )
        return links


def _wrapped(mesh: AdaptiveMesh, level: int, places: Places) -> Places:
    """Places with periodic axes wrapped."""
    counts = np.where(mesh.grid.periodic, mesh.counts(level), np.iinfo(np.int64).max)
    inside: Places = np.where(mesh.grid.periodic, places % counts, places)
    return inside


def keys_of(mesh: AdaptiveMesh, wanted: Sequence[Places]) -> NDArray[np.int64]:
    """Keys, see `Blocks.keys`, of places on levels 0, 1, ... (m, ndim each); not those outside."""
    if len(wanted) > mesh.levels + 1:
        raise InputError(
            f"the mesh has levels 0 to {mesh.levels}, got blocks for {len(wanted)} levels",
            hint="one array of places per level",
        )
    offsets = layout(mesh)[2]
    found = [np.empty(0, np.int64)]
    for level, given in enumerate(wanted):
        places = np.asarray(given, np.int64)
        if places.ndim != 2 or places.shape[1] != mesh.ndim:
            raise InputError(
                f"places of blocks must have shape (n, {mesh.ndim}), got {places.shape} for level "
                f"{level}",
                hint=f"np.empty((0, {mesh.ndim}), int) where there are none",
            )
        some = _keys(mesh, level, places)
        found.append(some[some >= 0] + offsets[level])
    return np.concatenate(found)


def _keys(mesh: AdaptiveMesh, level: int, places: Places) -> NDArray[np.int64]:
    """C-order numbers of places (m, ndim) on the complete level; `OUTSIDE` where there is none."""
    counts = np.array(mesh.counts(level))
    places = _wrapped(mesh, level, places)
    keys = np.zeros(len(places), np.int64)
    for axis, count in enumerate(counts):
        keys = keys * count + places[:, axis]
    outside = ((places < 0) | (places >= counts)).any(axis=-1)
    return np.where(outside, OUTSIDE, keys)


def layout(
    mesh: AdaptiveMesh,
) -> tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.int64]]:
    """Places along each axis of each level, which axes are periodic, what keys of a level add."""
    counts = np.array([mesh.counts(level) for level in range(mesh.levels + 1)], np.int64)
    offsets = np.concatenate([[0], np.cumsum(counts.prod(axis=1))])
    return counts, np.array(mesh.grid.periodic), offsets
