"""What a run will take, told before it starts: memory at the peak, time per step, steps to go."""

from __future__ import annotations

import math
import resource
import statistics
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np

from pmesh.run import tree
from pmesh.run.protocols import Moment, Watcher
from pmesh.run.snapshots import Snapshots
from pmesh.vortex.cost import footprint
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.perturbed import PerturbedFlow
from remesh.grid import Grid
from remesh.machine import free_memory, size_text, used_memory

ENOUGH = 20.0  # seconds of steps after which no further one is taken
TAKEN = 4  # steps at most, of which the first may compile


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a run takes of memory and time; print it.

    Memory is that of the mesh at the start, or after the steps that were taken: it may grow. What a
    case computes once at its end, and figures, come to it. Time is that of real steps from the
    start, without snapshots and checkpoints.
    """

    grid: Grid  # at the start or after the steps taken, the finest mesh if it is adaptive
    dtype: str
    program: int  # bytes that the program takes without the run
    free: int | None  # bytes that may be taken beside that; None: not known
    peaks: Mapping[str, int] = field(default_factory=dict)  # bytes by part of the run: predicted
    nodes: int | None = None  # that a step moves
    measured: int | None = None  # bytes at the peak so far, program included
    seconds: float | None = None  # per step; None: no step was taken
    taken: int = 0  # steps that say so
    dt: float | None = None  # of the last step taken [T]
    rule: str = ""  # that set it
    left: float | None = None  # time to go [T]

    @property
    def memory(self) -> int | None:
        """Bytes of the run at its peak, the program not counted; None: cannot be predicted."""
        return max(self.peaks.values()) if self.peaks else None

    @property
    def fits(self) -> bool:
        """Whether the memory suffices, as far as is known."""
        return self.memory is None or self.free is None or self.memory <= self.free

    @property
    def steps(self) -> int | None:
        """Steps to the end at the present dt."""
        if self.left is None or not self.dt:
            return None
        return math.ceil(self.left / self.dt * (1.0 - 1e-12))

    def __str__(self) -> str:
        """The estimate in a few lines."""
        lines = {
            "mesh": self._mesh(),
            "memory": self._memory(),
            "time": self._time(),
            "to go": self._left(),
        }
        return "\n".join(f"{name:8}{text}" for name, text in lines.items() if text)

    def _mesh(self) -> str:
        grid = self.grid
        sides = " x ".join(map(str, grid.shape))
        kinds = sorted(set(grid.boundary))
        words = kinds[0] if len(kinds) == 1 else ", ".join(grid.boundary)
        own = "" if self.nodes in (None, grid.size) else f", {self.nodes} of them in use"
        return f"{sides} nodes, {words}, {self.dtype}{own}"

    def _memory(self) -> str:
        room = "" if self.free is None else f"; {size_text(self.free)} are free"
        if self.memory is None:
            known = size_text(self.measured or self.program)
            return f"not predicted for such a mesh; {known} at the peak so far{room}"
        part = max(self.peaks, key=lambda name: self.peaks[name])
        verdict = "" if self.free is None else ": it fits" if self.fits else ": it does not fit"
        when = "at the start" if self.measured is None else "after the first steps"
        so_far = "" if self.measured is None else f", {size_text(self.measured)} measured so far"
        return (
            f"{size_text(self.memory + self.program)} at the peak ({part}): "
            f"{size_text(self.memory)} for the mesh {when}, {size_text(self.program)} for "
            f"the program{so_far}{room}{verdict}"
        )

    def _time(self) -> str:
        if self.seconds is None:
            return ""
        rate = (self.nodes or self.grid.size) / self.seconds / 1e6
        return (
            f"{self.seconds:.3g} s per step ({rate:.2g} million node-steps per second), "
            f"median of {self.taken} steps taken from the start"
        )

    def _left(self) -> str:
        if self.steps is None or self.seconds is None:
            return ""
        return (
            f"about {self.steps} steps of dt = {self.dt:.3g}, which the {self.rule} rule sets and "
            f"may change: {time_text(self.steps * self.seconds)}"
        )


def estimate(
    flow: Any, state: Any = None, *, until: float | None = None, watch: Sequence[Watcher] = ()
) -> Estimate:
    """What a run of a flow takes; writes nothing.

    Memory is predicted for a `VortexFlow` on a uniform mesh, alone or in a base flow, before
    anything is made. With a ``state`` a few real steps from it are timed, if they fit, with those
    of the watchers that write nothing; with ``until`` [T] the time to the end follows.
    """
    free, own = free_memory(), sum(array.nbytes for _, array in tree.arrays(state))
    told = Estimate(
        grid=_grid(flow, state),
        dtype=_precision(flow, state),
        program=max(0, used_memory() - own),
        free=None if free is None else free + own,
        peaks=predicted(flow, watch, _grid(flow, state)),
    )
    if state is None:
        return told
    told = replace(told, nodes=int(state.size))
    return _timed(told, flow, state, until, watch) if told.fits else told


def predicted(flow: Any, watch: Sequence[Watcher] = (), grid: Grid | None = None) -> dict[str, int]:
    """Bytes at the peak of each part of a run; none for flows whose memory cannot be predicted.

    ``grid``: what the mesh has grown to, if not that at the start.
    """
    if not isinstance(flow, VortexFlow | PerturbedFlow) or not isinstance(flow.grid, Grid):
        return {}
    grid = grid or flow.grid
    own = footprint(flow, grid)
    held = own.kept + 2 * own.state  # the loop keeps the state before
    peaks = {
        "start": own.start,
        "step": own.step,
        "ledger": own.ledger,
        "checkpoint": held + round(1.13 * own.state),
    }
    pictures = [writing(flow, watcher, grid) for watcher in watch if isinstance(watcher, Snapshots)]
    if pictures:
        peaks["snapshot"] = held + max(pictures)
    return peaks


def writing(flow: VortexFlow | PerturbedFlow, watcher: Snapshots, grid: Grid) -> int:
    """Bytes that a snapshot takes: its fields, the file's image, and a copy of the field at work.

    Vectors are written with three components; in the plane that takes one copy more.
    """
    bodies = getattr(flow, "bodies", ())
    own = np.dtype(flow.dtype)
    kind: np.dtype[Any] = watcher.dtype or own
    parts = {"vorticity": 1 if grid.ndim == 2 else 3, "velocity": grid.ndim, "chi": 1}
    if not bodies:
        del parts["chi"]
    names = [name for name in parts if watcher.fields is None or name in watcher.fields]
    image, most = 0, 0
    for name in names:
        size = 1 if parts[name] == 1 else 3
        image += size
        most = max(most, image + size * (2 if parts[name] == 2 else 1))
    if kind != own:
        most += sum(parts[name] for name in names)
    made = sum(parts[name] for name in names if name != "vorticity")  # that no state holds
    kept = made if watcher.reduce == 1 else 0
    share = 1.0 / float(watcher.reduce**grid.ndim)
    written = kept * own.itemsize + most * kind.itemsize * share
    return round(max(float(made * own.itemsize), written) * grid.size)


def _timed(
    told: Estimate, flow: Any, state: Any, until: float | None, watch: Sequence[Watcher]
) -> Estimate:
    """The estimate with the time of a few steps."""
    end = math.inf if until is None else until
    start, dt, rule = state, None, ""
    spans: list[float] = []
    quiet = [one for one in watch if not isinstance(one, Snapshots)]
    began = perf_counter()
    while len(spans) < TAKEN and state.time < end:
        if len(spans) > 1 and perf_counter() - began + spans[-1] > ENOUGH:
            break
        limit = flow.limit(state)
        dt, rule = min(limit.dt, end - state.time), limit.rule
        if not (math.isfinite(dt) and dt > 0):
            break
        clock = perf_counter()
        state = flow.step(state, dt)
        _watched(quiet, Moment(flow=flow, state=state, dt=dt, rule=rule, until=end))
        spans.append(perf_counter() - clock)
    if not spans:
        return told
    return replace(
        told,
        grid=_grid(flow, state),
        measured=_peak(),
        peaks=predicted(flow, watch, _grid(flow, state)),
        seconds=statistics.median(spans[1:] or spans),
        taken=len(spans[1:] or spans),
        dt=flow.limit(state).dt if state.time < end else dt,
        rule=rule,
        left=None if until is None else until - start.time,
    )


def _watched(watch: Sequence[Watcher], moment: Moment) -> None:
    """Ask the watchers that need no run directory."""
    for watcher in watch:
        if not hasattr(watcher, "open"):
            watcher(moment)


def _peak() -> int:
    """Largest memory that this process has held so far [bytes]."""
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024


def _grid(flow: Any, state: Any) -> Grid:
    given = getattr(state, "grid", None) or getattr(flow, "lattice", None) or flow.grid
    return given if isinstance(given, Grid) else given.grid


def _precision(flow: Any, state: Any) -> str:
    if hasattr(flow, "dtype"):
        return str(flow.dtype)
    kinds = [array.dtype for _, array in tree.arrays(state) if array.dtype.kind == "f"]
    return str(kinds[0]) if kinds else "float64"


def time_text(seconds: float) -> str:
    """A time in the unit that suits it."""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"
