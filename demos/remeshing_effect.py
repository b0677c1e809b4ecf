"""A vortex draws a disk out and back; in between particles overlap only if remeshed: 5 s.

Without remeshing the particles come back exactly, but at half time, where they have lost their
overlap, what a mollifier rebuilds of them is full of holes. Velocity: LeVeque, SIAM J. Numer. Anal.
33 (1996) 627; overlap: Cottet & Koumoutsakos (2000), section 2.3.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

import pmesh
import remesh
from levelset.laws import SingleVortex
from levelset.profile import LEVEL, profile
from levelset.shapes import Disk
from levelset.transport import ParticleLevelSet
from pmesh.cases.style import OURS, REFERENCE, panels, styled
from remesh.mollifier import mollify

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh")
options.add_argument("--out", type=Path, default=Path("out/remeshing_effect_demo"))
args = options.parse_args()

CELLS = 64 if args.quick else 128  # along the unit box
PERIOD = 4.0  # [T]: there and back
RADIUS = 1.2 / CELLS  # of the mollifier [L]

disk = Disk(0.15, center=(0.5, 0.75))
grid = remesh.Grid((CELLS + 1,) * 2, 1 / CELLS)
fine = remesh.Grid((4 * CELLS + 1,) * 2, 0.25 / CELLS)
remeshed = ParticleLevelSet(
    grid=grid, velocity=SingleVortex(period=PERIOD), kernel="L6,4", width=4.0, remeshing="distorted"
)
never = replace(remeshed, remeshing="never")
level = LEVEL * never.reach  # of the profile far outside
points = grid.points().reshape(2, -1).T


def filled(nodal):
    """Particles on all nodes that are not far outside: positions and values."""
    kept = np.flatnonzero(nodal < 0.9999 * level)
    return {"nodes": kept, "positions": points[kept], "values": nodal[kept]}


def rebuilt(particles):
    """The mollified sum of what particles differ by from the level outside."""
    change, where = particles["values"] - level, fine.points().reshape(2, -1).T
    found = mollify(particles["positions"], change, grid.cell_volume, where, RADIUS, order=4)
    return level + found.reshape(fine.shape)


alone = replace(never.start(disk), **filled(profile(disk.distance(points.T), never.reach)))
kept = remeshed.start(disk)
pictures = {}
for time in (PERIOD / 2, PERIOD):
    alone = pmesh.run(never, alone, until=time, dt=1 / CELLS)
    kept = pmesh.run(remeshed, kept, until=time, dt=1 / CELLS)
    both = (
        {"positions": alone.positions, "values": alone.values},
        filled(remeshed.band(kept).filled(level).ravel()),
    )
    for name, particles in zip(("never remeshed", "remeshed when distorted"), both, strict=True):
        phi = rebuilt(particles)
        area = (phi < 0).sum() * fine.cell_volume / disk.area - 1
        print(f"t = {time:g}, {name:24}: area {100 * area:+.1f} %")
        pictures[time, name] = phi


@styled
def draw():
    figure, axes = panels(1, 4, (12.0, 3.4), sharex=True, sharey=True)
    for panel, ((time, name), phi) in zip(axes[0], pictures.items(), strict=True):
        panel.contourf(*fine.axes(), phi.T, levels=[-1e9, 0.0], colors=[OURS], alpha=0.8)
        if time == PERIOD:
            turn = np.linspace(0, 2 * np.pi, 200)
            panel.plot(0.5 + 0.15 * np.cos(turn), 0.75 + 0.15 * np.sin(turn), color=REFERENCE)
        panel.set(title=f"$t$ = {time:g}, {name}", xlim=(0, 1), ylim=(0, 1))
        panel.set_aspect("equal")
        panel.grid(False)
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "overlap.png", dpi=200)
