"""Swimmers in space: the velocity of their matter, their moments, how they are turned."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from levelset.second import second_moments
from levelset.shape import rotation
from levelset.triangle_mesh import TriangleMesh
from pmesh.bodies.gait import offsets
from pmesh.bodies.motion import Fixed, Free
from pmesh.bodies.outline import Eel
from pmesh.bodies.profile import Arch
from pmesh.bodies.swimmer import Swimmer
from remesh.errors import InputError

TILT = (0.3, -0.5, 0.7)


def posed(swimmer, time=1.3, center=(0.3, -0.2, 0.1), angle=TILT):
    return replace(swimmer.start(), time=time, center=center, angle=angle)


def pieces(swimmer, time, radius, turn):
    """Matter at shares of its sections' radius and angle: own places (3, n, m), weights (n, m)."""
    body, along = swimmer._shape(time), swimmer.gait.sheet
    width, height = along.spread[:, None], along.rise[:, None]
    straight = width * radius * np.cos(turn)
    low, high = offsets(swimmer.section, body.curvature[:, None], np.abs(straight))
    rho = np.where(straight < 0, low, high)
    normal = np.stack((-np.sin(body.angle), np.cos(body.angle)))[..., None]
    flat = body.place.T[..., None] + rho * normal
    rigid = 1.0 if swimmer.section == "incompressible" else 1 - body.curvature[:, None] * straight
    places = np.concatenate((flat, (height * radius * np.sin(turn))[None]))
    return places * swimmer.length, width * height * radius * rigid


def over_the_body(swimmer, time, law):
    """Integral over the body of a law of own places: polar across, splines between kinks along."""
    r, w = np.polynomial.legendre.leggauss(8)
    turn = 2 * math.pi * np.arange(24) / 24
    radius, angle = np.repeat((r + 1) / 2, 24), np.tile(turn, 8)
    places, weights = pieces(swimmer, time, radius, angle)
    sums = law(places) * weights @ np.repeat(w / 2, 24) * (2 * math.pi / 24)
    s, total = swimmer.gait.sheet.stations, 0.0
    for a, b in ((0.0, 0.04), (0.04, 0.95), (0.95, 1.0)):
        piece = (s >= a - 1e-12) & (s <= b + 1e-12)
        total = total + CubicSpline(s[piece], sums[..., piece], axis=-1).integrate(s[piece][0], b)
    return total


def cross(a, b):
    return np.cross(a, b, axis=0)


class Flat(Arch):
    """A profile that has no height behind the middle."""

    def half_height(self, s):
        return np.where(s < 0.5, 0.1, 0.0)


def test_the_volume_is_that_of_the_reference():
    fish = Swimmer.carling(ndim=3, length=2.0)
    assert fish.measure.volume == pytest.approx(0.0059326147 * 8, abs=8e-10)
    assert fish.measure.center == (0.0, 0.0, 0.0)
    assert fish.ndim == 3


@pytest.mark.parametrize("time", [0.0, 0.8, 1.45])
def test_the_bent_body_has_the_same_volume_about_the_origin(time):
    fish = Swimmer.carling(ndim=3, samples=2000)
    volume = fish.measure.volume
    assert over_the_body(fish, time, lambda x: np.ones(x.shape[1:])) == pytest.approx(
        volume, rel=1e-9
    )
    assert over_the_body(fish, time, lambda x: x) == pytest.approx([0.0] * 3, abs=1e-10 * volume)


@pytest.mark.parametrize("section", ["incompressible", "rigid"])
@pytest.mark.parametrize("time", [0.8, 1.45])
def test_the_deformation_has_no_momentum_and_no_angular_momentum(section, time):
    fish = Swimmer.carling(ndim=3, samples=2000, section=section)
    pose = posed(fish, time, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    volume, spread = fish.measure.volume, fish.inertia_at(time)
    momentum = over_the_body(fish, time, lambda x: fish.deformation(x, pose))
    angular = over_the_body(fish, time, lambda x: cross(x, fish.deformation(x, pose)))
    assert momentum == pytest.approx([0.0] * 3, abs=1e-10 * volume)
    assert angular == pytest.approx([0.0] * 3, abs=1e-10 * spread)


@pytest.mark.parametrize("section", ["incompressible", "rigid"])
def test_the_deformation_is_the_velocity_of_the_matter(section):
    fish = Swimmer.carling(ndim=3, length=2.0, period=3.0, section=section)
    time, step = 4.1, 1e-3
    pose = posed(fish, time)
    radius, turn = np.array([0.3, 0.9, 0.9, 0.7]), np.array([0.2, 1.4, 3.0, 5.0])
    near = [pieces(fish, time + n * step, radius, turn)[0] for n in (-2, -1, 1, 2)]
    rate = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * step)
    rate[:2] += np.reshape(fish._shape(time).drift, (2, 1, 1)) * 2.0 / 3.0
    places = pose.placed(pieces(fish, time, radius, turn)[0])
    found = fish.deformation(places, pose)
    assert found[:, 1:-1] == pytest.approx(pose.turned(rate)[:, 1:-1], abs=1e-6)


@pytest.mark.parametrize("section", ["incompressible", "rigid"])
def test_its_divergence_is_the_one_stated(section):
    fish = Swimmer.carling(ndim=3, section=section, samples=1600)
    pose = posed(fish)
    places, _ = pieces(fish, pose.time, np.array([0.2, 0.8]), np.array([0.5, 2.5]))
    points, step = pose.placed(places[:, 40:-40:10]), 1e-4
    found = np.zeros(points.shape[1:])
    for axis in range(3):
        shift = step * np.eye(3)[axis][:, None, None]
        ahead, back = fish.deformation(points + shift, pose), fish.deformation(points - shift, pose)
        found += (ahead - back)[axis] / (2 * step)
    stated = fish.divergence(points, pose)
    assert (stated is None) == (section == "incompressible") == fish.solenoidal
    assert found == pytest.approx(np.zeros_like(found) if stated is None else stated, abs=3e-3)


@pytest.mark.parametrize("angle", [(0.0, 0.0, 0.0), TILT])
def test_the_inertia_is_that_of_the_surface(angle):
    fish = Swimmer.carling(ndim=3, length=2.0)
    pose = posed(fish, 1.3, angle=angle)
    second = second_moments(TriangleMesh(*fish.surface(pose, 256)))
    exact = np.trace(second) * np.eye(3) - second
    assert fish.inertia(pose) == pytest.approx(exact, abs=5e-4 * np.trace(second))
    straight = fish.inertia(fish.start())
    assert np.trace(straight) == pytest.approx(2 * fish.measure.inertia, rel=1e-12)
    assert straight[2, 2] == pytest.approx(fish.inertia_at(0.0))


def test_its_mean_section_is_the_plane_swimmer_of_that_outline():
    solid = Swimmer.carling(ndim=3)
    plane = Swimmer(midline=solid.midline, outline=Eel(exponent=2.0))
    one, two = solid._shape(1.3), plane._shape(1.3)
    turn = one.angle[0] - two.angle[0]
    moved = (two.ring - two.ring[0]) @ rotation((turn,)).T + one.ring[0]
    assert moved == pytest.approx(one.ring, abs=1e-12)
    pose = posed(solid, 1.3, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert solid.outline_points(pose)[:, :2] == pytest.approx(one.ring, abs=1e-15)


@pytest.mark.parametrize("angle", [(0.0, 0.0, 2.0), TILT])
def test_poses_turn_and_shift_it(angle):
    fish = Swimmer.carling(ndim=3)
    own = posed(fish, 1.3, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    pose = posed(fish, 1.3, angle=angle)
    points = (0.5 - np.random.default_rng(5).random((3, 1000))) * [[1.1], [0.3], [0.3]]
    turned = rotation(angle) @ points + np.reshape(pose.center, (3, 1))
    assert fish.distance(turned, pose) == pytest.approx(fish.distance(points, own), abs=1e-7)
    velocity = rotation(angle) @ fish.deformation(points, own)
    assert fish.deformation(turned, pose) == pytest.approx(velocity, abs=1e-7)


def test_it_is_its_own_mirror_image_up_and_down_and_half_a_period_on():
    one, two = Swimmer.carling(ndim=3), Swimmer.carling(ndim=3, phase=0.5)
    pose = posed(one, 1.9, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    points = 0.4 - 0.8 * np.random.default_rng(3).random((3, 500))
    for other, way in ((one, [1, 1, -1]), (two, [1, -1, 1])):
        flip = np.reshape(way, (3, 1))
        assert other.distance(flip * points, pose) == pytest.approx(one.distance(points, pose))
        assert flip * other.deformation(flip * points, pose) == pytest.approx(
            one.deformation(points, pose), abs=1e-12
        )


def test_volume_and_momentum_on_a_mesh_near_those_of_the_body_as_it_is_refined():
    fish = Swimmer.carling(ndim=3)
    pose = posed(fish, 1.3, (0.0, 0.0, 0.0), (0.0, 0.0, 0.4))
    found = []
    for h in (1 / 50, 1 / 150):
        low, high = fish.bounds(pose)
        axes = [np.arange(a - h, b + 1.5 * h, h) for a, b in zip(low, high, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"))
        chi = np.clip(0.5 - fish.distance(points, pose) / h, 0, 1) * h**3
        v = chi * fish.deformation(points, pose)
        sums = np.concatenate((v.sum(axis=(1, 2, 3)), cross(points, v).sum(axis=(1, 2, 3))))
        found.append((abs(chi.sum() / fish.measure.volume - 1), np.abs(sums).max() / chi.sum()))
    assert found[1][0] < 2e-3
    assert found[1][1] < 5e-4
    assert found[1][0] < found[0][0] / 4
    assert found[1][1] < found[0][1] / 4


@pytest.mark.parametrize("angle", [(0.0, 0.0, 0.4), TILT])
def test_bounds_hold_the_surface(angle):
    fish = Swimmer.carling(ndim=3)
    pose = posed(fish, angle=angle)
    vertices, _ = fish.surface(pose)
    low, high = fish.bounds(pose)
    assert (vertices >= np.array(low) - 1e-12).all()
    assert (vertices <= np.array(high) + 1e-12).all()
    assert (np.ptp(vertices, axis=0) > np.subtract(high, low) - 0.06).all()


def test_lengths_and_periods_scale_it_and_float32_is_kept():
    one, two = Swimmer.carling(ndim=3), Swimmer.carling(ndim=3, length=2.0, period=4.0)
    small, large = (posed(x, t, (0.0,) * 3) for x, t in ((one, 1.3), (two, 5.2)))
    points = 0.4 - 0.8 * np.random.default_rng(4).random((3, 500))
    exact, speed = one.distance(points, small), one.deformation(points, small)
    assert two.distance(2 * points, large) == pytest.approx(2 * exact)
    assert two.deformation(2 * points, large) == pytest.approx(0.5 * speed, abs=1e-12)
    few = points.astype("f4")
    assert one.distance(few, small).dtype == one.deformation(few, small).dtype == np.float32
    assert one.distance(few, small) == pytest.approx(exact, abs=1e-5)


def test_a_swimmer_in_space_is_placed_by_heading_or_orientation():
    at = Swimmer.carling(ndim=3, position=(1.0, 2.0, 3.0), heading=0.5).placed()
    assert (at.center, at.angle) == ((1.0, 2.0, 3.0), (0.0, 0.0, 0.5))
    assert Swimmer.carling(ndim=3, orientation=TILT).placed().angle == TILT
    far = Swimmer.carling(ndim=3, heading=4.0).placed()
    assert far.angle == pytest.approx((0.0, 0.0, 4.0 - 2 * math.pi))
    resting = Swimmer.carling(ndim=3, motion=Fixed()).start()
    assert resting.velocity == resting.spin == (0.0, 0.0, 0.0)
    assert hash(Swimmer.carling(ndim=3)) == hash(Swimmer.carling(ndim=3))
    assert Swimmer.carling(ndim=3) != Swimmer.carling()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"ndim": 4}, "2 or 3 dimensions"),
        ({"ndim": 3, "position": (0.0, 0.0)}, r"position \(x, y, z\)"),
        ({"ndim": 3, "orientation": (0.0, 1.0)}, "rotation vector"),
        ({"ndim": 3, "orientation": TILT, "heading": 1.0}, "instead of a heading"),
        ({"ndim": 2, "orientation": TILT}, "rotation vector"),
        ({"profile": 0.1}, "profile"),
        ({"profile": Flat()}, "half-height"),
        ({"ndim": 3, "motion": Free(velocity=(1.0, 0.0))}, "3 components"),
    ],
)
def test_swimmers_in_space_that_are_none_are_refused(options, says):
    with pytest.raises(InputError, match=says):
        Swimmer.carling(**options)


def test_what_is_of_the_other_dimension_is_refused():
    solid, plane = Swimmer.carling(ndim=3), Swimmer.carling()
    with pytest.raises(InputError, match="plane bodies"):
        solid.outlines(solid.start(), 0.01)
    with pytest.raises(InputError, match="in space"):
        plane.surface(plane.start())
    with pytest.raises(InputError, match=r"points \(3, \.\.\.\)"):
        solid.distance(np.zeros((2, 4)), solid.start())
