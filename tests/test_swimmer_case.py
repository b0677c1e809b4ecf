"""The swimmers' cases: what they refuse, measure and draw, and what symmetry asks of a swimmer."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.bodies.motion import Fixed, Free
from pmesh.cases.registry import find
from pmesh.cases.runner import run_case
from pmesh.cases.swimmer import HELD, PUBLISHED, SwimmerCase
from pmesh.cases.swimmer_pair import SwimmerPair
from pmesh.cases.swimming import RAMP, start_grid
from pmesh.cases.track import Track, deformation_drift, disagreement, efficiency, imbalance
from pmesh.run.series import read_series
from remesh.errors import InputError

SMALL = {"nodes": 104, "every": 0.2}


def swum(**options):
    """Flow and state after a short swim, the wave at full height soon."""
    case = SwimmerCase(nodes=104, **options)
    flow, state = case.build()
    while state.time < 0.5:
        state = flow.step(state, 0.0125)
    return flow, state


@pytest.fixture(scope="module")
def straight_on():
    """A swimmer towards -x."""
    return swum()


def circle_track(n=400, radius=2.0, rate=0.5):
    """A body on a circle, as columns of a run: exact place, velocity and mean force."""
    time = np.linspace(0.0, 4.0, n)
    turn = rate * time
    columns = {
        "time": time,
        "body0_x": radius * np.cos(turn),
        "body0_y": radius * np.sin(turn),
        "body0_angle": turn,
        "body0_u": -radius * rate * np.sin(turn),
        "body0_v": radius * rate * np.cos(turn),
        "body0_spin": np.full(n, rate),
    }
    dt = np.diff(time)
    for axis, name in (("x", "u"), ("y", "v")):
        gained = np.diff(columns[f"body0_{name}"]) / dt
        columns[f"body0_force_{axis}"] = np.concatenate([[math.nan], gained])
    columns["body0_torque"] = np.zeros(n)
    columns["body0_power"] = np.concatenate([[math.nan], np.full(n - 1, 3.0)])
    return columns


def metric(report, start):
    """The metric whose name begins so."""
    (found,) = (m for m in report.metrics if m.name.startswith(start))
    return found


# --- the track of a body


def test_a_track_tells_the_chord_of_a_circle_as_the_way():
    track = Track.read(circle_track())
    direction, speed = track.way(1.0, 3.0)
    chord = 2 * 2.0 * math.sin(0.5 * 0.5 * 2.0)
    assert speed == pytest.approx(chord / 2.0, rel=1e-4)
    middle = 0.5 * 2.0
    assert np.allclose(direction, [-math.sin(middle), math.cos(middle)], atol=1e-4)


def test_the_lateral_velocity_is_half_the_range_across_the_way():
    track = Track.read(circle_track())
    lateral = track.lateral(1.0, 3.0, track.way(1.0, 3.0)[0])
    assert lateral == pytest.approx(math.sin(0.5), rel=1e-2)


def test_means_over_steps_are_integrated_exactly_between_steps():
    track = Track.read(circle_track())
    gained = track.at(track.velocity, 3.3) - track.at(track.velocity, 0.7)
    assert np.allclose(track.integral(track.force, 0.7, 3.3), gained, atol=1e-12)
    assert track.integral(track.power, 0.0, 4.0) == pytest.approx(12.0)


def test_a_run_without_a_moving_body_has_no_track():
    with pytest.raises(InputError, match="no columns of a moving body3"):
        Track.read(circle_track(), 3)


def test_efficiency_is_one_without_work_and_half_where_work_is_the_energy():
    assert efficiency(2.0, 3.0, 0.0) == 1.0
    assert efficiency(2.0, 3.0, 9.0) == 0.5


def test_a_balance_closes_where_the_fluid_gets_what_the_body_loses():
    """An impulse that stays, and one that gains a tenth of what the body does."""
    track = Track.read(circle_track())
    exchanged = float(track.integral(np.hypot(*track.force.T), 1.0, 3.0))
    total = np.zeros_like(track.velocity)
    assert imbalance(track, total, 1.0, 3.0) == 0.0
    leak = 0.1 * np.hypot(*(track.at(track.velocity, 3.0) - track.at(track.velocity, 1.0)))
    part = imbalance(track, total + 0.1 * track.velocity, 1.0, 3.0)
    assert part == pytest.approx(leak / exchanged, rel=1e-12)


def test_another_force_is_compared_where_it_is_known():
    track = Track.read(circle_track())
    other = 1.02 * track.force
    other[::2] = math.nan
    known = track.within(1.0, 3.0) & np.isfinite(other[:, 0])
    net = np.hypot(*(track.dt[known] @ track.force[known]))
    size = track.dt[known] @ np.hypot(*track.force[known].T)
    assert disagreement(track, other, 1.0, 3.0) == pytest.approx(0.02 * net / size, rel=1e-9)
    assert disagreement(track, np.full_like(other, math.nan), 1.0, 3.0) is None


# --- the cases


def test_the_named_cases_are_found():
    assert find("swimmer") is SwimmerCase
    assert find("swimmer-pair") is SwimmerPair


def test_the_start_mesh_has_a_node_at_the_origin_and_room_around_the_body():
    body = SwimmerCase().swimmer(heading=0.3)
    grid = start_grid([body], 1 / 128)
    low, high = body.bounds(body.start())
    steps = np.array(grid.origin) * 128
    assert np.allclose(steps, np.round(steps))
    end = np.array(grid.origin) + (np.array(grid.shape) - 1) / 128
    assert np.all(np.array(low) - grid.origin > 0.15)
    assert np.all(end - np.array(high) > 0.15)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"nodes": 64}, "nodes must be at least 104"),
        ({"tether": "tethered", "heading": 30.0}, "heading must be along x"),
        ({"wake": 0.5}, "wake must be more than 1"),
        ({"viscosity": 0.0}, "viscosity must be positive"),
        ({"routes": 0}, "routes must be a number of steps"),
    ],
)
def test_a_swimmer_that_cannot_be_run_is_refused(options, told):
    with pytest.raises(InputError, match=told):
        SwimmerCase(**options)


def test_swimmers_in_each_other_are_refused():
    with pytest.raises(InputError, match="distance must be"):
        SwimmerPair(distance=0.0)
    SwimmerPair(distance=-0.5, offset=0.6)


def test_a_tether_holds_what_it_says():
    assert SwimmerCase(tether="free").motion() == Free(density=1.0)
    assert SwimmerCase(tether="tethered").motion() == Free(density=1.0, locked=("x",))
    assert SwimmerCase(tether="fixed").motion() == Fixed()


def test_a_fixed_swimmer_tells_its_mean_force_and_is_not_called_self_propelled():
    """A force (cos, 3) of which whole periods leave (0, 3)."""
    columns = circle_track()
    columns["body0_force_x"] = np.cos(2 * math.pi * (columns["time"] - 0.5 * columns["time"][1]))
    columns["body0_force_y"] = np.full(400, 3.0)
    case = SwimmerCase(tether="fixed", until=4.0)
    found = {m.name: m.value for m in case._swimming(Track.read(columns), 0.1)}
    assert found["mean force along x, L^3/T^2"] == pytest.approx(0.0, abs=1e-3)
    assert found["mean force along y, L^3/T^2"] == pytest.approx(3.0)
    assert found["power, L^4/T^3"] == pytest.approx(3.0)
    assert "ropelled" not in HELD["fixed"]


def test_the_published_speed_is_judged_only_where_it_is_meant():
    def of(**options):
        return SwimmerCase(**options)._speed("speed", 0.5)

    assert of().reference == PUBLISHED
    assert of().passed is True
    assert of(nodes=128).reference == PUBLISHED
    assert of(nodes=128).passed is None
    others = ({"gait": "anguilliform"}, {"viscosity": 1e-3}, {"tether": "tethered"})
    for other in ({"until": 4.0}, *others):
        assert of(**other).reference is None


def test_means_are_over_whole_periods_after_the_ramp():
    for until in (1.0, 1.5, 2.5, 3.0, 8.0, 8.5):
        first, last = SwimmerCase(until=until).counted
        assert last == until
        assert (last - first) % 1.0 == 0.0
        assert first >= (RAMP if until >= RAMP + 2 else 0.0)


def test_a_window_follows_the_heading():
    case = SwimmerCase(wake=4.0, heading=90.0)
    window = case.window((case.swimmer(heading=math.radians(90.0)),))
    assert window.upper == pytest.approx((2.5, 4.0))
    assert window.lower == pytest.approx((2.5, 2.5))


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    """A short run of the swimmer, from the parameters to the figure."""
    folder = tmp_path_factory.mktemp("swimmer") / "run"
    case = SwimmerCase(until=0.4, routes=2, **SMALL)
    return run_case("swimmer", case, folder), folder


def test_a_run_judges_momentum_and_slip(short_run):
    report, folder = short_run
    for start in ("deformation's momentum", "and angular momentum"):
        assert 0 <= metric(report, start).value < 1e-12
    assert all(m.passed is not False for m in report.metrics)
    picture = (folder / "figure.png").read_bytes()
    assert picture.startswith(b"\x89PNG")


def test_the_impulse_of_body_and_fluid_stays_zero(short_run):
    _, folder = short_run
    series = read_series(folder / "series.csv")
    track = Track.read(series)
    impulse = np.stack([series["impulse_x"], series["impulse_y"]], axis=1)
    assert imbalance(track, impulse, 0.0, 0.4) < 1e-6


def test_the_momentum_that_passes_a_box_is_what_the_body_gains(short_run):
    """The control volume knows nothing of the law that moves the body."""
    _, folder = short_run
    series = read_series(folder / "series.csv")
    track = Track.read(series)
    passed = np.stack([series["body0_flux_force_x"], series["body0_flux_force_y"]], axis=1)
    apart = disagreement(track, passed, 0.0, 0.4)
    assert apart is not None
    assert apart < 0.02


def test_a_deformation_not_corrected_on_the_mesh_would_be_told(straight_on, monkeypatch):
    """The check of the deformation's momentum sees the drift that the mesh takes out."""
    flow, state = straight_on
    drift = deformation_drift(flow, state.grid, state.poses)[0]
    assert max(drift) < 1e-12
    held = (SwimmerCase(nodes=104).swimmer(motion=Free(locked=("x", "y", "angle"))),)
    from dataclasses import replace

    kept = deformation_drift(replace(flow, bodies=held), state.grid, state.poses)[0]
    assert max(kept) > 1e-6, "locked coordinates keep what the mesh makes of them"


# --- symmetry


def test_a_mirrored_swimmer_swims_the_mirror_image(straight_on):
    """The lattice is its own mirror image: to round-off, but for the solver's tolerance."""
    pose = straight_on[1].poses[0]
    other = swum(mirrored=True)[1].poses[0]
    moved = math.hypot(*pose.center)
    assert abs(other.center[0] - pose.center[0]) < 1e-3 * moved
    assert abs(other.center[1] + pose.center[1]) < 1e-3 * moved
    assert abs(other.angle[0] + pose.angle[0]) < 1e-3 * abs(pose.angle[0]) + 1e-6


def test_a_swimmer_that_heads_back_swims_back(straight_on):
    pose = straight_on[1].poses[0]
    other = swum(heading=180.0)[1].poses[0]
    moved = math.hypot(*pose.center)
    assert abs(other.center[0] + pose.center[0]) < 1e-3 * moved
    assert abs(other.center[1] + pose.center[1]) < 1e-3 * moved


def test_a_swimmer_swims_towards_its_head(straight_on):
    assert straight_on[1].poses[0].center[0] < 0
    assert straight_on[1].poses[0].velocity[0] < -0.03


# --- the pair


def test_a_pair_runs_beside_one_alone(tmp_path):
    case = SwimmerPair(until=0.1, distance=0.1, **{**SMALL, "every": 0.1})
    report = run_case("swimmer-pair", case, tmp_path / "run")
    assert metric(report, "mean speed, alone").value > 0
    assert metric(report, "power, follower over alone").value == pytest.approx(1.0, abs=0.1)
    tracks = case.tracks(report.outcome)
    assert tracks["follower"].place[0] == pytest.approx((1.1, 0.0))
    assert list(tracks) == ["leader", "follower", "alone"]


def test_a_pair_may_swim_without_the_one_alone(tmp_path):
    case = SwimmerPair(until=0.03, alone=False, every=0.03, nodes=104)
    report = run_case("swimmer-pair", case, tmp_path / "run")
    assert not [m for m in report.metrics if "alone" in m.name]


# --- resumption


@pytest.mark.parametrize(
    ("name", "make"),
    [("swimmer", SwimmerCase), ("swimmer-pair", SwimmerPair)],
)
def test_a_stopped_run_goes_on_bit_for_bit(tmp_path, name, make):
    """Routes of forces too, which look back a step."""

    def interrupt(moment):
        if moment.step == 5:
            raise KeyboardInterrupt

    case = make(until=0.08, nodes=104, every=0.04)
    whole = run_case(name, case, tmp_path / "whole").outcome
    with pytest.raises(KeyboardInterrupt):
        run_case(name, case, tmp_path / "parts", watch=[interrupt])
    parts = run_case(name, case, tmp_path / "parts", resume=True).outcome
    assert (tmp_path / "parts/series.csv").read_text() == (
        tmp_path / "whole/series.csv"
    ).read_text()
    ends = [getattr(end.state, "first", end.state).vorticity for end in (parts, whole)]
    assert np.array_equal(*ends)
