"""The forced wall lies where its calibration says, wherever it is between nodes."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.bodies import forced_wall
from pmesh.bodies.forced_wall import calibrated, sheet_retraction


@pytest.mark.parametrize("strength", [100.0, 1000.0, 10_000.0])
def test_the_place_between_nodes_moves_the_wall_by_a_thirtieth_of_a_spacing_at_most(strength):
    wall = calibrated(strength, 8, 2.0)
    places = [
        forced_wall._channel(shift, strength, wall.sharpening, 8, 2.0) for shift in np.arange(8) / 8
    ]
    outside, beside = np.transpose(places)
    assert np.abs(outside - wall.retraction).max() < 1 / 30
    assert np.abs(beside).max() < 1e-4


def test_without_sharpening_a_flow_passes_beside_the_wall():
    _, beside = forced_wall._channel(0.0, 1000.0, 0.0, 8, 2.0)
    assert beside < -0.03


def test_a_stronger_force_acts_further_outside():
    places = [calibrated(strength, 8, 2.0).retraction for strength in (10.0, 100.0, 1e3, 1e4)]
    assert places == sorted(places)
    assert 0.0 < places[0] < places[-1] < 1.5


def test_the_sheet_of_a_start_lies_where_a_stream_loses_its_momentum():
    """The same for any place between nodes, and outside of the markers."""
    places = [forced_wall._sheet(shift, 1e3, 8, 2.0) for shift in np.arange(8) / 8]
    assert np.ptp(places) < 0.1
    assert sheet_retraction(1e3, 8, 2.0) == pytest.approx(np.mean(places), abs=0.01)


def test_the_calibration_repeats_itself():
    assert calibrated(1000.0, 8, 2.0) == calibrated(1000.0, 8, 2.0)
