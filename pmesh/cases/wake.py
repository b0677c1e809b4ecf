"""Pictures of a wake: which part of it, in which colours, with the bodies in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.style import show_field, styled
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Values = NDArray[np.floating[Any]]
FILL, EDGE, EMPTY = "#d9d9d9", "#444444", "#f7f7f7"  # a body, its outline, where nothing is
INDICATOR = "chi"  # the field that is 1 in bodies
WALL = 0.35  # depth at which the outline is drawn; the indicator begins at 0, near the wall
WEAK = 0.03  # of the colours' limit: what is weaker is not looked at
MARGIN = 0.06  # of the window's longer side


class Shot(Protocol):
    """Plane fields by name at a time: a snapshot."""

    @property
    def time(self) -> float:
        """Time [T]."""

    @property
    def grid(self) -> Grid:
        """The mesh."""

    @property
    def names(self) -> Mapping[str, Any]:
        """The fields it holds."""

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A field."""


class Window(NamedTuple):
    """A part of the plane [L]."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [L]."""
        return self.right - self.left, self.top - self.bottom

    def moved(self, x: float, y: float) -> Window:
        """The window after a shift."""
        return Window(self.left + x, self.right + x, self.bottom + y, self.top + y)


def plane(shot: Shot, name: str) -> Values:
    """A field to be seen: a scalar as it is, of a vector its length. Refuses fields in space."""
    if shot.grid.ndim != 2:
        raise InputError(
            f"pictures show plane fields, this one has {shot.grid.ndim} dimensions",
            hint="ParaView opens fields.vtkhdf",
        )
    field = np.asarray(shot[name])
    field = field.astype(np.float64) if field.dtype.kind != "f" else field
    return np.sqrt((field**2).sum(axis=0)) if field.ndim > 2 else field


def indicator(shot: Shot) -> Values | None:
    """Where bodies are (1) and are not (0); None without any."""
    return np.asarray(shot[INDICATOR], np.float64) if INDICATOR in shot.names else None


def depth(chi: NDArray[Any]) -> Values:
    """The indicator so that it grows straight from its outer edge, and its contours are smooth.

    The indicator is drawn in from the wall and begins like the cube of the distance from its edge.
    """
    return np.asarray(np.cbrt(12 / math.pi**2 * np.asarray(chi, np.float64)))


def colour_limit(shots: Sequence[Shot], name: str = "vorticity") -> float:
    """The value at which colours saturate, one for all: two digits, so that a bar reads well.

    Of what counts, more than a hundredth of the largest, a seventh is beyond it in the median
    snapshot with bodies, the layers at their walls, so that the wake shows; without, nearly none.
    """
    limits = []
    for shot in shots:
        size, chi = np.abs(plane(shot, name)), indicator(shot)
        share = 0.995 if chi is None else 0.85
        size = size if chi is None else size[depth(chi) < WALL]
        live = size[size > 0.01 * size.max(initial=0.0)]
        if live.size:
            limits.append(float(np.quantile(live, share)))
    top = float(np.median(limits)) if limits else 1.0
    return float(f"{top:.1e}")


def window(shots: Sequence[Shot], name: str = "vorticity", *, limit: float | None = None) -> Window:
    """The part of the plane that holds all bodies and all that is seen of a field, and a margin.

    A periodic axis is shown whole.
    """
    limit = colour_limit(shots, name) if limit is None else limit
    boxes = []
    for shot in shots:
        seen, chi, grid = np.abs(plane(shot, name)) > WEAK * limit, indicator(shot), shot.grid
        seen = seen if chi is None else seen | (depth(chi) > WALL)
        box = []
        for axis, (low, length) in enumerate(zip(grid.origin, grid.length, strict=True)):
            lines = np.flatnonzero(seen.any(axis=1 - axis))
            if grid.periodic[axis] or not lines.size:
                box += [low, low + length]
            else:
                box += [low + grid.spacing * lines[0], low + grid.spacing * lines[-1]]
        boxes.append(box)
    corners = np.array(boxes)
    left, bottom = corners[:, [0, 2]].min(axis=0)
    right, top = corners[:, [1, 3]].max(axis=0)
    wide = [0.0 if wraps else MARGIN * max(right - left, top - bottom) for wraps in grid.periodic]
    return Window(
        float(left - wide[0]), float(right + wide[0]),
        float(bottom - wide[1]), float(top + wide[1]),
    )  # fmt: skip


def draw_vorticity(
    panel: Axes,
    vorticity: NDArray[Any],
    grid: Grid,
    limit: float,
    *,
    chi: NDArray[Any] | None = None,
    outlines: Sequence[Values] = (),
    label: str | None = None,
) -> None:
    """Vorticity [1/T] in colours that saturate at the limit, with a bar if labelled; the bodies.

    Bodies by their indicator ``chi`` on the grid, or by ``outlines``, closed lines (n, 2) [L].
    """
    show_field(panel, np.asarray(vorticity), grid, limit=limit, label=label)
    draw_bodies(panel, grid, chi=chi, outlines=outlines)
    panel.set_facecolor(EMPTY)  # the colour of zero: the mesh ends where nothing is


def draw_bodies(
    panel: Axes,
    grid: Grid,
    *,
    chi: NDArray[Any] | None = None,
    outlines: Sequence[Values] = (),
) -> None:
    """Bodies, filled and outlined."""
    from matplotlib.patches import Polygon

    for line in outlines:
        panel.add_patch(Polygon(line, closed=True, fc=FILL, ec=EDGE, lw=0.7, zorder=3))
    if chi is not None and np.max(chi) > 0.5:
        x, y = grid.axes()
        inside = depth(chi).T
        panel.contourf(x, y, inside, levels=[WALL, math.inf], colors=[FILL], zorder=3)
        panel.contour(x, y, inside, levels=[WALL], colors=[EDGE], linewidths=0.7, zorder=3)


@styled
def wake_figure(shot: Shot, *, limit: float | None = None, part: Window | None = None) -> Figure:
    """The vorticity of a snapshot to scale, as wide as a page, with its bar and its bodies."""
    limit = colour_limit([shot]) if limit is None else limit
    part = window([shot], limit=limit) if part is None else part
    figure, panel = page(part)
    draw_vorticity(
        panel, plane(shot, "vorticity"), shot.grid, limit, chi=indicator(shot), label="vorticity"
    )
    frame(panel, part)
    panel.set_title(f"t = {shot.time:.4g}")
    return figure


@styled
def ftle_figure(
    exponent: Values, grid: Grid, *, time: float, span: float, chi: NDArray[Any] | None, on: Grid
) -> Figure:
    """A finite-time Lyapunov exponent [1/T] on ``grid``, bodies on the grid ``on``."""
    (x, y), half = grid.axes(), 0.5 * grid.spacing
    part = Window(x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)
    figure, panel = page(part)
    top = float(np.quantile(exponent, 0.998))
    colours = "Blues" if span < 0 else "Oranges"
    shown = np.maximum(exponent, 0.0)
    show_field(panel, shown, grid, limit=top or 1.0, colours=colours, label="FTLE")
    draw_bodies(panel, on, chi=chi)
    frame(panel, part)
    kind = "attracting" if span < 0 else "repelling"
    panel.set_title(f"{kind} structures at t = {time:.4g}, over {abs(span):.4g}")
    return figure


@styled
def dye_figure(shot: Shot, positions: Values, *, line: Values, part: Window) -> Figure:
    """Dye over the vorticity of a snapshot: positions (releases, sources, 2), from a line."""
    figure, panel = page(part)
    limit = 3.0 * colour_limit([shot])  # pale: the dye is what is to be seen
    draw_vorticity(panel, plane(shot, "vorticity"), shot.grid, limit, chi=indicator(shot))
    sources = positions.shape[1]
    for number in range(sources):
        colour = f"C{number % 10}" if sources <= 10 else "#14507d"
        panel.plot(*positions[:, number].T, ".", ms=1.6, color=colour, mew=0)
    panel.plot(*line.T, color="#c8511b", lw=1.0)
    frame(panel, part)
    panel.set_title(f"dye at t = {shot.time:.4g}")
    return figure


def page(part: Window) -> tuple[Figure, Axes]:
    """A figure with one panel, as wide as a page or as high, in the shape of the window."""
    from matplotlib.figure import Figure

    width, height = part.size
    scale = min(6.0 / width, 7.5 / height)  # inches, less what bars and letters take
    size = (max(width * scale, 1.6) + 1.2, max(height * scale, 1.4) + 0.7)
    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots()


def frame(panel: Axes, part: Window) -> None:
    """Limits and names of the axes."""
    panel.set(xlim=part[:2], ylim=part[2:], xlabel="$x$", ylabel="$y$")
    panel.set_aspect("equal")
    panel.grid(False)
