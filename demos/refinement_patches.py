"""Patches of finer particles follow a spot: a fine mesh's error on a third of its nodes, 5 s.

Three levels share the field smoothly; each remeshes its own particles. What leaves a patch is
remeshed on the coarser level, what enters it is interpolated: sum and moments of the kernel stay.
The multilevel route of Bergdorf, Cottet & Koumoutsakos, Multiscale Model. Simul. 4 (2005) 328.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle

import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, panels, show_field, styled

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and few steps")
options.add_argument("--out", type=Path, default=Path("out/refinement_patches"))
args = options.parse_args()

CELLS, STEPS = (48, 8) if args.quick else (80, 40)  # of the coarsest mesh; until the end
LEVELS, UNTIL = 3, 0.2 if args.quick else 1.0  # each twice as fine as the one before; [T]
KERNEL, RAMP = "L4,2", 8  # coarse cells over which two levels share the field
WIDTH, FAINT = 0.025, 1e-4  # of the spot [L], and what a patch may leave out


def turned(positions, time):
    """Where a vortex takes positions (n, 2): the slower, the farther out."""
    x, y = positions.T - 0.5
    angle = 2 * np.pi * time * np.maximum(1 - 4 * (x**2 + y**2), 0)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y], axis=1)


def spot(positions, time):
    x, y = turned(positions, -time).T
    return np.exp(-((x - 0.5) ** 2 + (y - 0.72) ** 2) / WIDTH**2)


def nodes(grid):
    return grid.points().reshape(2, -1).T


def patch(grid, positions):
    """A mesh twice as fine around positions; its ends lie on nodes of the coarser mesh."""
    index = np.rint((positions - grid.origin) / grid.spacing).astype(int)
    low = np.maximum(index.min(axis=0) - RAMP - 2, 0)
    high = np.minimum(index.max(axis=0) + RAMP + 2, np.array(grid.shape) - 1)
    return remesh.Grid(2 * (high - low) + 1, grid.spacing / 2, grid.origin + low * grid.spacing)


def share(grids, level, positions):
    """The part of the field that goes to a level: 1 inside its patch, 0 at the patch's ends."""
    if level == 0 or level == len(grids):
        return np.full(len(positions), float(level == 0))
    grid = grids[level]
    low = np.array(grid.origin)
    depth = np.minimum(positions - low, low + grid.length - positions).min(axis=1)
    s = np.clip((depth / (2 * grid.spacing) - 2) / RAMP, 0, 1)  # none where kernels reach out
    return s**3 * (10 - 15 * s + 6 * s**2)


def remeshed(particles, grids):
    """Fields on all levels from the particles of all levels: (positions, strengths) each."""
    fields, handed = [], (np.empty((0, 2)), np.empty(0))
    for level in reversed(range(len(grids))):  # what is outside its patch goes to the coarser level
        positions = np.concatenate([particles[level][0], handed[0]])
        strengths = np.concatenate([particles[level][1], handed[1]])
        part = share(grids, level, positions)
        handed = positions[part < 1], ((1 - part) * strengths)[part < 1]
        kept = positions[part > 0], (part * strengths)[part > 0]
        fields.insert(0, remesh.p2m(*kept, grids[level], kernel=KERNEL))
    for level in range(1, len(grids)):  # what is inside a patch goes to the finer level
        coarse, fine = grids[level - 1], grids[level]
        enters = fields[level - 1] * share(grids, level, nodes(coarse)).reshape(coarse.shape)
        there = remesh.m2p(enters, nodes(fine), coarse, kernel=KERNEL)
        fields[level - 1] = fields[level - 1] - enters
        fields[level] = fields[level] + there.reshape(fine.shape)
    return fields


def combined(fields, grids, positions):
    """The field at positions: the sum of what the levels hold there."""
    result = np.zeros(len(positions))
    for field, grid in zip(fields, grids, strict=True):
        low = np.array(grid.origin) - 1e-9
        inside = ((positions > low) & (positions < low + grid.length + 2e-9)).all(axis=1)
        result[inside] += remesh.m2p(field, positions[inside], grid, kernel=KERNEL)
    return result


def carry(cells, levels):
    """The spot on its way: at each step the time, the meshes, their fields, and the error."""
    grids = [remesh.Grid((cells + 1,) * 2, 1 / cells)]
    while len(grids) < levels:
        points = nodes(grids[-1])
        grids.append(patch(grids[-1], points[spot(points, 0) > FAINT]))
    fields = []
    for level, grid in enumerate(grids):
        points = nodes(grid)
        part = share(grids, level, points) * (1 - share(grids, level + 1, points))
        fields.append((part * spot(points, 0)).reshape(grid.shape))
    stages = []
    for step in range(STEPS + 1):
        time = step * UNTIL / STEPS
        if step:
            particles, bright = [], []
            for field, grid in zip(fields, grids, strict=True):
                held = np.abs(field.ravel()) > 1e-15
                moved = turned(nodes(grid)[held], UNTIL / STEPS)
                particles.append((moved, field.ravel()[held] * grid.cell_volume))
                bright.append(moved[np.abs(field.ravel()[held]) > FAINT])
            grids = grids[:1]
            while len(grids) < levels:
                grids.append(patch(grids[-1], np.concatenate(bright)))
            fields = remeshed(particles, grids)
        error = np.abs(combined(fields, grids, SEEN) - spot(SEEN, time)).max()
        stages.append((time, grids, fields, error))
    return stages


def moments(grids, fields):
    """Sum, and first and second moments about the middle."""
    total = np.zeros(4)
    for field, grid in zip(fields, grids, strict=True):
        x, y = grid.points() - 0.5
        laws = np.stack([np.ones_like(x), x, y, x**2 + y**2])
        total += (laws * field).sum(axis=(1, 2)) * grid.cell_volume
    return total


SEEN = nodes(remesh.Grid((4 * CELLS + 1,) * 2, 1 / (4 * CELLS)))  # where errors are measured
finest = CELLS * 2 ** (LEVELS - 1)
runs = {
    "coarse mesh": carry(CELLS, 1),
    "fine mesh": carry(finest, 1),
    "patches": carry(CELLS, LEVELS),
}
sizes = {name: max(sum(grid.size for grid in s[1]) for s in run) for name, run in runs.items()}
for name, run in runs.items():
    first, last = (moments(*stage[1:3]) for stage in (run[0], run[-1]))
    print(f"{name:11}: {sizes[name]:6} nodes, error {run[-1][3]:.2e}, "
          f"sum kept to {abs(last[0] / first[0] - 1):.0e}")  # fmt: skip


@styled
def draw():
    figure, axes = panels(2, 3, (11.0, 7.2))
    shown = [runs["patches"][k] for k in (0, STEPS // 4, STEPS // 2, STEPS)]
    colours = (REFERENCE, OTHERS[0])
    for panel, (time, grids, fields, _) in zip(axes.ravel(), shown, strict=False):
        grid = remesh.Grid((4 * CELLS + 1,) * 2, 1 / (4 * CELLS))
        show_field(panel, combined(fields, grids, SEEN).reshape(grid.shape), grid, limit=1,
                   colours="BuPu", power=0.6)  # fmt: skip
        for finer, colour in zip(grids[1:], colours, strict=True):
            frame = Rectangle(finer.origin, *finer.length, fill=False, ec=colour, lw=1.4)
            panel.add_patch(frame)
        panel.set(title=f"$t$ = {time:g}", xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[])
    for (name, run), colour in zip(runs.items(), (OTHERS[2], REFERENCE, OURS), strict=True):
        times, _, _, errors = zip(*run, strict=True)
        style = {"ls": "--", "lw": 3.0} if name == "fine mesh" else {}
        axes[1, 1].semilogy(times[1:], errors[1:], color=colour, label=name, **style)
        count = [sum(grid.size for grid in stage[1]) for stage in run]
        axes[1, 2].semilogy(times, count, color=colour, label=name, **style)
    axes[1, 1].set(title="largest error", xlabel="$t$")
    axes[1, 1].legend()
    axes[1, 2].set(title="nodes", xlabel="$t$")
    name_panels(axes)
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "patches.png", dpi=150)
