"""The frames of a movie of vortices in space: lit surfaces seen by a camera that stands still."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.frames import Frames, Pixels, colour_strip
from pmesh.cases.interface_film import VIEW, Box, picture_size
from pmesh.cases.vortices import (
    SHARES,
    Look,
    extent,
    layers_of,
    looked,
    map_of,
    picture,
)
from pmesh.cases.wake import Shot
from remesh.errors import InputError

SAMPLES = 9  # snapshots that levels and colours are found from
USUAL = ("velocity", "vorticity")  # fields of the colours, the first one that is held
WIDE = 0.04  # of the largest side, beside what is shown


def vortex_film(
    shots: Sequence[Shot],
    field: str | None = None,
    *,
    level: Sequence[float] | None = None,
    colour_by: str | None = None,
    limit: float | None = None,
    view: tuple[float, float] | None = None,
    pixels: int = 640,
    centre: Callable[[Shot], tuple[float, ...]] | None = None,
) -> Frames:
    """The pictures of the snapshots: surfaces of a field in the colours of another one.

    ``field`` and ``level`` as for `vortices.looked`, the same level and the same scale of colours
    in all pictures; ``colour_by`` a field, by default the velocity on the
    vorticity, lambda2 and q, where held, or "none". One box holds all that is ever
    seen; with a ``centre`` of each snapshot it moves along. A second or two per picture.
    Refuses a run in which there is nothing to see.
    """
    some = shots[:: -(-len(shots) // SAMPLES)]
    look = looked(some, field, levels=level)
    field = look.field
    if colour_by is None:
        held = (name for name in USUAL if all(name in shot.names for shot in shots))
        colour_by = next((name for name in held if name != field), None)
        colour_by = colour_by if field in SHARES else None
    elif colour_by == "none":
        colour_by = None
    look = looked(some, field, levels=look.levels, colour_by=colour_by)
    if limit is not None and look.limits is not None:
        look = look._replace(limits=(-limit if look.limits[0] < 0 else 0.0, limit))
    places = [np.array(centre(shot) if centre else (0.0,) * 3) for shot in shots]
    box = _box(shots, look, places)
    return Frames(pixels=_pictures(shots, look, box, places, pixels, view or VIEW))


def _box(shots: Sequence[Shot], look: Look, places: Sequence[NDArray[Any]]) -> Box:
    """What holds all that is ever seen, each snapshot moved back by its place."""
    ends = []
    for shot, place in zip(shots, places, strict=True):
        if layers := layers_of(shot, look):
            ends.append(np.array(extent(layers, shot.grid)) - place)
    if not ends:
        raise InputError(
            f"{look.field!r} reaches the level {look.levels[0]:g} in no snapshot",
            hint="another --level, or none",
        )
    corners = np.array(ends)
    low, high = corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
    wide = WIDE * (high - low).max() * ~np.array(shots[0].grid.periodic)
    return Box(low - wide, high + wide)


def _pictures(
    shots: Sequence[Shot], look: Look, box: Box, places: Sequence[NDArray[Any]], pixels: int,
    view: tuple[float, float],
) -> Iterator[Pixels]:  # fmt: skip
    size = picture_size(box, pixels, view)
    for shot, place in zip(shots, places, strict=True):
        part = box.moved(place)
        bounds = (tuple(part.low.tolist()), tuple(part.high.tolist()))
        image = picture(shot, look, bounds=bounds, view=view, size=size)
        yield np.concatenate([head(shot, look, size[0]), image])


def head(shot: Shot, look: Look, width: int) -> Pixels:
    """The strip above a picture: time, field and level, the colours and what they say."""
    levels = " and ".join(f"{level:.3g}" for level in look.levels)
    left = f"t = {shot.time:.4g}    {look.field} = {levels}"
    return colour_strip(width, left, look.colour_by, look.limits, map_of(look))
