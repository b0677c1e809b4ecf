"""The swimmer in space: what its case refuses, measures and draws, and its track."""

from __future__ import annotations

import math
import shutil

import numpy as np
import pytest

from pmesh.cases.registry import find
from pmesh.cases.runner import run_case
from pmesh.cases.swimmer_in_space import NAME, PUBLISHED, SwimmerInSpace, extrapolated
from pmesh.cases.swimming import start_grid
from pmesh.cases.track import Track, imbalance
from pmesh.run.series import read_series
from remesh.errors import InputError

SMALL = {"nodes": 52, "until": 0.025, "every": 0.025, "dtype": "float64"}


def helix_track(n=300, radius=1.5, rate=0.7, climb=0.2):
    """A body on a helix about z, as columns of a run: exact place, velocity and mean force."""
    time = np.linspace(0.0, 4.0, n)
    turn, none = rate * time, np.zeros(n)
    columns = {
        "time": time,
        **{f"body0_{a}": x for a, x in zip("xyz", (radius * np.cos(turn), radius * np.sin(turn),
                                                   climb * time), strict=True)},
        **{f"body0_turn_{a}": x for a, x in zip("xyz", (none, none, turn), strict=True)},
        **{f"body0_{a}": x for a, x in zip("uvw", (-radius * rate * np.sin(turn),
                                                   radius * rate * np.cos(turn),
                                                   np.full(n, climb)), strict=True)},
        **{f"body0_spin_{a}": x for a, x in zip("xyz", (none, none, none + rate), strict=True)},
        **{f"body0_torque_{a}": none for a in "xyz"},
        "body0_power": none + 3.0,
    }  # fmt: skip
    for axis, name in zip("xyz", "uvw", strict=True):
        gained = np.diff(columns[f"body0_{name}"]) / np.diff(time)
        columns[f"body0_force_{axis}"] = np.concatenate([[math.nan], gained])
    return columns


def metric(report, start):
    """The metric whose name begins so."""
    (found,) = (m for m in report.metrics if m.name.startswith(start))
    return found


# --- its track


def test_a_track_in_space_tells_the_chord_of_a_helix_as_the_way():
    direction, speed = Track.read(helix_track()).way(1.0, 3.0)
    chord = 2 * 1.5 * math.sin(0.5 * 0.7 * 2.0)
    assert speed == pytest.approx(math.hypot(chord, 0.4) / 2.0, rel=1e-4)
    assert direction[2] == pytest.approx(0.4 / math.hypot(chord, 0.4), rel=1e-4)


def test_a_pose_in_space_is_that_of_the_columns():
    columns = helix_track()
    pose = Track.read(columns).pose(7)
    for got, names in (
        (pose.center, ("x", "y", "z")),
        (pose.angle, ("turn_x", "turn_y", "turn_z")),
        (pose.velocity, ("u", "v", "w")),
        (pose.spin, ("spin_x", "spin_y", "spin_z")),
    ):
        assert got == tuple(float(columns[f"body0_{name}"][7]) for name in names)
    assert pose.time == columns["time"][7]


def test_means_over_steps_are_integrated_exactly_in_space():
    track = Track.read(helix_track())
    gained = track.at(track.velocity, 3.3) - track.at(track.velocity, 0.7)
    assert np.allclose(track.integral(track.force, 0.7, 3.3), gained, atol=1e-12)


def test_a_balance_sees_what_is_gained_across_the_plane():
    """An impulse that gains along z a tenth of what is exchanged."""
    track = Track.read(helix_track())
    exchanged = float(track.integral(np.linalg.norm(track.force, axis=1), 1.0, 3.0))
    impulse = np.zeros_like(track.velocity)
    assert imbalance(track, impulse, 1.0, 3.0) == 0.0
    impulse[:, 2] = 0.05 * exchanged * track.time
    assert imbalance(track, impulse, 1.0, 3.0) == pytest.approx(0.1, rel=1e-9)


def test_the_amplitude_to_the_side_is_taken_in_the_plane():
    columns = helix_track()
    columns["body0_w"] = np.sin(40 * columns["time"])  # nothing to the side
    track = Track.read(columns)
    assert track.lateral(1.0, 3.0, track.way(1.0, 3.0)[0]) == pytest.approx(
        0.5 * (np.ptp(track.velocity[track.within(1.0, 3.0), :2]
                      @ _side(track.way(1.0, 3.0)[0]))), rel=1e-12)  # fmt: skip


def _side(direction):
    x, y = direction[:2] / np.hypot(*direction[:2])
    return np.array([-y, x])


# --- what is said of its speed


def test_a_speed_of_first_order_is_extrapolated_exactly():
    law = lambda nodes: 0.4 - 1.7 / nodes  # noqa: E731
    assert extrapolated((96, 64), (law(96), law(64))) == pytest.approx(0.4, abs=1e-14)
    assert extrapolated((64, 96), (law(64), law(96))) == pytest.approx(0.4, abs=1e-14)


def test_the_published_speed_stands_beside_what_is_meant_and_is_not_judged():
    told = SwimmerInSpace()._speed("speed", 0.3)
    assert (told.reference, told.tolerance, told.grade, told.passed) == (PUBLISHED, 0.1, "C", None)
    for other in ({"gait": "anguilliform"}, {"viscosity": 1e-3}, {"until": 2.0}):
        assert SwimmerInSpace(**other)._speed("speed", 0.3).reference is None


# --- the case


def test_the_case_is_found_by_its_name():
    assert find(NAME) is SwimmerInSpace


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"nodes": 48}, "nodes must be at least 52"),
        ({"projection": -1}, "projection must be a number of steps"),
        ({"wake": 0.5}, "wake must be more than 1"),
        ({"gait": "carangiform"}, "gait"),
        ({"dtype": "float16"}, "dtype"),
    ],
)
def test_a_swimmer_in_space_that_cannot_be_run_is_refused(options, told):
    with pytest.raises(InputError, match=told):
        SwimmerInSpace(**options)


def test_the_start_mesh_lies_around_the_body_with_a_node_at_the_origin():
    body = SwimmerInSpace().swimmer(ndim=3)
    grid = start_grid([body], 1 / 64, 0.12)
    low, high = (np.array(corner) for corner in body.bounds(body.start()))
    assert np.allclose(np.array(grid.origin) * 64, np.round(np.array(grid.origin) * 64))
    assert np.all(low - grid.origin > 0.11)
    assert np.all(np.array(grid.origin) + (np.array(grid.shape) - 1) / 64 - high > 0.09)


def test_a_swimmer_in_its_plane_keeps_three_coordinates():
    assert SwimmerInSpace().recipe().bodies[0].motion.locked == ("z", "turn_x", "turn_y")
    assert SwimmerInSpace(planar=False).recipe().bodies[0].motion.locked == ()


def test_a_window_keeps_the_wake_behind():
    case = SwimmerInSpace(wake=4.0)
    assert case.window(()).upper == (4.0, 2.5, 2.5)
    assert case.window(()).lower == (2.5, 2.5, 2.5)


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    """Three steps, from the parameters to the figure."""
    folder = tmp_path_factory.mktemp("swimmer") / "run"
    return run_case(NAME, SwimmerInSpace(**SMALL), folder), folder


def test_a_run_judges_momenta_symmetry_and_slip(short_run):
    report, folder = short_run
    for start in ("deformation's momentum", "and angular momentum"):
        assert 0 <= metric(report, start).value < 1e-12
    assert metric(report, "force out of its plane").value < 1e-6
    assert all(m.passed is not False for m in report.metrics)
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_the_impulse_of_body_and_fluid_stays_zero_in_space(short_run):
    series = read_series(short_run[1] / "series.csv")
    track = Track.read(series)
    impulse = np.stack([series[f"impulse_{axis}"] for axis in "xyz"], axis=1)
    assert imbalance(track, impulse, 0.0, 0.025) < 1e-5


def test_a_run_beside_another_tells_the_limit_of_no_spacing(short_run, tmp_path):
    """The other one is the same, said to be finer, and twice as fast."""
    report, folder = short_run
    shutil.copytree(folder, tmp_path / "other")
    table = tmp_path / "other" / "case.toml"
    table.write_text(table.read_text().replace("nodes = 52", "nodes = 104"))
    series = read_series(folder / "series.csv")
    lines = (tmp_path / "other" / "series.csv").read_text().splitlines()
    names = lines[0].split(",")
    for row in range(1, len(lines)):
        cells = lines[row].split(",")
        for axis in "xyz":
            cells[names.index(f"body0_{axis}")] = repr(2 * float(series[f"body0_{axis}"][row - 1]))
        lines[row] = ",".join(cells)
    (tmp_path / "other" / "series.csv").write_text("\n".join(lines) + "\n")
    case = SwimmerInSpace(beside=str(tmp_path / "other"), **SMALL)
    found = {m.name.split(",")[0]: m.value for m in case.metrics(report.outcome)}
    own = found["mean speed"]
    assert found["mean speed with 104 nodes"] == pytest.approx(2 * own)
    assert found["mean speed in the limit of no spacing"] == pytest.approx(3 * own)


def test_a_run_beside_nothing_or_itself_is_refused(short_run, tmp_path):
    with pytest.raises(InputError, match="no file"):
        SwimmerInSpace(beside=str(tmp_path), **SMALL).build()
    with pytest.raises(InputError, match="with other nodes than 52"):
        SwimmerInSpace(beside=str(short_run[1]), **SMALL).build()
