"""The frames of a movie of an interface: filled in the plane, a lit surface in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.camera import aimed
from pmesh.cases.frames import Frames, Pixels, strip
from pmesh.cases.surfaces import STEEL, Layer, render
from pmesh.cases.wake import Shot
from remesh.errors import InputError

Array = NDArray[np.floating[Any]]
INTERFACES = ("level_set", "phi")  # names of level sets in snapshots, negative inside
VALUES = "values"  # on a surface, in the snapshots of what spreads on it
VIEW = (-55.0, 22.0)  # azimuth and elevation of the camera [degrees]
MARGIN = 0.06  # of what is shown in the plane, at each side
FILLED, LINE, START = "#a9cbec", "#0b559f", "#9a9a9a"  # inside, the contour, the first contour
FINE = 3.0  # pixels between the points that contours in the plane go through
UNDER = 0.02  # values on both sides of zero by less, over the largest, are of one sign
SLIM = 0.5  # least ratio of the picture's sides


class Box(NamedTuple):
    """A part of the plane or of space."""

    low: Array  # (ndim,) [L]
    high: Array

    def moved(self, by: Array) -> Box:
        """The box after a shift."""
        return Box(self.low + by, self.high + by)


def interface_of(shots: Sequence[Shot]) -> str | None:
    """The name of the level set that all snapshots hold; None if there is none."""
    held = (name for name in INTERFACES if all(name in shot.names for shot in shots))
    return next(held, None)


def interface_film(
    shots: Sequence[Shot],
    field: str,
    *,
    follow: bool = False,
    limit: float | None = None,
    pixels: int = 640,
) -> Frames:
    """The pictures of the snapshots' interface; in space in the colours of another field.

    What is inside is filled; in space the surface is lit, and seen by a camera that stands still or
    with ``follow`` goes with the centre of what is inside. One box holds all that is ever inside.
    An interface that has gone leaves an empty picture. A second per picture in space. Refuses a run
    without anything inside, and a limit of the colours where there are none.
    """
    name = interface_of(shots)
    if name is None:
        raise InputError(
            "the snapshots hold no level set", hint=f"a field named {' or '.join(INTERFACES)}"
        )
    if limit is not None and field in INTERFACES:
        raise InputError(
            f"an interface has no colours to limit, got limit {limit:g}",
            hint="a movie without --limit, or of another --field",
        )
    places = [_centre(shot, name) if follow else np.zeros(shot.grid.ndim) for shot in shots]
    box = extent(shots, name, places)
    if shots[0].grid.ndim == 2:
        return Frames(pixels=_plane(shots, name, box, places, pixels, start=not follow))
    return Frames(pixels=_space(shots, name, field, box, places, pixels, limit))


def _plane(
    shots: Sequence[Shot], name: str, box: Box, places: Sequence[Array], pixels: int, *, start: bool
) -> Any:
    """Pictures in the plane, the contour at the start in grey."""
    size = _even(box.high - box.low, pixels)
    first = shots[0] if start else None
    for shot, place in zip(shots, places, strict=True):
        picture = _filled(shot, name, box.moved(place), size, first)
        told = f"grey: t = {first.time:.4g}" if first is not None else ""
        yield _titled(picture, shot, told)


def _filled(shot: Shot, name: str, box: Box, size: tuple[int, int], first: Shot | None) -> Pixels:
    """The inside, filled, and its contour."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size[0] / 100, size[1] / 100), dpi=100)
    canvas: Any = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    for one, colour in ((first, START), (shot, LINE)):
        if one is None or not _crossed(one[name]):
            continue
        x, y, phi = _fine(one, name, FINE * (box.high[0] - box.low[0]) / size[0])
        if one is shot:
            axes.contourf(x, y, phi.T, levels=[-np.inf, 0.0], colors=[FILLED])
        axes.contour(x, y, phi.T, levels=[0.0], colors=[colour], linewidths=1.3)
    axes.set(xlim=(box.low[0], box.high[0]), ylim=(box.low[1], box.high[1]))
    canvas.draw()
    return np.asarray(canvas.buffer_rgba(), np.uint8)[..., :3].copy()


def _space(
    shots: Sequence[Shot], name: str, field: str, box: Box, places: Sequence[Array], pixels: int,
    limit: float | None,
) -> Any:  # fmt: skip
    """Pictures in space."""
    size = picture_size(box, pixels)
    ends = None if field in INTERFACES else _limits(shots, name, field, limit)
    told = "" if ends is None else f"{field}, {ends[0]:.3g} to {ends[1]:.3g}"
    colours = "RdBu_r" if ends is not None and ends[0] == -ends[1] else "viridis"
    for shot, place in zip(shots, places, strict=True):
        phi = np.asarray(shot[name], np.float64)
        part = box.moved(place)
        if _crossed(phi):
            values = None if ends is None else _scalar(shot, field)
            layer = Layer(
                surface=(phi, shot.grid), colour=STEEL, values=values, colours=colours, limits=ends
            )
            bounds = (tuple(part.low.tolist()), tuple(part.high.tolist()))
            picture = render(layer, bounds=bounds, view=VIEW, size=size)
        else:
            picture = np.full((size[1], size[0], 3), 255, np.uint8)
        yield _titled(picture, shot, told)


def _titled(picture: Pixels, shot: Shot, told: str) -> Pixels:
    """The picture below a strip with the time."""
    line = strip(picture.shape[1], f"t = {shot.time:.4g}", told)
    return np.concatenate([np.repeat(line[..., None], 3, axis=2), picture])


def _crossed(phi: Array) -> bool:
    return bool(phi.min() < 0 < phi.max())


def _fine(shot: Shot, name: str, spacing: float) -> tuple[Array, Array, Array]:
    """A level set in the plane between its nodes, by cubics, and its axes; periodic ones closed."""
    from scipy import ndimage

    grid = shot.grid
    phi = np.pad(
        np.asarray(shot[name], np.float64),
        [(0, int(wraps)) for wraps in grid.periodic],
        mode="wrap",
    )
    parts = max(1, round(grid.spacing / spacing))
    x, y = (np.arange(parts * (n - 1) + 1) / parts for n in phi.shape)
    fine = ndimage.map_coordinates(phi, np.meshgrid(x, y, indexing="ij"), order=3, mode="nearest")
    return grid.origin[0] + grid.spacing * x, grid.origin[1] + grid.spacing * y, fine


def _centre(shot: Shot, name: str) -> Array:
    """The centre of what is inside [L]; the middle of the mesh if nothing is."""
    grid = shot.grid
    inside = np.clip(0.5 - np.asarray(shot[name], np.float64) / grid.spacing, 0.0, 1.0)
    total = inside.sum()
    if total == 0:
        return np.array(grid.origin) + 0.5 * np.array(grid.length)
    sums = (
        inside.sum(axis=tuple(k for k in range(grid.ndim) if k != axis))
        for axis in range(grid.ndim)
    )
    return np.array([axis @ part / total for axis, part in zip(grid.axes(), sums, strict=True)])


def extent(shots: Sequence[Shot], name: str, places: Sequence[Array]) -> Box:
    """What holds all that is ever inside, each snapshot moved back by its place, and a margin."""
    boxes = []
    for shot, place in zip(shots, places, strict=True):
        inside, grid = shot[name] < 0, shot.grid
        if not inside.any():
            continue
        ends = []
        for axis in range(grid.ndim):
            others = tuple(k for k in range(grid.ndim) if k != axis)
            lines = np.flatnonzero(inside.any(axis=others))
            ends.append((lines[0] - 1, lines[-1] + 1))
        boxes.append(np.array(grid.origin) + grid.spacing * np.array(ends).T - place)
    if not boxes:
        raise InputError(
            "nothing is inside the interface in any snapshot", hint="a level set < 0 inside"
        )
    corners = np.array(boxes)
    low, high = corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
    edge = MARGIN * (high - low).max() if len(low) == 2 else 0.0
    return Box(low - edge, high + edge)


def picture_size(box: Box, pixels: int, view: tuple[float, float] = VIEW) -> tuple[int, int]:
    """Width and height of a picture in space [pixels]: the shape of the box as it is seen."""
    corners = np.array([box.low, box.high])
    points = np.stack(np.meshgrid(*corners.T), axis=-1).reshape(-1, 3)
    seen = np.ptp(aimed(points, view, (pixels, pixels)).project(points)[:, :2], axis=0)
    return _even(np.maximum(seen, SLIM * seen.max()), pixels)


def _even(sides: Array, pixels: int) -> tuple[int, int]:
    """Even numbers of pixels in the ratio of the sides, ``pixels`` along the longer one."""
    width, height = (max(32, 2 * round(float(0.5 * pixels * side / sides.max()))) for side in sides)
    return width, height


def _scalar(shot: Shot, field: str) -> Array:
    """A scalar field as it is, of a vector its length."""
    values = np.asarray(shot[field], np.float64)
    return np.sqrt((values**2).sum(axis=0)) if values.ndim > shot.grid.ndim else values


def _limits(
    shots: Sequence[Shot], name: str, field: str, limit: float | None
) -> tuple[float, float]:
    """Values at which colours end: those found beside the interface, even about zero if signed."""
    low, high = np.inf, -np.inf
    for shot in shots:
        near, inside = np.zeros(shot.grid.shape, bool), shot[name] < 0
        for axis in range(shot.grid.ndim):
            cut = np.moveaxis(near, axis, 0)
            side = np.moveaxis(inside, axis, 0)
            crossing = side[1:] != side[:-1]
            cut[1:] |= crossing
            cut[:-1] |= crossing
        values = _scalar(shot, field)
        values = values[near & np.isfinite(values)]
        low, high = min(low, values.min(initial=np.inf)), max(high, values.max(initial=-np.inf))
    if limit is not None:
        return (-limit if -low > UNDER * high else 0.0), limit
    if not low < high:
        return (low - 0.5, low + 0.5) if low == high else (0.0, 1.0)
    top = max(-low, high)
    if min(-low, high) > UNDER * top:
        return -top, top
    return (
        (float(max(low, 0.0)), float(high)) if high > -low else (float(low), float(min(high, 0.0)))
    )
