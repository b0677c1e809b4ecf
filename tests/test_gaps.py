"""Gaps between bodies: exact, along the common normal, one for each place that is near."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Ellipse
from pmesh.bodies.body import RigidBody
from pmesh.bodies.gaps import contacts
from pmesh.bodies.motion import Free, Prescribed
from pmesh.bodies.swimmer import Swimmer

REACH = 0.1
FREE = Free()


def found(*bodies, reach=REACH):
    return contacts(bodies, [body.start() for body in bodies], reach)


@pytest.mark.parametrize("turn", np.linspace(0.0, 6.0, 7))
@pytest.mark.parametrize("gap", [-0.03, 0.0, 0.02, 0.09])
def test_two_disks_touch_on_the_line_between_their_centres(turn, gap):
    way = np.array([np.cos(turn), np.sin(turn)])
    one = RigidBody(Disk(0.5, center=(0.2, 0.1)), motion=FREE)
    two = RigidBody(Disk(0.3, center=tuple((0.8 + gap) * way + (0.2, 0.1))))
    (contact,) = found(one, two)
    assert (contact.first, contact.second) == (0, 1)
    assert contact.gap == pytest.approx(gap, abs=1e-9)
    assert contact.normal == pytest.approx(-way, abs=1e-5)  # from the second to the first
    assert contact.point == pytest.approx((0.5 + gap / 2) * way + (0.2, 0.1), abs=1e-5)


def test_the_gap_of_an_ellipse_to_a_wall_is_exact_at_any_turn():
    """The support of an ellipse: sqrt((a sin)^2 + (b cos)^2) below its centre."""
    wall = RigidBody(Box((8.0, 1.0), center=(0.0, -0.5)))
    body = RigidBody(Ellipse((0.6, 0.25)), motion=FREE)
    for angle in np.linspace(0.0, 3.0, 11):
        depth = np.hypot(0.6 * np.sin(angle), 0.25 * np.cos(angle))
        pose = replace(body.start(), center=(0.3, depth + 0.04), angle=(angle,))
        (contact,) = contacts([body, wall], [pose, wall.start()], REACH)
        assert contact.gap == pytest.approx(0.04, abs=1e-8)
        assert contact.normal == pytest.approx((0.0, 1.0), abs=1e-5)
        side = (0.36 - 0.0625) * np.sin(angle) * np.cos(angle) / depth
        assert contact.point == pytest.approx((0.3 - side, 0.02), abs=1e-4)


@pytest.mark.parametrize("turn", [0.2, 0.6, 1.1])
def test_the_corner_of_a_tilted_box_is_what_touches_a_wall(turn):
    cos, sin = np.cos(turn), np.sin(turn)
    corner = min(
        ((sx * cos - sy * sin, sx * sin + sy * cos) for sx in (-0.5, 0.5) for sy in (-0.2, 0.2)),
        key=lambda point: point[1],
    )
    box = RigidBody(Box((1.0, 0.4)), motion=FREE)
    wall = RigidBody(Box((8.0, 1.0), center=(0.0, -0.5)))
    pose = replace(box.start(), center=(0.0, 0.05 - corner[1]), angle=(turn,))
    (contact,) = contacts([wall, box], [wall.start(), pose], REACH)
    assert contact.gap == pytest.approx(0.05, abs=1e-6)
    assert contact.normal == pytest.approx((0.0, -1.0), abs=1e-4)
    assert contact.point == pytest.approx((corner[0], 0.025), abs=1e-3)


def test_a_flat_face_is_told_by_its_ends():
    box = RigidBody(Box((1.0, 0.4), center=(0.3, 0.25)), motion=FREE)
    wall = RigidBody(Box((8.0, 1.0), center=(0.0, -0.5)))
    ends = sorted(contact.point[0] for contact in found(box, wall))
    assert ends == pytest.approx([-0.2, 0.8], abs=REACH / 4)
    assert [contact.gap for contact in found(box, wall)] == pytest.approx([0.05, 0.05], abs=1e-9)


def test_a_disk_in_a_notch_touches_both_of_its_walls():
    notch = RigidBody(Box((2.0, 2.0)) - Box((2.0, 2.0), center=(1.0, 1.0)))
    disk = RigidBody(Disk(0.5, center=(0.55, 0.53)), motion=FREE)
    low, side = found(disk, notch)
    assert (low.gap, side.gap) == pytest.approx((0.03, 0.05), abs=1e-9)
    assert low.normal == pytest.approx((0.0, 1.0), abs=1e-6)
    assert side.normal == pytest.approx((1.0, 0.0), abs=1e-6)


def test_only_pairs_within_reach_with_a_free_body_are_told():
    disks = [RigidBody(Disk(0.5, center=(x, 0.0))) for x in (0.0, 1.05)]
    assert found(*disks) == ()
    led = RigidBody(Disk(0.5), motion=Prescribed(angle=lambda t: t))
    assert found(led, disks[1]) == ()
    free = RigidBody(Disk(0.5), motion=FREE)
    assert len(found(free, disks[1])) == 1
    assert found(free, disks[1], reach=0.04) == ()
    assert found(free, RigidBody(Disk(0.5, center=(5.0, 0.0)))) == ()
    assert found(free) == ()


def test_a_body_that_bends_is_near_where_it_is_at_that_time():
    swimmer = Swimmer.carling(length=1.0, period=1.0)
    still = swimmer.start()
    for time in (1.3, 1.8):
        pose = replace(still, time=time)
        line = np.stack([np.full(4001, 0.3), np.linspace(-0.5, 0.5, 4001)])
        top = line[1][swimmer.distance(line, pose) < 0].max()
        tip = RigidBody(Disk(0.05, center=(0.3, float(top) + 0.09)))
        near = contacts([swimmer, tip], [pose, tip.start()], REACH)
        gap = float(swimmer.distance(np.array([[0.3], [top + 0.09]]), pose)[0]) - 0.05
        assert near[0].gap == pytest.approx(gap, abs=1e-3)
        assert near[0].normal[1] < -0.7
