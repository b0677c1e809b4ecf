"""Subnormal numbers flushed to zero while compiled loops run."""

from __future__ import annotations

import numpy as np
import pytest

from remesh import _flags
from remesh.threads import share

TINY = np.full(8, 1e-40, np.float32)


def halved() -> float:
    return float((TINY * np.float32(0.5)).max())


@pytest.mark.skipif(not _flags.KNOWN, reason="control words are known for x86 only")
def test_subnormal_numbers_are_zero_until_the_control_word_is_restored():
    assert halved() > 0
    word = _flags.flush()
    flushed = halved()
    _flags.restore(word)
    assert flushed == 0.0
    assert halved() > 0


@pytest.mark.skipif(not _flags.KNOWN, reason="control words are known for x86 only")
@pytest.mark.parametrize("threads", [1, 3])
def test_shared_work_is_done_with_them_as_zero_and_the_caller_computes_as_before(threads):
    found = np.full(3, np.nan)

    def work(first: int, pieces: int, step: int) -> None:
        for piece in range(first, pieces, step):
            found[piece] = halved()

    share(work, 3, threads)
    assert not found.any()
    assert halved() > 0


def test_the_control_word_is_restored_when_work_fails():
    def work(first: int, pieces: int, step: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        share(work, 1, 1)
    assert halved() > 0
