"""Progress: a live line on a terminal; elsewhere one log line now and then."""

from __future__ import annotations

import logging
import sys
from time import perf_counter
from typing import IO, TYPE_CHECKING

from pmesh.run.protocols import Moment

if TYPE_CHECKING:
    from rich.progress import Progress as Bar
    from rich.progress import TaskID

log = logging.getLogger("pmesh.run")


class Progress:
    """A watcher that shows step, time, dt with its rule, and the time left.

    On a terminal a live line, four times a second; elsewhere a line through the logger
    ``pmesh.run`` every ``seconds`` of work, at the start and at the end.
    """

    def __init__(self, *, seconds: float = 10.0, stream: IO[str] | None = None) -> None:
        self.seconds = seconds
        self.stream = stream
        self._bar: Bar | None = None
        self._task: TaskID | None = None
        self._last: Moment | None = None

    def open(self, moment: Moment) -> None:
        """Start the line, or say in the log where the run starts."""
        stream = self.stream or sys.stderr
        self._start = self._from = moment.time
        self._began = perf_counter()
        self._spoke = self._began
        self._first = moment.step + 1
        self._last = None
        if stream.isatty():
            self._bar = _bar(stream)
            self._task = self._bar.add_task("", total=1.0, line=line(moment, None))
            self._bar.start()
        else:
            log.info("from t = %.6g to t = %.6g, %s", moment.time, moment.until, _nodes(moment))

    def __call__(self, moment: Moment) -> None:
        """Show this moment."""
        self._last = moment
        now = perf_counter()
        if moment.step == self._first:  # it may compile: no measure of what is left
            self._from, self._began = moment.time, now
        if self._bar is not None and self._task is not None:
            done = _part(moment, self._start)
            self._bar.update(self._task, completed=done, line=line(moment, self._left(moment)))
        elif now - self._spoke >= self.seconds:
            self._spoke = now
            log.info("%s", line(moment, self._left(moment)))

    def close(self) -> None:
        """Leave the last line standing."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None
        elif self._last is not None:
            log.info("%s; %.1f s of work", line(self._last, None), self._last.seconds)

    def _left(self, moment: Moment) -> float | None:
        """Seconds left, if the rest goes as fast as the part after the first step did."""
        done = _part(moment, self._from)
        return (perf_counter() - self._began) * (1 - done) / done if done > 0 else None


def line(moment: Moment, left: float | None) -> str:
    """Step, time, dt and its rule, and the time left, in one line."""
    text = (
        f"step {moment.step}  t = {moment.time:.4g} / {moment.until:.4g}"
        f"  dt = {moment.dt:.2e} ({moment.rule})"
    )
    return text if left is None else f"{text}  {duration(left)} left"


def duration(seconds: float) -> str:
    """Seconds as people say them: 42 s, 3 min 20 s, 2 h 5 min."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def _part(moment: Moment, start: float) -> float:
    whole = moment.until - start
    return (moment.time - start) / whole if whole > 0 else 1.0


def _nodes(moment: Moment) -> str:
    """What a step moves; of less than all nodes of the grid, how many these are."""
    grid, size = moment.state.grid, int(moment.state.size)
    whole = " x ".join(str(n) for n in grid.shape) + " nodes"
    return whole if size == grid.size else f"{size} of {whole}"


def _bar(stream: IO[str]) -> Bar:
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn
    from rich.progress import Progress as Bar

    return Bar(
        BarColumn(bar_width=24),
        TaskProgressColumn(),
        TextColumn("{task.fields[line]}"),
        console=Console(file=stream),
        refresh_per_second=4,
    )
