"""Two vortex rings leapfrog: the rear one shrinks, slips through and leads, 8 minutes.

Paths of the cores beside thin-ring theory: Borisov, Kilin & Mamaev (2013).
"""

import argparse
from pathlib import Path

from pmesh.cases.leapfrog import LeapfrogCase
from pmesh.cases.runner import run_case

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="a coarse mesh and a short run")
options.add_argument("--out", type=Path, default=Path("out/leapfrog_demo"))
args = options.parse_args()

# both rings have radius 1 [L] and circulation 1 [L^2/T]
COARSE = {"core": 0.25, "spacing": 0.1, "gap": 1.0, "until": 0.15, "pictures": 1}
FINE = {"core": 0.15, "spacing": 0.05, "gap": 0.7, "until": 2.4, "pictures": 4}
case = LeapfrogCase(**(COARSE if args.quick else FINE), projection=5, dtype="float32")

report = run_case("leapfrog", case, args.out, overwrite=True)  # leaves figure.png
for metric in report.metrics:
    known = "" if metric.reference is None else f", known {metric.reference:.4g}"
    print(f"{metric.name}: {metric.value:.4g}{known}")
