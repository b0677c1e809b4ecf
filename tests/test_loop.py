from __future__ import annotations

import importlib
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from toy import Decay, ToyState

from pmesh.run import checkpoint, tree
from pmesh.run.clock import next_step, next_stop
from pmesh.run.loop import run
from pmesh.run.series import read_series
from pmesh.run.snapshots import Snapshots, read_snapshots
from pmesh.run.watchers import Forces, Ledger
from pmesh.vortex.flow import VortexFlow
from remesh.errors import BlowUpError, InputError, StorageError
from remesh.grid import Grid
from remesh.limit import Limit, tightest

SQUARE = Grid((8, 8), 1 / 8)
CUBE = Grid((4, 5, 6), 1 / 4)


def watch() -> list:
    return [Forces(), Ledger(), Snapshots(every=0.1)]


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("grid", [SQUARE, CUBE])
def test_the_run_ends_exactly_at_until_with_the_right_decay(grid: Grid, dtype: str) -> None:
    flow = Decay(grid=grid, dtype=dtype, largest=0.01)
    start = flow.start()
    end = run(flow, start, until=0.7)
    assert end.time == 0.7
    assert end.vorticity.dtype == dtype
    np.testing.assert_allclose(end.vorticity, np.exp(-0.7) * start.vorticity, rtol=2e-5)


def test_the_loop_lands_exactly_on_every_time_of_a_paced_watcher() -> None:
    flow, seen = Decay(grid=SQUARE), []

    class At:
        every = 0.1

        def __call__(self, moment: object) -> None:
            if moment.on(self.every):  # type: ignore[attr-defined]
                seen.append(moment.time)  # type: ignore[attr-defined]

    run(flow, flow.start(), until=1.0, watch=[At()])
    assert seen == [k * 0.1 for k in range(11)]


@given(
    time=st.floats(0, 1e3),
    every=st.lists(st.floats(1e-3, 10), max_size=3),
    ahead=st.floats(1e-3, 1e3),
    dt=st.floats(1e-3, 10),
)
def test_the_next_step_is_within_the_limit_and_arrives_in_equal_steps(
    time: float, every: list[float], ahead: float, dt: float
) -> None:
    until = time + ahead
    stop = next_stop(time, until, every)
    assert time < stop <= until
    step = next_step(time, stop, Limit(dt, "body"))
    assert 0 < step.dt <= dt * (1 + 1e-8)
    assert step.dt >= min(0.5 * dt, stop - time) * (1 - 1e-8)
    assert (stop - time) / step.dt == pytest.approx(round((stop - time) / step.dt))


def test_the_tightest_limit_wins_and_a_limit_that_is_nan_is_never_hidden() -> None:
    assert tightest(Limit(0.2, "body"), Limit(0.1, "deformation")).rule == "deformation"
    assert tightest(Limit(0.1, "a"), Limit(0.1, "b")).rule == "a"
    assert tightest(Limit(0.1, "body"), Limit(float("nan"), "deformation")).rule == "deformation"
    with pytest.raises(InputError, match="got none"):
        tightest()


def test_a_given_dt_is_the_largest_step_and_the_series_names_the_rule(tmp_path: Path) -> None:
    flow = Decay(grid=SQUARE)
    run(flow, flow.start(), until=0.2, dt=0.01, out=tmp_path / "a", watch=[Ledger()])
    series = read_series(tmp_path / "a")
    assert len(series["dt"]) == 21
    assert set(series["rule"][1:-1]) == {"given"}
    np.testing.assert_allclose(series["dt"][1:], 0.01)
    run(flow, flow.start(), until=0.2, out=tmp_path / "b", watch=[Ledger()])
    assert read_series(tmp_path / "b")["rule"][1] == "deformation"


def test_an_infinite_limit_goes_to_the_next_stop_in_one_step() -> None:
    flow = Decay(grid=SQUARE)
    still = replace(flow, rate=0.0)
    object.__setattr__(still, "limit", lambda state: Limit(np.inf, "none"))
    assert run(still, flow.start(), until=5.0).step == 1


@pytest.mark.parametrize("grows", [0, 2])
@pytest.mark.parametrize("stopped", [3, 7])
def test_a_resumed_run_repeats_an_unbroken_one_bit_for_bit(
    tmp_path: Path, stopped: int, grows: int
) -> None:
    flow = Decay(grid=SQUARE, grows=grows)

    def kill(moment: object) -> None:
        if moment.step == stopped:  # type: ignore[attr-defined]
            raise MemoryError

    whole = run(flow, flow.start(), until=1.0, out=tmp_path / "whole", watch=watch())
    with pytest.raises(MemoryError):
        run(flow, flow.start(), until=1.0, out=tmp_path / "cut", watch=[*watch(), kill])
    end = run(flow, flow.start(), until=1.0, out=tmp_path / "cut", watch=watch(), resume=True)
    assert tree.same(whole, end)
    assert tree.same(whole, checkpoint.load(tmp_path / "cut/checkpoint.h5", like=whole))
    rows = [(tmp_path / run_of / "series.csv").read_bytes() for run_of in ("whole", "cut")]
    assert rows[0] == rows[1]
    ours, theirs = read_snapshots(tmp_path / "whole"), read_snapshots(tmp_path / "cut")
    assert [s.time for s in ours] == [s.time for s in theirs] == [k * 0.1 for k in range(11)]
    for one, other in zip(ours, theirs, strict=True):
        assert one.grid == other.grid
        assert all(one[name].tobytes() == other[name].tobytes() for name in one.names)


def test_a_finished_run_can_be_carried_further(tmp_path: Path) -> None:
    flow = Decay(grid=SQUARE)
    run(flow, flow.start(), until=0.5, out=tmp_path, watch=watch())
    end = run(flow, flow.start(), until=1.0, out=tmp_path, watch=watch(), resume=True)
    assert end.time == 1.0
    steps = read_series(tmp_path)["step"]
    assert list(steps) == list(range(end.step + 1))


def test_a_blow_up_names_step_time_dt_rule_and_the_last_good_state(tmp_path: Path) -> None:
    flow = Decay(grid=SQUARE, breaks_at=5)
    with pytest.raises(BlowUpError) as caught:
        run(flow, flow.start(), until=1.0, out=tmp_path / "x", watch=watch())
    assert re.fullmatch(
        r"vorticity is not finite after step 5 \(t = 0\.\d+\); dt = \d\.\d+(e-\d+)? was set by the "
        r"\w+ rule\.\n  Last good state: \S+/x/checkpoint\.h5\.  try: a smaller `deformation`, or "
        r"a finer `spacing`",
        str(caught.value),
    )
    kept = checkpoint.load(tmp_path / "x/checkpoint.h5", like=caught.value.state)
    assert kept.step == 4
    assert tree.same(kept, caught.value.state)
    assert read_series(tmp_path / "x")["step"][-1] == 4


def test_a_blow_up_without_a_directory_keeps_the_last_good_state_in_the_error() -> None:
    flow = Decay(grid=SQUARE, breaks_at=3)
    with pytest.raises(BlowUpError, match="the error's `state`") as caught:
        run(flow, flow.start(), until=1.0)
    assert caught.value.state.step == 2


@pytest.mark.parametrize(
    ("error", "problem", "hint"),
    [
        (InputError("displacement must be finite", hint="look"), "displacement must be .*", "look"),
        (
            OverflowError("too large"),
            r"the numbers broke \(OverflowError: too large\)",
            "a smaller",
        ),
        (MemoryError("Unable to allocate 2 TiB"), r"the memory does not .*2 TiB\)", "a smaller s"),
        (MemoryError(), "the memory is full", "a smaller step, or a mesh of fewer nodes"),
    ],
)
def test_a_step_that_cannot_be_taken_is_a_blow_up_with_its_cause(
    tmp_path: Path, error: Exception, problem: str, hint: str
) -> None:
    flow = Decay(grid=SQUARE)
    step = flow.step

    def break_third(state: ToyState, dt: float) -> ToyState:
        if state.step == 2:
            raise error
        return step(state, dt)

    object.__setattr__(flow, "step", break_third)
    with pytest.raises(BlowUpError) as caught:
        run(flow, flow.start(), until=1.0, out=tmp_path, watch=watch())
    assert re.match(
        rf"{problem} after step 3 \(t = 0\.\d+\); dt = \d\.\d+ was set by the \w+ rule\.\n"
        rf"  Last good state: \S+/checkpoint\.h5\.  try: {hint}",
        str(caught.value),
    )
    assert caught.value.__cause__ is error
    assert checkpoint.load(tmp_path / "checkpoint.h5", like=flow.start()).step == 2


def test_vortices_too_strong_for_their_step_are_a_blow_up() -> None:
    grid = Grid((32, 32), 1 / 16, (-1.0, -1.0))
    x, y = grid.points()
    flow = VortexFlow(grid=grid, domain="fixed", deformation=1e300)
    state = flow.start(vorticity=1e14 * np.exp(-(x**2 + y**2) / 0.02))
    object.__setattr__(flow, "limit", lambda state: Limit(np.inf, "none"))
    with pytest.raises(BlowUpError, match=r"displacement must be finite.*step 1 .*given rule"):
        run(flow, state, until=2.0, dt=1.0)


def test_a_bug_in_a_step_is_not_called_a_blow_up() -> None:
    flow = Decay(grid=SQUARE)
    object.__setattr__(flow, "step", lambda state, dt: state + dt)
    with pytest.raises(TypeError):
        run(flow, flow.start(), until=1.0)


def test_the_first_error_is_the_one_reported(tmp_path: Path, monkeypatch: Any) -> None:
    flow = Decay(grid=SQUARE, breaks_at=2)

    def full(*_: object, **__: object) -> None:
        raise OSError("no space left on device")

    def fill(moment: Any) -> None:
        if moment.step == 1:
            monkeypatch.setattr(checkpoint, "save", full)

    with pytest.raises(BlowUpError, match="vorticity is not finite"):
        run(flow, flow.start(), until=1.0, out=tmp_path, watch=[fill])


def test_a_limit_of_zero_or_nan_ends_the_run_with_its_rule() -> None:
    flow = Decay(grid=SQUARE)
    for dt in (0.0, float("nan"), -1.0):
        object.__setattr__(flow, "limit", lambda state, dt=dt: Limit(dt, "strain"))
        with pytest.raises(BlowUpError, match=r"the time step vanishes after step 0.*strain"):
            run(flow, flow.start(), until=1.0)


def test_ctrl_c_leaves_a_checkpoint_and_says_where(tmp_path: Path) -> None:
    flow = Decay(grid=SQUARE)

    def interrupt(moment: object) -> None:
        if moment.step == 6:  # type: ignore[attr-defined]
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"stopped after step 5 .*checkpoint\.h5 keeps it"):
        run(flow, flow.start(), until=1.0, out=tmp_path, watch=[Ledger(), interrupt])
    assert checkpoint.load(tmp_path / "checkpoint.h5", like=flow.start()).step == 5


def test_what_a_watcher_returns_becomes_columns_and_recorders_keep_theirs(tmp_path: Path) -> None:
    flow, ledger = Decay(grid=SQUARE), Ledger()
    own = lambda moment: {"peak": float(moment.state.vorticity.max())}  # noqa: E731
    run(flow, flow.start(), until=0.3, out=tmp_path, watch=[Forces(), ledger, own])
    series = read_series(tmp_path)
    assert list(series) == ["step", "time", "dt", "rule", "body0_drag", "circulation", "peak"]
    assert series["peak"][0] == flow.start().vorticity.max()
    np.testing.assert_array_equal(ledger.series["circulation"], series["circulation"])


def test_columns_that_come_and_go_are_refused(tmp_path: Path) -> None:
    flow = Decay(grid=SQUARE)
    own = lambda moment: {"late": 1.0} if moment.step else None  # noqa: E731
    with pytest.raises(InputError, match=r"same columns, got \['late'\]"):
        run(flow, flow.start(), until=0.3, out=tmp_path, watch=[own])


def test_strided_arrays_of_a_state_become_what_a_checkpoint_gives_back() -> None:
    wide = np.arange(40.0).reshape(5, 8)
    state = ToyState(0.0, 0, SQUARE, wide[:, ::2])
    settled = tree.settled(state)
    assert settled.vorticity.flags.c_contiguous
    np.testing.assert_array_equal(settled.vorticity, wide[:, ::2])
    assert tree.settled(settled) is settled


def test_a_flow_that_keeps_wrong_time_is_refused() -> None:
    flow = Decay(grid=SQUARE)
    step = flow.step
    object.__setattr__(flow, "step", lambda state, dt: replace(step(state, dt), time=0.0))
    with pytest.raises(InputError, match="must add 1 to the step and dt to the time"):
        run(flow, flow.start(), until=1.0)


def test_a_run_is_not_written_over_another_one_unless_asked(tmp_path: Path) -> None:
    flow = Decay(grid=SQUARE)
    run(flow, flow.start(), until=0.2, out=tmp_path, watch=watch())
    before = (tmp_path / "series.csv").read_bytes()
    with pytest.raises(InputError, match="already holds a run"):
        run(flow, flow.start(), until=0.1, out=tmp_path)
    assert (tmp_path / "series.csv").read_bytes() == before
    (tmp_path / "notes.txt").write_text("mine")
    run(flow, flow.start(), until=0.1, out=tmp_path, overwrite=True)
    assert read_series(tmp_path)["time"][-1] == 0.1
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_run_that_fails_before_its_start_is_written_leaves_nothing(tmp_path: Path) -> None:
    flow = Decay(grid=SQUARE)

    def fail(moment: object) -> None:
        raise StorageError("no")

    with pytest.raises(StorageError):
        run(flow, flow.start(), until=1.0, out=tmp_path / "new", watch=[Ledger(), fail])
    assert not (tmp_path / "new").exists()


def test_the_package_is_the_function() -> None:
    package = importlib.import_module("pmesh.run")
    flow = Decay(grid=SQUARE)
    assert package(flow, flow.start(), until=0.1).time == 0.1
