"""Two spots of dye spread along a ring until it is evenly coloured; their sum stays: 20 s.

Any shape will do; the colour in the end is known, the dye over the area.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from levelset.shapes import Torus
from levelset.surface_diffusion import SurfaceDiffusion
from pmesh.cases.style import panels, styled
from pmesh.cases.surfaces import Layer, render, show_surface

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/surface_diffusion"))
args = options.parse_args()

CELLS = 12 if args.quick else 16  # per unit length; the tube's radius is half of one
TIMES = (0.02, 0.1) if args.quick else (0.05, 0.3, 1.5)  # [L^2/D]
shape = Torus(1.0, 0.5)  # radii of the ring and of the tube [L]


def spots(points):
    """Dye at two places, a tall spot and a wide one."""
    ends = np.array([[1.5, 0.0, 0.0], [-0.5, 0.7, 0.45]])
    near = [np.sum((points - end[:, None]) ** 2, axis=0) for end in ends]
    return np.exp(-20 * near[0]) + 0.6 * np.exp(-6 * near[1])


half = np.array([1.5, 1.5, 0.5])
counts = [2 * (round(CELLS * a) + 6) + 1 for a in half]
grid = remesh.Grid(counts, 1 / CELLS, [-(n // 2) / CELLS for n in counts])
flow = SurfaceDiffusion(grid=grid, diffusivity=1.0, stretch=60.0)

states = [flow.start(shape, spots)]
for time in TIMES:
    states.append(pmesh.run(flow, states[-1], until=time))

mean = states[0].mass / shape.surface
for state in states:
    kept = flow.ledger(state)
    print(
        f"t = {state.time:4g}: dye {kept['mass']:.12f}, "
        f"between {kept['lowest']:.4f} and {kept['highest']:.4f}; in the end {mean:.4f}"
    )


@styled
def draw():
    figure, (row,) = panels(1, len(states), (3.4 * len(states), 2.8))
    limits = (0.0, 0.15)
    for panel, state in zip(row, states, strict=True):
        fields = flow.fields(state)
        layer = Layer(surface=(fields["phi"], grid), values=fields["values"], limits=limits)
        picture = render(layer, view=(-50, 35), size=(800, 620))
        bar = limits if state is states[-1] else None
        show_surface(panel, picture, title=f"$t$ = {state.time:g}", limits=bar, label="$c$")
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "surface_diffusion.png", dpi=200)
