"""A movie of a run: one field of all its snapshots in the same colours, as GIF or MP4."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.frames import KINDS, Frames, Kind, Pixels, ffmpeg, strip, written
from pmesh.cases.interface_film import INTERFACES, VALUES, extent, interface_film, interface_of
from pmesh.cases.mesh_picture import outlined
from pmesh.cases.slices import Plane, plane_of
from pmesh.cases.vortex_film import vortex_film
from pmesh.cases.wake import (
    EDGE,
    EMPTY,
    FILL,
    WALL,
    Shot,
    Window,
    colour_limit,
    depth,
    indicator,
    plane,
    window,
)
from pmesh.run.files import write_atomic
from pmesh.run.snapshots import read_snapshots, snapshot_names
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.boxes import leaf_boxes

LEVELS = 96  # colours of the field
BODY, RIM, INK = LEVELS, LEVELS + 1, LEVELS + 2  # palette entries; from INK on 8 greys, to paper
GREYS = 8
PAPER = INK + GREYS - 1


def movie(
    folder: str | Path,
    out: str | Path | None = None,
    *,
    kind: Kind = "gif",
    field: str | None = None,
    fps: float = 12.0,
    follow: bool = False,
    limit: float | None = None,
    pixels: int = 640,
    mesh: bool = False,
    level: Sequence[float] | None = None,
    colour_by: str | None = None,
    view: tuple[float, float] | None = None,
    cut: str | None = None,
    name: str | None = None,
) -> Path:
    """Write the movie of a run directory, by default ``movie.gif`` in it; returns its path.

    ``field``: by default the vorticity, with the line of an interface in it; in a run without it
    the interface: filled in the plane, in space a lit surface in the colours of the ``values`` on
    it, if there are any, or of another field. One window over all snapshots, or with
    ``follow`` one that moves with the bodies; colours that saturate at ``limit`` [of the field];
    ``pixels`` along the longer side. Bodies are filled, the time is above; ``mesh`` outlines the
    active blocks of adaptive plane runs. ``name``: of the watcher whose snapshots are shown.
    In space, without an interface, lit surfaces on which the field has the ``level``, or levels
    (by default a share of its extreme), in the colours of ``colour_by``, seen from ``view``
    (azimuth, elevation) [degrees]: of the vorticity by default, with bodies of ``lambda2``, which
    like ``q`` is worked out of the velocity, of any field or component such as ``vorticity_x``.
    With ``cut``, such as "z=0", a plane instead, by default of the vorticity across it.
    GIF by Pillow; MP4 by imageio-ffmpeg (``pip install "pmesh-flow[movie]"``) or an ffmpeg on the
    path. Refuses a run without snapshots, an unknown field, and MP4 without ffmpeg.
    """
    if kind not in KINDS:
        raise InputError(f"a movie is one of {', '.join(KINDS)}, got {kind!r}", hint="gif")
    if not (math.isfinite(fps) and 0 < fps <= 100 and 64 <= pixels <= 4096):
        raise InputError(
            f"fps must be above 0 and at most 100, pixels from 64 to 4096, got {fps:g} and "
            f"{pixels}",
            hint="--fps 12 --pixels 640",
        )
    if kind == "mp4":
        ffmpeg()
    path = Path(folder) / f"movie.{kind}" if out is None else Path(out)
    frames = film(
        snapshots(folder, name=name), field, follow=follow, limit=limit, pixels=pixels, mesh=mesh,
        level=level, colour_by=colour_by, view=view, cut=cut,
    )  # fmt: skip
    write_atomic(path, written(frames, kind, fps))
    return path


def snapshots(folder: str | Path, *fields: str, name: str | None = None) -> list[Any]:
    """The snapshots of a run that hold these fields; refuses a run without any."""
    shots = read_snapshots(folder, name)
    if not shots:
        held = ", ".join(snapshot_names(folder))
        raise InputError(
            f"{folder} holds no snapshots{f' below {name!r}' if name else ''}",
            hint=held if name and held else "the directory of a run with `every` set",
        )
    for field in fields:
        _check_held(shots, field)
    return shots


def _check_held(shots: Sequence[Shot], name: str) -> None:
    if any(name not in shot.names for shot in shots):
        known = ", ".join(sorted(set.intersection(*(set(shot.names) for shot in shots))))
        raise InputError(f"the snapshots hold no field {name!r}", hint=f"one of {known}")


def film(
    shots: Sequence[Shot],
    field: str | None = None,
    *,
    follow: bool = False,
    limit: float | None = None,
    pixels: int = 640,
    mesh: bool = False,
    level: Sequence[float] | None = None,
    colour_by: str | None = None,
    view: tuple[float, float] | None = None,
    cut: str | None = None,
) -> Frames:
    """The pictures of the snapshots: of a plane field, of an interface, of surfaces in space."""
    if cut is not None:
        shots = [Plane(shot, *plane_of(cut)) for shot in shots]
        field = f"vorticity_{shots[0].across}" if field is None else field  # type: ignore[attr-defined]
    interface = interface_of(shots)
    in_space = shots[0].grid.ndim == 3 and (interface is None or level is not None)
    if not in_space and (level, colour_by, view) != (None, None, None):
        raise InputError(
            "a level, colours by another field and a view are of surfaces in space",
            hint="a run in space without an interface, and no --slice",
        )
    if in_space:
        return vortex_film(
            shots, field, level=level, colour_by=colour_by, limit=limit, view=view, pixels=pixels,
            centre=centre if follow else None,
        )  # fmt: skip
    if field is None:
        ours = "vorticity" if shots[0].grid.ndim == 2 else VALUES
        held = all(ours in shot.names for shot in shots) and (interface or ours == "vorticity")
        field = ours if held else interface or "vorticity"
    _check_held(shots, field)
    if interface is not None and (field in INTERFACES or shots[0].grid.ndim == 3):
        return interface_film(shots, field, follow=follow, limit=limit, pixels=pixels)
    limit = colour_limit(shots, field) if limit is None else limit
    signed = any(plane(shot, field).min() < 0 for shot in shots)
    places = [centre(shot) if follow else (0.0, 0.0) for shot in shots]
    parts = [window([shot], field, limit=limit) for shot in shots]
    parts = [part.moved(-place[0], -place[1]) for part, place in zip(parts, places, strict=True)]
    ends = np.array(parts)
    whole = Window(*ends[:, 0:1].min(0), *ends[:, 1:2].max(0), *ends[:, 2:3].min(0),
                   *ends[:, 3:4].max(0))  # fmt: skip
    if interface is not None and any((shot[interface] < 0).any() for shot in shots):
        low, high = extent(shots, interface, [np.array(place) for place in places])
        whole = Window(min(whole.left, low[0]), max(whole.right, high[0]),
                       min(whole.bottom, low[1]), max(whole.top, high[1]))  # fmt: skip
    sides = (max(32, 2 * round(0.5 * pixels * side / max(whole.size))) for side in whole.size)
    shape = tuple(sides)
    name = field if plane(shots[0], field).shape == shots[0][field].shape else f"|{field}|"
    scale = f"{name}, {'±' if signed else '0 to '}{limit:g}"
    frames = (
        _frame(
            shot,
            field,
            interface,
            whole.moved(place[0], place[1]),
            shape,
            limit,
            signed,
            scale,
            mesh,
        )
        for shot, place in zip(shots, places, strict=True)
    )
    return Frames(pixels=frames, palette=palette(signed))


def centre(shot: Shot) -> tuple[float, ...]:
    """Centre of area or volume of the bodies [L]; refuses a snapshot without bodies."""
    chi = indicator(shot)
    if chi is None or chi.max() <= 0:
        raise InputError("there is no body to follow", hint="a movie without --follow")
    size, axes = chi.sum(), range(chi.ndim)
    sums = (chi.sum(axis=tuple(k for k in axes if k != axis)) for axis in axes)
    return tuple(float(x @ part / size) for x, part in zip(shot.grid.axes(), sums, strict=True))


def palette(signed: bool) -> Pixels:
    """Colours of the field, the body, its rim, and greys from ink to paper; (256, 3)."""
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb

    colours = colormaps["RdBu_r" if signed else "viridis"](np.linspace(0, 1, LEVELS))[:, :3]
    if signed:
        colours[[LEVELS // 2 - 1, LEVELS // 2]] = to_rgb(EMPTY)  # nothing is where it is weak
    greys = np.linspace(to_rgb("#222222"), to_rgb("#ffffff"), GREYS)
    table = np.concatenate([colours, [to_rgb(FILL), to_rgb(EDGE)], greys])
    full = np.ones((256, 3))
    full[: len(table)] = table
    return np.rint(255 * full).astype(np.uint8)


def resampled(
    field: NDArray[Any], grid: Grid, x: NDArray[Any], y: NDArray[Any]
) -> NDArray[np.float64]:
    """A plane field at x times y, bilinear, shape (len(x), len(y)); zero beyond the mesh."""
    values = np.asarray(field, np.float64)
    for axis, points in enumerate((x, y)):
        place = (np.asarray(points) - grid.origin[axis]) / grid.spacing
        n = grid.shape[axis]
        first = np.floor(place).astype(int)
        part = np.expand_dims(place - first, 1 - axis)
        low, high = (_line(values, first + k, axis, n, grid.periodic[axis]) for k in (0, 1))
        values = (1 - part) * low + part * high
    return values


def _line(
    values: NDArray[np.float64], index: NDArray[Any], axis: int, n: int, wraps: bool
) -> NDArray[np.float64]:
    taken = np.take(values, index % n, axis=axis)
    if not wraps:
        outside = np.expand_dims((index < 0) | (index >= n), 1 - axis)
        taken = np.where(outside, 0.0, taken)
    return taken


def _frame(
    shot: Shot, field: str, interface: str | None, part: Window, shape: tuple[int, ...],
    limit: float, signed: bool, scale: str, mesh: bool,
) -> Pixels:  # fmt: skip
    """One picture: a strip with the time, the field below it, an interface and bodies on top."""
    width, height = shape
    x = part.left + (np.arange(width) + 0.5) * part.size[0] / width
    y = part.top - (np.arange(height) + 0.5) * part.size[1] / height
    seen = resampled(plane(shot, field), shot.grid, x, y).T / limit
    level = 0.5 * (seen + 1) if signed else seen
    picture = np.clip(np.floor(level * LEVELS), 0, LEVELS - 1).astype(np.uint8)
    blocks = getattr(shot, "blocks", None)
    if mesh and blocks is not None and blocks.mesh.ndim == 2:
        picture[outlined(leaf_boxes(blocks), part, (height, width))] = INK + GREYS // 2
    if interface is not None:
        inside = resampled(shot[interface], shot.grid, x, y).T < 0
        picture[inside & ~_shrunk(_shrunk(inside))] = INK if signed else PAPER
    chi = indicator(shot)
    if chi is not None:
        inside = resampled(depth(chi), shot.grid, x, y).T > WALL
        picture[inside] = RIM
        picture[_shrunk(inside)] = BODY
    grey = strip(width, f"t = {shot.time:.4g}", scale).astype(np.float64) / 255
    above = (INK + np.rint(grey * (GREYS - 1))).astype(np.uint8)
    return np.concatenate([above, picture])


def _shrunk(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The inside without its outermost pixels."""
    core = inside.copy()
    for axis in (0, 1):
        for step in (-1, 1):
            core &= np.roll(inside, step, axis)
    return core
