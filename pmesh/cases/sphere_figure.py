"""The figure of a sphere in a stream: its drag, its first drag or side forces, and its vortices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pmesh.cases.case import Outcome
from pmesh.cases.slices import show_slice
from pmesh.cases.sphere_laws import published, stokes_drag
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, styled
from pmesh.cases.vortices import NothingToShowError, looked, scalar, show_isosurface

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmesh.cases.sphere import SphereCase
    from pmesh.run.snapshots import Snapshot

FEWEST = 5  # steps in that time from which it is compared with the law
EARLY = 0.3  # T up to which the first drag is shown
VIEW = (-50.0, 20.0)  # of the camera [degrees]


@styled
def sphere_figure(case: SphereCase, outcome: Outcome) -> Figure:
    """Drag over time, first drag or side forces, vortices by lambda-2, vorticity on z = 0."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 6.6), layout="constrained")
    top, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 1.05)).ravel()
    left, right = top.subplots(1, 2)
    _draw_drag(left, case, outcome)
    if case.sheds and case.until > 2:
        _draw_sides(right, case, outcome)
    else:
        _draw_first(right, case, outcome)
    wide, cut = below.subplots(1, 2)
    _draw_vortices(wide, case, outcome)
    _draw_cut(cut, case, outcome)
    name_panels([left, right, wide, cut])
    figure.suptitle(
        f"{case.title}, Re = {case.reynolds:g}: {case.nodes} nodes per diameter, "
        f"window {case.behind:g} D behind",
        fontsize=11,
    )
    return figure


def _draw_drag(panel: Axes, case: SphereCase, outcome: Outcome) -> None:
    """The drag by both routes, beside the first law and the published mean."""
    drag = case.drag(outcome)
    early = np.geomspace(0.005, min(1.0, case.until), 100)
    law = stokes_drag(case.reynolds, early, early)
    panel.plot(early, law, color=REFERENCE, lw=1.2, ls=":", label="unsteady Stokes flow, exact")
    panel.plot(drag.time, drag.momentum, color=OURS, label="ours, penalisation momentum")
    panel.plot(drag.time, drag.impulse, color=OTHERS[0], lw=1.0, ls="--",
               label="ours, vorticity impulse")  # fmt: skip
    if known := published(case.reynolds).get("drag"):
        panel.axhline(known.value, color=REFERENCE, lw=1.2, ls="--",
                      label=f"{known.value:g}, {known.source}")  # fmt: skip
    late = drag.momentum[drag.time > 0.1 * case.until]
    top = 2.2 * float(late.max()) if late.size else 5.0
    panel.set(xlim=(0, case.until), ylim=(0, top), xlabel="$T = U t / D$", ylabel="$C_D$")
    panel.set_title("drag coefficient")
    panel.legend(loc="upper right")


def _draw_first(panel: Axes, case: SphereCase, outcome: Outcome) -> None:
    """The drag of the start over the exact law, without its steady part."""
    from matplotlib.ticker import NullLocator

    from pmesh.cases.sphere import STEPS

    drag = case.drag(outcome)
    shown = (drag.time <= EARLY) & (np.arange(drag.end.size) >= STEPS)
    times = np.geomspace(0.01, EARLY, 100)
    panel.loglog(times, stokes_drag(case.reynolds, times, times), color=REFERENCE, lw=1.2, ls=":",
                 label="unsteady Stokes flow, exact")  # fmt: skip
    panel.loglog(drag.time[shown], drag.momentum[shown], "o", ms=3.5, color=OURS,
                 label="ours, means over steps")  # fmt: skip
    judged = case.early(drag)
    panel.set_title("first drag")
    if judged.any():
        panel.set_title("first drag; grey: where it is compared")
        panel.axvspan(drag.begin[judged][0], drag.end[judged][-1], color="#ededed", zorder=0)
    panel.set(xlabel="$T$", ylabel="$C_D$", xlim=(0.01, EARLY))
    panel.set_xticks([0.01, 0.02, 0.05, 0.1, 0.2, 0.3])
    panel.set_yticks([1, 1.5, 2, 3, 4, 6])
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    panel.legend(loc="lower left")
    if shown.sum() < FEWEST:
        panel.set_title("first drag: too few steps to compare")


def _draw_sides(panel: Axes, case: SphereCase, outcome: Outcome) -> None:
    """Side forces over time, and the published mean."""
    from pmesh.cases.sphere import FORCE

    series = outcome.series
    time = np.asarray(series["time"])[1:] - 0.5 * np.asarray(series["dt"])[1:]
    y, z = (FORCE * np.asarray(series[f"body0_force_{axis}"])[1:] for axis in "yz")
    panel.plot(time, y, color=OURS, label="$C_y$")
    panel.plot(time, z, color=OTHERS[0], lw=1.0, label="$C_z$")
    known = published(case.reynolds).get("lift")
    if known:
        side = float(np.sign(y[time > 0.5 * case.until].mean())) or 1.0
        panel.axhline(side * known.value, color=REFERENCE, lw=1.2, ls="--",
                      label=f"mean, {known.source}")  # fmt: skip
    late = np.abs(y[time > 0.1 * case.until])
    top = 1.6 * max(float(late.max()) if late.size else 0.0, known.value if known else 0.01)
    panel.set(xlim=(0, case.until), ylim=(-top, top), xlabel="$T = U t / D$")
    panel.set_title("side forces")
    panel.legend(loc="upper right", ncols=3)


def _draw_vortices(panel: Axes, case: SphereCase, outcome: Outcome) -> None:
    """Surfaces of lambda-2, in the colours of the streamwise vorticity, of the speed if round."""
    shot = outcome.snapshots()[-1]
    name, label = ("vorticity_x", r"$\omega_x D/U$") if case.impulse else ("velocity", "speed / U")
    field, told = "lambda2", r"$\lambda_2 D^2/U^2$"
    levels = None if case.impulse else _ring(shot)
    try:
        looked([shot], field)
    except NothingToShowError:  # at first there are layers, and no vortex
        field, told, levels = "vorticity", r"$|\omega| D/U$", None
    look = show_isosurface(panel, shot, field, levels=levels, colour_by=name, view=VIEW,
                           size=(1300, 850), label=label)  # fmt: skip
    shown = f" = {look.levels[0]:.3g}" if look.levels else ""
    panel.set_title(f"{told}{shown}, $T$ = {shot.time:.4g}")


def _ring(shot: Snapshot) -> tuple[float] | None:
    """Lambda-2 around the ring behind a sphere in a steady wake; None while there is none."""
    x, y, z = shot.grid.points()
    behind = (x > 0.5) & (x**2 + y**2 + z**2 > 0.4) & (y**2 + z**2 < 0.25)
    lowest = float(scalar(shot, "lambda2")[behind].min())
    return (float(f"{0.75 * lowest:.2g}"),) if lowest < -0.05 else None


def _draw_cut(panel: Axes, case: SphereCase, outcome: Outcome) -> None:
    """Vorticity across the plane z = 0."""
    shot = outcome.snapshots()[-1]
    limit = 0.6 * case.reynolds**0.5
    show_slice(panel, shot, "z=0", limit=limit, label=r"$\omega_z D/U$",
               title=f"vorticity on $z$ = 0, $T$ = {shot.time:.4g}")  # fmt: skip
    panel.set(xlim=(-case.ahead, min(case.behind, 1.5 + case.until)),
              ylim=(-case.beside, case.beside))  # fmt: skip
