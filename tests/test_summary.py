from __future__ import annotations

import io
import json
import logging
import math
from pathlib import Path
from time import sleep
from types import SimpleNamespace
from typing import Any

import pytest
from toy import Decay

from pmesh.run.loop import run
from pmesh.run.progress import Progress, duration
from pmesh.run.protocols import Moment
from pmesh.run.summary import Cost, Metric, peak_memory, show, write_summary
from remesh.errors import InputError
from remesh.grid import Grid

COST = Cost(steps=10, seconds=2.0, node_steps=4_000_000)


@pytest.mark.parametrize(
    ("metric", "error", "passed"),
    [
        (Metric("a", 1.02, 1.0, 0.05), 0.02, True),
        (Metric("a", -1.02, -1.0, 0.01), -0.02, False),
        (Metric("a", 0.003, 0.0, 0.005, kind="absolute"), 0.003, True),
        (Metric("a", 1.0, kind="report"), None, None),
        (Metric("a", 1.1, 1.0, kind="report"), 0.1, None),
        (Metric("a", math.nan, 1.0, 0.1), math.nan, False),
        (Metric("a", math.inf, 1.0, 0.1), math.inf, False),
    ],
)
def test_a_metric_passes_if_its_error_is_within_its_tolerance(
    metric: Metric, error: float | None, passed: bool | None
) -> None:
    assert metric.error == (error if error is None else pytest.approx(error, nan_ok=True))
    assert metric.passed is passed


def test_a_metric_that_cannot_be_judged_is_refused() -> None:
    with pytest.raises(InputError, match="needs a reference and a tolerance"):
        Metric("a", 1.0)
    with pytest.raises(InputError, match="no relative error"):
        Metric("a", 1.0, 0.0, 0.1)
    with pytest.raises(InputError, match="kind must be"):
        Metric("a", 1.0, 1.0, 0.1, kind="procentual")  # type: ignore[arg-type]


def test_the_summary_has_the_entries_of_the_run_contract_and_is_strict_json(
    tmp_path: Path,
) -> None:
    metrics = [
        Metric("drag", 1.29, 1.287, 0.03, "B", "Koumoutsakos & Leonard (1995)"),
        Metric("broken", math.nan, 1.0, 0.1),
    ]
    write_summary(tmp_path / "summary.json", "cylinder", metrics, COST)

    def never(word: str) -> None:
        raise AssertionError(word)

    found = json.loads((tmp_path / "summary.json").read_text(), parse_constant=never)
    assert list(found) == ["case", "metrics", "cost"]
    assert list(found["metrics"][0]) == [
        *("name", "value", "reference", "error", "tolerance", "pass", "grade", "source")
    ]
    assert found["metrics"][0]["pass"] is True
    assert found["metrics"][1]["value"] is None
    assert found["metrics"][1]["pass"] is False
    cost = found["cost"]
    assert list(cost) == ["steps", "seconds", "particle_steps_per_second", "peak_memory_mb"]
    assert cost["particle_steps_per_second"] == 2_000_000
    assert 10 < cost["peak_memory_mb"] == pytest.approx(peak_memory(), abs=1)


def test_the_closing_table_shows_value_reference_error_and_result() -> None:
    stream = io.StringIO()
    metrics = [
        Metric("peak drag", 1.29, 1.287, 0.03, "B", "K&L [1995]"),
        Metric("slip", 0.2, 0.0, 0.1, kind="absolute"),
        Metric("steps", 12, kind="report"),
        Metric("speed", 0.9, 1.0, 0.02, kind="report"),
    ]
    show("Cylinder", metrics, COST, stream)
    text = stream.getvalue()
    for word in ("peak drag", "1.29", "1.287", "0.233 %", "3 %", "pass", "FAIL", "K&L [1995]"):
        assert word in text
    (speed,) = (line for line in text.splitlines() if " speed " in f" {line} ")
    assert "not judged" in speed
    assert text.count("not judged") == 1
    assert "10 steps in 2.0 s, 2.00 million particle steps per second" in text


def test_progress_off_a_terminal_is_one_log_line_now_and_then(
    caplog: pytest.LogCaptureFixture,
) -> None:
    flow = Decay(grid=Grid((8, 8), 0.1))
    with caplog.at_level(logging.INFO, "pmesh"):
        run(flow, flow.start(), until=1.0, watch=[Progress(stream=io.StringIO())])
    assert len(caplog.messages) == 2
    assert caplog.messages[0] == "from t = 0 to t = 1, 8 x 8 nodes"
    assert "t = 1 / 1  dt = " in caplog.messages[1]
    caplog.clear()
    with caplog.at_level(logging.INFO, "pmesh"):
        run(flow, flow.start(), until=0.2, watch=[Progress(stream=io.StringIO(), seconds=0.0)])
    assert any("(deformation)  0 s left" in line for line in caplog.messages)


def test_progress_says_how_many_nodes_of_a_grid_are_moved(
    caplog: pytest.LogCaptureFixture,
) -> None:
    state = SimpleNamespace(time=0.0, step=0, size=609, grid=Grid((64, 32), 0.1))
    moment = Moment(flow=None, state=state, dt=0.0, rule="start", until=1.0)
    with caplog.at_level(logging.INFO, "pmesh"):
        Progress(stream=io.StringIO()).open(moment)
    assert caplog.messages == ["from t = 0 to t = 1, 609 of 64 x 32 nodes"]


def test_a_first_step_that_compiles_does_not_count_as_the_pace_of_a_run(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Slow(Decay):
        def step(self, state: Any, dt: float) -> Any:
            if state.step == 0:
                sleep(0.3)
            return super().step(state, dt)

    flow = Slow(grid=Grid((8, 8), 0.1))
    watch = [Progress(stream=io.StringIO(), seconds=0.0)]
    with caplog.at_level(logging.INFO, "pmesh"):
        run(flow, flow.start(), until=10.0, watch=watch)
    lines = [line for line in caplog.messages if line.startswith("step ")]
    assert "left" not in lines[1], "step 1 tells nothing"
    assert lines[2].endswith("  0 s left") or lines[2].endswith("  1 s left")


def test_progress_on_a_terminal_is_a_live_line() -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    stream, flow = Terminal(), Decay(grid=Grid((8, 8), 0.1))
    run(flow, flow.start(), until=1.0, watch=[Progress(stream=stream)])
    text = stream.getvalue()
    assert "100%" in text
    assert "t = 1 / 1" in text


def test_durations_are_said_as_people_say_them() -> None:
    assert [duration(s) for s in (41.6, 200, 7500)] == ["42 s", "3 min 20 s", "2 h 5 min"]
