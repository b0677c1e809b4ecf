"""Kill a run at random moments, resume it, and compare with an unbroken run bit for bit.

    python benchmarks/kill_resume.py [CASE] [--trials 20] [--seed 1] [--out DIR] [CASE'S OPTIONS]

Each trial starts the run, ends it with SIGKILL at a random moment, resumes it (every third time it
is killed once more) and compares series.csv, the last state and every snapshot. A line per trial.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from pmesh.cases.registry import find
from pmesh.cases.runner import read_case
from pmesh.run import checkpoint, tree
from pmesh.run.series import read_series
from pmesh.run.snapshots import read_snapshots


def start(case: str, options: list[str], folder: Path, *, resume: bool) -> subprocess.Popen[bytes]:
    """The run as a process of its own, with a checkpoint about every fifth of a second."""
    words = [sys.executable, "-m", "pmesh", "run", case, *options, "--out", str(folder)]
    words += ["--checkpoint-every", "0.2", *(["--resume"] if resume else [])]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def finish(process: subprocess.Popen[bytes]) -> None:
    """Wait for the end of a run, which must be a good one."""
    _, said = process.communicate()
    if process.returncode:
        raise SystemExit(f"the run failed:\n{said.decode()}")


def rows(folder: Path) -> int:
    """Rows of the series so far, half a row counts."""
    path = folder / "series.csv"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def kill(process: subprocess.Popen[bytes], folder: Path, row: int, after: float) -> str:
    """Kill the run so many seconds after a row of its series; say where that was."""
    while process.poll() is None and rows(folder) < row:
        time.sleep(0.0005)
    time.sleep(after)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    if process.returncode == 0:
        return "at its end"
    try:
        return f"after step {read_series(folder)['step'][-1]:.0f}"
    except (OSError, LookupError):
        return "before its first step"


def differences(one: Path, other: Path) -> list[str]:
    """What differs between two runs: the series, the last state, the snapshots, the parameters."""
    name, values = read_case(one / "case.toml")
    like = find(name).make(values).build()[1]
    found = [
        file
        for file in ("series.csv", "case.toml")
        if (one / file).read_bytes() != (other / file).read_bytes()
    ]
    states = [checkpoint.load(folder / "checkpoint.h5", like) for folder in (one, other)]
    if not tree.same(*states):
        found.append("checkpoint.h5")
    shots, others = read_snapshots(one), read_snapshots(other)
    alike = [(s.step, s.time, s.grid) for s in shots] == [(s.step, s.time, s.grid) for s in others]
    if not alike or any(
        ours[field].tobytes() != theirs[field].tobytes()
        for ours, theirs in zip(shots, others, strict=True)
        for field in ours.names
    ):
        found.append("fields")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("case", nargs="?", default="elliptic-vortex")
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/kill_resume"))
    given, options = parser.parse_known_args()
    options = options or ["--quick"]
    moments = random.Random(given.seed)
    shutil.rmtree(given.out, ignore_errors=True)
    whole, broken = given.out / "whole", given.out / "broken"
    finish(start(given.case, options, whole, resume=False))  # compiles what has to be compiled
    cost = json.loads((whole / "summary.json").read_text())["cost"]
    pace = cost["seconds"] / max(1, cost["steps"])
    good = 0
    for trial in range(given.trials):
        shutil.rmtree(broken, ignore_errors=True)
        killed = []
        for attempt in range(2 if trial % 3 == 2 else 1):
            process = start(given.case, options, broken, resume=attempt > 0)
            row, after = moments.randrange(rows(whole)), moments.uniform(0, 3 * pace)
            killed.append(kill(process, broken, row, after))
        finish(start(given.case, options, broken, resume=True))
        found = differences(whole, broken)
        good += not found
        print(f"{trial + 1:3} killed {', then '.join(killed)}: {', '.join(found) or 'identical'}")
    print(f"{good} of {given.trials} identical to the unbroken run ({given.case})")
    return 0 if good == given.trials else 1


if __name__ == "__main__":
    sys.exit(main())
