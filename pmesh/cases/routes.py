"""Drag and lift by every route that a run has: their means, amplitudes and disagreement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.run.summary import Kind, Metric

if TYPE_CHECKING:
    from pmesh.run.statistics import Cycle, Statistics

Values = NDArray[np.float64]
COMPONENTS = {"drag": "x", "lift": "y"}
ROUTES = {  # columns of the series, in order of trust
    "momentum": "body0_force_",
    "impulse": "impulse_force_",
    "control volume": "body0_flux_force_",
    "traction": "body0_surface_force_",
}
MAIN, TRACTION = "momentum", "traction"
SEEN = 4.0  # spacings in the boundary layer, D / sqrt(Re), from where traction is accurate
MEANS, AMPLITUDES = 0.015, 0.03  # of the main route's, by which others may differ


@dataclass(frozen=True, eq=False)
class Routes:
    """Force coefficients of the first body by each route, means over steps that end at times."""

    time_end: Values  # of the steps [T]
    dt: Values  # [T]
    curves: Mapping[tuple[str, str], Values]  # by route and component

    @classmethod
    def of(cls, series: Mapping[str, NDArray[Any]], *, scale: float) -> Routes:
        """From the columns of a run; ``scale`` makes coefficients of forces.

        A route that was asked at some steps only is completed by the main one and what it differs
        by, straight between those steps; one asked at fewer than two is left out.
        """
        time, dt = np.asarray(series["time"])[1:], np.asarray(series["dt"])[1:]
        curves: dict[tuple[str, str], Values] = {}
        for component, axis in COMPONENTS.items():
            main = scale * np.asarray(series[ROUTES[MAIN] + axis], np.float64)[1:]
            for route, stem in ROUTES.items():
                curve = scale * np.asarray(series.get(stem + axis, [np.nan]), np.float64)[1:]
                known = np.flatnonzero(np.isfinite(curve))
                if known.size >= 2:
                    apart = (curve - main)[known]
                    curves[route, component] = main + np.interp(time, time[known], apart)
        return cls(time, dt, curves)

    @property
    def time(self) -> Values:
        """Middles of the steps [T]."""
        return self.time_end - 0.5 * self.dt

    def of_main(self, component: str) -> Values:
        """The drag or the lift by the main route."""
        return self.curves[MAIN, component]

    def others(self, component: str) -> dict[str, Values]:
        """The drag or the lift by the other routes."""
        return {
            route: curve
            for (route, name), curve in self.curves.items()
            if name == component and route != MAIN
        }

    def statistics(self, component: str) -> Statistics:
        """Statistics of a component by the main route."""
        from pmesh.run.statistics import statistics

        return statistics(self.time_end, self.of_main(component), self.dt)

    def mean(self, component: str, cycle: Cycle, route: str = MAIN) -> float:
        """The mean over the whole cycles."""
        return self.mean_over(component, (cycle.start, cycle.end), route)

    def mean_over(self, component: str, span: tuple[float, float], route: str = MAIN) -> float:
        """The mean from one time to another."""
        from pmesh.run.record import record

        curve = record(self.time_end, self.curves[route, component], self.dt)
        return float(curve.means(np.array(span))[0])

    def amplitude(self, component: str, cycle: Cycle, route: str = MAIN) -> float:
        """Half of peak to peak, by the mean over the whole cycles."""
        from pmesh.run.record import record

        curve = record(self.time_end, self.curves[route, component], self.dt)
        edges = np.linspace(cycle.start, cycle.end, cycle.cycles + 1)
        inner = edges[:-1, None] + np.diff(edges)[:, None] * np.linspace(0, 1, 128)
        return float(0.5 * np.mean(np.ptp(curve.at(inner), axis=1)))

    def metrics(self, cycle: Cycle, layer: float) -> list[Metric]:
        """How far the routes are apart over the cycles: mean drag, amplitude of the lift.

        ``layer``: the boundary layer's thickness in spacings, by which traction is judged or not.
        """
        found = []
        lift = self.amplitude("lift", cycle)
        for mean, route in zip(
            self.means_apart((cycle.start, cycle.end), layer), self.others("drag"), strict=True
        ):
            wide = abs(self.amplitude("lift", cycle, route) / lift - 1.0)
            name = f"lift amplitude, {route} and {MAIN} apart"
            found += [mean, Metric(name, wide, 0.0, AMPLITUDES, kind=_kind(route, layer))]
        return found

    def means_apart(self, span: tuple[float, float], layer: float) -> list[Metric]:
        """How far the routes' mean drags are apart over a span of time."""
        drag = self.mean_over("drag", span)
        return [
            Metric(f"mean drag, {route} and {MAIN} apart",
                   abs(self.mean_over("drag", span, route) / drag - 1.0), 0.0, MEANS,
                   kind=_kind(route, layer))
            for route in self.others("drag")
        ]  # fmt: skip

    def apart(self, component: str, when: NDArray[np.bool_], layer: float) -> list[Metric]:
        """How far the routes are apart in a part of the run; ``layer`` as in :meth:`metrics`."""
        main = self.of_main(component)[when]
        return [
            Metric(f"{component}, {route} and {MAIN} apart",
                   float(np.abs(curve[when] / main - 1.0).max()), 0.0, MEANS,
                   kind=_kind(route, layer))
            for route, curve in self.others(component).items()
        ]  # fmt: skip


def _kind(route: str, layer: float) -> Kind:
    """Traction is judged only where the mesh sees the layer that it reads."""
    return "report" if route == TRACTION and layer < SEEN else "absolute"
