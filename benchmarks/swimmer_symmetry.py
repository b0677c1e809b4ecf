"""Whether a swimmer cares which way it is turned: mirrored, and turned by 30 and 90 degrees.

Prints how far the centre of mass is from where the swimmer of the case puts it, in parts of the way
gone, and the same for the angle in radians; ends with an error if a place is off by 1 % or more.
About 4 minutes on one core at the defaults.
"""

import argparse
import math
import sys

import numpy as np

from pmesh.cases.swimmer import SwimmerCase

ALLOWED = 0.01
options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--nodes", type=int, default=112, help="per body length")
options.add_argument("--until", type=float, default=2.0, help="periods")
args = options.parse_args()
times = np.arange(0.1, args.until + 1e-9, 0.1)


def way(**turned):
    """Place and angle (times, 3) of a swimmer."""
    flow, state = SwimmerCase(nodes=args.nodes, until=args.until, **turned).build()
    rows = []
    for time in times:
        while state.time < time - 1e-12:
            rest = time - state.time
            dt = min(flow.limit(state).dt, rest)
            state = flow.step(state, rest if dt > 0.9 * rest else min(dt, 0.5 * rest))
        pose = state.poses[0]
        rows.append((*pose.center, pose.angle[0] - flow.bodies[0].heading))
    return np.array(rows)


known = way()
gone = np.cumsum(np.hypot(*np.diff(known[:, :2], axis=0, prepend=0.0).T))
worst = 0.0
for name, turned in (
    ("mirrored", {"mirrored": True}),
    ("turned by 30 degrees", {"heading": 30.0}),
    ("turned by 90 degrees", {"heading": 90.0}),
):
    found = way(**turned)
    angle = -math.radians(turned.get("heading", 0.0))
    c, s = math.cos(angle), math.sin(angle)
    found[:, :2] = found[:, :2] @ np.array([[c, s], [-s, c]])
    if "mirrored" in turned:
        found[:, 1:] *= -1
    off = np.hypot(*(found - known)[:, :2].T)
    yaw = np.abs(found[:, 2] - known[:, 2])
    print(
        f"{name}: place off by {100 * off[-1] / gone[-1]:.3f} % of the way at t = {times[-1]:g}, "
        f"angle by {yaw[-1]:.1e} (largest {yaw.max():.1e})",
        flush=True,
    )
    worst = max(worst, off[-1] / gone[-1])
sys.exit(0 if worst < ALLOWED else f"off by {100 * worst:.2f} %, allowed {100 * ALLOWED:g} %")
