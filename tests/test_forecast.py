"""Estimates: what they say, and that they write nothing."""

import numpy as np
import pytest

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.bodies.motion import Prescribed
from pmesh.run.forecast import Estimate, estimate, predicted, time_text
from pmesh.run.snapshots import Snapshots
from pmesh.run.watchers import Ledger
from pmesh.vortex.exact.viscous import TaylorGreen
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

GRID = Grid((64, 64), 1 / 64, boundary="periodic")
FLOW = VortexFlow(grid=GRID, viscosity=1e-2)
ADAPTED = "not predicted for such a mesh"


def test_memory_is_told_without_a_state_and_time_is_not() -> None:
    told = estimate(FLOW)
    assert told.memory == max(predicted(FLOW).values()) > 64 * 64 * 8 * 10
    assert (told.seconds, told.steps) == (None, None)
    assert "64 x 64 nodes, periodic, float64" in str(told)
    assert "per step" not in str(told)


def test_steps_from_a_state_tell_the_time_to_the_end() -> None:
    state = FLOW.start(vorticity=TaylorGreen(viscosity=1e-2).vorticity(GRID.points()))
    seen = Ledger()
    told = estimate(FLOW, state, until=1.0, watch=[seen, Snapshots(0.5)])
    assert told.seconds is not None
    assert told.taken == 3
    dt = FLOW.limit(state).dt
    assert told.steps == pytest.approx(1.0 / dt, rel=0.2)
    assert "which the deformation rule sets" in str(told)
    assert len(seen.series["step"]) == 4
    assert state.step == 0


def test_an_estimate_from_a_later_state_speaks_of_the_mesh_that_the_body_has_travelled_to() -> None:
    led = Prescribed(shift=lambda t: (t, 0.0), velocity=lambda t: (1.0, 0.0))
    body = RigidBody(Disk(radius=0.5), motion=led)
    grid = Grid((24, 24), 0.1, (-1.15, -1.15))
    flow = VortexFlow(grid=grid, viscosity=0.05, bodies=(body,), domain="follow")
    state = flow.start()
    away = Grid((32, 24), 0.1, (8.85, -1.15))  # without the place where it began
    assert predicted(flow, grid=away)["step"] > predicted(flow)["step"]
    told = estimate(flow, state)
    assert told.grid.size >= grid.size
    assert told.peaks == predicted(flow, grid=told.grid)


def test_an_estimate_for_a_run_of_few_steps_takes_no_more() -> None:
    state = FLOW.start(vorticity=TaylorGreen(viscosity=1e-2).vorticity(GRID.points()))
    dt = FLOW.limit(state).dt
    assert estimate(FLOW, state, until=0.5 * dt).taken == 1


def test_snapshots_of_all_fields_take_more_than_of_one_on_half_the_nodes() -> None:
    sizes = [
        predicted(FLOW, [Snapshots(0.1, **given)])["snapshot"]
        for given in ({"fields": ["vorticity"], "reduce": 2}, {"fields": ["vorticity"]}, {})
    ]
    assert sizes == sorted(sizes)
    assert "snapshot" not in predicted(FLOW)


def test_what_does_not_fit_takes_no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pmesh.run.forecast.free_memory", lambda: 1000)
    told = estimate(FLOW, FLOW.start(vorticity=np.zeros(GRID.shape)), until=1.0)
    assert not told.fits
    assert told.seconds is None
    assert "it does not fit" in str(told)


def test_where_nothing_can_be_predicted_it_says_so() -> None:
    told = Estimate(grid=GRID, dtype="float64", program=10**9, free=2 * 10**9)
    assert (told.memory, told.fits) == (None, True)
    assert f"{ADAPTED}; 1 GB at the peak so far" in str(told)


def test_times_are_told_in_units_that_suit_them() -> None:
    assert [time_text(x) for x in (1.5, 300, 9000, 4e5)] == [
        "1.5 s",
        "5.0 min",
        "2.5 h",
        "4.6 days",
    ]
