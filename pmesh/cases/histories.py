"""Pictures of a series: forces over time beside published ones, and their spectra."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.run.series import Series
from pmesh.run.statistics import Statistics, spectrum, statistics
from remesh.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.cases.reference import Curve

Values = NDArray[np.float64]
FORCE = re.compile(r"(^|_)(force|torque|power|drag|lift|thrust)(_|$)")  # means over steps
MOTION = re.compile(r"^body\d+_(u|v|w|spin.*)$")  # velocities, at the end of a step
ROUND_OFF = 1e-8  # of the largest force: a force that symmetry forbids
COLOURS = (OURS, OTHERS[1], OTHERS[0], "#b8860b", "#a23b72", OTHERS[2])
UNITS = {  # of columns, in the plane and per unit density of the fluid; length L, time T
    "u": "$[L/T]$",
    "v": "$[L/T]$",
    "w": "$[L/T]$",
    "spin": "$[rad/T]$",
    "force": "$[L^3/T^2]$",
    "torque": "$[L^4/T^2]$",
    "power": "$[L^4/T^3]$",
}
STYLES = ("-", ":", "--", "-.")
HARMONICS = 6  # of the dominant frequency, in the picture of a spectrum


def forces(series: Series) -> list[str]:
    """The columns that hold a force, torque or power, one number at least."""
    return [
        name
        for name, values in series.items()
        if FORCE.search(name) and np.isfinite(np.asarray(values, np.float64)).any()
    ]


def motions(series: Series) -> list[str]:
    """The columns that hold a velocity or spin of a body."""
    return [name for name in series if MOTION.match(name)]


def alive(series: Series, names: list[str]) -> list[str]:
    """Those of the columns that are more than round-off of the largest of them, after the start."""
    tops = {name: _top(series, name) for name in names}
    largest = max(tops.values(), default=0.0)
    return [name for name in names if tops[name] > ROUND_OFF * largest]


def statistics_of(series: Series, names: list[str]) -> dict[str, Statistics]:
    """Statistics of columns, without those too short to have any."""
    found = {}
    for name in names:
        try:
            found[name] = statistics(series["time"], series[name], _dt(series, name))
        except InputError:
            continue
    return found


@styled
def history_figure(series: Series, names: list[str], published: Mapping[str, Curve]) -> Figure:
    """Columns over time, a panel for each kind of force, over published curves where there are."""
    kinds: dict[str, list[str]] = {}
    for name in names:
        kinds.setdefault(_kind(name), []).append(name)
    figure, axes = panels(len(kinds), 1, (7.2, 0.6 + 2.1 * len(kinds)), sharex=True)
    for panel, (kind, members) in zip(axes[:, 0], kinds.items(), strict=True):
        for number, name in enumerate(members):
            colour, style = COLOURS[number % len(COLOURS)], STYLES[number % len(STYLES)]
            dt = _dt(series, name)
            time = series["time"] - (0.0 if dt is None else 0.5 * dt)
            told = np.isfinite(series[name])  # some routes are asked at every few steps
            panel.plot(
                time[told], series[name][told], style, color=colour, lw=1.3, label=spoken(name)
            )
        curves = [(name, published[name]) for name in members if name in published]
        for number, (_, curve) in enumerate(curves):
            panel.plot(
                curve.time, curve.value, "os^D"[number % 4], color=REFERENCE, mfc="white",
                label=curve.source,
            )  # fmt: skip
        panel.set(ylabel=_with_unit(kind), ylim=_limits(series, members, [c for _, c in curves]))
        if len(members) + len(curves) > 1:
            panel.legend(loc="best", ncols=2)
    axes[-1, 0].set(xlabel="$t$", xlim=(0.0, float(series["time"][-1])))
    return figure


@styled
def spectrum_figure(series: Series, found: Mapping[str, Statistics]) -> Figure | None:
    """Power spectra of the periodic columns, their later half; None if there is none."""
    cycles = {name: known for name, known in found.items() if known.cycle is not None}
    if not cycles:
        return None
    figure, axes = panels(1, 1, (7.2, 2.9))
    panel: Axes = axes[0, 0]
    first = min(known.cycle.frequency.value for known in cycles.values() if known.cycle)
    top = 0.0
    for number, (name, known) in enumerate(cycles.items()):
        part = spectrum(series["time"], series[name], _dt(series, name), after=known.start)
        seen = (part.frequency > 0) & (part.frequency < HARMONICS * first)
        colour = COLOURS[number % len(COLOURS)]
        panel.semilogy(
            part.frequency[seen], part.power[seen], STYLES[number % len(STYLES)], color=colour,
            lw=1.2, label=spoken(name),
        )  # fmt: skip
        top = max(top, float(part.power[seen].max(initial=0.0)))
        if known.cycle is not None:
            panel.axvline(known.cycle.frequency.value, color=colour, lw=0.6, alpha=0.6)
    panel.set(xlabel="frequency", ylabel="power density", xlim=(0, HARMONICS * first))
    panel.set_ylim(1e-8 * top, 3 * top)
    panel.legend(loc="upper right", ncols=2)
    return figure


def spoken(name: str) -> str:
    """A column's name as one says it: "body 0, force x"."""
    body, _, rest = name.partition("_")
    number = body.removeprefix("body")
    if number != body and number.isdigit() and rest:
        return f"body {number}, {rest.replace('_', ' ')}"
    return name.replace("_", " ")


def _dt(series: Series, name: str) -> Values | None:
    """The steps of a column that holds means over them, None for values at their ends."""
    return np.asarray(series["dt"], np.float64) if FORCE.search(name) else None


def _kind(name: str) -> str:
    """What a column measures, whichever body and route."""
    if MOTION.match(name):
        return name.partition("_")[2].replace("_", " ")
    words = name.split("_")
    start = next((i for i, word in enumerate(words) if FORCE.search(word)), 0)
    return " ".join(words[start:])


def _with_unit(kind: str) -> str:
    """The name of an axis: what is measured, and its unit per density of the fluid."""
    words = kind.split()
    unit = next((unit for word, unit in UNITS.items() if word in words), None)
    return kind if unit is None else f"{kind} {unit}"


def _late(series: Series, name: str) -> Values:
    """A column after the singular start of a run: a fiftieth of it."""
    time = np.asarray(series["time"], np.float64)
    values = np.asarray(series[name], np.float64)[time >= 0.02 * time[-1]]
    return np.asarray(values[np.isfinite(values)])


def _top(series: Series, name: str) -> float:
    return float(np.abs(_late(series, name)).max(initial=0.0))


def _limits(series: Series, names: list[str], curves: list[Curve]) -> tuple[float, float]:
    """Limits that show what comes after the start, and zero where it is near."""
    ours = np.concatenate([_late(series, name) for name in names])
    low, high = (float(x) for x in np.quantile(ours, [0.01, 0.99]))
    end = float(series["time"][-1])
    for curve in curves:
        shown = curve.value[(curve.time >= 0.05 * end) & (curve.time < end)]
        low, high = min(low, *shown, high), max(high, *shown, low)
    low = 0.0 if 0 < low < 0.6 * high else low
    high = 0.0 if 0 > high > 0.6 * low else high
    room = 0.12 * (high - low) or max(abs(high), 1e-12)
    return low - (room if low != 0 else 0.0), high + (room if high != 0 else 0.0)
