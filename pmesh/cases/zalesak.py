"""Zalesak's bodies turn rigidly: what disk and sphere share, and how their error is measured."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, NoReturn, Self

import numpy as np
from numpy.typing import NDArray

from levelset.shape import Shape
from pmesh.cases.case import Case, Outcome
from pmesh.cases.interface_error import mean_error
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE
from pmesh.run.summary import Metric
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from levelset.interface import Interface
    from levelset.laws import Rotation
    from levelset.transport import ParticleLevelSet
    from pmesh.run.protocols import Moment, Watcher
    from pmesh.run.series import Series

Values = NDArray[np.float64]
PERIOD = 628.0  # [T]
BOX = 100.0  # [L]
WORDS = ("never", "always", "distorted")
ROTATION = "rigid motion keeps every distance"
MOST = 1e-6  # allowed departure [L]


class Marks(NamedTuple):
    """Points on the interface that the particles rebuild at the start."""

    points: Values  # (n, ndim) [L]
    values: Values  # (n,): what is rebuilt there, nearly zero [L]
    slopes: Values  # (n,): its gradient's size


@dataclass(frozen=True, kw_only=True)
class Zalesak(Case):
    """A slotted body turns rigidly in a box 100 wide; a turn takes 628 units of time."""

    until: float = option(PERIOD, "end of the run; a turn takes 628", unit="T")
    turns: float | None = option(None, "end of the run in turns, in place of `until`; not both")
    nodes: int = option(100, "mesh cells along the box")
    steps: int = option(628, "time steps per turn (RK4)")
    remeshing: str = option("never", "never, always, distorted, or every so many steps")
    kernel: str = option("L6,4", "remeshing kernel")
    width: float | None = option(None, "half width of the band in spacings; 3 or, remeshed, 6")
    radius: float = option(0.8, "of the mollifier that rebuilds, in spacings")
    every: float = option(PERIOD / 4, "time between snapshots", unit="T")

    looks: ClassVar[int] = 20  # at the interface, per turn
    fine: ClassVar[int] = 10  # samples per spacing of the mean error
    reach: ClassVar[float] = 1.5  # spacings to both sides of the interface that they cover

    def __post_init__(self) -> None:
        """Refuse what cannot be computed; turns become the end of the run."""
        super().__post_init__()
        self.positive("turns", "width", "radius", "every")
        if self.turns is not None:
            if self.until != PERIOD:
                _refuse_two_ends(self.until, self.turns)
            object.__setattr__(self, "until", PERIOD * self.turns)
            object.__setattr__(self, "turns", None)
        self.require(self.nodes >= 25, "nodes", "at least 25: the slot is 5 wide")
        self.require(self.steps >= 8, "steps", "at least 8")
        words = ", ".join(WORDS)
        known = self.remeshing in WORDS or (self.remeshing.isdigit() and int(self.remeshing) > 0)
        self.require(known, "remeshing", f"{words} or a number of steps")

    @classmethod
    def make(cls, values: Mapping[str, Any], *, quick: bool = False) -> Self:
        """The case with these options; refuses turns and an end in time at once."""
        if (turns := values.get("turns")) is not None:
            if "until" in values:
                _refuse_two_ends(values["until"], turns)
            values = {**values, "until": PERIOD}  # also for a quick run
        return super().make(values, quick=quick)

    @property
    @abstractmethod
    def shape(self) -> Shape:
        """The body at the start."""

    @property
    @abstractmethod
    def law(self) -> Rotation:
        """How it turns."""

    @property
    def spacing(self) -> float:
        """Of the mesh [L]."""
        return BOX / self.nodes

    @property
    def word(self) -> str:
        """What its volume is called."""
        return "area" if self.shape.ndim == 2 else "volume"

    def build(self) -> tuple[Any, Any]:
        """The recipe, and particles near the body's surface."""
        return _start(replace(self, until=PERIOD))

    def recipe(self) -> ParticleLevelSet:
        """Steps of the asked length are the largest that the recipe allows."""
        from levelset.transport import ParticleLevelSet

        often = self.remeshing
        grid = Grid((self.nodes + 1,) * self.shape.ndim, self.spacing)
        return ParticleLevelSet(
            grid=grid,
            velocity=self.law,
            kernel=self.kernel,
            width=self.width or (3.0 if often == "never" else 6.0),
            remeshing=often if often in WORDS else int(often),  # type: ignore[arg-type]
            deformation=self.law.max_gradient() * PERIOD / self.steps,
        )

    def watchers(self) -> Sequence[Watcher]:
        """What this module measures, and snapshots."""
        from pmesh.run.snapshots import Snapshots

        return [self.watch, Snapshots(self.every, dtype="float32")]

    def watch(self, moment: Moment) -> dict[str, float]:
        """Watcher: particles and their paths; now and then volume and interface."""
        state, flow = moment.state, moment.flow
        found = {
            "particles": float(state.size),
            "remeshings": float(state.remeshings),
            "path_error": self.path_error(state),
        }
        if state.step % max(1, self.steps // self.looks) and not moment.on(self.every):
            return {**found, **dict.fromkeys((self.word, "departure", "mean_error"), math.nan)}
        return {
            **found,
            self.word: float(flow.ledger(state)["volume"]),
            "departure": self.departure(state),
            "mean_error": self.mean_error(state) if self.shape.ndim == 2 else math.nan,
        }

    def rebuilt(self, state: Interface, points: NDArray[Any]) -> Values:
        """The signed distance [L] that particles stand for at points (m, ndim): a mollified sum."""
        return np.asarray(self.build()[0].rebuild(state, points, radius=self.radius))

    def path_error(self, state: Interface) -> float:
        """How far particles are at most from where the exact rotation takes them [L]."""
        if state.remeshings:
            return math.nan  # they have begun anew
        homes = self.spacing * np.stack(np.unravel_index(state.nodes, state.grid.shape), axis=1)
        away = state.positions - self.law.flow(homes, 0.0, state.time)
        return float(np.sqrt((away**2).sum(axis=1)).max())

    def departure(self, state: Interface) -> float:
        """How far the rebuilt interface has left its own start, turned exactly: at most [L].

        The change of the level set at the points of the start, over its slope there.
        """
        marks = _marks(replace(self, until=PERIOD))
        now = self.rebuilt(state, self.law.flow(marks.points, 0.0, state.time))
        return float(np.abs((now - marks.values) / marks.slopes).max())

    def mean_error(self, state: Interface) -> float:
        """Mean distance of the rebuilt interface from the exact one, in spacings."""

        def value_at(points: Values) -> Values:
            return self.rebuilt(state, self.law.flow(points, 0.0, state.time))

        return mean_error(self.shape, value_at, self.spacing, fine=self.fine, reach=self.reach)

    def field(self, state: Interface, fine: int) -> tuple[Values, Grid]:
        """The level set that the particles rebuild, turned back to the start, and its mesh.

        ``fine`` nodes per spacing, up to 1.5 spacings from the exact interface; beyond the latter.
        """
        step = self.spacing / fine
        low, high = (np.array(corner) for corner in self.shape.reach(2.0 * self.spacing))
        counts = np.ceil((high - low) / step).astype(int) + 1
        grid = Grid(tuple(counts), step, tuple(low))
        points = grid.points()
        phi = self.shape.distance(points)
        near = np.abs(phi) < 1.5 * self.spacing
        there = self.law.flow(points[:, near].T, 0.0, state.time)
        found = self.rebuilt(state, there)
        phi[near] = np.where(np.isnan(found), phi[near], found)
        return np.asarray(phi), grid

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Volume and interface at the end; without remeshing, how exact the motion is."""
        flow, state, first = outcome.flow, outcome.state, self.build()[1]
        known = self.shape.volume
        volume = float(flow.ledger(state)["volume"])
        found = [Metric(f"{self.word} at the end", volume, known, 0.01, "A", "closed form")]
        if not state.remeshings:
            found += [
                Metric(name, value, 0.0, MOST, "A", ROTATION, "absolute")
                for name, value in (
                    ("departure of the rebuilt interface", self.departure(state)),
                    ("departure of the particles", self.path_error(state)),
                )
            ]
        if self.remeshing == "distorted":
            often = float(state.remeshings)
            found.append(Metric("remeshings", often, 0.0, 0.0, "A", ROTATION, "absolute"))
        return [
            *found,
            Metric("mean interface error in cells, start", self.mean_error(first), kind="report"),
            Metric("mean interface error in cells, end", self.mean_error(state), kind="report"),
            Metric("particles", float(state.size), kind="report"),
        ]


def show_errors(panel: Axes, series: Series, spacing: float) -> None:
    """Departures and, where it was measured, the mean error over the turns."""
    turns = series["time"] / PERIOD
    for name, label, colour in (
        ("mean_error", "mean distance from the exact surface", OTHERS[0]),
        ("departure", "rebuilt interface from its start, largest", OURS),
        ("path_error", "particles from exact paths, largest", OTHERS[1]),
    ):
        values = np.asarray(series[name], np.float64)
        seen = np.isfinite(values) & (values > 0)
        if seen.any():
            scale = spacing if name == "mean_error" else 1.0
            panel.semilogy(turns[seen], scale * values[seen], color=colour, label=label)
    panel.axhline(MOST, color=REFERENCE, lw=1.0, ls=(0, (4, 3)), label="asked without remeshing")
    panel.set(title=f"errors (a cell is {spacing:g})", xlabel="turns", xlim=(0, None))


def _refuse_two_ends(until: object, turns: object) -> NoReturn:
    raise InputError(
        f"until and turns both say when to end, got {until} and {turns}",
        hint=f"--turns {turns} alone",
    )


def in_turns(time: float) -> str:
    """A time in turns."""
    turns = time / PERIOD
    return f"{turns:.4g} turn{'' if turns == 1 else 's'}"


@lru_cache(maxsize=4)
def _start(case: Zalesak) -> tuple[ParticleLevelSet, Interface]:
    """The recipe, and the particles near the surface."""
    flow = case.recipe()
    return flow, flow.start(case.shape)


@lru_cache(maxsize=4)
def _marks(case: Zalesak) -> Marks:
    """Points of the rebuilt interface at the start, some per spacing in the plane, in space fewer.

    From points of the exact surface by Newton steps along the gradient.
    """
    state = _start(case)[1]
    points = _surface_points(case)
    h = 1e-3 * case.spacing
    for _ in range(8):
        values = case.rebuilt(state, points)
        gradient = np.stack(
            [
                case.rebuilt(state, points + h * e) - case.rebuilt(state, points - h * e)
                for e in np.eye(case.shape.ndim)
            ],
            axis=1,
        ) / (2 * h)
        slopes = np.sqrt((gradient**2).sum(axis=1))
        if np.abs(values).max() < 1e-9:
            break
        points = points - (values / slopes**2)[:, None] * gradient
    return Marks(points, values, slopes)


def _surface_points(case: Zalesak) -> Values:
    """Points (n, ndim) of the body's surface, spread over it."""
    if case.shape.ndim == 2:
        from levelset.contour import contour, even

        return even(contour(case.shape)[0], 0.4 * case.spacing)
    from levelset.surface import triangles

    grid = case.recipe().finest
    found = triangles(case.shape.distance(grid.points()), grid).vertices
    return found[:: max(1, len(found) // 800)]
