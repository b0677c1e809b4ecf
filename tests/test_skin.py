"""The finest blocks around bodies, and a velocity without ripples."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.shapes import Disk, Ellipse
from pmesh.bodies.body import RigidBody
from pmesh.vortex.skin import RIPPLE, SKIN, hull, skin, smoothed
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

EDGE = len(RIPPLE) // 2
MESH = AdaptiveMesh(grid=Grid((256, 128), 1 / 64, (-2.0, -1.0)), levels=2)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_waves_from_node_to_node_go_and_polynomials_stay(dtype):
    i, j = np.meshgrid(np.arange(40.0), np.arange(36.0), indexing="ij")
    smooth = np.stack([(i / 40) ** 5 * (j / 36) ** 2, 1 + i - 2 * j]).astype(dtype)
    for wave in ((-1.0) ** i, (-1.0) ** j, (-1.0) ** (i + j)):
        given = smooth + wave.astype(dtype)
        before = given.copy()
        found = smoothed(given)
        np.testing.assert_array_equal(given, before)
        assert found.dtype == dtype
        inner = (slice(None), slice(EDGE, -EDGE), slice(EDGE, -EDGE))
        np.testing.assert_allclose(found[inner], smooth[inner], atol=300 * np.finfo(dtype).eps)


@pytest.mark.parametrize(
    ("nodes", "lost"),
    [(3, 729 / 4096), (4, 1 / 64), (6, 1 / 4096), (12, 9.0356e-8)],
)
def test_a_short_wave_loses_much_of_itself_and_a_resolved_one_nothing(nodes, lost):
    # sin(pi / nodes)^12: of 60, 45 and 30 degrees exactly, of 15 to five digits
    wave = np.broadcast_to(np.cos(2 * np.pi / nodes * np.arange(48))[:, None], (1, 48, 20))
    kept = 1 - lost
    np.testing.assert_allclose(
        smoothed(wave.copy())[0, EDGE:-EDGE], kept * wave[0, EDGE:-EDGE], atol=1e-12
    )


def test_boxes_too_small_for_the_filter_stay_as_they_are():
    given = np.random.default_rng(1).normal(size=(2, 8, 9))
    np.testing.assert_array_equal(smoothed(given), given)


def test_a_hull_holds_all_boxes_and_no_more():
    one = Grid((8, 10), 0.25, (-1.0, 0.0))
    two = Grid((12, 6), 0.25, (0.5, -2.0))
    whole = hull([one, two])
    assert whole.shape == (18, 18)
    assert whole.origin == (-1.0, -2.0)
    assert hull([one]) == one


@pytest.mark.parametrize("shape", [Disk(0.4, center=(0.3, 0.1)), Ellipse(axes=(0.8, 0.2))])
def test_the_skin_holds_every_node_near_a_surface_and_no_block_far_from_it(shape):
    body = RigidBody(shape)
    places = skin((body,), (body.start(),), MESH)
    assert len(np.unique(places, axis=0)) == len(places)
    points = MESH.grid.points()
    distance = np.abs(body.distance(points, body.start()))
    h, size = MESH.grid.spacing, MESH.block
    near = np.argwhere(distance < SKIN * h) // size
    held = {tuple(place) for place in places}
    assert {tuple(place) for place in near} <= held
    parts = distance.reshape(256 // size, size, 128 // size, size).min(axis=(1, 3))
    assert max(parts[place] for place in held) < (SKIN + 8) * h


def test_two_bodies_have_both_their_skins():
    bodies = tuple(RigidBody(Disk(0.3, center=(x, 0.0))) for x in (-1.0, 1.0))
    poses = tuple(body.start() for body in bodies)
    both = skin(bodies, poses, MESH)
    parts = [skin((b,), (p,), MESH) for b, p in zip(bodies, poses, strict=True)]
    np.testing.assert_array_equal(both, np.unique(np.concatenate(parts), axis=0))
