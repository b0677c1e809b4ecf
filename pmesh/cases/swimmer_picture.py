"""Pictures of a swimmer in space: its body among the vortices it shed, and a cut through both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.slices import Plane
from pmesh.cases.surfaces import Bounds, Layer, render, show_surface
from pmesh.cases.track import Track
from pmesh.cases.vortices import BODY, Look, layers_of, looked, map_of
from pmesh.cases.wake import Shot, colour_limit, draw_vorticity, frame, window
from remesh.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pmesh.bodies.swimmer import Swimmer

Values = NDArray[np.float64]
VIEW = (-62.0, 34.0)  # azimuth and elevation [degrees]
PIXELS = (1300, 800)
AROUND = 48  # points around a section of the body


class Hull(NamedTuple):
    """The surface of a body."""

    vertices: Values  # (n, 3) [L]
    faces: NDArray[np.int64]  # (m, 3)


class Bare:
    """A snapshot without its bodies' indicator: what is drawn of it is the flow alone."""

    def __init__(self, shot: Shot) -> None:
        self.time, self.grid = shot.time, shot.grid
        self.names = {name: kind for name, kind in shot.names.items() if name != "chi"}
        self._shot = shot

    def __getitem__(self, name: str) -> NDArray[np.floating]:
        """A field."""
        return self._shot[name]


def draw_vortices(
    panels: Sequence[Axes], shots: Sequence[Shot], body: Swimmer, track: Track
) -> None:
    """Surfaces of lambda-2 coloured by the vorticity across the plane of its bends, and the body.

    All stages with one level, one scale and one point of view.
    """
    look = _look(shots)
    hulls = [Hull(*body.surface(track.pose(track.row(shot.time)), AROUND)) for shot in shots]
    layers = [
        [Layer(surface=hull, colour=BODY), *([] if look is None else layers_of(Bare(shot), look))]
        for hull, shot in zip(hulls, shots, strict=True)
    ]
    bounds = _bounds(layers, hulls)
    for number, (panel, parts, shot) in enumerate(zip(panels, layers, shots, strict=True)):
        image = render(*parts, view=VIEW, bounds=bounds, size=PIXELS)
        last = look is not None and number == len(shots) - 1
        told = "" if look is None else rf"$\lambda_2$ = {look.levels[0]:.3g}, "
        show_surface(
            panel,
            image,
            title=f"{told}$t$ = {shot.time:.3g}",
            colours="coolwarm" if look is None else map_of(look),
            limits=look.limits if last and look is not None else None,
            label=r"$\omega_z$",
        )


def draw_cut(panel: Axes, shot: Shot, body: Swimmer, track: Track) -> None:
    """Vorticity across the plane in which it bends, and its section there."""
    cut = Plane(shot, 2, float(track.place[track.row(shot.time), 2]))
    limit = colour_limit([cut], "vorticity_z")
    line = body.outline_points(track.pose(track.row(shot.time)))[:, :2]
    draw_vorticity(panel, cut["vorticity_z"], cut.grid, limit, outlines=[line], label=r"$\omega_z$")
    frame(panel, window([cut], "vorticity_z", limit=limit))
    panel.set(xlabel="$x / L$", ylabel="$y / L$")
    panel.set_title(f"vorticity in the plane $z$ = 0, $t$ = {shot.time:.3g}")


def _look(shots: Sequence[Shot]) -> Look | None:
    """What shows the vortices; None in a flow that has none yet."""
    try:
        return looked(shots, "lambda2", colour_by="vorticity_z")
    except InputError:
        return None


def _bounds(layers: Sequence[Sequence[Layer]], hulls: Sequence[Hull]) -> Bounds:
    """Corners of a box around all that is shown."""
    ends = [end for hull in hulls for end in (hull.vertices.min(axis=0), hull.vertices.max(axis=0))]
    for parts in layers:
        for layer in parts[1:]:
            phi, grid = layer.surface  # type: ignore[misc]
            inside = np.argwhere(np.asarray(phi) < 0)
            ends += [np.asarray(grid.origin) + grid.spacing * inside.min(axis=0)]
            ends += [np.asarray(grid.origin) + grid.spacing * inside.max(axis=0)]
    low, high = np.min(ends, axis=0), np.max(ends, axis=0)
    return tuple(low.tolist()), tuple(high.tolist())
