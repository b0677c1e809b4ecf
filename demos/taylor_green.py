"""Periodic vortices fade while a free stream carries them; dots ours, line exact: 5 s.

Repeats the decay exp(-8 pi^2 t/Re) of Taylor & Green (1937).
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OURS, REFERENCE, panels, styled
from pmesh.vortex.exact import TaylorGreen

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/taylor_green"))
args = options.parse_args()

REYNOLDS = 100.0  # speed * length / viscosity
NODES = 32 if args.quick else 128  # per period
UNTIL = 0.3 if args.quick else 1.0  # [T]; a vortex turns in about 0.5

exact = TaylorGreen(viscosity=1 / REYNOLDS, drift=(1.0, 0.5))
grid = remesh.Grid(shape=(NODES, NODES), spacing=1 / NODES, boundary="periodic")
flow = pmesh.VortexFlow(grid=grid, viscosity=exact.viscosity, freestream=exact.drift)

history = []  # a watcher is any function of a moment of the run


def watch_energy(moment):
    turning = pmesh.velocity(moment.state.vorticity, grid)  # without the free stream
    history.append((moment.time, 0.5 * np.sum(turning**2) * grid.cell_volume))


end = pmesh.run(flow, flow.start(vorticity=exact.vorticity), until=UNTIL, watch=[watch_energy])

time, energy = np.transpose(history)
law = np.array([exact.energy(t) for t in time])
print(f"energy at t = {end.time:g}: ours {energy[-1]:.6f}, exact {law[-1]:.6f}, "
      f"{100 * (energy[-1] / law[-1] - 1):+.3f} %")  # fmt: skip


@styled
def draw():
    figure, ((panel,),) = panels(1, 1, (5.0, 3.6))
    panel.plot(time, law, color=REFERENCE, label=r"exact: $\frac{1}{4} e^{-16\pi^2 t/Re}$")
    panel.plot(time, energy, "o", color=OURS, label=f"ours, {NODES} nodes per period")
    panel.set(title="Taylor-Green vortices: energy", xlabel="time $t$", ylim=(0, None))
    panel.legend()
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "energy.png", dpi=200)
