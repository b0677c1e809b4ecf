"""A plane through a flow in space, seen as a flow in the plane is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.vortices import CRITERIA, scalar
from pmesh.cases.wake import INDICATOR, Shot, draw_bodies
from remesh.errors import InputError
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AXES = "xyz"


class Plane:
    """A snapshot in space cut by a plane across one axis: a snapshot of scalars in the plane.

    Fields between the two nearest planes of nodes are straight. ``plane["vorticity_z"]`` is a
    component, ``plane["vorticity"]`` a vector's length; `vortices.scalar` tells what else.
    The first of the axes left points right, the other one up. Refuses planes outside the mesh.
    """

    def __init__(self, shot: Shot, axis: int, place: float) -> None:
        grid = shot.grid
        if grid.ndim != 3:
            raise InputError("a slice is of flows in space", hint="a movie without --slice")
        at = (place - grid.origin[axis]) / grid.spacing
        if grid.periodic[axis]:
            at %= grid.shape[axis]
        elif not -1e-9 <= at <= grid.shape[axis] - 1 + 1e-9:
            first, last = grid.axes()[axis][[0, -1]]
            raise InputError(
                f"the plane {AXES[axis]} = {place:g} is not in the mesh",
                hint=f"{AXES[axis]} from {first:g} to {last:g}",
            )
        self._shot, self._axis = shot, axis
        self._low = min(int(at + 1e-9), grid.shape[axis] - 1)
        self._part = min(max(at - self._low, 0.0), 1.0)
        self.place = place
        left = [k for k in range(3) if k != axis]
        self.time = shot.time
        self.grid = Grid(
            [grid.shape[k] for k in left],
            grid.spacing,
            [grid.origin[k] for k in left],
            [grid.boundary[k] for k in left],
        )

    @property
    def names(self) -> Mapping[str, Any]:
        """The scalars that can be asked for."""
        held = dict(self._shot.names)
        for name in self._shot.names:
            if self._shot[name].ndim > 3:
                held |= {f"{name}_{axis}": None for axis in AXES}
        if "velocity" in held or "vorticity" in held:
            held |= dict.fromkeys(CRITERIA)
        return held

    @property
    def across(self) -> str:
        """The axis that the plane lies across."""
        return AXES[self._axis]

    @property
    def labels(self) -> tuple[str, str]:
        """The axes in the plane."""
        left = AXES.replace(self.across, "")
        return left[0], left[1]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A scalar in the plane."""
        field = np.moveaxis(scalar(self._shot, name), self._axis, 0)
        low = field[self._low]
        if self._part < 1e-9:
            return np.ascontiguousarray(low)
        high = field[(self._low + 1) % len(field)]
        return np.ascontiguousarray((1 - self._part) * low + self._part * high)


def plane_of(text: str) -> tuple[int, float]:
    """Axis and place of a plane as written: ``z=0.5``."""
    name, _, number = text.replace(" ", "").partition("=")
    try:
        axis, place = tuple(AXES).index(name), float(number)
    except ValueError:
        axis, place = -1, math.nan
    if not math.isfinite(place):
        raise InputError(f"a slice is a plane such as z=0, got {text!r}", hint="--slice z=0")
    return axis, place


def show_slice(
    panel: Axes,
    shot: Shot,
    plane: str,
    field: str | None = None,
    *,
    limit: float | None = None,
    label: str | None = None,
    title: str | None = None,
) -> float:
    """Draw a scalar in a plane, such as "z=0", to scale, its bar beside it and the bodies on top.

    ``field``: as for `vortices.scalar`, by default the vorticity across the plane. ``limit``: where
    colours saturate, the largest value if None; "" as ``label`` draws no bar. Returns the limit.
    """
    from pmesh.cases.style import show_field

    cut = Plane(shot, *plane_of(plane))
    signed = field is None
    field = f"vorticity_{cut.across}" if field is None else field
    values = cut[field]
    top = float(np.abs(values).max()) or 1.0 if limit is None else limit
    colours = "RdBu_r" if signed or values.min() < 0 else "viridis"
    bar = None if label == "" else label or field
    show_field(panel, values, cut.grid, limit=top, colours=colours, label=bar)
    chi = np.asarray(cut[INDICATOR], np.float64) if INDICATOR in shot.names else None
    draw_bodies(panel, cut.grid, chi=chi)
    panel.set(xlabel=f"${cut.labels[0]}$", ylabel=f"${cut.labels[1]}$")
    place = cut.place if abs(cut.place) > 1e-9 * cut.grid.spacing else 0.0
    panel.set_title(f"${cut.across}$ = {place:.4g}" if title is None else title)
    return top
