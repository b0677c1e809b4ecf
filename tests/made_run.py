"""A run directory made by hand: a disk in a stream, with forces and fields that are known."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from pmesh.run.rundir import CASE, SERIES, SNAPSHOTS, SUMMARY
from pmesh.run.series import SeriesFile
from pmesh.run.snapshots import Snapshot, write_snapshot
from pmesh.run.summary import Cost, Metric, write_summary
from remesh.grid import Grid

PERIOD = 2.0
CASE_TEXT = """case = "cylinder"
version = "0.0"
commit = "0123abc"

[parameters]
until = 20.0
reynolds = 550.0
"""


def force(time: float) -> tuple[float, float]:
    """Drag and lift at a time."""
    phase = 2 * math.pi * time / PERIOD
    return 1.3 + 0.02 * math.cos(2 * phase), 0.4 * math.sin(phase)


def shot(path: Path, time: float, *, x: float = 0.0, bodies: bool = True) -> Snapshot:
    """A stream of speed 2 along x, a disk of radius 0.5 at (x, 0), and vorticity behind it."""
    grid = Grid((48 + 2 * round(time), 32), 0.125, (-2.0, -2.0))
    px, py = grid.points()
    away = np.hypot(px - x, py)
    fields: dict[str, Any] = {
        "vorticity": -3.0 * py * np.exp(-((px - x - 1.5) ** 2) - py**2),
        "velocity": np.stack([np.full(grid.shape, 2.0), np.zeros(grid.shape)]),
    }
    if bodies:
        edge = np.clip((away - 0.45) / 0.15, -1, 1)
        fields["chi"] = 0.5 * (1 - edge - np.sin(np.pi * edge) / np.pi)
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_snapshot(path, grid, fields, round(10 * time), time)


def make(folder: Path, *, moving: bool = False, bodies: bool = True, done: bool = True) -> Path:
    """The files of a run; the disk moves at speed 0.5 if asked."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / CASE).write_text(CASE_TEXT)
    series = SeriesFile(folder / SERIES)
    names = ("body0_force_x", "body0_force_y", "body0_power", "circulation")
    for step in range(401):
        time = 0.05 * step
        values = (*force(time), 1e-15 * step, 0.1 * time) if step else (math.nan,) * 3 + (0.0,)
        row = dict(zip(names, values, strict=True))
        if not bodies:
            row = {"circulation": row["circulation"]}
        dt = 0.05 if step else 0.0
        series.append({"step": step, "time": time, "dt": dt, "rule": "deformation", **row})
    series.close()
    for time in (0.0, 1.0, 2.0, 3.0):
        x = 0.5 * time if moving else 0.0
        shot(folder / SNAPSHOTS / f"{round(10 * time):08d}.vtkhdf", time, x=x, bodies=bodies)
    if done:
        metrics = [
            Metric("mean drag", 1.3, 1.31, 0.01, "B", "Somebody <1999> & others"),
            Metric("far off", 2.0, 1.0, 0.1, "C"),
            Metric("only told", 3.0, kind="report"),
        ]
        write_summary(
            folder / SUMMARY, "cylinder", metrics, Cost(steps=400, seconds=2.0, node_steps=10**6)
        )
    return folder
