"""Any field from a file, compressed by wavelets over decades of tolerance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.case import Case, Outcome
from pmesh.cases.given_field import IMAGES, read_field
from pmesh.cases.options import option
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, show_field, styled
from pmesh.run.summary import Metric
from remesh.grid import Grid
from remesh.limit import Limit
from remesh.multires.compression import Compressed, compress
from remesh.multires.kept import kept_blocks
from remesh.multires.storage import save
from remesh.multires.wavelets import WAVELETS, get_wavelet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.run.protocols import Moment, Watcher

Values = NDArray[np.float64]
FIRST = 0.1  # tolerance at the start; a decade less per unit of time
PER_DECADE = 4  # steps
FILE = "compressed.h5"
FACTOR = 10.0  # the error stays below so many tolerances
ROUND_OFF = 1e-12  # of moments, relative
SOURCE = "Sweldens, SIAM J. Math. Anal. 29 (1998) 511"


@dataclass(frozen=True)
class Squeezed:
    """A field, and what its compression to one tolerance gave."""

    time: float  # decades below the first tolerance
    step: int
    grid: Grid
    field: Values
    tolerance: float
    columns: dict[str, float]

    @property
    def size(self) -> int:
        """Node values that a step transforms."""
        return self.field.size


@dataclass(frozen=True, kw_only=True)
class Squeeze:
    """Compression as a flow whose time is the number of decades of tolerance."""

    wavelet: str

    def at(self, state: Squeezed) -> Squeezed:
        """The state with its field compressed to the tolerance of its time."""
        tolerance = FIRST * 10.0**-state.time
        packed = compress(state.field, state.grid, tolerance=tolerance, wavelet=self.wavelet)
        blocks = kept_blocks(packed)
        scale = float(packed.scale.max()) or 1.0
        columns = {
            "tolerance": tolerance,
            "error": packed.error_bound / scale,
            "coefficients": float(packed.size),
            "ratio": packed.ratio,
            "moments": moment_error(packed.expand(), state.field, state.grid, packed),
            "active": float(blocks.active),
            "compression": state.grid.size / blocks.active,
        }
        return replace(state, tolerance=tolerance, columns=columns)

    def start(self, field: Values, grid: Grid) -> Squeezed:
        """The field compressed to the first tolerance."""
        return self.at(Squeezed(0.0, 0, grid, field, FIRST, {}))

    def step(self, state: Squeezed, dt: float) -> Squeezed:
        """The same field, ``dt`` decades of tolerance lower."""
        return self.at(replace(state, time=state.time + dt, step=state.step + 1))

    def limit(self, state: Squeezed) -> Limit:
        """A part of a decade."""
        return Limit(1.0 / PER_DECADE, "decade")

    def ledger(self, state: Squeezed) -> Mapping[str, float]:
        """Tolerance, error, sizes, and how well the moments were kept."""
        return state.columns

    def forces(self, state: Squeezed) -> Mapping[str, float]:
        """None."""
        return {}

    def fields(self, state: Squeezed) -> Mapping[str, Any]:
        """The field as its coefficients tell it; components by number unless one per axis."""
        tolerance = FIRST * 10.0**-state.time
        packed = compress(state.field, state.grid, tolerance=tolerance, wavelet=self.wavelet)
        field, ndim = packed.expand(), state.grid.ndim
        if field.ndim == ndim or len(field) == ndim:
            return {"field": field}
        return {f"field_{k}": part for k, part in enumerate(field)}


@dataclass(frozen=True, kw_only=True)
class CompressCase(Case):
    """A field of yours, or filaments of a vortex, held by the wavelet coefficients that matter."""

    until: float = option(5.0, "how far the tolerance goes down from 0.1", unit="decades")
    file: str = option("", "npy, npz, HDF5, a run's vtkhdf, or an image; filaments if empty")
    dataset: str = option("", "which array of the file")
    boundary: str = option(
        "unbounded", "how the field goes on at its ends", choices=("unbounded", "periodic")
    )
    tolerance: float = option(1e-3, "of the mesh that is drawn and of the file that is kept")
    wavelet: str = option("4.4", "wavelet family", choices=tuple(WAVELETS))
    nodes: int = option(512, "mesh nodes along a side of the filaments' box")

    title: ClassVar[str] = "A field compressed by wavelets"
    source: ClassVar[str] = SOURCE
    short: ClassVar[Mapping[str, Any]] = {"nodes": 192}

    def __post_init__(self) -> None:
        """Refuse what cannot be compressed."""
        super().__post_init__()
        self.require(0 < self.tolerance < 1, "tolerance", "between 0 and 1")
        self.require(self.nodes >= 32, "nodes", "at least 32")
        self.require(self.until <= 12, "until", "at most 12, where round-off begins")

    def given(self) -> tuple[Values, Grid]:
        """The field and its grid."""
        if self.file:
            return read_field(self.file, self.dataset, self.boundary)
        periodic: Any = self.boundary
        grid = Grid((self.nodes,) * 2, 2.0 / self.nodes, (-1.0, -1.0), periodic)
        return filaments(grid.points()), grid

    def build(self) -> tuple[Any, Any]:
        """The compression of the field to ever lower tolerances."""
        flow = Squeeze(wavelet=self.wavelet)
        return flow, flow.start(*self.given())

    def watchers(self) -> Sequence[Watcher]:
        """The ledger, the field at each decade, and one that keeps the compressed field."""
        from pmesh.run.snapshots import Snapshots
        from pmesh.run.watchers import Ledger

        return [Ledger(), Snapshots(1.0), _Keeper(self.tolerance, self.wavelet)]

    def metrics(self, outcome: Outcome) -> list[Metric]:
        """The error over the tolerance, what became of the moments, and how small it is."""
        series = outcome.series
        over = np.asarray(series["error"]) / np.asarray(series["tolerance"])
        packed = self._packed(outcome)
        keeps = get_wavelet(self.wavelet).moments
        moments = float(np.max(series["moments"]))
        own = packed.error_bound / (float(packed.scale.max()) or 1.0)
        found = [
            Metric("largest error over its tolerance", float(over.max()), 0.0, FACTOR, "A",
                   SOURCE, "absolute"),
            Metric(f"error at tolerance {self.tolerance:g}", own, 0.0, FACTOR * self.tolerance,
                   "A", SOURCE, "absolute"),
            Metric("values per coefficient there", packed.ratio, kind="report"),
            Metric("coefficients there", float(packed.size), kind="report"),
        ]  # fmt: skip
        if keeps:
            known = ("A", SOURCE)
            found.insert(2, Metric("largest change of a moment that the lifting keeps", moments,
                                   0.0, ROUND_OFF, *known, "absolute"))  # fmt: skip
        return found

    def _packed(self, outcome: Outcome) -> Compressed:
        """The field compressed to the case's own tolerance."""
        state = outcome.state
        return compress(state.field, state.grid, tolerance=self.tolerance, wavelet=self.wavelet)

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The field with its mesh, what was lost, and error and size over the tolerance."""
        from matplotlib.figure import Figure

        packed, state = self._packed(outcome), outcome.state
        figure = Figure(figsize=(11.0, 8.6), layout="constrained")
        axes: Any = figure.subplots(2, 2)
        self._field(axes[0, 0], packed, state)
        self._lost(axes[0, 1], packed, state)
        series = outcome.series
        self._errors(axes[1, 0], series["tolerance"], series["error"])
        self._sizes(axes[1, 1], series, state)
        name_panels(axes)
        return figure

    def _field(self, panel: Axes, packed: Compressed, state: Squeezed) -> None:
        from pmesh.cases.mesh_picture import show_mesh

        plane, grid, at = _plane(state.field, state.grid)
        signed = bool(plane.min() < -0.01 * plane.max())
        limit = float(np.abs(plane).max()) or 1.0
        photo = Path(self.file).suffix.lower() in IMAGES
        colours = "RdBu_r" if signed else "gray" if photo else "BuPu"
        show_field(panel, plane, grid, colours=colours, limit=limit)
        (x, y) = grid.axes()
        blocks = kept_blocks(packed)
        show_mesh(panel, blocks, window=(x[0], x[-1], y[0], y[-1]), at=at, width=0.7)
        for lines in panel.collections:
            lines.set_alpha(0.5)
        nodes = " x ".join(map(str, state.grid.shape))
        panel.set_title(f"{nodes} nodes; blocks at tolerance {self.tolerance:g}")

    def _lost(self, panel: Axes, packed: Compressed, state: Squeezed) -> None:
        plane, grid, _ = _plane(packed.expand() - state.field, state.grid, signed=True)
        unit = self.tolerance * (float(packed.scale.max()) or 1.0)
        show_field(panel, plane / unit, grid, label="difference over tolerance",
                   limit=max(float(np.abs(plane).max()) / unit, 1e-3))  # fmt: skip
        panel.set_title(f"lost at 1 coefficient for {packed.ratio:.3g} values")

    def _errors(self, panel: Axes, tolerance: Any, error: Any) -> None:
        panel.loglog(tolerance, FACTOR * tolerance, color=REFERENCE, label="10 x tolerance")
        panel.loglog(tolerance, tolerance, "--", color=OTHERS[2], lw=1.0, label="tolerance")
        seen = np.asarray(error) > 0
        panel.loglog(tolerance[seen], error[seen], "o-", color=OURS, label="largest error")
        panel.set(title="error over the largest value", xlabel="tolerance")
        panel.invert_xaxis()
        panel.legend()

    def _sizes(self, panel: Axes, series: Any, state: Squeezed) -> None:
        tolerance = series["tolerance"]
        panel.axhline(state.field.size, color=REFERENCE, lw=1.0, label="values of the field")
        panel.loglog(tolerance, series["active"], "s-", ms=3, color=OTHERS[0],
                     label="nodes of the blocks that hold them")  # fmt: skip
        panel.loglog(tolerance, series["coefficients"], "o-", color=OURS, label="coefficients")
        panel.set(title="size", xlabel="tolerance")
        panel.invert_xaxis()
        panel.legend()


class _Keeper:
    """A watcher that leaves the field, compressed to one tolerance, in the run directory."""

    def __init__(self, tolerance: float, wavelet: str) -> None:
        self.tolerance, self.wavelet = tolerance, wavelet

    def open(self, moment: Moment) -> None:
        """Write the file: it depends on the field only."""
        if moment.out is not None:
            state = moment.state
            save(moment.out / FILE, compress(state.field, state.grid, tolerance=self.tolerance,
                                             wavelet=self.wavelet))  # fmt: skip

    def close(self) -> None:
        """Nothing is left open."""

    def __call__(self, moment: Moment) -> None:
        """No columns."""


def filaments(points: Values) -> Values:
    """Vorticity of an elliptical patch that a vortex has wound up, beside a weaker round one.

    ``points`` (2, ...) in (-1, 1)^2 [L]; smooth, with structures from 0.02 to 1 [L].
    """
    x, y = points[0] + 0.15, points[1]
    turn = 16.0 * np.exp(-((np.hypot(x, y) / 0.45) ** 2))
    u, v = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    wound = np.exp(-(((u / 0.42) ** 2 + (v / 0.14) ** 2) ** 2))
    other = np.exp(-(((points[0] - 0.6) ** 2 + (points[1] - 0.5) ** 2) / 0.12**2))
    return np.asarray(wound - 0.6 * other)


def moment_error(ours: NDArray[Any], field: Values, grid: Grid, packed: Compressed) -> float:
    """Largest change of a sum of f x^a y^b z^c that the lifting keeps, over that of |f x^a ...|.

    Exponents below the wavelet's moments; 0 on periodic axes. About the middle of the grid.
    """
    change, size = ours - field, np.abs(field)
    for axis, x in reversed(list(enumerate(grid.axes()))):
        count = 1 if grid.periodic[axis] else packed.wavelet.moments
        reach = 0.5 * (x[-1] - x[0])
        powers = ((x - x[0] - reach) / reach) ** np.arange(max(count, 1))[:, None]
        along = axis - grid.ndim
        change = np.moveaxis(np.tensordot(change, powers, (along, 1)), -1, along)
        size = np.moveaxis(np.tensordot(size, np.abs(powers), (along, 1)), -1, along)
    largest = np.abs(change)[size > 0] / size[size > 0]
    return float(largest.max(initial=0.0))


def _plane(
    values: Values, grid: Grid, *, signed: bool = False
) -> tuple[Values, Grid, float | None]:
    """What of a field a picture shows: one component or the length, in space the middle slice."""
    shown = values
    if values.ndim > grid.ndim:
        parts = np.abs(values).max(axis=0) if signed else np.sqrt((values**2).sum(axis=0))
        shown = parts if len(values) > 1 else values[0]
    if grid.ndim == 2:
        return shown, grid, None
    middle = grid.shape[2] // 2
    flat = Grid(grid.shape[:2], grid.spacing, grid.origin[:2])
    return shown[:, :, middle], flat, grid.origin[2] + middle * grid.spacing
