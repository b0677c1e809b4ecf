"""Whether a case fits into the memory, and the size of it that would."""

from __future__ import annotations

import dataclasses
from typing import Any

from pmesh.cases.case import Case
from pmesh.cases.options import options, spelt
from pmesh.run.forecast import Estimate, estimate, predicted
from remesh.errors import InputError
from remesh.machine import free_memory, size_text

STRIDE = 8  # nodes between the sizes that are tried
PARTS = 256  # of a spacing


def refuse_too_large(case: Case) -> None:
    """Refuse a case whose memory is predicted and is not there, with the size that would fit.

    A case that tells no `Case.recipe` is not looked at.
    """
    peaks, free = predicted(_recipe(case), case.watchers()), free_memory()
    if not peaks or free is None or max(peaks.values()) <= free:
        return
    raise InputError(
        f"the run needs {size_text(max(peaks.values()))} of memory, {size_text(free)} are free",
        hint=advice(case, free),
    )


def forecast(case: Case) -> Estimate:
    """What a run of the case takes, with a few steps if it fits; writes nothing."""
    flow = _recipe(case)
    if flow is not None:
        told = estimate(flow, watch=case.watchers())
        if not told.fits:
            return told
    flow, state = case.build()
    return estimate(flow, state, until=case.until, watch=case.watchers())


def advice(case: Case, free: int) -> str:
    """The finest size of the case that fits into ``free`` bytes, as an option."""
    found = finest(case, free)
    if found is None:
        return "a coarser mesh, or a smaller domain"
    value, size = found
    return f"{options(type(case))[case.size].flag} {spelt(value)} ({size_text(size)})"


def finest(case: Case, free: int) -> tuple[float, int] | None:
    """The finest value of the option `Case.size` that fits, and its bytes; None without one."""
    if not case.size:
        return None
    given = getattr(case, case.size)
    whole = options(type(case))[case.size].kind is int

    def sized(part: int) -> float:
        """Finer and finer: nodes, or 256ths of the spacing given."""
        return STRIDE * part if whole else float(f"{given * PARTS / part:.3g}")

    def fits(part: int) -> bool:
        size = _bytes(case, sized(part))
        return size is None or size <= free  # what a case refuses as too coarse is small

    last = PARTS if not whole else (given // STRIDE if given else 1 << 16)
    low, high = 1, 2
    while high <= last and fits(high):
        low, high = high, 2 * high
    high = min(high, last + 1)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    size = _bytes(case, sized(low))
    return None if size is None or size > free else (sized(low), size)


def _bytes(case: Case, value: float) -> int | None:
    """What the case takes at this size; None if it refuses it."""
    try:
        other = dataclasses.replace(case, **{case.size: value})
        return max(predicted(_recipe(other), other.watchers()).values(), default=None)
    except InputError:
        return None


def _recipe(case: Case) -> Any:
    """The flow of a case; refuses one whose very description is too large."""
    try:
        return case.recipe()
    except MemoryError as error:
        raise InputError(
            f"the mesh is too large to be described ({error})", hint="a coarser mesh"
        ) from error
