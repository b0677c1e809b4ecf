"""How long the first answers take: import, help, the list of cases, the first step of a run.

    python benchmarks/startup.py [--check] [--repeats 5]

Each line is a median of processes started afresh, with compiled kernels cached by one run before.
``--check`` exits with 1 where a limit is passed. Takes about half a minute.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

PYTHON = sys.executable
PMESH = [PYTHON, "-m", "pmesh"]


def whole(*words: str) -> Callable[[], float]:
    """Seconds from a command to its end."""

    def work() -> float:
        start = time.perf_counter()
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        return time.perf_counter() - start

    return work


def first_step(*options: str) -> Callable[[], float]:
    """Seconds from ``pmesh run cylinder`` until step 1 stands in its series.csv."""

    def work() -> float:
        with tempfile.TemporaryDirectory() as folder:
            series = Path(folder) / "run" / "series.csv"
            words = [*PMESH, "run", "cylinder", *options, "--out", str(series.parent)]
            start = time.perf_counter()
            process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
            try:
                while not (series.exists() and "\n1," in series.read_text()):
                    if process.poll() is not None:
                        raise SystemExit(process.communicate()[1].decode())
                    time.sleep(0.005)
                return time.perf_counter() - start
            finally:
                process.kill()
                process.communicate()

    return work


ROWS = {  # what: how to measure it, and its limit [s]
    "python -c pass": (whole(PYTHON, "-c", "pass"), None),
    "import pmesh": (whole(PYTHON, "-c", "import pmesh"), 0.4),
    "pmesh --help": (whole(*PMESH, "--help"), 0.5),
    "pmesh cases": (whole(*PMESH, "cases"), 0.5),
    "pmesh run cylinder --help": (whole(*PMESH, "run", "cylinder", "--help"), None),
    "first step of pmesh run cylinder": (first_step(), 3.0),
}


def main() -> None:
    parser = argparse.ArgumentParser(description="time the first answers")
    parser.add_argument("--check", action="store_true", help="fail where a limit is passed")
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    first_step()()  # compiles what is not cached yet
    late = []
    print(
        f"{'seconds, median of ' + str(options.repeats):34} {'median':>7} {'worst':>7} {'limit':>7}"
    )
    for name, (work, limit) in ROWS.items():
        times = [work() for _ in range(options.repeats)]
        middle = statistics.median(times)
        allowed = f"{limit:7.1f}" if limit else " " * 7
        print(f"{name:34} {middle:7.2f} {max(times):7.2f} {allowed}", flush=True)
        if limit and middle > limit:
            late.append(name)
    if options.check and late:
        raise SystemExit(f"too slow: {', '.join(late)}")


if __name__ == "__main__":
    main()
