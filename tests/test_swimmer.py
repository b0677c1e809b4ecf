"""Swimmers as bodies: distance, velocity of matter, measures, poses."""

import math
from dataclasses import replace

import numpy as np
import pytest

from levelset.shape import rotation
from pmesh.bodies.gait import offsets
from pmesh.bodies.motion import Fixed, Free, Prescribed
from pmesh.bodies.swimmer import Swimmer
from remesh.errors import InputError

MAKERS = {
    "carling": Swimmer.carling,
    "anguilliform": Swimmer.anguilliform,
    "carangiform": Swimmer.carangiform,
    "cstart": Swimmer.cstart,
}


def posed(swimmer, time=1.3, center=(0.3, -0.2), angle=0.7):
    return replace(swimmer.start(), time=time, center=center, angle=(angle,))


def around(swimmer, pose, n, margin, dtype="f8"):
    """Nodes of a mesh over the body's box, and its spacing."""
    low, high = swimmer.bounds(pose)
    h = (high[0] - low[0] + 2 * margin) / n
    rows = math.ceil((high[1] - low[1] + 2 * margin) / h)
    axes = [a - margin + h * (np.arange(m) + 0.5) for a, m in zip(low, (n, rows), strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij")).astype(dtype), h


def polygon_distance(points, ring):
    """Distance to a closed line, negative where it is wound around, one segment at a time."""
    best, winding = np.full(points.shape[1], np.inf), np.zeros(points.shape[1])
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        p, d = points - a[:, None], b - a
        share = np.clip((d @ p) / (d @ d), 0, 1)
        best = np.minimum(best, np.hypot(*(p - share * d[:, None])))
        side = d[0] * p[1] - d[1] * p[0]
        up, down = (
            (a[1] <= points[1]) & (b[1] > points[1]),
            (a[1] > points[1]) & (b[1] <= points[1]),
        )
        winding += (up & (side > 0)).astype(float) - (down & (side < 0))
    return np.where(winding != 0, -best, best)


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize(("dtype", "tolerance"), [("f8", 1e-14), ("f4", 2e-7)])
def test_the_distance_is_that_to_the_outline(name, dtype, tolerance):
    swimmer = MAKERS[name]()
    pose = posed(swimmer, time=0.7)
    points, _ = around(swimmer, pose, 60, 0.2, dtype)
    found = swimmer.distance(points, pose)
    exact = polygon_distance(points.reshape(2, -1).astype("f8"), swimmer.outline_points(pose))
    assert found.dtype == np.dtype(dtype)
    assert found.shape == points.shape[1:]
    assert np.abs(found.ravel() - exact).max() <= tolerance


def test_the_sign_is_right_close_to_the_nose_and_the_tail():
    swimmer = Swimmer.carling()
    pose = posed(swimmer)
    ring = swimmer.outline_points(pose)
    turn = np.linspace(0, 2 * math.pi, 60)
    for tip in (ring[0], ring[len(ring) // 2]):
        for radius in (1e-7, 1e-4):
            points = tip[:, None] + radius * np.stack((np.cos(turn), np.sin(turn)))
            exact = polygon_distance(points, ring)
            assert swimmer.distance(points, pose) == pytest.approx(exact, abs=1e-15)


@pytest.mark.parametrize("name", MAKERS)
def test_the_contour_is_close_to_the_smooth_one(name):
    swimmer = MAKERS[name]()
    pose = posed(swimmer)
    fine = MAKERS[name](samples=6400).outline_points(pose)
    assert np.abs(swimmer.distance(fine.T.copy(), pose)).max() < 2e-5


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("section", ["incompressible", "rigid"])
def test_the_deformation_is_the_velocity_of_the_matter(name, section):
    swimmer = MAKERS[name](section=section, length=2.0, period=3.0)
    time, step, share = 4.1, 1e-3, np.array([-0.9, -0.3, 0.4, 0.8])

    def places(now):
        """Where pieces of matter are, for a body held where it is."""
        body = swimmer._shape(now)
        width = share[:, None] * swimmer.outline.half_width(body.stations)
        rho = np.choose(share[:, None] > 0, offsets(section, body.curvature, np.abs(width)))
        normal = np.stack((-np.sin(body.angle), np.cos(body.angle)))
        own = body.place.T[:, None] + rho * normal[:, None]
        return 2.0 * np.tensordot(rotation((0.7,)), own, axes=1) + pose_center

    pose = posed(swimmer, time)
    pose_center = np.array(pose.center)[:, None, None]
    near = [places(time + n * step) for n in (-2, -1, 1, 2)]
    rate = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * step)
    drift = rotation((0.7,)) @ swimmer._shape(time).drift * 2.0 / 3.0
    found = swimmer.deformation(places(time), pose) - drift[:, None, None]
    assert found[..., 1:-1] == pytest.approx(rate[..., 1:-1], abs=1e-6)


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("section", ["incompressible", "rigid"])
def test_its_divergence_is_the_one_stated(name, section):
    swimmer = MAKERS[name](section=section)
    pose = posed(swimmer)
    points, h = around(swimmer, pose, 500, 0.02)
    inside = swimmer.distance(points, pose) < -2 * h
    velocity = swimmer.deformation(points, pose)
    exact = swimmer.divergence(points, pose)
    found = np.gradient(velocity[0], h, axis=0) + np.gradient(velocity[1], h, axis=1)
    if section == "incompressible":
        assert exact is None
        assert np.abs(found[inside]).max() <= 3e-3
    else:
        assert np.abs((found - exact)[inside]).max() <= 3e-3
        assert np.abs(exact[inside]).max() > 0.1


def test_the_velocity_has_no_jumps_around_the_body():
    swimmer = Swimmer.carling()
    pose = posed(swimmer)
    points, h = around(swimmer, pose, 600, 0.04)
    near = np.abs(swimmer.distance(points, pose)) < 0.03
    velocity = swimmer.deformation(points, pose)
    for axis in (0, 1):
        jump = np.abs(np.diff(velocity, axis=axis + 1)).max(axis=0)
        both = near[1:] & near[:-1] if axis == 0 else near[:, 1:] & near[:, :-1]
        assert jump[both].max() <= 12 * h  # velocity gradients reach 2 pi times the slope


@pytest.mark.parametrize("name", MAKERS)
def test_momentum_on_a_mesh_is_small_and_falls_with_the_spacing(name):
    swimmer = MAKERS[name](samples=1600)
    pose = posed(swimmer)
    found = []
    for n in (100, 400):
        points, h = around(swimmer, pose, n, 2 / n)
        chi = np.clip(0.5 - swimmer.distance(points, pose) / h, 0, 1) * h**2
        v = swimmer.deformation(points, pose)
        x, y = points[0] - pose.center[0], points[1] - pose.center[1]
        sums = [(chi * v[0]).sum(), (chi * v[1]).sum(), (chi * (x * v[1] - y * v[0])).sum()]
        found.append(np.abs(sums).max() / chi.sum())
    assert found[1] < 1e-4
    assert found[1] < found[0]


def test_float32_points_give_float32_velocities():
    swimmer = Swimmer.carling(section="rigid")
    pose = posed(swimmer)
    points, _ = around(swimmer, pose, 50, 0.02)
    few = points.astype("f4")
    exact = swimmer.deformation(few.astype("f8"), pose)
    assert swimmer.deformation(few, pose).dtype == np.float32
    assert swimmer.divergence(few, pose).dtype == np.float32
    assert swimmer.deformation(few, pose) == pytest.approx(exact, abs=1e-6)


def test_lengths_and_periods_scale_the_swimmer():
    one, two = Swimmer.carling(), Swimmer.carling(length=2.0, period=4.0)
    small = posed(one, 1.3, (0.0, 0.0))
    large = posed(two, 5.2, (0.0, 0.0))
    points, _ = around(one, small, 40, 0.02)
    assert two.distance(2 * points, large) == pytest.approx(2 * one.distance(points, small))
    assert two.deformation(2 * points, large) == pytest.approx(
        0.5 * one.deformation(points, small), abs=1e-12
    )
    assert two.measure.volume == pytest.approx(4 * one.measure.volume)
    assert two.inertia_at(5.2) == pytest.approx(16 * one.inertia_at(1.3))


def test_the_measure_is_that_of_the_straight_body():
    swimmer = Swimmer.carling()
    assert swimmer.measure.volume == pytest.approx(0.0485132741, abs=1e-10)
    assert swimmer.measure.inertia == pytest.approx(0.0032910, abs=5e-8)
    assert swimmer.inertia_at(0.0) == pytest.approx(swimmer.measure.inertia, rel=1e-12)
    assert swimmer.inertia_at(1.3) < swimmer.measure.inertia
    assert swimmer.inertia(replace(swimmer.start(), time=1.3)) == swimmer.inertia_at(1.3)
    assert swimmer.measure.center == (0.0, 0.0)


def test_a_wave_begun_half_a_period_apart_makes_the_mirror_image():
    one, two = Swimmer.carling(), Swimmer.carling(phase=0.5)
    for time in (0.4, 1.9):
        pose = posed(one, time, (0.0, 0.0), 0.0)
        flipped = two.midline_points(pose) * [1, -1]
        assert flipped == pytest.approx(one.midline_points(pose), abs=1e-12)


def test_headings_turn_the_swimmer_about_its_centre():
    ahead, turned = Swimmer.carling(), Swimmer.carling(heading=0.5, position=(1.0, 2.0))
    line = ahead.outline_points(ahead.start()) @ rotation((0.5,)).T + [1.0, 2.0]
    assert turned.outline_points(turned.start()) == pytest.approx(line)
    nose = ahead.outline_points(ahead.start())[0]
    assert nose == pytest.approx([-0.3900623, 0.0], abs=5e-8)  # the head points to -x


def test_bounds_hold_the_outline():
    swimmer = Swimmer.cstart()
    pose = posed(swimmer, 0.7)
    low, high = swimmer.bounds(pose)
    ring = swimmer.outline_points(pose)
    assert tuple(ring.min(axis=0)) == low
    assert tuple(ring.max(axis=0)) == high


def test_swimmers_are_values():
    assert Swimmer.carling() == Swimmer.carling()
    assert hash(Swimmer.cstart()) == hash(Swimmer.cstart())
    assert Swimmer.carling() != Swimmer.carling(phase=0.25)
    assert Swimmer.carling().deforming
    assert Swimmer.carling().solenoidal
    assert not Swimmer.carling(section="rigid").solenoidal
    assert Swimmer.carling().ndim == 2


def test_free_swimmers_start_with_their_velocity_and_led_ones_where_they_are_led():
    free = Swimmer.carling(motion=Free(velocity=(-0.5, 0.0), spin=0.1))
    assert (free.start().velocity, free.start().spin) == ((-0.5, 0.0), (0.1,))
    led = Swimmer.carling(motion=Prescribed(shift=lambda t: (1.0 - t, 0.0)))
    assert led.start().center == (1.0, 0.0)
    assert Swimmer.carling(motion=Fixed()).start().velocity == (0.0, 0.0)


def test_it_starts_from_rest_unless_told_to_jolt():
    pose = Swimmer.carling().start()
    points = np.array([[-0.2, 0.5], [0.0, 0.0]])
    assert not Swimmer.carling().deformation(points, pose).any()
    assert np.abs(Swimmer.carling(ramp="sine").deformation(points, pose)).max() > 0.005


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"length": 0.0}, "length must be positive"),
        ({"period": -1.0}, "period must be positive"),
        ({"position": (0.0, 0.0, 0.0)}, "position"),
        ({"heading": math.inf}, "heading"),
        ({"samples": 3}, "samples"),
        ({"section": "soft"}, "section"),
        ({"motion": "free"}, "motion"),
        ({"outline": 0.05}, "outline"),
    ],
)
def test_swimmers_that_are_none_are_refused(options, says):
    with pytest.raises(InputError, match=says):
        Swimmer.carling(**options)


def test_points_that_are_not_in_the_plane_are_refused():
    with pytest.raises(InputError, match=r"points \(2, \.\.\.\)"):
        Swimmer.carling().distance(np.zeros((3, 4)), Swimmer.carling().start())
