"""Generalised conjugate residuals: a linear system that is symmetric or nearly so, of any sign."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
KEPT = 10  # search directions that new ones are made orthogonal to


class Solved(NamedTuple):
    """An approximate solution, and how far it is from one."""

    solution: Array
    rest: Array  # b - apply(x)
    residual: float  # its squared norm
    iterations: int


def solve(
    apply: Callable[[Array], Array],
    start: Array,
    residual: Array,
    *,
    target: float,
    iterations: int,
) -> Solved:
    """Lower ``|b - apply(x)|^2`` to ``target`` from x = ``start``, whose residual is given.

    Vectors are flat. Minimal in the span of the last 10 images: neither definite nor exactly
    symmetric matrices disturb it. One ``apply`` per iteration (Eisenstat, Elman & Schultz 1983).
    """
    solution, rest = start, residual
    norm, count = _dot(rest, rest), 0
    directions: list[tuple[Array, Array]] = []
    while not norm <= target and count < iterations and np.isfinite(norm):
        way, image = rest.copy(), apply(rest)
        for other, other_image in directions:
            part = image.dtype.type(_dot(image, other_image))
            way -= part * other
            image -= part * other_image
        size = _dot(image, image) ** 0.5
        if not size > 0:
            break
        way /= way.dtype.type(size)
        image /= image.dtype.type(size)
        length = rest.dtype.type(_dot(rest, image))
        solution = solution + length * way
        rest = rest - length * image
        norm, count = _dot(rest, rest), count + 1
        directions = [*directions[1 - KEPT :], (way, image)]
    return Solved(solution, rest, norm, count)


def _dot(a: Array, b: Array) -> float:
    """Inner product in one thread: threads cost more than vectors of this size give."""
    return float(np.einsum("i,i->", a, b, dtype=np.float64))
