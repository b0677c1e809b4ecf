"""Two vortex rings collide head-on and stretch each other at Re = 1000, 5 minutes.

The start of what Lim & Nickels (1992) photographed; the radius beside thin-ring theory.
"""

import argparse
from pathlib import Path

from pmesh.cases.ring_collision import RingCollision
from pmesh.cases.runner import run_case

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/ring_collision_demo"))
args = options.parse_args()

# both rings have radius 1 [L] and circulation 1 [L^2/T]
COARSE = {"core": 0.25, "spacing": 0.1, "gap": 1.25, "until": 0.2, "pictures": 1}
FINE = {"core": 0.25, "spacing": 1 / 12, "gap": 1.5, "until": 6.0, "pictures": 4}
case = RingCollision(**(COARSE if args.quick else FINE), waves=(6,), amplitude=0.02)

report = run_case("ring-collision", case, args.out, overwrite=True)  # leaves figure.png
for metric in report.metrics:
    known = "" if metric.reference is None else f", known {metric.reference:.4g}"
    print(f"{metric.name}: {metric.value:.4g}{known}")
