"""Compiled loops of hashed blocks: open addressing over whole numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

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
