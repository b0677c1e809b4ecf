"""What Zalesak's bodies share: options, the turn, and measures of how exact it is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pmesh.cases.zalesak import MOST, PERIOD, in_turns
from pmesh.cases.zalesak_disk import ZalesakDisk
from pmesh.cases.zalesak_sphere import ZalesakSphere
from pmesh.run.loop import run
from pmesh.run.protocols import Moment
from remesh.errors import InputError


@pytest.fixture(scope="module")
def turned():
    """The disk after an eighth of a turn: case, recipe, state."""
    case = ZalesakDisk(until=PERIOD / 8)
    flow, state = case.build()
    return case, flow, run(flow, state, until=case.until)


def test_turns_are_a_word_for_the_end():
    assert ZalesakDisk(turns=2.5).until == 2.5 * PERIOD
    assert ZalesakDisk(turns=2.5) == ZalesakDisk(until=2.5 * PERIOD)
    assert ZalesakDisk().until == PERIOD


@pytest.mark.parametrize("case", [ZalesakDisk, ZalesakSphere])
def test_turns_and_another_end_at_once_are_refused(case):
    with pytest.raises(InputError, match=r"both say when to end, got 100\.0 and"):
        case(until=100.0, turns=2.0)
    with pytest.raises(InputError, match="until and turns both say when to end"):
        case.make({"until": PERIOD, "turns": 2.0})
    assert case.make({"turns": 2.0}, quick=True).until == 2 * PERIOD


def test_a_turn_takes_the_steps_asked_for():
    case = ZalesakDisk(steps=40)
    flow, state = case.build()
    assert flow.limit(state).dt == pytest.approx(PERIOD / 40)
    assert case.law.period == pytest.approx(PERIOD)


def test_the_turn_is_anticlockwise_by_a_quarter_in_a_quarter_of_the_period():
    (place,) = ZalesakDisk().law.flow(np.array([[50.0, 75.0]]), 0.0, PERIOD / 4)
    assert place == pytest.approx([25.0, 50.0])
    (place,) = ZalesakSphere().law.flow(np.array([[50.0, 50.0, 75.0]]), 0.0, PERIOD / 4)
    assert place == pytest.approx([75.0, 50.0, 50.0])  # about y: from z to x


def test_rigid_motion_without_remeshing_is_exact(turned):
    case, _, state = turned
    assert case.path_error(state) < 0.1 * MOST
    assert case.departure(state) < 0.1 * MOST
    assert state.remeshings == 0


def test_the_departure_is_that_of_the_time_integration():
    """RK4: with half the steps sixteen times as far, for particles and interface."""
    away = []
    for steps in (40, 80):
        case = ZalesakDisk(until=PERIOD / 4, steps=steps)
        flow, state = case.build()
        end = run(flow, state, until=case.until)
        away.append((case.path_error(end), case.departure(end)))
    assert math.log2(away[0][0] / away[1][0]) == pytest.approx(4.0, abs=0.2)
    assert math.log2(away[0][1] / away[1][1]) == pytest.approx(4.0, abs=0.2)


def test_the_departure_sees_a_shift_of_the_particles(turned):
    case, _, state = turned
    shifted = replace(state, positions=state.positions + np.array([3e-4, 0.0]))
    assert case.departure(shifted) == pytest.approx(3e-4, rel=0.1)
    assert case.path_error(shifted) == pytest.approx(3e-4, rel=1e-3)


def test_the_mean_error_does_not_change_on_the_way(turned):
    case, _, state = turned
    start = case.mean_error(case.build()[1])
    assert case.mean_error(state) == pytest.approx(start, abs=1e-4)
    assert start < 0.01


def test_the_field_is_turned_back_to_the_start(turned):
    case, _, state = turned
    phi, grid = case.field(state, 2)
    exact = case.shape.distance(grid.points())
    smooth = np.abs(grid.points()[1] - 75.0) < 8.0  # away from the slot's corners
    near = smooth & (np.abs(exact) < 1.0)
    assert np.abs(phi - exact)[near].max() < 0.01


def test_series_hold_the_costly_measures_now_and_then_only(turned):
    case, flow, state = turned
    looked = case.watch(Moment(flow=flow, state=replace(state, step=31), dt=1.0, rule="", until=1))
    passed = case.watch(
        Moment(flow=flow, state=replace(state, step=30, time=30.0), dt=1.0, rule="", until=1)
    )
    assert looked.keys() == passed.keys()
    assert np.isfinite(looked["area"])
    assert np.isnan(passed["area"])
    assert passed["particles"] == state.size


def test_remeshing_on_demand_never_happens_in_rigid_motion():
    case = ZalesakDisk(until=PERIOD / 8, remeshing="distorted", steps=80)
    flow, state = case.build()
    assert run(flow, state, until=case.until).remeshings == 0


def test_remeshing_every_so_many_steps_is_taken_as_a_number():
    case = ZalesakDisk(until=PERIOD / 8, remeshing="5", steps=80)
    flow, state = case.build()
    end = run(flow, state, until=case.until)
    assert end.remeshings == 2
    assert math.isnan(case.path_error(end))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"nodes": 10}, "nodes must be at least 25"),
        ({"steps": 2}, "steps must be at least 8"),
        ({"turns": -1.0}, "turns must be positive"),
        ({"width": 0.0}, "width must be positive"),
        ({"radius": -1.0}, "radius must be positive"),
        ({"every": 0.0}, "every must be positive"),
        ({"remeshing": "often"}, "remeshing must be never, always, distorted or a number"),
        ({"remeshing": "0"}, "remeshing must be"),
        ({"until": -1.0}, "until must be a positive time"),
    ],
)
def test_options_out_of_range_are_refused(options, said):
    with pytest.raises(InputError, match=said):
        ZalesakDisk(**options)


def test_times_are_told_in_turns():
    assert in_turns(PERIOD) == "1 turn"
    assert in_turns(0.25 * PERIOD) == "0.25 turns"
