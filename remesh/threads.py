"""Threads for loops and transforms that release the lock; no split of work depends on them."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import lru_cache
from typing import Any

from remesh.errors import InputError


def thread_count(threads: int | None) -> int:
    """The number of threads to use: as asked, else what numba was told (NUMBA_NUM_THREADS)."""
    if threads is None:
        import numba

        return int(numba.get_num_threads())
    if int(threads) != threads or threads < 1:
        raise InputError(f"threads must be a whole number >= 1, got {threads}", hint="threads=2")
    return int(threads)


@lru_cache(maxsize=8)
def _pool(threads: int, process: int) -> ThreadPoolExecutor:
    """Kept threads, of this very process: after a fork those of the parent do no work."""
    return ThreadPoolExecutor(threads, thread_name_prefix="remesh")


def share(work: Callable[..., Any], pieces: int, threads: int, *arguments: Any) -> None:
    """Call ``work(first, pieces, step, *arguments)`` so that each piece is done exactly once.

    Piece k is done by thread k modulo the number of threads; a law that gives each piece its own
    output therefore returns the same bits for any number of threads. ``first`` is the number of
    the thread, below ``threads``: scratch of its own is told by it. Numbers too small to be normal
    (1e-38 in single precision) count as zero, on processors of the x86 family.
    """
    step = max(1, min(threads, pieces))
    if step == 1:
        _flushed(work, 0, pieces, 1, *arguments)
        return
    pool = _pool(step - 1, os.getpid())
    others = [
        pool.submit(_flushed, work, first, pieces, step, *arguments) for first in range(1, step)
    ]
    try:
        _flushed(work, 0, pieces, step, *arguments)
    finally:
        wait(others)  # none of them writes when the caller goes on
    for other in others:
        other.result()


def _flushed(work: Callable[..., Any], *arguments: Any) -> None:
    """Do the work with subnormal numbers as zero, which costs up to a hundred times less."""
    from remesh import _flags

    word = _flags.flush()
    try:
        work(*arguments)
    finally:
        _flags.restore(word)
