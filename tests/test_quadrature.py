"""Volume, area, centre and integrals are those of the shape, to the order stated."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipe

from levelset.band import Band
from levelset.quadrature import area, centroid, integrate, measures, volume
from levelset.shapes import Box, Disk, Ellipsoid, SlottedDisk, SlottedSphere, Sphere
from remesh.errors import InputError
from remesh.grid import Grid

CENTER = (0.013, 0.021, 0.004)


def mesh(n, ndim, boundary="unbounded"):
    h = 3.1 / n
    return Grid((n,) * ndim, h, origin=(-1.55 + h / 2,) * ndim, boundary=boundary)


def seen(grid):
    return [x - c for x, c in zip(grid.points(), CENTER, strict=False)]


def disk(grid):
    return np.sqrt(sum(x * x for x in seen(grid))) - 1.0


def ellipse(grid):
    x, y = seen(grid)
    return np.exp(x * x + (y / 0.6) ** 2 - 1.0) - 1.0  # no polynomial, no distance


def ellipsoid(grid):
    x, y, z = seen(grid)
    return np.exp(x * x + (y / 0.7) ** 2 + (z / 0.7) ** 2 - 1.0) - 1.0


def torus(grid):
    x, y, z = seen(grid)
    return np.hypot(np.hypot(x, y) - 1.0, z) - 0.4


def spheroid_area(a, b):
    """Of the prolate spheroid with half axes a > b = b."""
    e = math.sqrt(1 - (b / a) ** 2)
    return 2 * math.pi * b * b * (1 + a / (b * e) * math.asin(e))


ELLIPSE = (ellipse, math.pi * 0.6, 4 * ellipe(1 - 0.36), (32, 64, 128))
CIRCLE = (disk, math.pi, 2 * math.pi, (32, 64, 128))
ELLIPSOID = (ellipsoid, 4 / 3 * math.pi * 0.49, spheroid_area(1.0, 0.7), (16, 32, 64))
TORUS = (torus, 2 * math.pi**2 * 0.16, 4 * math.pi**2 * 0.4, (16, 32, 64))


@pytest.mark.parametrize("case", [ELLIPSE, CIRCLE, ELLIPSOID, TORUS])
def test_volume_and_area_are_of_order_four_at_least(case):
    law, inside, surface, counts = case
    ndim = 2 if counts[0] == 32 else 3
    errors = []
    for n in counts:
        grid = mesh(n, ndim)
        phi = law(grid)
        errors.append((abs(volume(phi, grid) - inside), abs(area(phi, grid) - surface)))
    orders = np.log2(np.array(errors[1]) / errors[2])
    assert (orders > 3.8).all(), (orders, errors)
    assert errors[2][0] < 1e-4 * inside
    assert errors[2][1] < 1e-4 * surface


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_a_band_is_enough_and_what_is_beyond_it_is_never_read(dtype, ndim):
    grid = mesh(40, ndim)
    phi = disk(grid).astype(dtype)
    nodes = np.flatnonzero(np.abs(phi) < 4 * grid.spacing)
    known = np.full(grid.shape, np.nan, dtype)
    known.reshape(-1)[nodes] = phi.reshape(-1)[nodes]
    assert volume(known, grid, nodes=nodes) == pytest.approx(volume(phi, grid), rel=1e-13)
    assert area(known, grid, nodes=nodes) == pytest.approx(area(phi, grid), rel=1e-13)
    assert centroid(known, grid, nodes=nodes) == pytest.approx(centroid(phi, grid), abs=1e-13)
    assert volume(phi.reshape(-1)[nodes], grid, nodes=nodes) == volume(known, grid, nodes=nodes)


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize(("layers", "off"), [(3.0, 1e-6), (2.2, 2e-5)])
def test_a_narrow_band_costs_few_digits(ndim, layers, off):
    grid = mesh(40, ndim)
    phi = disk(grid)
    nodes = np.flatnonzero(np.abs(phi) < layers * grid.spacing)
    assert volume(phi, grid, nodes=nodes) == pytest.approx(volume(phi, grid), rel=off)
    assert area(phi, grid, nodes=nodes) == pytest.approx(area(phi, grid), rel=off)


@pytest.mark.parametrize("boundary", ["unbounded", "periodic"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_a_band_that_misses_corners_of_crossed_cells_is_refused(ndim, boundary):
    grid = mesh(40, ndim, boundary)
    for middle in (0, 20):  # across the seam, if there is one
        phi = np.roll(disk(grid), middle * (boundary == "periodic"), 0)
        nodes = np.flatnonzero(np.abs(phi) < 1.0 * grid.spacing)
        for law in (volume, area, measures):
            with pytest.raises(InputError, match="the band is too thin: the contour crosses cells"):
                law(phi, grid, nodes=nodes)
        enough = np.flatnonzero(np.abs(phi) < math.sqrt(ndim) * grid.spacing)
        assert area(phi, grid, nodes=enough) == pytest.approx(area(phi, grid), rel=2e-3)
        assert volume(phi, grid, nodes=enough) == pytest.approx(volume(phi, grid), rel=2e-3)


@pytest.mark.parametrize("corner", [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_any_corner_that_is_missing_is_noticed(corner):
    grid = Grid((7, 8), 1.0)
    phi = grid.points()[0] + 0.3 * grid.points()[1] - 4.2
    nodes = np.arange(grid.size)
    assert area(phi, grid, nodes=nodes) > 0
    crossed = np.flatnonzero((phi[:-1, :-1] < 0) & (phi[1:, 1:] >= 0))[2]
    i, j = np.divmod(crossed, grid.shape[1] - 1)
    missing = (i + corner[0]) * grid.shape[1] + j + corner[1]
    with pytest.raises(InputError, match="too thin"):
        area(phi, grid, nodes=np.delete(nodes, missing))


@pytest.mark.parametrize(("layers", "order"), [(3.0, 3.8), (2.0, 1.8)])
def test_the_order_in_a_band_is_four_with_two_nodes_to_each_side_and_two_with_corners(
    layers, order
):
    errors = []
    for n in (32, 64, 128):
        grid = mesh(n, 2)
        near = np.abs(disk(grid)) < layers * grid.spacing
        phi = disk(grid) * (3.0 + disk(grid)) * np.exp(grid.points()[0])
        found = measures(phi, grid, nodes=np.flatnonzero(near))
        errors.append(abs(found.volume - math.pi))
    assert math.log2(errors[1] / errors[2]) > order, errors


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("ndim", [2, 3])
def test_one_pass_measures_what_each_law_does_and_a_band_stands_for_its_parts(ndim, dtype):
    grid = mesh(24, ndim)
    phi = disk(grid).astype(dtype)
    nodes = np.flatnonzero(np.abs(phi) < 4 * grid.spacing)
    band = Band(grid, nodes, phi.reshape(-1)[nodes])
    found = measures(band)
    assert found.volume == volume(band) == volume(phi, grid, nodes=nodes)
    assert found.area == area(band) == area(phi, grid, nodes=nodes)
    np.testing.assert_array_equal(found.centroid, centroid(band))
    assert integrate(np.ones(len(nodes)), band) == pytest.approx(found.area, rel=1e-12)
    assert np.isnan(measures(np.ones(grid.shape), grid).centroid).all()
    with pytest.raises(InputError, match="a band has a grid and nodes of its own"):
        volume(band, grid, nodes=nodes)
    with pytest.raises(InputError, match="needs its grid"):
        volume(phi)


@pytest.mark.parametrize("boundary", ["unbounded", "periodic"])
@pytest.mark.parametrize("ndim", [2, 3])
def test_inside_and_outside_fill_the_box(boundary, ndim):
    grid = mesh(30, ndim, boundary)
    phi = disk(grid)
    nodes = np.flatnonzero(np.abs(phi) < 3 * grid.spacing)
    box = math.prod(grid.length)
    assert volume(phi, grid) + volume(-phi, grid) == pytest.approx(box, rel=1e-12)
    both = volume(phi, grid, nodes=nodes) + volume(-phi, grid, nodes=nodes)
    assert both == pytest.approx(box, rel=1e-12)
    assert area(phi, grid) == pytest.approx(area(-phi, grid), rel=1e-12)


@pytest.mark.parametrize("ndim", [2, 3])
def test_a_shape_across_a_periodic_seam_has_its_volume(ndim):
    grid = mesh(30, ndim, "periodic")
    phi = disk(grid)
    moved = np.roll(phi, (17, 9, 21)[:ndim], range(ndim))
    nodes = np.flatnonzero(np.abs(moved) < 4 * grid.spacing)
    for found in (volume(moved, grid), volume(moved, grid, nodes=nodes)):
        assert found == pytest.approx(volume(phi, grid), rel=1e-12)
    assert area(moved, grid) == pytest.approx(area(phi, grid), rel=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rows_without_band_are_inside_or_outside_as_their_neighbours(axis):
    grid = Grid((20, 21, 22), 0.1)
    phi = grid.points()[axis] - 0.95
    nodes = np.flatnonzero(np.abs(phi) < 0.35)
    sides = [n for i, n in enumerate(grid.length) if i != axis]
    assert volume(phi, grid, nodes=nodes) == pytest.approx(0.95 * math.prod(sides), rel=1e-12)
    assert area(phi, grid, nodes=nodes) == pytest.approx(math.prod(sides), rel=1e-12)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_wall_through_nodes_counts_once(axis, sign):
    grid = Grid((9, 10, 11), 0.25)
    phi = sign * (grid.points()[axis] - 1.0)
    sides = math.prod(n for i, n in enumerate(grid.length) if i != axis)
    assert area(phi, grid) == pytest.approx(sides, rel=1e-12)
    inside = 1.0 if sign > 0 else grid.length[axis] - 1.0
    assert volume(phi, grid) == pytest.approx(inside * sides, rel=1e-12)


def test_the_slotted_sphere_has_its_volume():
    grid = Grid((41, 41, 41), 1.0)
    shape = SlottedSphere(center=(20.3, 20.1, 20.2))
    assert volume(shape.distance(grid.points()), grid) == pytest.approx(12757.888, rel=1e-3)


@pytest.mark.parametrize(("cells", "off"), [(1.0, 0.05), (1.5, 0.03), (2.0, 0.005), (3.0, 0.002)])
def test_curved_sheets_of_a_few_cells_keep_their_volume(cells, off):
    grid = Grid((40, 40, 40), 1.0)
    shift = np.array([0.3, -0.1, 0.2]).reshape(3, 1, 1, 1)
    radius = np.sqrt(((grid.points() - 19.5 - shift) ** 2).sum(axis=0))
    exact = 4 * math.pi * (13.4**2 * cells + cells**3 / 12)
    assert volume(np.abs(radius - 13.4) - cells / 2, grid) == pytest.approx(exact, rel=off)


def test_the_slotted_disk_has_its_area_on_the_usual_mesh():
    grid = Grid((100, 100), 1.0)
    shape = SlottedDisk(15.0, 5.0, 25.0, center=(50.0, 75.0))
    phi = shape.distance(grid.points())
    assert volume(phi, grid) == pytest.approx(582.2070306, rel=1e-3)
    assert area(phi, grid) == pytest.approx(143.8047, rel=3e-2)


@pytest.mark.parametrize("shape", [Box((1.3, 0.71)), Box((1.3, 0.71, 0.92))])
def test_a_box_keeps_its_volume_to_second_order(shape):
    grid = mesh(40, shape.ndim)
    found = volume(shape.distance(grid.points() - 0.0137), grid)
    assert found == pytest.approx(shape.volume, rel=5e-3)


@pytest.mark.parametrize(("cells", "off"), [(1.0, 0.06), (1.5, 0.03), (2.0, 0.005), (3.0, 0.002)])
@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 4])
def test_filaments_of_a_few_cells_keep_their_area(cells, off, angle):
    grid = Grid((60, 60), 1.0, origin=(-30.0, -30.0))
    x, y = grid.points()
    along, across = (
        x * math.cos(angle) + y * math.sin(angle),
        y * math.cos(angle) - x * math.sin(angle),
    )
    found = []
    for shift in np.linspace(0.0, 1.0, 12, endpoint=False):
        gap = np.hypot(np.maximum(np.abs(along) - 20.0, 0.0), across - shift) - cells / 2
        found.append(volume(gap, grid))
    assert np.mean(found) == pytest.approx(40 * cells + math.pi * cells**2 / 4, rel=off)


def test_small_disks_are_seen_wherever_they_are_between_the_nodes():
    grid = Grid((12, 12), 1.0)
    rng = np.random.default_rng(1)
    for radius, off in ((1.0, 0.05), (2.0, 0.005)):
        found = []
        for _ in range(30):
            shape = Disk(radius, center=tuple(rng.uniform(5.0, 6.0, 2)))
            found.append(volume(shape.distance(grid.points()), grid))
        assert np.mean(found) == pytest.approx(math.pi * radius**2, rel=off)


@pytest.mark.parametrize("ndim", [2, 3])
def test_no_random_level_set_has_more_than_the_box_or_less_than_nothing(ndim):
    grid = Grid((9,) * ndim, 1.0)
    rng = np.random.default_rng(3)
    for _ in range(5):
        phi = rng.normal(size=grid.shape)
        inside = volume(phi, grid)
        assert 0.0 < inside < 8.0**ndim
        assert inside + volume(-phi, grid) == pytest.approx(8.0**ndim, rel=1e-9)
        assert 0.0 < area(phi, grid) < 20.0 * 8.0**ndim


def test_polynomials_are_integrated_over_the_inside_and_the_surface():
    grid = mesh(48, 3)
    phi = Sphere(1.0).distance(grid.points())
    x, _, z = grid.points()
    inside = integrate(x * x + z, phi, grid, over="inside")
    assert inside == pytest.approx(4 * math.pi / 15, rel=1e-6)
    assert integrate(x * x + z, phi, grid) == pytest.approx(4 * math.pi / 3, rel=1e-6)
    nodes = np.flatnonzero(np.abs(phi) < 4 * grid.spacing)
    banded = integrate(x * x + z, phi, grid, nodes=nodes)
    assert banded == pytest.approx(integrate(x * x + z, phi, grid), rel=1e-12)


def test_integrals_over_the_inside_are_of_order_four():
    exact = 2 * math.pi * (math.sin(1.0) - (1 - math.cos(1.0)))  # of cos(r) r over the disk
    errors = []
    for n in (16, 32, 64):
        grid = mesh(n, 2)
        radius = np.sqrt(sum(x * x for x in seen(grid)))
        errors.append(abs(integrate(np.cos(radius), radius - 1.0, grid, over="inside") - exact))
    assert math.log2(errors[1] / errors[2]) > 3.8, errors


@pytest.mark.parametrize("ndim", [2, 3])
def test_the_centre_is_the_shapes(ndim):
    grid = mesh(40, ndim)
    assert centroid(disk(grid), grid) == pytest.approx(CENTER[:ndim], abs=1e-6)


@pytest.mark.parametrize("axes", [(1, 0, 2), (2, 1, 0), (0, 2, 1)])
def test_no_axis_and_no_direction_is_preferred(axes):
    grid = mesh(24, 3)
    phi = torus(grid)
    nodes = np.flatnonzero(np.abs(phi) < 3 * grid.spacing)
    known = np.zeros(grid.shape)
    known.reshape(-1)[nodes] = phi.reshape(-1)[nodes]
    turned = np.transpose(known, axes)
    for other in (turned, known[::-1], known[:, ::-1, ::-1]):
        other = np.ascontiguousarray(other)
        places = np.flatnonzero(other)
        assert volume(other, grid, nodes=places) == pytest.approx(
            volume(known, grid, nodes=nodes), rel=1e-9
        )
        assert area(other, grid, nodes=places) == pytest.approx(
            area(known, grid, nodes=nodes), rel=1e-6
        )


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_no_bit(threads):
    grid = mesh(20, 3)
    phi = torus(grid)
    assert area(phi, grid, threads=threads) == area(phi, grid, threads=1)
    assert volume(phi, grid, threads=threads) == volume(phi, grid, threads=1)


def test_one_sign_is_nothing_or_the_whole_box():
    grid = Grid((8, 9), 0.5)
    ones = np.ones(grid.shape)
    assert volume(ones, grid) == area(ones, grid) == area(-ones, grid) == 0.0
    assert volume(-ones, grid) == pytest.approx(3.5 * 4.0)
    assert volume(ones, grid, nodes=np.zeros(0, np.int64)) == 0.0
    with pytest.raises(InputError, match="an empty inside has no centre"):
        centroid(ones, grid)


def test_bad_input_is_refused():
    grid = Grid((8, 9), 0.5)
    phi = grid.points()[0] - 1.1
    with pytest.raises(InputError, match=r"phi must have shape \(8, 9\)"):
        volume(phi.T, grid)
    with pytest.raises(InputError, match="phi must be finite, it is not at 1 of 72"):
        area(np.where(np.arange(72).reshape(8, 9) == 3, np.nan, phi), grid)
    with pytest.raises(InputError, match="phi must be real numbers, got complex128"):
        volume(phi + 0j, grid)
    with pytest.raises(InputError, match="values must be real numbers, got complex128"):
        integrate(phi + 0j, phi, grid)
    with pytest.raises(InputError, match="nodes must ascend"):
        volume(phi, grid, nodes=np.array([3, 2]))
    with pytest.raises(InputError, match="the inside reaches beyond it"):
        integrate(phi, phi, grid, over="inside", nodes=np.arange(72))
    with pytest.raises(InputError, match="over must be"):
        integrate(phi, phi, grid, over="outside")
    with pytest.raises(InputError, match="values must have shape"):
        integrate(phi.T, phi, grid)
    with pytest.raises(InputError, match="values must be finite"):
        integrate(phi * np.nan, phi, grid)
    nodes = np.flatnonzero(np.abs(phi.T.reshape(9, 8)) < 0.2)
    grid = Grid((9, 8), 0.5)
    with pytest.raises(InputError, match="the band has a hole"):
        volume(np.ascontiguousarray(phi.T), grid, nodes=np.delete(np.arange(72), nodes))


def test_gauss_and_bonnet_hold_for_a_body_whose_middle_has_no_curvature():
    """int K dA = 4 pi; in the middle of an ellipsoid the level set is flat."""
    from levelset.curvatures import curvature

    grid = Grid((49, 49, 49), 1 / 16, (-1.5, -1.5, -1.5))
    phi = Ellipsoid((1.0, 0.8, 0.6)).distance(grid.points())
    bend = curvature(phi, grid, kind="gaussian", at="contour")
    bend[24, 24, 24] = np.nan
    assert integrate(bend, phi, grid) == pytest.approx(4 * math.pi, rel=2e-3)
    bend[40, 24, 24] = np.nan  # on the surface
    with pytest.raises(InputError, match="values must be finite beside the surface"):
        integrate(bend, phi, grid)
