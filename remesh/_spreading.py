"""Compiled loops of the spreading law: a stencil along one axis after another, in place."""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True, fastmath={"contract"})
def fold(source, weights, wraps, target):
    """A stencil along the last axis of (rows, n): target = sum of weights of neighbours."""
    rows, n = source.shape
    reach = weights.size - 1
    for r in range(rows):
        line, out = source[r], target[r]
        for k in range(n):
            out[k] = weights[0] * line[k]
        for m in range(1, reach + 1):
            w = weights[m]
            for k in range(m, n - m):
                out[k] += w * (line[k - m] + line[k + m])
            for k in range(min(m, n)):
                low = k - m
                if wraps:
                    out[k] += w * line[low % n]
                high = k + m
                if high < n:
                    out[k] += w * line[high]
                elif wraps:
                    out[k] += w * line[high % n]
            for k in range(max(n - m, m), n):
                out[k] += w * line[k - m]
                if wraps:
                    out[k] += w * line[(k + m) % n]


@njit(cache=True, nogil=True, fastmath={"contract"})
def mix(source, weights, wraps, target):
    """The same along the first axis."""
    n, columns = source.shape
    reach = weights.size - 1
    for i in range(n):
        out = target[i]
        middle = source[i]
        for k in range(columns):
            out[k] = weights[0] * middle[k]
        for m in range(1, reach + 1):
            w = weights[m]
            low, high = i - m, i + m
            if wraps:
                low, high = low % n, high % n
            if low >= 0 and high < n:
                one, other = source[low], source[high]
                for k in range(columns):
                    out[k] += w * (one[k] + other[k])
            elif low >= 0:
                one = source[low]
                for k in range(columns):
                    out[k] += w * one[k]
            elif high < n:
                one = source[high]
                for k in range(columns):
                    out[k] += w * one[k]


@njit(cache=True, nogil=True)
def copy(source, target):
    """target = source, for planes that do not lie in one piece."""
    for i in range(source.shape[0]):
        for k in range(source.shape[1]):
            target[i, k] = source[i, k]


@njit(cache=True, nogil=True)
def planes(first, pieces, step, field, weights, middle, wraps, scratch, out):
    """Planes of fixed first index: along the last axis, then along the middle one."""
    one, other = scratch[first, 0], scratch[first, 1]
    for piece in range(first, pieces, step):
        fold(field[piece], weights, wraps[2], one)
        if middle:
            mix(one, weights, wraps[1], other)
            copy(other, out[piece])
        else:
            copy(one, out[piece])


@njit(cache=True, nogil=True)
def columns(first, pieces, step, field, weights, wraps, scratch, edges):
    """Slabs of the second index: along the first axis, in place."""
    nodes = field.shape[0]
    for piece in range(first, pieces, step):
        low, high = edges[piece], edges[piece + 1]
        one = scratch[first, 0, : nodes * (high - low)].reshape(nodes, high - low)
        other = scratch[first, 1, : nodes * (high - low)].reshape(nodes, high - low)
        copy(field[:, low:high], one)
        mix(one, weights, wraps[0], other)
        copy(other, field[:, low:high])
