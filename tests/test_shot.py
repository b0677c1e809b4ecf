"""One snapshot on the disk: what comes back, and what is refused."""

import h5py
import numpy as np
import pytest

from pmesh.run.shot import Snapshot, image_group, read_snapshot, write_snapshot
from remesh.errors import InputError, StorageError
from remesh.grid import Grid

GRIDS = [
    Grid((6, 5), 0.5, (-1.0, 2.0), ("periodic", "unbounded")),
    Grid((5, 4, 6), 0.25, (-1.0, 2.0, 0.5)),
]


def fields_on(grid):
    rng = np.random.default_rng(1)
    return {
        "w": rng.standard_normal(grid.shape),
        "u": rng.standard_normal((grid.ndim, *grid.shape)).astype(np.float32),
        "chi": (rng.random(grid.shape) > 0.5).astype(np.uint8),
    }


@pytest.mark.parametrize("grid", GRIDS)
def test_what_is_written_is_what_is_read_with_its_place_and_time(grid, tmp_path):
    given = fields_on(grid)
    written = write_snapshot(tmp_path / "1.vtkhdf", grid, given, 7, 0.125)
    found = read_snapshot(tmp_path / "1.vtkhdf")
    assert found == written
    assert (found.step, found.time, found.grid) == (7, 0.125, grid)
    assert found.names == {"w": (0, np.dtype("f8")), "u": (3, np.dtype("f4")),
                           "chi": (0, np.dtype("u1"))}  # fmt: skip
    for name, values in given.items():
        np.testing.assert_array_equal(found[name], values)
        assert found[name].flags.c_contiguous


def test_a_plane_vector_is_stored_with_a_third_component_of_zeros(tmp_path):
    write_snapshot(tmp_path / "1.vtkhdf", GRIDS[0], fields_on(GRIDS[0]), 0, 0.0)
    with h5py.File(tmp_path / "1.vtkhdf") as file:
        assert not file["VTKHDF/PointData/u"][..., 2].any()
        assert file["VTKHDF/PointData/u"].shape == (5, 6, 3)


@pytest.mark.parametrize("shape", [(6,), (5, 6), (3, 6, 5), (6, 5, 2)])
def test_a_field_of_another_shape_is_refused_and_nothing_is_written(shape, tmp_path):
    with pytest.raises(InputError, match="'w' must have the grid's shape"):
        write_snapshot(tmp_path / "1.vtkhdf", GRIDS[0], {"w": np.zeros(shape)}, 0, 0.0)
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_is_not_there_and_a_file_that_is_none_are_refused(tmp_path):
    shot = write_snapshot(tmp_path / "1.vtkhdf", GRIDS[0], fields_on(GRIDS[0]), 0, 0.0)
    with pytest.raises(InputError, match="got 'v'"):
        shot["v"]
    (tmp_path / "2.vtkhdf").write_bytes(b"no such image")
    with pytest.raises(StorageError):
        read_snapshot(tmp_path / "2.vtkhdf")
    (tmp_path / "1.vtkhdf").unlink()
    with pytest.raises(StorageError):
        _ = shot["w"]
    assert isinstance(shot, Snapshot)


@pytest.mark.parametrize("grid", GRIDS)
def test_an_image_always_counts_three_axes(grid, tmp_path):
    with h5py.File(tmp_path / "image", "w") as file:
        root = image_group(file, grid.shape, grid.origin, grid.spacing)
        extent = root.attrs["WholeExtent"]
        assert list(extent[::2]) == [0, 0, 0]
        assert list(extent[1::2] + 1) == [*grid.shape, *(1,) * (3 - grid.ndim)]
        assert len(root.attrs["Origin"]) == len(root.attrs["Spacing"]) == 3
