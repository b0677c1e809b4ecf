"""How figures look: one set of colours, letters and frames for all cases and demos."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure

OURS = "#0b559f"  # what we computed
REFERENCE = "#c8511b"  # what is exact or published
OTHERS = ("#2f8f5b", "#7b4fa3", "#8a8a8a")
LETTERS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "mathtext.fontset": "dejavusans",
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "figure.dpi": 100,
    "savefig.dpi": 200,
}


def panels(
    rows: int, columns: int, size: tuple[float, float], **grid_options: Any
) -> tuple[Figure, Any]:
    """A figure of ``size`` inches and its array of axes (rows, columns), in the project's style.

    Built without pyplot: no window, no global state. ``save`` writes it.
    """
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LETTERS):
        figure = Figure(figsize=size, layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False, **grid_options)
    return figure, axes


def save(figure: Figure, path: str | Path) -> None:
    """Write the figure as the path's ending says, making its folder."""
    import matplotlib

    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(LETTERS):
        figure.savefig(target)


def show_field(
    axes: Axes,
    field: NDArray[Any],
    grid: Grid,
    *,
    limit: float | None = None,
    colours: str = "RdBu_r",
    label: str | None = None,
) -> Colorbar | None:
    """Draw a plane scalar field to scale, zero in the middle of the colours; a bar if labelled."""
    top = float(np.abs(field).max()) if limit is None else limit
    low = -top if colours == "RdBu_r" else 0.0
    half = 0.5 * grid.spacing
    (x, y) = grid.axes()
    picture = axes.imshow(
        np.asarray(field).T,
        origin="lower",
        extent=(x[0] - half, x[-1] + half, y[0] - half, y[-1] + half),
        cmap=colours,
        vmin=low,
        vmax=top,
        interpolation="bilinear",
    )
    axes.set_aspect("equal")
    axes.grid(False)
    if label is None:
        return None
    bar = axes.figure.colorbar(picture, ax=axes, shrink=0.85, pad=0.02)
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)
    return bar


def name_panels(axes: Any) -> None:
    """Write (a), (b), ... before the panels' titles."""
    for letter, panel in zip("abcdefghijkl", np.asarray(axes).ravel(), strict=False):
        panel.set_title(f"({letter}) {panel.get_title()}", loc="left")
        panel.set_title("", loc="center")
