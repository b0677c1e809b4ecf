"""The report of a run: one page of HTML with everything in it, to look at, send and print."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from html import escape
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pmesh.cases.frames import written
from pmesh.cases.histories import (
    alive,
    forces,
    history_figure,
    motions,
    spectrum_figure,
    spoken,
    statistics_of,
)
from pmesh.cases.interface_film import INTERFACES
from pmesh.cases.markup import anchor, drawn, image, number, span, spark, table, video
from pmesh.cases.movie import film
from pmesh.cases.options import options, spelt
from pmesh.cases.reference import DATA, Curve
from pmesh.cases.registry import find
from pmesh.cases.runner import read_case
from pmesh.cases.wake import wake_figure
from pmesh.run.amr import AdaptiveSnapshot
from pmesh.run.files import reading, write_atomic
from pmesh.run.rundir import CASE, FIGURE, SERIES, SUMMARY
from pmesh.run.series import Series, read_series
from pmesh.run.snapshots import Snapshot, read_snapshots
from pmesh.run.statistics import Statistics
from remesh.errors import InputError, PmeshError

if TYPE_CHECKING:
    from pmesh.cases.case import Case

Movie = Literal["gif", "mp4", "none"]
FRAMES = 100  # of the movie: of more snapshots every second, third, ... is shown
FEW = 30  # of lit surfaces in space, which take a second or two each
HEAD = ("step", "time", "dt", "rule")


@dataclass(frozen=True)
class Run:
    """What a run directory holds; what is not there yet is empty or None."""

    folder: Path

    @cached_property
    def content(self) -> dict[str, Any]:
        """Case, version, commit and parameters, as in case.toml; of a script's run its folder."""
        if not (self.folder / CASE).is_file():
            return {"case": self.folder.resolve().name, "parameters": {}}
        name, parameters = read_case(self.folder / CASE)
        text = (self.folder / CASE).read_text(encoding="utf-8")
        return {**tomllib.loads(text), "case": name, "parameters": parameters}

    @cached_property
    def case(self) -> Case | None:
        """The case with its parameters; None if its class is not here, or no longer takes them."""
        try:
            return find(self.content["case"]).make(self.content["parameters"])
        except (InputError, ImportError):
            return None

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The content of summary.json; empty for a run that has not finished."""
        path = self.folder / SUMMARY
        if not path.is_file():
            return {}
        with reading(path):
            return dict(json.loads(path.read_text(encoding="utf-8")))

    @cached_property
    def series(self) -> Series:
        """The columns of series.csv; none before the first row."""
        return read_series(self.folder) if (self.folder / SERIES).is_file() else {}

    @cached_property
    def snapshots(self) -> list[Snapshot]:
        """The snapshots in the order of their times."""
        return read_snapshots(self.folder)

    @cached_property
    def forces(self) -> list[str]:
        """The columns with forces that are not round-off."""
        return alive(self.series, forces(self.series)) if len(self.times) > 1 else []

    @cached_property
    def motions(self) -> list[str]:
        """The columns with velocities of bodies that are not round-off."""
        return alive(self.series, motions(self.series)) if len(self.times) > 1 else []

    @cached_property
    def statistics(self) -> dict[str, Statistics]:
        """Of the forces and velocities."""
        return statistics_of(self.series, self.forces + self.motions)

    @property
    def times(self) -> Any:
        """Times of the rows [T]."""
        return self.series.get("time", np.empty(0))

    @property
    def published(self) -> Mapping[str, Curve]:
        """Published histories by column."""
        return self.case.published() if self.case else {}


def report(folder: str | Path, out: str | Path | None = None, *, movie: Movie = "gif") -> Path:
    """Write the page about a run directory, by default ``report.html`` in it; returns its path.

    Parameters, metrics, figure, forces over published ones, their statistics and spectra, wake,
    movie ("gif", "mp4" or "none"), ledger, cost and version: what the run has. Nothing in it is
    loaded from elsewhere. Refuses a directory without a run.
    """
    if movie not in ("gif", "mp4", "none"):
        raise InputError(f"movie must be gif, mp4 or none, got {movie!r}", hint="gif")
    run = Run(Path(folder))
    if not any((run.folder / name).is_file() for name in (CASE, SERIES)):
        raise InputError(f"{folder} holds no run", hint="a directory that `pmesh run` wrote")
    path = run.folder / "report.html" if out is None else Path(out)
    write_atomic(path, page(run, movie).encode())
    return path


def page(run: Run, movie: Movie = "gif") -> str:
    """The HTML of the report."""
    parts = {
        "Metrics": _metrics(run),
        "Figure": _picture(run),
        "Forces": _if_drawn(_forces, run),
        "Motion": _if_drawn(_motion, run),
        "Statistics": _statistics(run),
        "Spectrum": _if_drawn(_spectrum, run),
        "Wake" if run.forces else "Vorticity": _if_drawn(_wake, run),
        "Mesh": _if_drawn(_mesh, run),
        "Movie": _if_drawn(partial(_movie, kind=movie), run),
        "Series": _ledger(run),
        "Parameters": _parameters(run),
        "Cost and version": _cost(run),
    }
    shown = {name: body for name, body in parts.items() if body}
    title = run.case.title if run.case else run.content["case"]
    return Template((DATA / "report.html").read_text(encoding="utf-8")).substitute(
        title=escape(title),
        lead=escape(run.case.source if run.case else "") or "A run of pmesh",
        facts="\n".join(
            f"<div><dt>{escape(name)}</dt><dd>{value}</dd></div>" for name, value in _facts(run)
        ),
        links=" ".join(f'<a href="#{anchor(name)}">{name}</a>' for name in shown),
        sections="\n".join(
            f'<section id="{anchor(name)}">\n<h2>{name}</h2>\n{body}\n</section>'
            for name, body in shown.items()
        ),
    )


def _if_drawn(part: Callable[[Run], str], run: Run) -> str:
    """A part of the page, or the line that says why it has no picture."""
    try:
        return part(run)
    except PmeshError as error:
        return f'<p class="soft">No picture: {escape(error.problem)}.</p>'


def _facts(run: Run) -> Iterable[tuple[str, str]]:
    judged = [m["pass"] for m in run.summary.get("metrics", ()) if m["pass"] is not None]
    if not run.summary and run.case:
        yield "result", "not finished"
    elif judged:
        kind = "pass" if all(judged) else "fail"
        yield "within tolerance", f'<span class="{kind}">{sum(judged)} of {len(judged)}</span>'
    if len(run.times):
        yield "time reached", number(run.times[-1])
        yield "steps", f"{int(run.series['step'][-1]):,}"
    if run.summary:
        yield "seconds of work", f"{run.summary['cost']['seconds']:,.1f}"


def _metrics(run: Run) -> str:
    rows = []
    for metric in run.summary.get("metrics", ()):
        numbers = [number(metric[key]) for key in ("value", "reference", "error", "tolerance")]
        aside = "" if metric["reference"] is None else span("soft", "not judged")
        result = {True: span("pass", "pass"), False: span("fail", "FAIL"), None: aside}
        words = [escape(str(metric[key])) for key in ("grade", "source")]
        rows.append([escape(metric["name"]), *numbers, result[metric["pass"]], *words])
    if not rows:
        return (
            ""
            if run.summary or not run.case
            else "<p>The run has not finished: it has no metrics yet.</p>"
        )
    names = ("metric", "value", "reference", "error", "tolerance", "result", "grade", "source")
    grades = "Grades: A exact, B read in a published document, C remembered."
    return table(names, rows, numbers=range(1, 5)) + f'<p class="soft">{grades}</p>'


def _picture(run: Run) -> str:
    path = run.folder / FIGURE
    if not path.is_file():
        return ""
    with reading(path):
        return image(path.read_bytes(), "png", "The picture of the case, ours over the reference")


def _forces(run: Run) -> str:
    if not run.forces:
        return ""
    sources = sorted({curve.source for curve in run.published.values()})
    text = "Forces over time, per unit density; means over a step at its middle"
    over = f"{text}, over {' and '.join(sources)}" if sources else text
    return drawn(history_figure(run.series, run.forces, run.published), over)


def _motion(run: Run) -> str:
    if not run.motions:
        return ""
    return drawn(history_figure(run.series, run.motions, {}), "Velocities of the bodies over time")


def _statistics(run: Run) -> str:
    if not run.statistics:
        return ""
    rows = []
    for name, found in run.statistics.items():
        cycle = found.cycle
        cells: list[object] = (
            [cycle.amplitude, cycle.frequency, cycle.cycles] if cycle else [""] * 3
        )
        over = f"{found.start:.4g} to {found.end:.4g}"
        rows.append([escape(str(x)) for x in (spoken(name), over, found.mean, found.rms, *cells)])
    odd = {note for found in run.statistics.values() if (note := found.note)}
    why = "".join(f"<li>{escape(note)}</li>" for note in sorted(odd))
    names = ("column", "over t", "mean", "rms", "amplitude", "frequency", "cycles")
    told = "Periodic columns over their whole cycles, others over the later half of the run."
    found_table = table(names, rows, numbers=range(1, 7))
    return f'{found_table}<p class="soft">{told}</p>' + (
        f"<ul class='soft'>{why}</ul>" if why else ""
    )


def _spectrum(run: Run) -> str:
    figure = spectrum_figure(run.series, run.statistics) if run.statistics else None
    text = "Power spectral density of the periodic columns, from when they are periodic; "
    return drawn(figure, text + "a line at each dominant frequency") if figure else ""


def _wake(run: Run) -> str:
    shown = [shot for shot in run.snapshots if "vorticity" in shot.names]
    if not shown:
        return ""
    last = shown[-1]
    if last.grid.ndim == 2:
        return drawn(wake_figure(last), f"Vorticity at t = {last.time:.5g}")
    if not np.any(last["vorticity"]):
        return ""
    from pmesh.cases.vortex_figure import vortex_figure

    figure, look = vortex_figure(last)
    level = f"Where {look.field} = {look.levels[0]:.3g}" if look.levels else f"No {look.field}"
    text = f"{level} at t = {last.time:.5g}, and the vorticity across two planes"
    return drawn(figure, text)


def _mesh(run: Run) -> str:
    shown = [shot for shot in run.snapshots if isinstance(shot, AdaptiveSnapshot)]
    if not shown or not shown[-1].names:
        return ""
    from pmesh.cases.mesh_picture import mesh_history

    last, names = shown[-1], shown[-1].names
    name = next((n for n in ("vorticity", *INTERFACES) if n in names), next(iter(names)))
    figure = mesh_history(last.on_blocks(name), last.blocks, run.series)
    return drawn(figure, f"{spoken(name)} and the blocks of its mesh at t = {last.time:.5g}")


def _movie(run: Run, kind: Movie) -> str:
    shown = [shot for shot in run.snapshots if "vorticity" in shot.names]
    if kind == "none" or len(shown) < 2:
        return ""
    in_space = shown[0].grid.ndim == 3
    if in_space and not any(np.any(shot["vorticity"]) for shot in shown):
        return ""
    shown = shown[:: -(-len(shown) // (FEW if in_space else FRAMES))]
    content = written(film(shown), kind, fps=12.0)
    what = "Vortices" if in_space else "Vorticity"
    text = f"{what} from t = {shown[0].time:.4g} to {shown[-1].time:.4g}"
    return image(content, "gif", text) if kind == "gif" else video(content, text)


def _ledger(run: Run) -> str:
    rows = []
    for name, column in run.series.items():
        if name in HEAD:
            continue
        values = np.asarray(column, np.float64)
        known = values[np.isfinite(values)]
        if known.size:
            ends = [number(x) for x in (known[0], known[-1], known.min(), known.max())]
            rows.append([escape(spoken(name)), *ends, spark(run.times, values)])
    names = ("column", "first", "last", "smallest", "largest", "over time")
    return table(names, rows, numbers=range(1, 5)) if rows else ""


def _parameters(run: Run) -> str:
    known = options(type(run.case)) if run.case else {}
    rows = []
    for name, value in run.content["parameters"].items():
        unit = known[name].unit if name in known else ""
        help = known[name].help if name in known else ""
        rows.append([f"<code>{escape(name)}</code>", *map(escape, (spelt(value), unit, help))])
    names = ("parameter", "value", "unit", "what it is")
    return table(names, rows, numbers=[1]) if rows else ""


def _cost(run: Run) -> str:
    cost = run.summary.get("cost", {})
    rows = [[escape(name.replace("_", " ")), f"{value:,}"] for name, value in cost.items()]
    known = [name for name in ("case", "version", "commit") if name in run.content]
    rows += [[name, f"<code>{escape(str(run.content[name]))}</code>"] for name in known]
    return table(("what", "value"), rows, numbers=[1]) if len(rows) > 1 else ""
