"""The figure of a flow in space: lit surfaces of its vortices, and two cuts through them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

from pmesh.cases.slices import Plane, show_slice
from pmesh.cases.style import styled
from pmesh.cases.vortices import LIVE, SKIN, STRONG, Look, scalar, show_isosurface
from pmesh.cases.wake import INDICATOR, Shot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FAINT = 0.02  # of the limit: vorticity below it need not be seen in a cut
BESIDE = 0.1  # of what is seen, shown beside it


@styled
def vortex_figure(shot: Shot, *, pixels: int = 1100) -> tuple[Figure, Look]:
    """Surfaces of its vortices in the colours of the velocity, if held, and cuts across y and z.

    The cuts show the vorticity across them on one scale, that of the flow away from walls, where
    there is any, and pass the nodes nearest to its middle; also returns what the surfaces are,
    ``pixels`` wide. Refuses a snapshot without vorticity.
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
    shown = f" = {look.levels[0]:.3g}" if look.levels else ""
    wide.set_title(f"{look.field}{shown}, $t$ = {shot.time:.4g}")
    cuts = [_middle(shot, axis) for axis in (1, 2)]
    limit = max(_strength(cut) for cut in cuts) or None
    for row, cut in enumerate(cuts):
        panel = figure.add_subplot(panels[row, 1])
        show_slice(panel, shot, f"{cut.across}={cut.place:.17g}", limit=limit)
        _close_up(panel, cut, limit or 0.0)
    return figure, look


def _middle(shot: Shot, axis: int) -> Plane:
    """The plane of nodes nearest to the middle of the squared vorticity along an axis."""
    size = scalar(shot, "vorticity").astype(np.float64) ** 2
    part = size.sum(axis=tuple(k for k in range(3) if k != axis))
    middle = round(float(np.arange(part.size) @ part / part.sum())) if part.any() else 0
    return Plane(shot, axis, float(shot.grid.axes()[axis][middle]))


def _strength(cut: Plane) -> float:
    """Largest vorticity across a plane; past bodies nearly the largest of the wake."""
    size = np.abs(cut[f"vorticity_{cut.across}"])
    chi = cut[INDICATOR] > 0 if INDICATOR in cut.names else np.zeros(size.shape, bool)
    if not chi.any():
        return float(size.max())
    wake = size[~ndimage.binary_dilation(chi, iterations=SKIN)]
    wake = wake[wake > LIVE * wake.max(initial=0.0)]
    return float(np.quantile(wake, STRONG)) if wake.size else float(size.max())


def _close_up(panel: Axes, cut: Plane, limit: float) -> None:
    """Show of a plane what is alive in it, and its bodies; of periodic axes all."""
    alive = cut["vorticity"] > FAINT * limit
    if INDICATOR in cut.names:
        alive |= cut[INDICATOR] > 0
    if not alive.any():
        return
    for axis in (0, 1):
        x = cut.grid.axes()[axis]
        if cut.grid.periodic[axis]:
            continue
        seen = x[np.flatnonzero(alive.any(axis=1 - axis))]
        spare = BESIDE * (seen[-1] - seen[0]) + cut.grid.spacing
        ends = (max(x[0], seen[0] - spare), min(x[-1], seen[-1] + spare))
        panel.set(**{"xlim" if axis == 0 else "ylim": ends})
