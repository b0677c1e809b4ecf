"""Pictures of where the flow of a run carries points: FTLE ridges and dye, from its snapshots."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pmesh.cases.movie import snapshots
from pmesh.cases.wake import (
    WALL,
    Window,
    depth,
    dye_figure,
    ftle_figure,
    indicator,
    window,
)
from pmesh.run.files import write_atomic
from pmesh.run.snapshots import Snapshot
from pmesh.vortex.flowmap import Array, VelocityHistory, ftle, streaklines
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHARE = 0.25  # of the run: how long an FTLE looks and dye flows, if not said


def ftle_picture(
    folder: str | Path,
    out: str | Path | None = None,
    *,
    time: float | None = None,
    span: float | None = None,
    nodes: int = 300,
    part: Window | None = None,
) -> Path:
    """Draw the FTLE of a run at a time [T] over a span [T], ``ftle.png`` in its directory.

    A negative span looks back, a quarter of the run if not given, and shows what attracts; the
    time is the last snapshot's then, else the first's. ``nodes`` along the longer side of ``part``,
    by default what is seen of the vorticity. Refuses times beyond the snapshots.
    """
    if not 16 <= nodes <= 4000:
        raise InputError(f"nodes must be from 16 to 4000, got {nodes}", hint="--nodes 300")
    shots = _plane_shots(folder)
    history = VelocityHistory(shots)
    first, last = history.span
    span = -SHARE * (last - first) if span is None else span
    time = (last if span < 0 else first) if time is None else time
    near = min(shots, key=lambda shot: abs(shot.time - time))
    grid = _grid(window([near]) if part is None else part, nodes)
    exponent = ftle(history, grid, time, span)
    figure = ftle_figure(exponent, grid, time=time, span=span, chi=indicator(near), on=near.grid)
    return _saved(figure, Path(folder) / "ftle.png" if out is None else Path(out))


def dye_picture(
    folder: str | Path,
    out: str | Path | None = None,
    *,
    line: Sequence[float] | None = None,
    sources: int = 21,
    start: float | None = None,
    time: float | None = None,
    releases: int = 200,
) -> Path:
    """Draw dye that left a line at even times until a snapshot's time, ``dye.png`` in its folder.

    ``line``: x, y of its ends [L]; before the bodies if not given, across the middle without any.
    Dye leaves ``sources`` points on it, ``releases`` times from ``start`` (a quarter of the run
    earlier) to ``time`` (the last snapshot's), at the snapshot nearest to it [T].
    """
    if line is not None and (len(line) != 4 or not all(map(math.isfinite, line))):
        raise InputError(f"a line is x0 y0 x1 y1, got {line}", hint="--line -2,-1,-2,1")
    if not (1 <= sources <= 1000 and 2 <= releases <= 10_000):
        raise InputError(
            f"sources must be from 1 to 1000 and releases from 2 to 10000, got {sources} and "
            f"{releases}",
            hint="--sources 21 --releases 200",
        )
    shots = _plane_shots(folder)
    history = VelocityHistory(shots)
    first, last = history.span
    time = last if time is None else time
    near = min(shots, key=lambda shot: abs(shot.time - time))
    start = max(first, near.time - SHARE * (last - first)) if start is None else start
    ends = np.reshape(_before(near) if line is None else line, (2, 2)).astype(np.float64)
    share = np.linspace(0, 1, sources)[:, None] if sources > 1 else np.array([[0.5]])
    points = (1 - share) * ends[0] + share * ends[1]
    dye = streaklines(history, points, start, near.time, releases=releases)
    part = window([near])
    corners = np.concatenate([ends, dye.positions[-1]])
    part = Window(
        min(part.left, float(corners[:, 0].min())), max(part.right, float(corners[:, 0].max())),
        min(part.bottom, float(corners[:, 1].min())), max(part.top, float(corners[:, 1].max())),
    )  # fmt: skip
    figure = dye_figure(near, dye.positions, line=ends, part=part)
    return _saved(figure, Path(folder) / "dye.png" if out is None else Path(out))


def _plane_shots(folder: str | Path) -> list[Snapshot]:
    """The snapshots of a run in the plane with all that is needed; refuses a run in space."""
    shots: list[Snapshot] = snapshots(folder, "velocity", "vorticity")
    if shots[0].grid.ndim != 2:
        raise InputError(
            "pictures of FTLE and dye are of flows in the plane, this run is in space",
            hint="pmesh movie DIR; the laws pmesh.ftle and pmesh.VelocityHistory take both",
        )
    return shots


def _grid(part: Window, nodes: int) -> Grid:
    """A mesh over a window."""
    spacing = max(part.size) / nodes
    shape = [max(8, round(side / spacing)) for side in part.size]
    return Grid(shape, spacing, (part.left + 0.5 * spacing, part.bottom + 0.5 * spacing))


def _before(shot: Snapshot) -> Array:
    """Ends of a line before the bodies of a snapshot, as long as they are high."""
    chi, (x, y) = indicator(shot), shot.grid.axes()
    if chi is None or not (inside := depth(chi) > WALL).any():
        part = window([shot])
        middle = 0.5 * (part.left + part.right)
        return np.array([middle, part.bottom, middle, part.top])
    across, up = x[inside.any(axis=1)], y[inside.any(axis=0)]
    size = max(across[-1] - across[0], up[-1] - up[0])
    return np.array([across[0] - 0.25 * size, up[0], across[0] - 0.25 * size, up[-1]])


def _saved(figure: Figure, path: Path) -> Path:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=200)
    write_atomic(path, stream.getbuffer())
    return path
