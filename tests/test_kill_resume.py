from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "benchmarks/kill_resume.py"
TOY = f"{Path(__file__).with_name('toy.py')}:ToyCase"


@pytest.mark.parametrize(
    ("case", "trials", "options"),
    [
        (TOY, 3, ["--nodes", "8", "--until", "3", "--pause", "0.01", "--grows", "1"]),
        ("elliptic-vortex", 2, ["--quick", "--until", "0.5"]),
    ],
)
def test_a_run_killed_at_random_moments_and_resumed_is_the_unbroken_run(
    tmp_path: Path, case: str, trials: int, options: list[str]
) -> None:
    words = [case, "--trials", str(trials), "--seed", "1", "--out", str(tmp_path / "k"), *options]
    done = subprocess.run(
        [sys.executable, str(SCRIPT), *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{trials} of {trials} identical" in done.stdout
