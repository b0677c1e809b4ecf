"""Vortices in space: surfaces of vorticity, lambda-2 or Q, coloured, the bodies beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.surfaces import Bounds, Image, Layer, render, show_surface
from pmesh.cases.wake import INDICATOR, WALL, Shot, depth
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.floating[Any]]
CRITERIA = ("lambda2", "q")  # worked out of the velocity
SHARES = {"lambda2": 0.06, "q": 0.06, "vorticity": 0.3}  # of the extreme: the level if not given
SHARE = 0.4  # of other fields
SKIN = 3  # nodes around bodies that are not looked at for a level
STRONG = 0.98  # quantile outside bodies that stands for the extreme of a wake
LIVE = 0.01  # of the largest: what is weaker is not looked at for it
GLASS = 0.28  # opacity of the outer ones of several surfaces
NOTE = "#6b6b6b"  # of words in an empty panel
BODY, ALONE = "#c6c2ba", "#5b9bd5"
UP, DOWN = "#d0644f", "#4f86c6"  # of surfaces where a signed field is positive, negative
SIGNED, PLAIN = "coolwarm", "viridis"  # maps of colours


class NothingToShowError(InputError):
    """A field that has no surface in the snapshots."""


class Look(NamedTuple):
    """What of a flow is shown: surfaces of one field, in the colours of another."""

    field: str  # a field of the snapshots, a component of it, lambda2, q or helicity
    levels: tuple[float, ...]  # each encloses what is beyond it, away from zero
    colour_by: str | None = None
    limits: tuple[float, float] | None = None  # of the colours


def scalar(shot: Shot, name: str) -> Array:
    """A scalar of a snapshot: a field, a vector's length, a component such as ``vorticity_x``.

    Also ``lambda2``, ``q`` and ``helicity`` (velocity times vorticity), by the velocity that the
    snapshot holds or that of its vorticity. Refuses what cannot be had from what it holds.
    """
    ndim = shot.grid.ndim
    if name in shot.names:
        values: Array = np.asarray(shot[name])
        values = values if values.dtype.kind == "f" else values.astype(np.float64)
        return np.sqrt((values**2).sum(axis=0)) if values.ndim > ndim else values
    whole, _, axis = name.rpartition("_")
    if whole in shot.names and axis in tuple("xyz"[:ndim]):
        values = np.asarray(shot[whole])
        if values.ndim > ndim:
            return np.asarray(values["xyz".index(axis)])
    if name in CRITERIA and (velocity := _velocity(shot)) is not None:
        from pmesh.vortex.criteria import lambda2, q_criterion

        return (lambda2 if name == "lambda2" else q_criterion)(velocity, shot.grid)
    if name == "helicity" and "vorticity" in shot.names:
        velocity = _velocity(shot)
        if velocity is not None and velocity.shape == shot["vorticity"].shape:
            return np.asarray((velocity * shot["vorticity"]).sum(axis=0))
    raise InputError(
        f"the snapshots hold no field {name!r}",
        hint=f"one of {', '.join(sorted([*shot.names, *CRITERIA, 'helicity']))}, or a component "
        "such as vorticity_x",
    )


def usual_field(shot: Shot) -> str:
    """What shows the vortices of a snapshot: lambda2 where walls have vorticity of their own."""
    return "vorticity" if _away(shot) is None else "lambda2"


def _velocity(shot: Shot) -> Array | None:
    """The velocity of a snapshot; up to a free stream that of its vorticity; None without both."""
    if "velocity" in shot.names:
        return np.asarray(shot["velocity"])
    if "vorticity" not in shot.names:
        return None
    from pmesh.spectral.poisson import velocity

    return np.asarray(velocity(shot["vorticity"], shot.grid))


def default_levels(shots: Sequence[Shot], field: str) -> tuple[float, ...]:
    """The level at which to draw a field: a share of its extreme in the median snapshot.

    Of fields of both signs, but for the criteria, the level on both sides of zero. Around bodies
    the extreme is that of the flow away from their walls, of all that is outside them where
    nothing is away. Snapshots in which the field is zero do not count. The share of lambda-2 and
    of Q, which are squares of rates, is about the square of the vorticity's. Refuses a field that
    has no such extreme in any snapshot, with `NothingToShowError`.
    """
    for skin in (SKIN, 0):
        tops, low, high = [], 0.0, 0.0
        for shot in shots:
            least, most, top = _extremes(shot, field, skin)
            low, high = min(low, least), max(high, most)
            tops += [top] if top > 0 else []
        if tops:
            level = float(f"{SHARES.get(field, SHARE) * float(np.median(tops)):.2g}")
            if low < -level and high > level:
                return level, -level
            return (-level,) if -low > high else (level,)
    what = {"lambda2": "is nowhere negative", "q": "is nowhere positive"}.get(field, "is zero")
    raise NothingToShowError(f"the field {field!r} {what} in the snapshots", hint="another --field")


def _extremes(shot: Shot, field: str, skin: int) -> tuple[float, float, float]:
    """Smallest and largest value of a field, at most and at least 0, and its size in the wake."""
    values, away = scalar(shot, field), _away(shot, skin)
    values = values if away is None else values[away]
    values = values[np.isfinite(values)]
    if field == "lambda2":
        values = np.minimum(values, 0.0)
    elif field == "q":
        values = np.maximum(values, 0.0)
    if not values.size:
        return 0.0, 0.0, 0.0
    size = np.abs(values)
    top = float(size.max())
    if away is not None and top > 0:
        top = float(np.quantile(size[size > LIVE * top], STRONG))
    return min(0.0, float(values.min())), max(0.0, float(values.max())), top


def _away(shot: Shot, skin: int = SKIN) -> NDArray[np.bool_] | None:
    """Where bodies and ``skin`` nodes beside their walls are not; None without bodies."""
    if INDICATOR not in shot.names:
        return None
    chi = np.asarray(shot[INDICATOR]) > 0
    if not chi.any():
        return None
    if not skin:
        return np.asarray(~chi)
    from scipy import ndimage

    found: NDArray[np.bool_] = ~ndimage.binary_dilation(chi, iterations=skin)
    return found


def colour_limits(
    shots: Sequence[Shot], name: str, field: str, levels: Sequence[float]
) -> tuple[float, float]:
    """Values at which the colours of surfaces end, even about zero if they are of both signs.

    Those of the nodes that surfaces pass away from walls, but for a hundredth at either end.
    """
    found = []
    for shot in shots:
        values, near = scalar(shot, name), scalar(shot, field)
        beside = np.zeros(shot.grid.shape, bool)
        for level in levels:
            inside = near > level if level > 0 else near < level
            for axis in range(shot.grid.ndim):
                cut, side = np.moveaxis(beside, axis, 0), np.moveaxis(inside, axis, 0)
                crossing = side[1:] != side[:-1]
                cut[1:] |= crossing
                cut[:-1] |= crossing
        away = _away(shot)
        values = values[beside & np.isfinite(values) & (True if away is None else away)]
        if values.size:
            found.append(np.quantile(values, (0.01, 0.99)))
    if not found:
        return 0.0, 1.0
    low, high = float(np.min(found)), float(np.max(found))
    if low < 0 < high and min(-low, high) > 0.1 * max(-low, high):
        return -max(-low, high), max(-low, high)
    low, high = (0.0 if abs(end) < 1e-3 * (high - low) else end for end in (low, high))
    return (low, high) if low < high else (low - 0.5, low + 0.5)


def looked(
    shots: Sequence[Shot],
    field: str | None = None,
    *,
    levels: Sequence[float] | None = None,
    colour_by: str | None = None,
    limits: tuple[float, float] | None = None,
) -> Look:
    """What to show, with the same levels and colours in all snapshots; what is not given is found.

    The field is by default the vorticity, lambda2 in a flow past bodies if there is any.

    Refuses levels that are zero or not finite, and what `scalar` and `default_levels` refuse.
    """
    asked, field = field, usual_field(shots[0]) if field is None else field
    try:
        given = default_levels(shots, field) if levels is None else tuple(map(float, levels))
    except NothingToShowError:
        if asked is not None or field == "vorticity":
            raise
        field, given = "vorticity", default_levels(shots, "vorticity")  # layers, and no vortex
    if not given or not all(np.isfinite(level) and level != 0 for level in given):
        raise InputError(
            f"levels must be finite numbers that are not zero, got {given}", hint="--level 1.5"
        )
    if colour_by is not None and limits is None:
        limits = colour_limits(shots, colour_by, field, given)
    return Look(field, given, colour_by, limits)


def layers_of(shot: Shot, look: Look) -> list[Layer]:
    """The surfaces of a snapshot, those of its bodies first; none where it has no such level.

    Of several levels of one sign the one furthest from zero is opaque, others are glass.
    """
    grid, values = shot.grid, scalar(shot, look.field)
    layers = [] if (body := body_layer(shot)) is None else [body]
    colours = None if look.colour_by is None else scalar(shot, look.colour_by)
    both = min(look.levels, default=0.0) < 0 < max(look.levels, default=0.0)
    for level in look.levels:
        phi = level - values if level > 0 else values - level
        if not phi.min() < 0 < phi.max():
            continue
        farther = [other for other in look.levels if other * level > level * level]
        alone = (UP if level > 0 else DOWN) if both else ALONE
        layers.append(
            Layer(
                surface=(phi, grid),
                colour=alone,
                opacity=GLASS if farther else 1.0,
                values=colours,
                colours=map_of(look),
                limits=look.limits,
            )
        )
    return layers


def map_of(look: Look) -> str:
    """Matplotlib's name of the colours."""
    return SIGNED if look.limits and look.limits[0] == -look.limits[1] else PLAIN


def body_layer(shot: Shot) -> Layer | None:
    """The surface of the bodies in a snapshot; None without any."""
    if INDICATOR not in shot.names:
        return None
    phi = WALL - depth(np.asarray(shot[INDICATOR]))
    if not phi.min() < 0 < phi.max():
        return None
    return Layer(surface=(phi, shot.grid), colour=BODY)


def extent(layers: Sequence[Layer], grid: Grid) -> tuple[NDArray[Any], NDArray[Any]]:
    """Lower and upper corner of what one or more surfaces enclose, a periodic axis whole."""
    low, high = [], []
    ends = np.array([_box(np.asarray(layer.surface[0]) < 0) for layer in layers])  # type: ignore[index]
    for axis, wraps in enumerate(grid.periodic):
        first, last = ends[:, axis, 0].min(), ends[:, axis, 1].max()
        if wraps:
            first, last = 0, grid.shape[axis]
        low.append(grid.origin[axis] + grid.spacing * first)
        high.append(grid.origin[axis] + grid.spacing * last)
    return np.array(low), np.array(high)


def _box(inside: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last node along each axis, one beyond what is inside."""
    ends = []
    for axis in range(3):
        others = tuple(k for k in range(3) if k != axis)
        lines = np.flatnonzero(inside.any(axis=others))
        ends.append((max(0, int(lines[0]) - 1), min(inside.shape[axis] - 1, int(lines[-1]) + 1)))
    return ends


def picture(shot: Shot, look: Look, *, bounds: Bounds | None = None, **options: Any) -> Image:
    """The surfaces of a snapshot, lit, (height, width, 3); ``options`` as of `surfaces.render`.

    Periodic axes are shown whole, with the edges of the box. What has no such level is an empty
    picture.
    """
    layers = layers_of(shot, look)
    width, height = options.get("size", (1200, 900))
    if not layers:
        return np.full((height, width, 3), 255, np.uint8)
    wraps = any(shot.grid.periodic)
    if bounds is None and wraps:
        low, high = extent(layers, shot.grid)
        bounds = (tuple(low.tolist()), tuple(high.tolist()))
    told = {"box": wraps, "ground": not wraps} | options
    return render(*layers, bounds=bounds, **told)


def show_isosurface(
    panel: Axes,
    shot: Shot,
    field: str | None = None,
    *,
    levels: Sequence[float] | None = None,
    colour_by: str | None = None,
    limits: tuple[float, float] | None = None,
    title: str | None = None,
    label: str | None = None,
    **options: Any,
) -> Look:
    """Put lit surfaces of a snapshot into a figure's panel, a bar of their colours beside it.

    ``levels``: of the field (by default as of `looked`), a share of its extreme if not given; of
    several the outer ones are glass. ``colour_by``: another field or component. ``label``: of the
    bar; the field's name if None, no bar if "". ``options`` as of `surfaces.render`: view, bounds,
    size, box, ground. A panel without anything to show says so.
    Returns what is shown, for a next panel to show the same: its levels (none of a field that is
    zero) and limits.
    """
    try:
        look = looked([shot], field, levels=levels, colour_by=colour_by, limits=limits)
    except NothingToShowError:
        look = Look(field or usual_field(shot), ())
    image = picture(shot, look, **options)
    bar = look.limits if label != "" else None
    show_surface(
        panel, image, title=title, colours=map_of(look), limits=bar, label=label or look.colour_by
    )
    if not look.levels or (image == 255).all():
        panel.text(0.5, 0.04, f"nothing to show of {look.field}", transform=panel.transAxes,
                   ha="center", color=NOTE)  # fmt: skip
    return look
