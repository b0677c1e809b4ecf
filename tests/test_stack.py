"""Levels of a mesh at work on one level set."""

import numpy as np
import pytest

from levelset import _stack
from levelset.curvature_flow import normal_bend
from levelset.floors import Floor
from levelset.lookup import places
from levelset.shapes import Disk, Sphere
from levelset.stack import LAYERS, Stack
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh


def mesh_of(ndim, cells, levels=2, tolerance=1e-3, boundary="unbounded"):
    grid = Grid((cells,) * ndim, 2.0 / cells, (-1.0,) * ndim, boundary)
    return AdaptiveMesh(grid=grid, levels=levels, tolerance=tolerance, block=8)


def stack_of(mesh, law, threads=1):
    """The levels around a contour that is known everywhere."""
    ground = mesh.level_grid(0)
    nodes = np.arange(ground.size)
    floors = [Floor(ground, nodes, law(places(ground, nodes)))]
    floors += [Floor(mesh.level_grid(level)) for level in range(1, mesh.levels + 1)]
    return Stack(mesh, floors, law, threads)


def wavy(at):
    """A level set of slope about one, its contour a bent line or sheet."""
    return at[:, 0] + 0.1 * np.sin(3.0 * at[:, -1]) + 0.3 * (at[:, 0] ** 2)


@pytest.mark.parametrize("ndim", [2, 3])
def test_every_node_is_told_by_one_level(ndim):
    mesh = mesh_of(ndim, 64)
    shape = Disk(0.4) if ndim == 2 else Sphere(0.4)
    stack = stack_of(mesh, lambda at: shape.distance(np.ascontiguousarray(at.T)))
    parts = stack.parts()
    assert all(len(nodes) for nodes in stack.nodes)
    for level, (nodes, part) in enumerate(zip(stack.nodes, parts, strict=True)):
        assert (np.diff(nodes) > 0).all()
        above = parts[level + 1].under if level < mesh.levels else np.empty(0, np.int64)
        told = np.concatenate([part.moved, part.told, above])
        np.testing.assert_array_equal(np.sort(told), nodes)
    assert not len(parts[0].told)
    np.testing.assert_array_equal(
        places(mesh.level_grid(1), parts[1].pairs), places(mesh.level_grid(0), parts[1].under)
    )
    stack.close(np.dtype(np.float64))


@pytest.mark.parametrize("ndim", [2, 3])
def test_rates_are_those_of_the_uniform_mesh(ndim):
    mesh = mesh_of(ndim, 64, boundary="periodic")
    scale = np.pi * np.arange(1, ndim + 1)

    def law(at):
        return np.cos(at @ scale) + 0.3 * np.sin(at[:, 0] * np.pi)

    stack = stack_of(mesh, law)
    stack.settle(parts := stack.parts())
    for level, part in enumerate(parts):
        grid = mesh.level_grid(level)
        phi = law(places(grid, np.arange(grid.size))).reshape(grid.shape)
        whole = sum(
            (
                16 * (np.roll(phi, 1, axis) + np.roll(phi, -1, axis))
                - np.roll(phi, 2, axis) - np.roll(phi, -2, axis) - 30 * phi
            ) / (12 * grid.spacing**2)
            for axis in range(ndim)
        )  # fmt: skip
        expected = (whole - normal_bend(phi, grid)).reshape(-1)[part.moved]
        stack.floors[level].field[stack.nodes[level]] = phi.reshape(-1)[stack.nodes[level]]
        rates = np.empty(len(part.moved))
        stack.rates(level, part.moved, rates)
        np.testing.assert_allclose(rates, expected, atol=1e-10 * np.abs(expected).max(initial=1.0))
    stack.close(np.dtype(np.float64))


@pytest.mark.parametrize("ndim", [2, 3])
def test_cubics_pass_from_level_to_level_exactly(ndim):
    mesh = mesh_of(ndim, 64, tolerance=1e-5)

    def cubic(at):
        x, z = at[:, 0], at[:, -1]
        return x + 0.4 * x**3 - 0.5 * x * z**2 + 0.3 * z**3

    stack = stack_of(mesh, wavy)
    parts = stack.parts()
    for floor, nodes, part in zip(stack.floors, stack.nodes, parts, strict=True):
        floor.field[nodes] = cubic(places(floor.grid, nodes))
        floor.field[part.told] = np.nan
    for floor, part in zip(stack.floors[:-1], parts[1:], strict=True):
        assert len(part.told)
        floor.field[part.under] = np.nan
    stack.settle(parts)
    for floor, nodes in zip(stack.floors, stack.nodes, strict=True):
        np.testing.assert_allclose(floor.field[nodes], cubic(places(floor.grid, nodes)), atol=1e-13)
    stack.close(np.dtype(np.float64))


def test_places_beyond_an_end_are_mirror_images_and_those_beyond_a_seam_wrap():
    for wraps, low, high in ((False, [2, 1], [4, 3]), (True, [4, 5], [0, 1])):
        result = np.empty(10, np.int64)
        _stack.table(6, wraps, 7, result)
        np.testing.assert_array_equal(result, 7 * np.array([*low, *range(6), *high]))


def test_new_nodes_take_interpolated_values_and_old_ones_are_kept():
    mesh = mesh_of(2, 64, tolerance=1e-5)
    stack = stack_of(mesh, wavy)
    for floor, nodes in zip(stack.floors, stack.nodes, strict=True):
        np.testing.assert_array_equal(floor.field[nodes], wavy(places(floor.grid, nodes)))
    bands = stack.close(np.dtype(np.float64))
    ground = bands[0]._replace(nodes=np.arange(mesh.level_grid(0).size))
    floors = [Floor(*ground), *(Floor(mesh.level_grid(level)) for level in (1, 2))]
    anew = Stack(mesh, floors)
    for floor, nodes in zip(anew.floors[1:], anew.nodes[1:], strict=True):
        found, exact = floor.field[nodes], wavy(places(floor.grid, nodes))
        assert 0 < np.abs(found - exact).max() < 2e-4
    anew.close(np.dtype(np.float64))


def test_bands_reach_some_layers_around_the_contour():
    mesh = mesh_of(2, 128, levels=1, tolerance=1e-5)
    stack = stack_of(mesh, lambda at: Disk(0.5).distance(np.ascontiguousarray(at.T)))
    at = places(mesh.grid, stack.nodes[1])
    off = np.abs(np.hypot(*at.T) - 0.5) / mesh.grid.spacing
    angle = np.arctan2(at[:, 1], at[:, 0])
    for low in np.linspace(-np.pi, np.pi, 16, endpoint=False):
        here = (angle >= low) & (angle < low + np.pi / 8)
        assert off[here].max() >= 2 * LAYERS
    assert off.max() < 4 * (LAYERS + 3)
    stack.close(np.dtype(np.float64))
