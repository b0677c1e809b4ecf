"""Pictures of adaptive meshes: a field with the outlines of its active blocks over it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.style import OURS, show_field, styled
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.boxes import Boxes, leaf_boxes
from remesh.multires.uniform import to_uniform

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure

    from pmesh.run.series import Series

Values = NDArray[Any]
Window = tuple[float, float, float, float]  # left, right, bottom, top [L]
PIXELS = 1400  # nodes along the longer side of a picture, about
SHADES = "YlGnBu"  # of the levels' outlines, from its second third on
FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def level_colours(blocks: Blocks) -> dict[int, Any]:
    """A colour for each level that has active nodes: the finer, the darker."""
    from matplotlib import colormaps

    levels = np.unique(leaf_boxes(blocks).level).tolist()
    parts = np.linspace(0.4, 1.0, len(levels)) if len(levels) > 1 else [0.8]
    return {level: colormaps[SHADES](part) for level, part in zip(levels, parts, strict=True)}


def show_mesh(
    axes: Axes,
    blocks: Blocks,
    *,
    window: Window | None = None,
    axis: int = 2,
    at: float | None = None,
    legend: bool = True,
    width: float = 0.8,
) -> None:
    """Outline the active quadrants of blocks, coloured by level, fine ones thinner.

    In space those that a plane across ``axis`` at ``at`` [L] cuts (the middle by default).
    """
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D

    boxes = cut(leaf_boxes(blocks), axis, _middle(blocks, axis) if at is None else at)
    left, right, bottom, top = _window(blocks, axis) if window is None else window
    near = (boxes.high > (left, bottom)).all(axis=1) & (boxes.low < (right, top)).all(axis=1)
    handles = []
    for level, colour in level_colours(blocks).items():
        own = near & (boxes.level == level)
        if not own.any():
            continue
        (x, y), (u, v) = boxes.low[own].T, boxes.high[own].T
        corners = np.stack([[x, u, u, x, x], [y, y, v, v, y]], axis=-1).swapaxes(0, 1)
        thin = width * 0.8 ** (level - int(boxes.level[near].min()))
        axes.add_collection(LineCollection(list(corners), colors=[colour], linewidths=thin))
        handles.append(Line2D([], [], color=colour, lw=1.6, label=f"{level}"))
    axes.set(xlim=(left, right), ylim=(bottom, top))
    axes.set_aspect("equal")
    axes.grid(False)
    if legend:
        axes.legend(handles=handles, title="level", loc="upper right", frameon=True, fontsize=7.0,
                    title_fontsize=7.0, handlelength=1.0, framealpha=0.85)  # fmt: skip


def show_values(
    axes: Axes,
    values: Values,
    blocks: Blocks,
    *,
    window: Window | None = None,
    axis: int = 2,
    at: float | None = None,
    limit: float | None = None,
    colours: str = "RdBu_r",
    power: float = 1.0,
    label: str | None = None,
) -> Colorbar | None:
    """Draw a scalar field on blocks to scale; in space on the plane across ``axis`` at ``at`` [L].

    At the finest level that a picture of the ``window`` resolves.
    """
    field, grid = sampled_window(values, blocks, window=window, axis=axis, at=at)
    top = float(np.abs(values[blocks.leaves()]).max()) if limit is None else limit
    bar = show_field(axes, field, grid, limit=top, colours=colours, power=power, label=label)
    left, right, bottom, upper = _window(blocks, axis) if window is None else window
    axes.set(xlim=(left, right), ylim=(bottom, upper))
    return bar


def sampled_window(
    values: Values,
    blocks: Blocks,
    *,
    window: Window | None = None,
    axis: int = 2,
    at: float | None = None,
) -> tuple[Values, Grid]:
    """A plane part of a field on blocks, on nodes as fine as a picture shows, and their grid."""
    mesh = blocks.mesh
    if values.shape != blocks.shape:
        raise InputError(
            f"a picture shows one scalar field {blocks.shape}, got {values.shape}",
            hint="values[0], or their magnitude",
        )
    shown = _window(blocks, axis) if window is None else window
    longest = max(shown[1] - shown[0], shown[3] - shown[2])
    level = mesh.levels
    while level > 0 and longest / mesh.spacing(level) > PIXELS:
        level -= 1
    spacing = mesh.spacing(level)
    region: list[range] = []
    ends = iter((shown[:2], shown[2:]))
    for k in range(mesh.ndim):
        if mesh.ndim == 3 and k == axis:
            place = _middle(blocks, axis) if at is None else at
            node = int(np.clip(round((place - mesh.grid.origin[k]) / spacing), 0,
                               mesh.level_grid(level).shape[k] - 1))  # fmt: skip
            region.append(range(node, node + 1))
            continue
        low, high = ((end - mesh.grid.origin[k]) / spacing for end in next(ends))
        first = max(0, int(np.floor(low)) - 1)
        last = min(mesh.level_grid(level).shape[k], int(np.ceil(high)) + 2)
        region.append(range(first, max(last, first + 4)))
    field = to_uniform(values, blocks, level, region=region)
    start = [mesh.grid.origin[k] + part.start * spacing for k, part in enumerate(region)]
    if mesh.ndim == 3:
        field = np.take(field, 0, axis=axis)
        start.pop(axis)
    return field, Grid(field.shape, spacing, start)


def cut(boxes: Boxes, axis: int, at: float) -> Boxes:
    """The boxes that the plane across an axis cuts, as boxes in it; plane ones as they are."""
    if boxes.low.shape[1] == 2:
        return boxes
    met = (boxes.low[:, axis] <= at) & (at < boxes.high[:, axis])
    low, high = (np.delete(part[met], axis, axis=1) for part in (boxes.low, boxes.high))
    return Boxes(boxes.level[met], low, high)


def show_blocks_in_space(axes: Any, blocks: Blocks, *, levels: int = 1) -> None:
    """The outside of the region of the finest ``levels``, box by box, in 3-D Matplotlib axes."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    boxes, colours = leaf_boxes(blocks), level_colours(blocks)
    low, high = boxes.low.min(axis=0), boxes.high.max(axis=0)
    whole = Poly3DCollection(list(_faces(low[None], high[None])), facecolors=(0, 0, 0, 0))
    whole.set_edgecolor("#909090")
    whole.set_linewidth(0.6)
    axes.add_collection3d(whole)
    for level in range(max(0, blocks.finest - levels + 1), blocks.finest + 1):
        own = boxes.level == level
        outer = _outer(_faces(boxes.low[own], boxes.high[own]))
        finest = level == blocks.finest
        part = Poly3DCollection(list(outer), facecolors=colours[level], shade=finest)
        part.set_alpha(0.9 if finest else 0.12)
        part.set_linewidth(0.3)
        part.set_edgecolor((1.0, 1.0, 1.0, 0.6) if finest else colours[level])
        axes.add_collection3d(part)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    axes.set_axis_off()


@styled
def mesh_figure(
    values: Values, blocks: Blocks, *, label: str = "", levels: int = 2, **options: Any
) -> Figure:
    """A field with its mesh over it; in space a slice, and the boxes of the finest levels."""
    from matplotlib.figure import Figure

    deep = blocks.mesh.ndim == 3
    figure = Figure(figsize=(11.0, 5.2) if deep else (6.4, 5.6), layout="constrained")
    panel = figure.add_subplot(1, 2 if deep else 1, 1)
    show_values(panel, values, blocks, label=label or None, **options)
    places = {name: options[name] for name in ("window", "axis", "at") if name in options}
    show_mesh(panel, blocks, **places)
    panel.set_title(
        f"{blocks.active:,} active nodes of {blocks.mesh.grid.size:,}: 1/{blocks.compression:.0f}"
    )
    if deep:
        side: Any = figure.add_subplot(1, 2, 2, projection="3d")
        show_blocks_in_space(side, blocks, levels=levels)
    return figure


@styled
def mesh_history(values: Values, blocks: Blocks, series: Series) -> Figure:
    """A field with its mesh, the length of a vector; active nodes and compression over time."""
    from matplotlib.figure import Figure

    length = values if values.shape == blocks.shape else np.sqrt((values**2).sum(axis=0))
    figure = Figure(figsize=(10.5, 4.6), layout="constrained")
    axes: Any = figure.subplots(1, 2, width_ratios=(1.2, 1))
    signed = bool((length[blocks.leaves()] < 0).any())
    show_values(axes[0], length, blocks, colours="RdBu_r" if signed else "BuPu")
    show_mesh(axes[0], blocks)
    axes[0].set_title(f"{blocks.active:,} active nodes, 1/{blocks.compression:.1f} of the finest")
    if "active" in series and len(series["time"]) > 1:
        axes[1].plot(series["time"], series["active"], color=OURS)
        axes[1].set(title="active nodes", xlabel="$t$", ylim=(0, None))
        other = axes[1].secondary_yaxis(
            "right", functions=(lambda n: 100 * n / blocks.mesh.grid.size,
                                lambda part: part * blocks.mesh.grid.size / 100),
        )  # fmt: skip
        other.set_ylabel("per cent of the finest grid's")
    else:
        axes[1].set_axis_off()
    return figure


def outlined(boxes: Boxes, window: Window, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Pixels (height, width), top row first, on the lower and left edges of plane boxes."""
    height, width = shape
    left, right, bottom, top = window
    scale = np.array([width / (right - left), height / (top - bottom)])
    low, high = ((part - (left, bottom)) * scale for part in (boxes.low, boxes.high))
    seen = (high > 0).all(axis=1) & (low < (width, height)).all(axis=1)
    first = np.floor(low[seen]).astype(int)
    last = np.minimum(np.floor(high[seen]).astype(int), (width - 1, height - 1))
    result = np.zeros((height, width), bool)
    for (x, y), (u, v) in zip(first, last, strict=True):
        if y >= 0:
            result[y, max(x, 0) : u + 1] = True
        if x >= 0:
            result[max(y, 0) : v + 1, x] = True
    return result[::-1]


def _faces(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """The six faces of each box (6 m, 4, 3)."""
    ends = np.stack([low, high])
    corners = np.stack([ends[[k >> 2 & 1, k >> 1 & 1, k & 1], :, [0, 1, 2]] for k in range(8)])
    faces: NDArray[np.float64] = np.stack([corners[list(face)] for face in FACES])  # (6, 4, 3, m)
    return np.moveaxis(faces, -1, 0).reshape(-1, 4, 3)


def _outer(faces: NDArray[np.float64]) -> NDArray[np.float64]:
    """The faces that no two boxes share: boxes of one size, or also such of half of it.

    Of a large face that small ones cover in part, the quarters that they leave.
    """
    sides = np.abs(np.diff(faces, axis=1)).max(axis=(1, 2))
    unit = float(sides.max(initial=1e-300))
    large = sides > 0.75 * unit
    if large.all():
        return faces[_alone(faces, unit)]
    quarters = 0.5 * (faces[large][:, :, None] + faces[large][:, None])  # (n, 4 corners, 4, 3)
    parts = np.concatenate([faces[~large], quarters.reshape(-1, 4, 3)])
    kept = _alone(parts, unit)
    count = int(np.count_nonzero(~large))
    rest = kept[count:].reshape(-1, 4)
    whole = np.asarray(rest.all(axis=1))
    left = rest & ~whole[:, None]
    return np.concatenate([parts[:count][kept[:count]], faces[large][whole], quarters[left]])


def _alone(faces: NDArray[np.float64], unit: float) -> NDArray[np.bool_]:
    """Which faces no other one lies on."""
    places = np.rint(faces.mean(axis=1) / unit * 64).astype(np.int64)
    _, which, count = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    return np.asarray(count[which.reshape(-1)] == 1)


def _window(blocks: Blocks, axis: int) -> Window:
    """The whole domain, without the axis that is cut."""
    grid = blocks.mesh.grid
    sides = [(o, o + n * grid.spacing) for o, n in zip(grid.origin, grid.shape, strict=True)]
    if grid.ndim == 3:
        sides.pop(axis)
    (left, right), (bottom, top) = sides
    return left, right, bottom, top


def _middle(blocks: Blocks, axis: int) -> float:
    """Where a field is cut if nothing else is said [L]."""
    grid = blocks.mesh.grid
    k = min(axis, grid.ndim - 1)
    return grid.origin[k] + 0.5 * grid.shape[k] * grid.spacing
