"""Laws of the band around a surface."""

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Ellipse, Polygon, Sphere
from levelset.solids import Capsule, Torus
from levelset.surface_band import SurfaceBand
from remesh.errors import InputError
from remesh.grid import Grid


def mesh(*half, shift=(0.31, 0.17, 0.43), boundary="unbounded"):
    """A mesh of spacing one, so that lengths are in spacings."""
    corner = [s - n for n, s in zip(half, shift, strict=False)]
    return Grid([2 * n + 1 for n in half], 1.0, corner, boundary)


def growth(surface):
    """The largest growth rate of the embedded Laplacian, and how many fields it keeps."""
    one = np.eye(len(surface.nodes))
    rates = np.linalg.eigvals(np.stack([surface.laplacian(row) for row in one], axis=1))
    return rates.real.max(), int((np.abs(rates) < 1e-9).sum())


def apart(gap, turn, radius=6.0):
    """Two disks."""
    way = (radius + 0.5 * gap) * np.array([np.cos(turn), np.sin(turn)])
    return Disk(radius, center=tuple(way)) | Disk(radius, center=tuple(-way))


@pytest.mark.parametrize("turn", [0.0, 0.6, np.pi / 4])
@pytest.mark.parametrize("gap", [2.0, 3.0, 4.0, 5.0])
def test_sheets_so_near_that_values_would_leak_or_grow_are_refused(gap, turn):
    with pytest.raises(InputError, match="two sheets of the surface are too close"):
        SurfaceBand.around(apart(gap, turn), mesh(21, 21))


@pytest.mark.parametrize(("gap", "turn"), [(6.0, 0.0), (6.7, 0.6), (7.3, np.pi / 4)])
def test_what_is_not_refused_neither_leaks_nor_grows(gap, turn):
    try:
        surface = SurfaceBand.around(apart(gap, turn, 4.5), mesh(18, 18))
    except InputError:
        assert gap < 7.2
        assert turn
        return
    fastest, kept = growth(surface)
    assert fastest < 1e-12
    assert kept == 2  # a constant on either disk
    assert len(surface.parts) == 2


@pytest.mark.parametrize("thick", [1.0, 2.0, 3.0, 4.0, 5.0])
def test_thin_parts_are_refused_aligned_with_the_mesh_or_not(thick):
    for shift in ((0.0, 0.0), (0.31, 0.17), (0.0, 0.5)):
        for shape in (Capsule((-9.0, 0.0), (9.0, 0.0), 0.5 * thick), Box((20.0, thick))):
            grid = mesh(19, 12, shift=shift)
            with pytest.raises(InputError, match=r"two sheets|one sign"):
                SurfaceBand.around(shape, grid)


def test_near_sheets_are_refused_in_space_and_across_a_periodic_seam():
    pair = Sphere(6.0, center=(-8.0, 0.0, 0.0)) | Sphere(6.0, center=(8.0, 0.0, 0.0))
    with pytest.raises(InputError, match=r"too close for the mesh, near \(-?2"):
        SurfaceBand.around(pair, mesh(21, 13, 13))
    grid = Grid((20, 27), 1.0, (-10.0, -13.2), ("periodic", "unbounded"))
    x, y = grid.points()
    with pytest.raises(InputError, match="two sheets"):  # a disk beside its own copy
        SurfaceBand.around(np.hypot(x, y) - 8.0, grid)


@pytest.mark.parametrize("shape", [
    Disk(4.0), Ellipse((12.0, 6.0)), Box((16.0, 12.0)).moved(angle=0.3),
    Polygon([(-12.0, -8.0), (12.0, -8.0), (0.0, 12.0)]),
])  # fmt: skip
def test_round_and_cornered_parts_that_the_mesh_sees_are_taken(shape):
    surface = SurfaceBand.around(shape, mesh(18, 18))
    fastest, kept = growth(surface)
    assert fastest < 1e-12
    assert kept == 1
    assert len(surface.parts) == 1


def test_parts_are_told_apart_and_measured_apart():
    shell = Sphere(13.0) - Sphere(4.5)
    surface = SurfaceBand.around(shell, mesh(19, 19, 19))
    assert sum(len(part) for part in surface.parts) == len(surface.nodes)
    np.testing.assert_allclose(
        np.sort(surface.areas), 4 * np.pi * np.array([4.5, 13.0]) ** 2, rtol=2e-3
    )
    assert surface.area == pytest.approx(surface.areas.sum())
    for part in surface.parts:
        radius = np.linalg.norm(surface.closest[part], axis=1)
        assert np.ptp(radius) < 0.1
    assert len(SurfaceBand.around(Torus(12.0, 6.0), mesh(24, 24, 12)).parts) == 1


def test_a_line_across_a_periodic_seam_is_one_part():
    grid = Grid((16, 21), 1.0, (0.0, -10.2), ("periodic", "unbounded"))
    _, y = grid.points()
    surface = SurfaceBand.around(y, grid)
    assert len(surface.parts) == 1
    assert surface.area == pytest.approx(16.0)
