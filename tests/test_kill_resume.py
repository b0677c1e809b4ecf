from __future__ import annotations

import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parents[1] / "benchmarks/kill_resume.py"
TOY = f"{Path(__file__).with_name('toy.py')}:ToyCase"


def test_a_run_killed_at_random_moments_and_resumed_is_the_unbroken_run(tmp_path: Path) -> None:
    trials = ["--trials", "3", "--seed", "1", "--out", str(tmp_path / "k")]
    options = ["--nodes", "8", "--until", "3", "--pause", "0.01", "--grows", "1"]
    done = subprocess.run(
        [sys.executable, str(SCRIPT), TOY, *trials, *options], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 of 3 identical" in done.stdout
