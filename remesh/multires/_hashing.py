"""Compiled loops of hashed blocks: open addressing over whole numbers, and tables by it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from remesh.multires.blocks import ABSENT, OUTSIDE

EMPTY = -1
FACTOR = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio: Knuth's multiplicative hash


@njit(cache=True, inline="always")
def slot_of(key: int, bits: int) -> Any:
    """Where the search for a key starts in a table of 2^bits slots."""
    return np.int64((np.uint64(key) * FACTOR) >> np.uint64(64 - bits))


@njit(cache=True, nogil=True)
def insert(keys: Any, table: Any, values: Any, bits: int) -> None:
    """Fill an empty table with the numbers of its keys."""
    mask = (1 << bits) - 1
    for i in range(keys.size):
        slot = slot_of(keys[i], bits)
        while table[slot] != EMPTY:
            slot = (slot + 1) & mask
        table[slot] = keys[i]
        values[slot] = i


@njit(cache=True, nogil=True)
def find(key: int, table: Any, values: Any, bits: int) -> Any:
    """Number of a key, -1 if it is not there."""
    mask = (1 << bits) - 1
    slot = slot_of(key, bits)
    while table[slot] != EMPTY:
        if table[slot] == key:
            return values[slot]
        slot = (slot + 1) & mask
    return np.int32(-1)


@njit(cache=True, nogil=True)
def find_all(keys: Any, table: Any, values: Any, bits: int, found: Any) -> None:
    """Numbers of many keys; negative keys are told as they are."""
    for i in range(keys.size):
        key = keys[i]
        found[i] = find(key, table, values, bits) if key >= 0 else key


@njit(cache=True, nogil=True)
def unfold(key: int, counts: Any, place: Any) -> None:
    """The place of a key of a level."""
    for axis in range(counts.size - 1, -1, -1):
        place[axis] = key % counts[axis]
        key //= counts[axis]


@njit(cache=True, nogil=True)
def fold(place: Any, counts: Any, periodic: Any) -> Any:
    """The key of a place of a level, `OUTSIDE` beyond unbounded ends."""
    key = np.int64(0)
    for axis in range(counts.size):
        p, count = place[axis], counts[axis]
        if not 0 <= p < count:
            if not periodic[axis]:
                return np.int64(OUTSIDE)
            p %= count
        key = key * count + p
    return key


@njit(cache=True, nogil=True)
def distinct(keys: Any) -> Any:
    """Keys in ascending order, each once."""
    keys = np.sort(keys)
    count = 0
    for i in range(keys.size):
        if i == 0 or keys[i] != keys[count - 1]:
            keys[count] = keys[i]
            count += 1
    return keys[:count]


@njit(cache=True, nogil=True)
def below(keys: Any, counts: Any, coarse: Any, periodic: Any) -> Any:
    """Keys of the coarser blocks under blocks and their neighbours."""
    ndim = counts.size
    place, under = np.empty(ndim, np.int64), np.empty(ndim, np.int64)
    found = np.empty(keys.size << ndim, np.int64)
    count = 0
    for key in keys:
        unfold(key, counts, place)
        for corner in range(1 << ndim):
            for axis in range(ndim):
                under[axis] = (place[axis] + (1 if corner >> axis & 1 else -1)) >> 1
            number = fold(under, coarse, periodic)
            if number >= 0:
                found[count] = number
                count += 1
    return distinct(found[:count])


@njit(cache=True, nogil=True)
def balance(wanted: Any, offsets: Any, counts: Any, periodic: Any) -> Any:
    """Keys of the wanted blocks and of all that must lie under them, and each level's first."""
    top = offsets.size - 2
    starts = np.zeros(top + 2, np.int64)
    needed = np.empty(0, np.int64)
    parts = [np.arange(offsets[1])]
    for level in range(top, 0, -1):
        low, high = np.searchsorted(wanted, offsets[level : level + 2])
        needed = distinct(np.concatenate((wanted[low:high] - offsets[level], needed)))
        starts[level + 1] = needed.size
        parts.append(needed + offsets[level])
        needed = below(needed, counts[level], counts[level - 1], periodic)
    starts[1] = offsets[1]
    starts = np.cumsum(starts)
    result = np.empty(starts[-1], np.int64)
    result[: starts[1]] = parts[0]
    for level in range(top, 0, -1):
        result[starts[level] : starts[level + 1]] = parts[top + 1 - level]
    return result, starts


@njit(cache=True, nogil=True)
def places(keys: Any, starts: Any, offsets: Any, counts: Any) -> Any:
    """The places of blocks."""
    result = np.empty((keys.size, counts.shape[1]), np.int64)
    for level in range(starts.size - 1):
        for n in range(starts[level], starts[level + 1]):
            unfold(keys[n] - offsets[level], counts[level], result[n])
    return result


@njit(cache=True, nogil=True)
def link(
    places: Any, starts: Any, keys: Any, values: Any, bits: int, counts: Any, periodic: Any,
    offsets: Any,
) -> Any:  # fmt: skip
    """Tables of neighbours, of coarser blocks and of children."""
    size, ndim = places.shape
    around, corners = 3**ndim, 1 << ndim
    neighbours = np.empty((size, around), np.int32)
    coarser = np.full((size, around), np.int32(OUTSIDE))
    children = np.full((size, corners), np.int32(ABSENT))
    step, place = np.empty((around, ndim), np.int64), np.empty(ndim, np.int64)
    for k in range(around):
        unfold(k, np.full(ndim, 3), step[k])
    step -= 1
    for n in range(starts[1]):
        for k in range(around):
            neighbours[n, k] = fold(places[n] + step[k], counts[0], periodic)
    for level in range(1, starts.size - 1):
        for n in range(starts[level], starts[level + 1]):
            quadrant = 0
            for axis in range(ndim):
                place[axis] = places[n, axis] >> 1
                quadrant = 2 * quadrant + (places[n, axis] & 1)
            key = fold(place, counts[level - 1], periodic) + offsets[level - 1]
            parent = find(key, keys, values, bits)
            children[parent, quadrant] = n
            coarser[n, around // 2] = parent
        for n in range(starts[level], starts[level + 1]):
            parent = coarser[n, around // 2]
            for k in range(around):
                beside, quadrant = 0, 0
                for axis in range(ndim):
                    p = places[n, axis] + step[k, axis]
                    beside = 3 * beside + (p >> 1) - (places[n, axis] >> 1) + 1
                    quadrant = 2 * quadrant + (p & 1)
                number = neighbours[parent, beside]
                coarser[n, k] = number
                neighbours[n, k] = children[number, quadrant] if number >= 0 else number
    return neighbours, coarser, children
