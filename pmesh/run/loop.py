"""The loop: it advances a state, keeps the clock, the files and the last good state."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any, Generic, cast

import numpy as np

from pmesh.run import tree
from pmesh.run.clock import arrives, next_step, next_stop
from pmesh.run.protocols import Flow, Moment, Paced, S, Staged, Watcher
from pmesh.run.rundir import CHECKPOINT, RunFolder
from remesh.errors import BlowUpError, InputError, PmeshError
from remesh.limit import Limit, tightest


def run(
    flow: Flow[S],
    state: S,
    *,
    until: float,
    watch: Sequence[Watcher] = (),
    out: str | Path | None = None,
    resume: bool = False,
    overwrite: bool = False,
    checkpoint_every: float = 30.0,
    dt: float | None = None,
) -> S:
    """Advance ``state`` to the time ``until`` [T] exactly, and return the state there.

    Each step is the largest that ``flow.limit(state)``, ``dt`` [T] and the next time to land on (a
    multiple of a watcher's ``every``, or ``until``) allow: a function of the state and of fixed
    parameters, so that ``resume=True``, which goes on from the checkpoint in the directory ``out``,
    repeats an unbroken run bit for bit. ``out`` receives ``series.csv``, what the watchers write
    and, every ``checkpoint_every`` seconds of work, ``checkpoint.h5``. Refuses an ``out`` with
    another run in it unless ``overwrite=True``. A step that cannot be taken, for its numbers or the
    memory, or whose state is not finite, raises a BlowUpError that names it, whose ``state`` is the
    last good one; on any failure, and on Ctrl-C, the checkpoint holds that.
    """
    ceiling = _checked(until, dt, checkpoint_every)
    folder = None if out is None else RunFolder(Path(out), resume=resume, overwrite=overwrite)
    if resume and folder is None:
        raise InputError("resume=True needs the run directory", hint="out='out/my-run'")
    state, seconds, node_steps = folder.restore(state) if folder else (state, 0.0, 0)
    _check_start(state, until)
    journey = _Journey(flow, tuple(watch), until, folder, checkpoint_every, seconds, node_steps)
    with journey.watching(state):
        while state.time < until:
            state = journey.advance(state, ceiling)
    return state


class _Journey(Generic[S]):
    """A run under way: who watches it, where it is written, what it has cost."""

    def __init__(
        self,
        flow: Flow[S],
        watch: tuple[Watcher, ...],
        until: float,
        folder: RunFolder | None,
        checkpoint_every: float,
        seconds: float,
        node_steps: int,
    ) -> None:
        self.flow, self.watch, self.until, self.folder = flow, watch, until, folder
        self.paces = [w.every for w in cast(tuple[Any, ...], watch) if isinstance(w, Paced)]
        self.checkpoint_every = checkpoint_every
        self.node_steps = node_steps
        self.started = perf_counter() - seconds
        self.saved = self.seconds
        self.good: S | None = None  # the last state that is finite and in the series

    @property
    def seconds(self) -> float:
        """Work so far [s], earlier parts of a resumed run included."""
        return perf_counter() - self.started

    def advance(self, state: S, ceiling: Limit) -> S:
        """One step: how far, go, check, tell."""
        stop = next_stop(state.time, self.until, self.paces)
        limit = tightest(self.flow.limit(state), ceiling)
        if not limit.dt > 1e-13 * max(abs(state.time), abs(stop)):
            raise self.blown_up(state, "the time step vanishes", limit, taken=0)
        step = next_step(state.time, stop, limit)
        new = self.take(state, step, stop)
        self.node_steps += new.size
        self.tell(self.moment(new, step))
        self.good = new
        if self.seconds - self.saved >= self.checkpoint_every:
            self.save()
        return new

    def take(self, state: S, step: Limit, stop: float) -> S:
        """The state after the step, finite and at the time meant, or a BlowUpError."""
        try:
            with np.errstate(all="ignore"):  # what overflows is found just below, and named
                new: S = tree.settled(self.flow.step(state, step.dt))
        except (InputError, ArithmeticError, MemoryError) as error:  # ours and what numbers do
            problem, hint = _told(error)
            raise self.blown_up(state, problem, step, hint) from error
        if bad := tree.first_not_finite(new):
            raise self.blown_up(state, f"{bad} is not finite", step)
        if new.step != state.step + 1 or not arrives(new.time, state.time + step.dt, step.dt):
            raise InputError(
                f"flow.step(state, dt={step.dt:.6g}) must add 1 to the step and dt to the time, "
                f"got step {state.step} -> {new.step}, time {state.time:.6g} -> {new.time:.6g}",
                hint="dataclasses.replace(state, step=state.step + 1, time=state.time + dt, ...)",
            )
        if arrives(new.time, stop, step.dt) and new.time != stop:
            new = cast(S, replace(cast(Any, new), time=stop))
        return new

    def tell(self, moment: Moment) -> None:
        """Call the watchers and write their row."""
        row: dict[str, object] = {
            "step": moment.step,
            "time": moment.time,
            "dt": moment.dt,
            "rule": moment.rule,
        }
        for watcher in self.watch:
            row.update(watcher(moment) or {})
        if self.folder:
            self.folder.series.append(row)

    def moment(self, state: S, step: Limit) -> Moment:
        """What the watchers see."""
        return Moment(
            flow=self.flow,
            state=state,
            dt=step.dt,
            rule=step.rule,
            until=self.until,
            seconds=self.seconds,
            node_steps=self.node_steps,
            out=self.folder.path if self.folder else None,
        )

    @contextlib.contextmanager
    def watching(self, state: S) -> Iterator[None]:
        """Open the watchers, show them the start, and whatever happens keep the last good state."""
        start = self.moment(state, Limit(0.0, "start"))
        fresh = self.folder is None or not self.folder.resumed
        closers: list[Callable[[], None]] = []
        try:
            if self.folder:
                self.folder.begin(state.step)
            for watcher in self.watch:
                if isinstance(watcher, Staged):
                    watcher.open(start)
                    closers.append(watcher.close)
            if fresh:
                self.tell(start)
            self.good = state
            if fresh:
                self.save()
            yield
            self.save()
        except KeyboardInterrupt:
            self.save()
            raise KeyboardInterrupt(self.farewell()) from None
        except BaseException:
            with contextlib.suppress(PmeshError, OSError, MemoryError):  # the first is reported
                self.save()
            raise
        finally:
            for close in reversed(closers):
                close()
            if self.folder:
                self.folder.close(forget=fresh and self.good is None)

    def save(self) -> None:
        """Write the last good state to the checkpoint."""
        if self.folder and self.good is not None:
            self.folder.save(self.good, self.seconds, self.node_steps)
        self.saved = self.seconds

    def farewell(self) -> str:
        """What Ctrl-C leaves behind."""
        if self.good is None:
            return "stopped before the first step"
        where = f"stopped after step {self.good.step} (t = {self.good.time:.6g})"
        return f"{where}; {self.folder.path / CHECKPOINT} keeps it" if self.folder else where

    def blown_up(
        self, state: S, problem: str, step: Limit, hint: str | None = None, taken: int = 1
    ) -> BlowUpError:
        """The error that names step, time, dt, its rule and where the last good state is."""
        if self.folder:
            kept = str(self.folder.path / CHECKPOINT)
        else:
            kept = f"the error's `state` (step {state.step})"
        error = BlowUpError(
            f"{problem} after step {state.step + taken} (t = {state.time + taken * step.dt:.4g}); "
            f"dt = {step.dt:.2g} was set by the {step.rule} rule.",
            hint=hint or "a smaller `deformation`, or a finer `spacing`",
            kept=kept,
        )
        error.state = state
        return error


def _told(error: Exception) -> tuple[str, str | None]:
    """What broke inside a step, and what to do."""
    if isinstance(error, PmeshError):
        return error.problem, error.hint
    if isinstance(error, MemoryError):
        said = f"the memory does not suffice ({error})" if str(error) else "the memory is full"
        return said, "a smaller step, or a mesh of fewer nodes"
    return f"the numbers broke ({type(error).__name__}: {error})", None


def _checked(until: float, dt: float | None, checkpoint_every: float) -> Limit:
    """The step that the user allows at most, once the numbers given are known to make sense."""
    if not math.isfinite(until):
        raise InputError(f"until must be a finite time, got {until}", hint="until=3.0")
    if dt is not None and not (math.isfinite(dt) and dt > 0):
        raise InputError(f"dt must be a positive time, got {dt}", hint="dt=None: the flow's limit")
    if not checkpoint_every >= 0:
        raise InputError(
            f"checkpoint_every must be seconds of work, got {checkpoint_every}",
            hint="30, or 0 for a checkpoint at every step",
        )
    return Limit(math.inf if dt is None else dt, "given")


def _check_start(state: S, until: float) -> None:
    """Refuse a start that is not finite, or one beyond the end."""
    if bad := tree.first_not_finite(state):
        raise InputError(f"{bad} of the start is not finite", hint="a start without nan and inf")
    if until < state.time:
        raise InputError(
            f"until must not lie before the state, got until = {until} and t = {state.time}",
            hint=f"until={state.time + 1.0:g}",
        )
