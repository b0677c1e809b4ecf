"""How figures look: one set of colours, letters and frames for all cases and demos."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure

P = ParamSpec("P")
T = TypeVar("T")
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


def styled(draw: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function that draws, so that it draws in the project's style."""

    @functools.wraps(draw)
    def in_style(*args: P.args, **options: P.kwargs) -> T:
        import matplotlib

        with matplotlib.rc_context(LETTERS):
            return draw(*args, **options)

    return in_style


def panels(
    rows: int, columns: int, size: tuple[float, float], **grid_options: Any
) -> tuple[Figure, Any]:
    """A figure of ``size`` inches and its array of axes (rows, columns).

    Built without pyplot: no window, no global state; ``figure.savefig`` writes it.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **grid_options)


def show_field(
    axes: Axes,
    field: NDArray[Any],
    grid: Grid,
    *,
    limit: float | None = None,
    colours: str = "RdBu_r",
    power: float = 1.0,
    label: str | None = None,
) -> Colorbar | None:
    """Draw a plane scalar field to scale, a bar beside it if labelled.

    "RdBu_r" has zero in its middle, other colours begin at zero; ``power < 1`` brings out the weak.
    """
    from matplotlib.colors import PowerNorm

    top = float(np.abs(field).max()) if limit is None else limit
    low = -top if colours == "RdBu_r" else 0.0
    half = 0.5 * grid.spacing
    (x, y) = grid.axes()
    picture = axes.imshow(
        np.asarray(field).T,
        origin="lower",
        extent=(x[0] - half, x[-1] + half, y[0] - half, y[-1] + half),
        cmap=colours,
        norm=PowerNorm(power, vmin=low, vmax=top),
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
