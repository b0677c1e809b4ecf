"""Bodies on a box of the mesh: indicator, owners, momentum-free deformations, swelling."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Ellipsoid, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.mask import (
    Mask,
    _deformation_of,
    _mask,
    at_rest,
    box_around,
    deformation_on,
    mask_of,
    rigid_modes,
    swelling,
)
from pmesh.bodies.motion import Fixed, Free, Prescribed, coordinates
from pmesh.bodies.swimmer import Swimmer
from remesh.grid import Grid

H = 1 / 8
GRID = Grid((64, 64), H, (-4.0, -4.0))
DISK = RigidBody(Disk(radius=1.0, center=(0.03, -0.05)))
FINE = Grid((160, 48), 1 / 128, (-0.5, -0.2))


def mask(*bodies: RigidBody, grid: Grid = GRID) -> Mask:
    bodies = bodies or (DISK,)
    return mask_of(bodies, tuple(body.start() for body in bodies), grid, 1.5 * H, 0.0)


def test_the_box_lies_on_the_lattice_and_holds_the_bodies():
    grid = Grid((64, 64), 0.1, (-3.17, -2.93))
    bodies = (RigidBody(Disk(radius=0.5, center=(1, 1))), RigidBody(Box(size=(0.4, 0.6))))
    box = box_around(bodies, tuple(body.start() for body in bodies), grid, 0.15)
    steps = (np.array(box.origin) - grid.origin) / 0.1
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    for axis, values in enumerate(box.axes()):
        assert values[0] < (-0.2, -0.3)[axis] - 0.15 - 3 * 0.1
        assert values[-1] > 1.5 + 0.15 + 3 * 0.1


def test_the_box_takes_a_periodic_axis_whole():
    grid = Grid((32, 64), 0.1, (0.0, -3.2), ("periodic", "unbounded"))
    body = RigidBody(Disk(radius=0.5, center=(1.6, 0.0)))
    box = box_around((body,), (body.start(),), grid, 0.15)
    assert (box.shape[0], box.origin[0], box.boundary) == (32, 0.0, grid.boundary)
    assert box.shape[1] < 64


def test_every_node_belongs_to_its_nearest_body():
    left = RigidBody(Disk(radius=0.6, center=(-1.5, 0.0)))
    right = RigidBody(Disk(radius=0.6, center=(1.5, 0.0)))
    both = mask(left, right, grid=GRID)
    x, _ = GRID.points()
    np.testing.assert_array_equal(both.owner[x < 0], 0)
    np.testing.assert_array_equal(both.owner[x > 0], 1)
    alone = mask(left, grid=GRID).chi + mask(right, grid=GRID).chi
    np.testing.assert_allclose(both.chi, alone, atol=1e-15)


def test_masks_of_a_step_are_drawn_once_and_those_of_older_steps_are_let_go():
    poses = [replace(DISK.start(), center=(0.1 * n, 0.0)) for n in range(8)]
    drawn = [mask_of((DISK,), (pose,), GRID, 1.5 * H, 0.0) for pose in poses]
    assert drawn[0].owner.dtype.itemsize == 2
    assert _mask.cache_info().currsize == 3
    again = [mask_of((DISK,), (pose,), GRID, 1.5 * H, 0.0) for pose in poses[-3:]]
    assert all(one is other for one, other in zip(again, drawn[-3:], strict=True))
    assert mask_of((DISK,), (poses[0],), GRID, 1.5 * H, 0.0) is not drawn[0]


def test_each_of_many_bodies_bends_once_at_each_place_of_a_step():
    school = [Swimmer.carling(heading=0.1 * n, samples=201) for n in range(5)]  # of no other test
    grid = box_around((school[0],), (school[0].start(),), FINE, 0.05)
    for _ in range(3):
        for time in (0.1, 0.2, 0.3):
            for fish in school:
                deformation_on(fish, replace(fish.start(), time=time), grid)
    told = [_deformation_of(fish).cache_info() for fish in school]
    assert [(one.misses, one.currsize) for one in told] == [(3, 3)] * 5


def test_bodies_that_overlap_are_one():
    disk, same = mask(grid=GRID), mask(DISK, DISK, grid=GRID)
    np.testing.assert_array_equal(disk.chi, same.chi)


def test_a_box_around_what_moves_has_few_shapes():
    """Solvers are kept per shape: sides are multiples of 8 nodes, wherever the body is."""
    body = RigidBody(Disk(radius=1.0), motion=Prescribed(shift=lambda t: (0.37 * t, 0.1 * t)))
    shapes = set()
    for time in np.linspace(0.0, 3.0, 40):
        pose = body.motion.pose(body.start(), float(time))
        box = box_around((body,), (pose,), GRID, 0.2)
        low, high = body.bounds(pose)
        assert all(o <= a - 0.2 for o, a in zip(box.origin, low, strict=True))
        ends = np.add(box.origin, np.multiply(np.subtract(box.shape, 1), H))
        assert all(b + 0.2 <= e for b, e in zip(high, ends, strict=True))
        shapes.add(box.shape)
    assert len(shapes) <= 2


def test_a_prescribed_body_tells_its_velocity_and_a_free_one_leaves_it_open():
    led = RigidBody(
        Disk(radius=1.0), motion=Prescribed(shift=lambda t: (t, 2 * t), angle=lambda t: 3 * t)
    )
    pose = led.motion.pose(led.start(), 0.0)
    velocity = mask_of((led,), (pose,), GRID, 1.5 * H, 0.0).velocity
    x, y = GRID.points()
    np.testing.assert_allclose(velocity, [1 - 3 * y, 2 + 3 * x], atol=1e-9)
    free = RigidBody(Disk(radius=1.0), motion=Free(velocity=(1.0, 2.0), spin=3.0))
    assert not mask_of((free,), (free.start(),), GRID, 1.5 * H, 0.0).velocity.any()


@pytest.mark.parametrize("time", [0.2, 0.9, 1.4])
@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_a_deformation_has_no_momentum_on_the_mesh(time, heading):
    """Linear and angular, to round-off; of the whole body, not drawn in, it has little anyway."""
    fish = Swimmer.carling(length=1.0, period=1.0, heading=heading)
    pose = fish.start().__class__(**{**fish.start().__dict__, "time": time})
    grid = box_around((fish,), (pose,), FINE, 0.05)
    seen = mask_of((fish,), (pose,), grid, 1.5 / 128, 0.01)
    modes = rigid_modes(grid.points(), pose)
    momenta = np.einsum("mixy,ixy->m", modes * seen.chi, seen.velocity)
    speed = float(np.abs(seen.velocity * seen.chi).sum())
    assert np.abs(momenta).max() <= 1e-13 * speed
    whole = mask_of((fish,), (pose,), grid, 1.5 / 128, 0.0)
    assert np.abs(whole.drift[0]).max() < 0.2 * np.abs(seen.drift[0]).max()


def test_what_is_locked_keeps_its_drift():
    held = Swimmer.carling(motion=Free(locked=("x", "y", "angle")))
    pose = held.start().__class__(**{**held.start().__dict__, "time": 1.2})
    grid = box_around((held,), (pose,), FINE, 0.05)
    seen = mask_of((held,), (pose,), grid, 1.5 / 128, 0.0)
    assert not seen.drift[0].any()
    np.testing.assert_array_equal(seen.velocity, deformation_on(held, pose, grid))


@pytest.mark.parametrize("locked", [("x",), ("angle",), ("x", "y")])
def test_a_partly_locked_deformation_has_no_momentum_along_what_is_loose(locked):
    tied = Swimmer.carling(heading=0.4, motion=Free(locked=locked))
    pose = replace(tied.start(), time=1.2)
    grid = box_around((tied,), (pose,), FINE, 0.05)
    seen = mask_of((tied,), (pose,), grid, 1.5 / 128, 0.01)
    momenta = np.einsum("mixy,ixy->m", rigid_modes(grid.points(), pose) * seen.chi, seen.velocity)
    loose = np.array([name not in locked for name in ("x", "y", "angle")])
    assert np.abs(momenta[loose]).max() <= 1e-13 * float(np.abs(seen.velocity * seen.chi).sum())
    assert not seen.drift[0][~loose].any()
    assert seen.drift[0][loose].all()


def test_where_a_surface_is_does_not_depend_on_its_speed():
    free = RigidBody(Disk(radius=1.0), motion=Free(velocity=(1.0, 2.0), spin=3.0))
    still = RigidBody(Disk(radius=1.0))
    assert at_rest((free,), (free.start(),)) == at_rest((still,), (still.start(),))


def test_what_does_not_move_is_drawn_once_and_what_bends_at_every_time():
    led = RigidBody(Disk(radius=1.0), motion=Prescribed(shift=lambda t: (max(t, 1.0), 0.0)))
    fish = Swimmer.carling(motion=Fixed())
    drawn = {}
    for name, body in (("fixed", DISK), ("free", replace(DISK, motion=Free())), ("led", led)):
        poses = [replace(body.start(), time=t) for t in (0.0, 0.3)]
        drawn[name] = [mask_of((body,), (pose,), GRID, 1.5 * H, 0.0) for pose in poses]
    assert all(first is then for first, then in drawn.values())
    poses = [replace(fish.start(), time=t) for t in (0.0, 0.3)]
    first, then = (mask_of((fish,), (pose,), FINE, 1.5 / 128, 0.0) for pose in poses)
    assert (first.chi != then.chi).any()
    slow = RigidBody(Disk(radius=1.0), motion=Prescribed(velocity=lambda t: (t, 0.0)))
    poses = [slow.motion.pose(slow.start(), t) for t in (0.0, 0.3)]
    first, then = (mask_of((slow,), (pose,), GRID, 1.5 * H, 0.0) for pose in poses)
    assert (first.velocity[0].max(), then.velocity[0].max()) == (0.0, 0.3)
    np.testing.assert_array_equal(first.chi, then.chi)


def test_rigid_sections_swell_and_shrink_by_the_same_amount():
    fish = Swimmer.carling(section="rigid")
    pose = fish.start().__class__(**{**fish.start().__dict__, "time": 1.2})
    grid = box_around((fish,), (pose,), FINE, 0.05)
    source = swelling((fish,), (pose,), grid, 1.5 / 128)
    assert source is not None
    assert abs(source.sum()) < 1e-12 * np.abs(source).sum()
    assert np.abs(source).max() > 0.1


def test_what_is_rigid_or_incompressible_does_not_swell():
    fish = Swimmer.carling()
    assert swelling((DISK, fish), (DISK.start(), fish.start()), GRID, 0.1) is None


def test_rigid_modes_in_space_are_unit_shifts_and_the_cross_products_of_unit_spins():
    ball = RigidBody(Sphere(0.5, center=(0.1, -0.2, 0.3)))
    pose, grid = ball.start(), Grid((5, 6, 7), 0.2, (-0.4, -0.5, -0.6))
    points = grid.points()
    modes = rigid_modes(points, pose)
    arm = np.moveaxis(points, 0, -1) - pose.center
    for axis, unit in enumerate(np.eye(3)):
        np.testing.assert_array_equal(np.moveaxis(modes[axis], 0, -1), unit + 0 * arm)
        np.testing.assert_allclose(np.moveaxis(modes[3 + axis], 0, -1), np.cross(unit, arm))


@dataclass(frozen=True)
class Wobbling(RigidBody):
    """A solid whose matter also moves by a law that has every momentum."""

    @property
    def deforming(self):
        return True

    def deformation(self, points, pose):
        x, y, z = points
        return np.stack([1.0 + y * z + y, 0.3 - x + x * x, 2.0 * x - z + 0.5 * y])


@pytest.mark.parametrize("locked", [(), ("x", "turn_y")])
def test_a_deformation_in_space_has_no_momentum_along_what_is_loose(locked):
    body = Wobbling(Ellipsoid((0.5, 0.3, 0.4)), motion=Free(locked=locked))
    pose = replace(body.start(), angle=(0.2, 0.3, -0.4))
    grid = box_around((body,), (pose,), Grid((32, 32, 32), 0.05, (-0.8,) * 3), 0.1)
    seen = mask_of((body,), (pose,), grid, 0.075, 0.01)
    modes = rigid_modes(grid.points(), pose)
    momenta = np.einsum("mixyz,ixyz->m", modes * seen.chi, seen.velocity)
    loose = np.array([name not in locked for name in coordinates(3)])
    assert np.abs(momenta[loose]).max() <= 1e-12 * float(np.abs(seen.velocity * seen.chi).sum())
    assert seen.drift[0][loose].all()
    assert not seen.drift[0][~loose].any()
