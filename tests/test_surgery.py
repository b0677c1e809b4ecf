"""The operation of the case cutting: its organ, its tools, its reference."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.measure import measure
from pmesh.cases import surgery
from pmesh.cases.surgery import SWITCH, Breathing, Operation, bore, swept_volume

CALM = Operation(0.13, 0.0)


def test_the_organ_breathes_with_the_velocity_of_its_shift() -> None:
    motion = Breathing(0.06)
    here = np.zeros((3, 3))
    for time in (0.1, 0.3, 0.77):
        step = 1e-5
        rate = np.subtract(motion.shift(time + step), motion.shift(time - step)) / (2 * step)
        assert motion(time, here) == pytest.approx(np.tile(rate, (3, 1)), abs=1e-8)
    assert motion.max_gradient(0.3) == 0.0


def test_what_is_left_and_what_was_taken_make_the_organ() -> None:
    points = np.random.default_rng(0).uniform(-0.8, 0.8, (3, 3000))
    operation = Operation(0.13, 0.06)
    left, taken = operation.section(0.7, points)
    places = points - np.reshape(operation.motion.shift(0.7), (3, 1))
    inside = operation.organ.distance(places) < 0
    assert np.array_equal((left < 0) | (taken < 0), inside)
    assert not np.any((left < 0) & (taken < 0))


def test_nothing_is_swept_at_first_and_all_of_the_groove_at_the_switch() -> None:
    assert swept_volume(CALM, 0.0) == 0.0
    times = [0.1, 0.25, SWITCH, 0.5, 1.0]
    found = [swept_volume(CALM, time) for time in times]
    assert found[2] == pytest.approx(found[3], rel=1e-6), "the burr has left, the blade not come"
    assert found == sorted(found)


def test_the_reference_does_not_depend_on_its_points(monkeypatch) -> None:
    fine = swept_volume(CALM, 0.9)
    surgery._points.cache_clear()
    monkeypatch.setattr(surgery, "FINE", 1 / 56)
    coarse = swept_volume.__wrapped__(CALM, 0.9)
    surgery._points.cache_clear()
    assert coarse == pytest.approx(fine, rel=4e-3)


def test_the_organ_holds_about_half_a_unit() -> None:
    """By another quadrature than the one of the runs."""
    volume = measure(CALM.organ).volume
    places, inside = surgery._points(CALM)
    ours = np.clip(0.5 - inside / surgery.FINE, 0, 1).sum() * surgery.FINE**3
    assert places.shape[0] == 3
    assert ours == pytest.approx(volume, rel=2e-3)


def test_a_ball_bores_what_it_should() -> None:
    found, exact = bore(0.15, 28)
    assert found == pytest.approx(exact, rel=2e-3)
