"""A small flow with everything the loop asks for, whose answers are known exactly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.run.protocols import Watcher
from pmesh.run.snapshots import Snapshots
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.limit import Limit, tightest


@dataclass(frozen=True)
class Body:
    position: NDArray[Any]
    label: str = "disk"
    angle: float | None = None


@dataclass(frozen=True)
class ToyState:
    time: float
    step: int
    grid: Grid
    vorticity: NDArray[Any]
    bodies: tuple[Body, ...] = ()

    @property
    def size(self) -> int:
        return self.grid.size


@dataclass(frozen=True, kw_only=True)
class Decay:
    """d(vorticity)/dt = -rate * vorticity by implicit midpoint steps, on a domain that may grow."""

    grid: Grid
    rate: float = 1.0
    largest: float = 0.07
    grows: int = 0  # nodes added on the low side of axis 0 every second step
    breaks_at: int | None = None  # the step whose result is not finite
    dtype: str = "float64"

    def start(self, seed: int = 0) -> ToyState:
        rng = np.random.default_rng(seed)
        vorticity = rng.standard_normal(self.grid.shape).astype(self.dtype)
        return ToyState(0.0, 0, self.grid, vorticity, (Body(np.array([0.1, 0.2])),))

    def step(self, state: ToyState, dt: float) -> ToyState:
        factor = (1 - self.rate * dt / 2) / (1 + self.rate * dt / 2)
        vorticity, grid = state.vorticity * vorticity_type(self.dtype, factor), state.grid
        if state.step + 1 == self.breaks_at:
            vorticity[0, 0] = np.nan
        if self.grows and state.step % 2:
            shape = (grid.shape[0] + self.grows, *grid.shape[1:])
            origin = (grid.origin[0] - self.grows * grid.spacing, *grid.origin[1:])
            grid = Grid(shape, grid.spacing, origin, grid.boundary)
            pad = [(self.grows, 0)] + [(0, 0)] * (grid.ndim - 1)
            vorticity = np.pad(vorticity, pad)
        bodies = tuple(replace(b, position=b.position + dt) for b in state.bodies)
        return ToyState(state.time + dt, state.step + 1, grid, vorticity, bodies)

    def limit(self, state: ToyState) -> Limit:
        # a step that depends on all digits of the state, as a real one does
        steep = 0.05 * (1 + float(np.abs(state.vorticity).max()) / 10)
        return tightest(Limit(self.largest, "body"), Limit(steep, "deformation"))

    def ledger(self, state: ToyState) -> dict[str, float]:
        return {"circulation": float(state.vorticity.sum()) * state.grid.cell_volume}

    def forces(self, state: ToyState) -> dict[str, float]:
        return {"body0_drag": float((state.vorticity**2).sum())}

    def fields(self, state: ToyState) -> dict[str, NDArray[Any]]:
        x = state.grid.points().astype(self.dtype)
        return {"vorticity": state.vorticity, "velocity": x, "chi": x[0] > 0}


def vorticity_type(dtype: str, value: float) -> Any:
    return np.dtype(dtype).type(value)


@dataclass(frozen=True, kw_only=True)
class ToyCase(Case):
    """Exponential decay of random numbers."""

    until: float = option(1.0, "end of the run", unit="T")
    rate: float = option(1.0, "rate of decay", unit="1/T")
    nodes: int = option(16, "nodes per axis")
    grows: int = option(0, "nodes by which the domain grows every second step")
    breaks_at: int | None = option(None, "the step that breaks")
    scheme: str = option("midpoint", "time scheme", choices=("midpoint", "euler"))
    origin: tuple[float, float] = option((0.0, -0.5), "first node", unit="L")
    noisy: bool = option(False, "whether to add noise")
    pause: float = option(0.0, "seconds each step waits, so that a test can interrupt it")

    title: ClassVar[str] = "Toy decay"
    source: ClassVar[str] = "d/dt w = -rate w"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 8, "until": 0.5}

    def __post_init__(self) -> None:
        super().__post_init__()
        self.positive("rate", "nodes")

    def build(self) -> tuple[Decay, ToyState]:
        grid = Grid((self.nodes, self.nodes), 1 / self.nodes, self.origin)
        flow = Decay(grid=grid, rate=self.rate, grows=self.grows, breaks_at=self.breaks_at)
        return flow, flow.start()

    def watchers(self) -> list[Watcher]:
        def wait(moment: Any) -> None:
            import time

            time.sleep(self.pause)

        return [*super().watchers(), Snapshots(every=0.25), wait]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        drift = outcome.series["circulation"][-1] / outcome.series["circulation"][0]
        exact = float(np.exp(-self.rate * self.until))
        return [
            Metric("decay", float(drift), exact, 1e-3, "A", "exp(-rate t)"),
            Metric("snapshots", len(outcome.snapshots()), kind="report"),
        ]

    def draw(self, outcome: Outcome) -> Any:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(3, 2))
        axes = figure.add_subplot()
        axes.plot(outcome.series["time"], outcome.series["circulation"])
        return figure
