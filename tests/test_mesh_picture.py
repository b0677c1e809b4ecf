"""Pictures of adaptive meshes: what they show is what the blocks hold, where they hold it."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from pmesh.cases.mesh_picture import (
    _faces,
    _outer,
    cut,
    level_colours,
    mesh_figure,
    mesh_history,
    outlined,
    sampled_window,
    show_mesh,
)
from pmesh.cases.style import panels
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.boxes import Boxes, leaf_boxes
from remesh.multires.mesh import AdaptiveMesh
from remesh.multires.sampling import sampled

PLANE = AdaptiveMesh(grid=Grid((256, 128), 1 / 128, (-1.0, 0.5)), levels=3, block=8)
SPACE = AdaptiveMesh(grid=Grid((64, 32, 32), 1 / 32), levels=2, block=8, tolerance=5e-3)


def bump(points):
    middle = (-0.1, 1.0) if len(points) == 2 else (0.9, 0.5, 0.4)
    square = sum((x - c) ** 2 for x, c in zip(points, middle, strict=True))
    return np.exp(-square / (0.06 if len(points) == 2 else 0.15) ** 2)


def test_a_window_shows_the_field_at_its_places():
    blocks, values = sampled(bump, PLANE)
    field, grid = sampled_window(values, blocks, window=(-0.3, 0.1, 0.8, 1.2))
    assert grid.spacing == PLANE.grid.spacing
    assert grid.origin[0] <= -0.3
    assert grid.axes()[1][-1] >= 1.2
    np.testing.assert_allclose(field, bump(grid.points()), atol=10 * PLANE.tolerance)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_slice_shows_the_plane_that_is_asked_for(axis):
    blocks, values = sampled(bump, SPACE)
    field, grid = sampled_window(values, blocks, axis=axis, at=0.5)
    x, y = grid.points()
    places = list(np.insert(np.stack([x, y]), axis, 0.5, axis=0))
    np.testing.assert_allclose(field, bump(places), atol=10 * SPACE.tolerance)


def test_a_large_domain_is_shown_on_a_coarser_level():
    mesh = AdaptiveMesh(grid=Grid((4096, 4096), 1 / 4096), levels=5, block=16)
    blocks, values = sampled(lambda x: np.exp(-100 * (x[0] ** 2 + x[1] ** 2)), mesh)
    assert sampled_window(values, blocks)[0].shape == (1024, 1024)
    assert sampled_window(values, blocks, window=(0.0, 0.1, 0.0, 0.1))[1].spacing == 1 / 4096


def test_outlines_are_the_boxes_of_active_nodes_each_level_in_its_colour():
    blocks, _ = sampled(bump, PLANE)
    boxes = leaf_boxes(blocks)
    _, ((panel,),) = panels(1, 1, (4.0, 3.0))
    show_mesh(panel, blocks)
    drawn = [c for c in panel.collections if isinstance(c, LineCollection)]
    assert sum(len(c.get_segments()) for c in drawn) == len(boxes.level)
    assert len(drawn) == len(level_colours(blocks)) == len(np.unique(boxes.level))
    widths = [c.get_linewidths()[0] for c in drawn]
    assert widths == sorted(widths, reverse=True)


def test_a_plane_across_a_domain_in_space_meets_boxes_of_its_whole_area():
    blocks, _ = sampled(bump, SPACE)
    met = cut(leaf_boxes(blocks), 2, 0.41)
    assert np.prod(met.high - met.low, axis=1).sum() == pytest.approx(2.0)


@pytest.mark.parametrize("mesh", [PLANE, SPACE], ids=["plane", "space"])
def test_the_figure_is_drawn_without_complaint(mesh, tmp_path):
    blocks, values = sampled(bump, mesh)
    mesh_figure(values, blocks, label="f").savefig(tmp_path / "mesh.png", dpi=60)
    assert (tmp_path / "mesh.png").stat().st_size > 5000


def test_pixels_on_the_edges_of_boxes_are_outlined():
    boxes = Boxes(np.zeros(2, np.int8), np.array([[0.0, 0.0], [2.0, 0.0]]),
                  np.array([[2.0, 2.0], [3.0, 1.0]]))  # fmt: skip
    found = outlined(boxes, (0.0, 4.0, 0.0, 2.0), (8, 16))
    assert found.shape == (8, 16)
    assert found[-1, :13].all()  # the lower edges of both
    assert not found[-1, 13:].any()
    assert found[:, 0].all()
    assert found[4:, 8].all()
    assert not found[:7, 1:8].any()
    assert not outlined(boxes, (10.0, 14.0, 0.0, 2.0), (8, 16)).any()


def test_a_run_is_drawn_with_its_nodes_over_time(tmp_path):
    blocks, values = sampled(bump, PLANE)
    series = {"time": np.arange(3.0), "active": np.array([100.0, 120.0, 90.0])}
    for field, told in ((values, series), (np.stack([values, -values]), {"time": np.zeros(1)})):
        figure = mesh_history(field, blocks, told)
        figure.savefig(tmp_path / "mesh.png", dpi=60)
        assert (tmp_path / "mesh.png").stat().st_size > 5000


def test_a_vector_field_is_refused():
    blocks, values = sampled(bump, PLANE)
    with pytest.raises(InputError, match="one scalar field"):
        mesh_figure(np.stack([values, values]), blocks)


def test_the_outside_of_a_level_has_no_faces_between_whole_blocks_and_quadrants():
    boxes = leaf_boxes(sampled(bump, SPACE)[0])
    for level in np.unique(boxes.level):
        own = boxes.level == level
        low, high = boxes.low[own], boxes.high[own]
        cell = SPACE.spacing(level) * SPACE.block / 2
        region = np.zeros(np.array(SPACE.level_grid(level).shape) * 2 // SPACE.block + 2, bool)
        for first, last in zip(np.rint(low / cell).astype(int), np.rint(high / cell).astype(int),
                               strict=True):  # fmt: skip
            region[tuple(slice(a + 1, b + 1) for a, b in zip(first, last, strict=True))] = True
        exposed = sum(np.count_nonzero(np.diff(region, axis=axis)) for axis in range(3))
        outer = _outer(_faces(low, high))
        area = np.prod(np.where((side := np.ptp(outer, axis=1)) > 0, side, 1.0), axis=1).sum()
        assert area == pytest.approx(exposed * cell**2)


def test_a_quadrant_before_a_whole_block_leaves_three_quarters_of_its_face():
    low, high = np.array([[0.0, 0, 0], [2, 0, 0]]), np.array([[2.0, 2, 2], [3, 1, 1]])
    outer = _outer(_faces(low, high))
    sizes = np.ptp(outer, axis=1).max(axis=1)
    assert (sizes == 2).sum() == 5
    assert (sizes == 1).sum() == 5 + 3
