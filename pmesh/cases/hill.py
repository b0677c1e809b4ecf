"""Hill's spherical vortex, which travels without changing its shape."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.run.protocols import Moment
from pmesh.run.summary import Metric
from pmesh.vortex.exact.hill import HillVortex
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Watcher
    from pmesh.run.snapshots import Snapshot

Array = NDArray[np.floating[Any]]

SOURCE = "Hill, Phil. Trans. R. Soc. A 185 (1894) 213"
HALF = 0.5  # of 15/2 U/a^2: the level of w_theta/r that bounds the vortex
TAIL, ROOM = 5.7, 7.0  # from the sphere to the mesh's end at the start: edges, spacings
LOOK = (-50.0, 18.0)  # azimuth and elevation [degrees]


def silhouette(vorticity: Array, grid: Grid, level: float) -> dict[str, float]:
    """Place and shape of a vortex about the z axis, from its rate w_theta/r [1/(L T)].

    ``place``: the centroid of the impulse along z [L]; ``volume`` [L^3] where the rate is over
    the level, ``along`` and ``across``: semi-axes of the ellipsoid with the volume and the second
    moments of that region [L]. A node that the level passes counts in part, which makes them of
    second order in the spacing. Nodes within a spacing and a half of the axis count by their
    distance to the ends: there the rate is that of the ring of nodes around them.
    """
    x, y, z = (np.asarray(p, np.float64) for p in grid.points())
    moment = x * vorticity[1] - y * vorticity[0]
    square = x * x + y * y
    place = float((moment * z).sum() / moment.sum())
    core = square < (1.5 * grid.spacing) ** 2
    rate = np.divide(moment, square, out=np.zeros_like(moment), where=~core)
    ring = ~core & (square < (3.0 * grid.spacing) ** 2)
    heights = rate.sum(axis=(0, 1), where=ring) / np.maximum(ring.sum(axis=(0, 1)), 1)
    rate = np.where(core, heights, rate)
    part = _filled(rate - level, grid)
    volume = float(part.sum()) * grid.cell_volume
    middle = float((part * z).sum() / part.sum())
    along = math.sqrt(5.0 * float((part * (z - middle) ** 2).sum() / part.sum()))
    across = math.sqrt(2.5 * float((part * square).sum() / part.sum()))
    return {"place": place, "volume": volume, "along": along, "across": across}


def _filled(phi: Array, grid: Grid) -> Array:
    """The part of each node's cell where ``phi`` is positive, from its slope at the node."""
    slopes = np.gradient(phi, grid.spacing)
    steep = np.sqrt(sum(slope * slope for slope in slopes))
    depth = np.divide(phi, steep * grid.spacing, out=np.sign(phi), where=steep > 0)
    return np.asarray(np.clip(0.5 + depth, 0.0, 1.0))


@dataclass(frozen=True, kw_only=True)
class HillCase(Case):
    """Hill's vortex travels two radii without viscosity: its speed and its shape."""

    until: float = option(2.0, "end of the run; it travels a radius in 1", unit="a/U")
    nodes: int = option(24, "mesh cells per radius")
    edge: float = option(1.5, "width over which the jump at the edge is smoothed", unit="h")
    kernel: str = option("M6'", "remeshing kernel")
    stretching: Literal["conservative", "classical"] = option("conservative", "form of stretching")
    time_scheme: Literal["RK2", "RK3", "RK4"] = option("RK2", "Runge-Kutta scheme")
    deformation: float = option(0.25, "largest dt * max|grad u|")
    projection: int = option(1, "steps between projections onto divergence-free vorticity; 0: none")
    dtype: Literal["float64", "float32"] = option("float64", "precision")
    every: float = option(0.5, "largest time between snapshots, one at the end", unit="a/U")

    title: ClassVar[str] = "Hill's spherical vortex"
    source: ClassVar[str] = SOURCE
    size: ClassVar[str] = "nodes"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 12, "until": 0.25}

    def __post_init__(self) -> None:
        """Refuse what cannot be computed."""
        super().__post_init__()
        self.positive("deformation", "every")
        self.require(self.nodes >= 8, "nodes", "at least 8 to see the vortex")
        self.require(self.projection >= 0, "projection", "not negative")
        self.require(0 < self.edge <= 0.3 * self.nodes, "edge", "positive, at most 0.3 radii")

    @property
    def exact(self) -> HillVortex:
        """The vortex, radius and speed 1."""
        return HillVortex()

    def vorticity(self, points: Array, place: float = 0.0) -> Array:
        """The vortex, its centre at a place on the z axis, its edge smoothed by two Gaussians.

        Twice the one of ``edge`` less the one sqrt(2) wider: their second moments cancel, and the
        speed departs from the sharp vortex's as the fourth power of the width, not the second.
        """
        width, center = self.edge / self.nodes, (0.0, 0.0, place)
        near = HillVortex(width=width, center=center).vorticity(points)
        far = HillVortex(width=math.sqrt(2.0) * width, center=center).vorticity(points)
        return np.asarray(2.0 * near - far)

    @property
    def level(self) -> float:
        """Of w_theta/r, where the vortex ends [1/(L T)]."""
        return HALF * 7.5

    def recipe(self) -> Any:
        """The flow on a box that travels with the vortex."""
        from pmesh.vortex.flow import VortexFlow

        cells = 8 * math.ceil((self.nodes + TAIL * self.edge + ROOM) / 8)
        grid = Grid((2 * cells,) * 3, 1 / self.nodes, (-cells / self.nodes,) * 3)
        return VortexFlow(
            grid=grid,
            kernel=self.kernel,
            stretching=self.stretching,
            time_scheme=self.time_scheme,
            deformation=self.deformation,
            projection=self.projection,
            domain="follow",
            dtype=self.dtype,
        )

    def build(self) -> tuple[Any, Any]:
        """The flow, and the vortex it starts from."""
        flow = self.recipe()
        return flow, flow.start(vorticity=self.vorticity)

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, place and shape, and snapshots of the vorticity."""
        from pmesh.run.snapshots import Snapshots

        even = self.until / math.ceil(self.until / self.every - 1e-9)  # one at the end
        snapshots = Snapshots(even, fields=["vorticity"], dtype="float32")
        return [*super().watchers(), self._watch, snapshots]

    def _watch(self, moment: Moment) -> dict[str, float]:
        """Place and shape."""
        return silhouette(moment.state.vorticity, moment.state.grid, self.level)

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """Speed, shape, and what Euler's equations keep."""
        series, state, known = outcome.series, outcome.state, ("A", SOURCE)
        speed = self._speed(series)
        shape = series["across"][-1] / series["along"][-1]
        apart = self._apart(state, series["place"][-1])
        impulse, energy = series["impulse_z"], series["energy"]
        volume, first = series["volume"], 4.0 / 3.0 * math.pi
        return [
            Metric("speed", speed, 1.0, 0.01, *known),
            Metric("impulse", impulse[-1], float(self.exact.impulse[2]), 0.01, *known),
            Metric("energy", energy[-1], self.exact.energy, 0.02, *known),
            Metric("volume over that at the start", volume[-1] / volume[0], 1.0, 0.02, *known),
            Metric("semi-axis along its way", series["along"][-1], 1.0, 0.02, *known),
            Metric("semi-axis across", series["across"][-1], 1.0, 0.02, *known),
            Metric("semi-axis across over along", shape, 1.0, 0.02, *known),
            Metric("volume at the start", volume[0], first, kind="report"),
            Metric("drift of impulse", impulse[-1] / impulse[0] - 1.0, 0.0, 1e-3, "A",
                   "Euler's equations", "absolute"),
            Metric("drift of energy", energy[-1] / energy[0] - 1.0, 0.0, 0.01, "A",
                   "Euler's equations", "absolute"),
            Metric("vorticity at its own place, rel. L1 error", apart, kind="report"),
            Metric("rms div w over rms |grad w|", series["divergence"][-1], kind="report"),
        ]  # fmt: skip

    def _speed(self, series: Mapping[str, Any]) -> float:
        """Mean speed of the impulse's centroid."""
        way, time = series["place"], series["time"]
        return float((way[-1] - way[0]) / (time[-1] - time[0]))

    def _apart(self, state: Any, place: float) -> float:
        """L1 distance to the start's vorticity moved to the same centroid, over its L1 norm."""
        exact = self.vorticity(state.grid.points(), float(place))
        apart = np.sqrt(((state.vorticity - exact) ** 2).sum(axis=0))
        return float(apart.sum() / np.sqrt((exact**2).sum(axis=0)).sum())

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The vortex on its way; a cut through it at the end; place and shape over time."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10.6, 6.9), layout="constrained")
        grid = figure.add_gridspec(2, 3, width_ratios=(1.05, 1, 1))
        lit, cut, rate, way, shape, kept = (
            figure.add_subplot(grid[i // 3, i % 3]) for i in range(6)
        )
        shot = outcome.snapshots()[-1]
        self._portrait(lit, shot)
        self._cut(cut, shot)
        self._rate(rate, outcome)
        self._way(way, outcome.series)
        self._shape(shape, outcome.series)
        self._kept(kept, outcome.series)
        name_panels([lit, cut, rate, way, shape, kept])
        figure.suptitle(
            f"Hill's spherical vortex: a/h = {self.nodes}, edge {self.edge:g} h, kernel "
            f"{self.kernel}, {self.stretching} stretching",
            fontsize=11,
        )
        return figure

    def _portrait(self, panel: Axes, shot: Snapshot) -> None:
        """A surface of the vorticity, in the colours of one component."""
        from pmesh.cases.vortices import show_isosurface

        low, high = (-1.15, -1.15, shot.time - 1.2), (1.15, 1.15, shot.time + 1.2)
        show_isosurface(
            panel, shot, "vorticity", levels=[3.0], colour_by="vorticity_x", label="",
            view=LOOK, size=(900, 820), bounds=(low, high), ground=False,
        )  # fmt: skip
        panel.set_title(f"$|\\omega|a/U$ = 3, $t$ = {shot.time:.3g}")

    def _cut(self, panel: Axes, shot: Snapshot) -> None:
        """Vorticity across the plane of its axis, over the exact edge."""
        x, y, z = shot.grid.axes()
        j = int(np.abs(y).argmin())
        across = np.asarray(shot["vorticity"][1][:, j])
        ends = (x[0], x[-1], z[0], z[-1])
        panel.imshow(across.T, origin="lower", extent=ends, cmap="RdBu_r", vmin=-7.5, vmax=7.5,
                     interpolation="bilinear")  # fmt: skip
        turn = np.linspace(0.0, 2.0 * np.pi, 200)
        panel.plot(np.cos(turn), shot.time + np.sin(turn), color=REFERENCE, lw=1.1, ls=(0, (4, 3)),
                   label="exact edge")  # fmt: skip
        panel.set_aspect("equal")
        panel.grid(False)
        panel.set(xlim=(-1.3, 1.3), ylim=(shot.time - 1.5, shot.time + 1.4), xlabel="$x/a$",
                  ylabel="$z/a$", title=r"$\omega_y$ at $y$ = 0")  # fmt: skip
        panel.legend(loc="lower right")

    def _rate(self, panel: Axes, outcome: Outcome) -> None:
        """w_y on a line across the vortex over the exact one."""
        state = outcome.state
        x, y, z = state.grid.axes()
        j, k = int(np.abs(y).argmin()), int(np.abs(z - outcome.series["place"][-1]).argmin())
        fine = np.linspace(0.0, 1.4, 300)
        panel.plot(fine, np.where(fine < 1.0, 7.5 * fine, 0.0), color=REFERENCE, label="exact")
        right = x >= 0
        panel.plot(x[right], state.vorticity[1][right, j, k], "o", color=OURS, ms=3.5, label="ours")
        panel.set(title=r"$\omega_\theta a/U$ across its middle", xlabel="$r/a$", xlim=(0.0, 1.4))
        panel.legend(loc="upper left")

    def _way(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """How far the centroid is from U t."""
        time = series["time"]
        every = max(1, len(time) // 20)
        panel.plot(time, time, color=REFERENCE, label="exact: $U t$")
        panel.plot(time[::every], (series["place"] - series["place"][0])[::every], "o", color=OURS,
                   label=f"ours: speed {self._speed(series):.4f} $U$")  # fmt: skip
        panel.set(title="way of the centroid", xlabel="$tU/a$")
        panel.legend(loc="upper left")

    def _shape(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """Semi-axes and volume."""
        panel.axhspan(0.98, 1.02, color=REFERENCE, alpha=0.12, lw=0, label="within 2 %")
        volume = series["volume"] / series["volume"][0]
        for values, colour, name in (
            (series["along"], OURS, "semi-axis along"),
            (series["across"], OTHERS[0], "semi-axis across"),
            (volume, OTHERS[1], "volume / first"),
        ):  # fmt: skip
            panel.plot(series["time"], values, color=colour, label=name)
        panel.set(title="shape over the exact one", xlabel="$tU/a$", ylim=(0.94, 1.06))
        panel.legend(loc="upper left", ncols=2)

    def _kept(self, panel: Axes, series: Mapping[str, Any]) -> None:
        """Drifts of what Euler's equations keep."""
        time = series["time"][1:]
        for name, colour in (("impulse_z", OURS), ("energy", OTHERS[0])):
            drift = np.maximum(np.abs(series[name][1:] / series[name][0] - 1.0), 1e-16)
            panel.semilogy(time, drift, color=colour, label=name.removesuffix("_z"))
        panel.semilogy(time, series["divergence"][1:], color=OTHERS[2], lw=1.0,
                       label=r"rms div $\omega$ / rms $|\nabla\omega|$")  # fmt: skip
        panel.set(title="drift", xlabel="$tU/a$", ylim=(1e-8, 100.0))
        panel.legend(loc="upper right")
