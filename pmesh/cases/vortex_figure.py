"""The figure of a flow in space: lit surfaces of its vortices, and two cuts through them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pmesh.cases.slices import AXES, show_slice
from pmesh.cases.style import styled
from pmesh.cases.vortices import Look, scalar, show_isosurface
from pmesh.cases.wake import Shot

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def vortex_figure(shot: Shot, *, pixels: int = 1100) -> tuple[Figure, Look]:
    """Surfaces of its vortices in the colours of the velocity, if held, and cuts across y and z.

    The cuts show the vorticity across them and pass the nodes nearest to its middle; also returns
    what the surfaces are, ``pixels`` wide. Refuses a snapshot without vorticity.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.2, 4.9), layout="constrained")
    panels = figure.add_gridspec(2, 2, width_ratios=(1.35, 1))
    wide = figure.add_subplot(panels[:, 0])
    speed = "velocity" if "velocity" in shot.names else None
    look = show_isosurface(
        wide,
        shot,
        colour_by=speed,
        size=(pixels, round(0.86 * pixels)),
        label="speed",
    )
    wide.set_title(f"{look.field} = {look.levels[0]:.3g}, $t$ = {shot.time:.4g}")
    size = scalar(shot, "vorticity").astype(np.float64) ** 2
    for row, axis in enumerate((1, 2)):
        others = tuple(k for k in range(3) if k != axis)
        part = size.sum(axis=others)
        middle = round(float(np.arange(part.size) @ part / part.sum()))
        place = shot.grid.axes()[axis][middle]
        name = AXES[axis]
        show_slice(figure.add_subplot(panels[row, 1]), shot, f"{name}={place:.17g}")
    return figure, look
