"""Two vortex rings lean towards each other and reconnect, Re = 400, 2 minutes.

The arrangement of Kida, Takaoka & Hussain (1991): lines of the inner arcs are exchanged across
the plane between the rings. What the inner arcs lose is found there, for no line ends in a fluid.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, styled
from pmesh.cases.vortices import show_isosurface
from pmesh.run.series import read_series
from pmesh.run.snapshots import read_snapshots
from pmesh.vortex.exact import oblique

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a short run")
options.add_argument("--out", type=Path, default=Path("out/oblique_rings"))
args = options.parse_args()

REYNOLDS = 400.0  # circulation over viscosity; radius [L] and circulation [L^2/T] are 1
SPACING = 0.1
UNTIL = 0.3 if args.quick else 12.0

half = 8 * np.array([5, 4, 3])  # nodes from the middle to the sides; the mesh goes along
grid = remesh.Grid(tuple(2 * half), SPACING, tuple((0.5 - half) * SPACING))
rings = oblique(distance=2.8, angle=np.pi / 6, core=0.3)
flow = pmesh.VortexFlow(
    grid=grid, viscosity=1 / REYNOLDS, domain="follow", negligible=1e-4, kernel="M8'",
    projection=1, dtype="float32",
)  # fmt: skip


def middle(field, axis, n):
    """Values between nodes n - 1 and n along an axis, right for cubics."""
    a, b, c, d = np.moveaxis(field, axis, 0)[n - 2 : n + 2]
    return (9 * (b + c) - (a + d)) / 16


def arcs(moment):
    """Circulation of an outer and an inner arc, and of what crosses x = 0 on one side."""
    (across, along, _), mesh = moment.state.vorticity, moment.state.grid
    x, y, _ = mesh.axes()
    i, j, cell = np.searchsorted(x, 0.0), np.searchsorted(y, 0.0), mesh.spacing**2
    left = middle(along[:i], 1, j)  # w_y on y = 0, x < 0
    between = middle(across[:, :j], 0, i)  # w_x on x = 0, y < 0
    return {
        "outer": -cell * left[left < 0].sum(),
        "inner": cell * left[left > 0].sum(),
        "exchanged": cell * abs(between.sum()),
    }


watch = [arcs, pmesh.Ledger(), pmesh.Progress(), pmesh.Snapshots(every=UNTIL / 3, dtype="float32")]
start = flow.start(vorticity=rings.vorticity)
pmesh.run(flow, start, until=UNTIL, watch=watch, out=args.out, overwrite=True)

series = read_series(args.out / "series.csv")
gap = series["outer"] - series["inner"] - series["exchanged"]
print(f"exchanged: {series['exchanged'][-1] / series['outer'][0]:.0%} of the circulation")
print(f"outer less inner less exchanged: {np.abs(gap).max():.1e} at most, 0 exact")


@styled
def draw():
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 6.6), layout="constrained")
    places = figure.add_gridspec(2, 3, height_ratios=(1.25, 1))
    for column, shot in enumerate(read_snapshots(args.out)[-3:]):
        panel = figure.add_subplot(places[0, column])
        show_isosurface(panel, shot, "vorticity", colour_by="vorticity_x", label="")
        panel.set_title(f"$|\\omega|$ in the colours of $\\omega_x$, $t$ = {shot.time:g}")
    panel = figure.add_subplot(places[1, :])
    for name, colour in (("outer", REFERENCE), ("inner", OURS), ("exchanged", OTHERS[0])):
        panel.plot(series["time"], series[name], color=colour, label=name)
    panel.plot(
        series["time"], series["inner"] + series["exchanged"], "k:", label="inner + exchanged"
    )
    panel.set(title="Circulation of the arcs", xlabel="time $t$", ylabel=r"$\Gamma$", ylim=(0, 1.1))
    panel.legend(ncols=4)
    return figure


draw().savefig(args.out / "oblique_rings.png", dpi=150)
