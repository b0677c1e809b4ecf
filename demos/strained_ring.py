"""A vortex ring is strained, stretched and turned by a flow; its impulse beside exp(-A^T t): 40 s.

The linear evolution of a "spherical" ring, solved exactly by Cauchy's formula.
"""

import argparse
from pathlib import Path

import numpy as np

import pmesh
import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, panels, styled
from pmesh.vortex.exact import StrainedRing
from pmesh.vortex.perturbed import PerturbedFlow

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/strained_ring"))
args = options.parse_args()

STRAIN = ((1.0, 0.5, 0.0), (0.5, -0.5, 0.0), (0.0, 0.0, -0.5))  # A of U = A x [1/T]
SPACING = 1 / 3 if args.quick else 1 / 7  # in widths of the ring
UNTIL = 0.2 if args.quick else 1.0  # [T]

ring = StrainedRing(strain=STRAIN, amplitude=(0.6, 0.0, 0.8))
cells = round(4.0 / SPACING)
grid = remesh.Grid((2 * cells,) * 3, SPACING, (-cells * SPACING,) * 3)
flow = PerturbedFlow(
    grid=grid, base=STRAIN, time_scheme="RK3", deformation=0.1, domain="follow", projection=1
)

ledger = pmesh.Ledger()
end = pmesh.run(flow, flow.start(vorticity=ring.vorticity), until=UNTIL, watch=[ledger])

series = ledger.series
ours = np.stack([series[f"impulse_{axis}"] for axis in "xyz"])
exact = np.transpose([ring.impulse(time) for time in series["time"]])
error = np.linalg.norm(ours[:, -1] - exact[:, -1]) / np.linalg.norm(exact[:, -1])
print(f"impulse at t = {end.time:g}: ours {ours[:, -1].round(4)}, exact {exact[:, -1].round(4)}, "
      f"{100 * error:.4f} % apart")  # fmt: skip


@styled
def draw():
    figure, ((panel,),) = panels(1, 1, (5.0, 3.6))
    for axis, colour in zip(range(3), (OURS, *OTHERS), strict=False):
        panel.plot(series["time"], exact[axis], color=REFERENCE)
        panel.plot(series["time"], ours[axis], "o", color=colour, label=f"ours, $I_{'xyz'[axis]}$")
    panel.plot([], [], color=REFERENCE, label=r"exact: $e^{-A^T t} I_0$")
    panel.set(title="impulse of a strained ring", xlabel="time $t$")
    panel.legend()
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "impulse.png", dpi=200)
