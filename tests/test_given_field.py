"""Fields from files: each format gives the values that it holds, where it holds them."""

import h5py
import numpy as np
import pytest

from pmesh.cases.given_field import read_field
from pmesh.run.amr import write_blocks
from pmesh.run.snapshots import write_snapshot
from remesh.errors import InputError, StorageError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh

VALUES = np.random.default_rng(0).standard_normal((12, 20))


def test_arrays_come_as_they_are_on_a_box_of_longest_side_1(tmp_path):
    np.save(tmp_path / "a.npy", VALUES.astype(np.float32))
    field, grid = read_field(tmp_path / "a.npy", boundary="periodic")
    assert grid == Grid((12, 20), 1 / 20, boundary="periodic")
    assert field.dtype == np.float64
    assert np.array_equal(field, VALUES.astype(np.float32))


@pytest.mark.parametrize("shape", [(6, 8), (2, 6, 8), (4, 6, 8), (3, 4, 6, 8)])
def test_components_stand_in_front(tmp_path, shape):
    np.save(tmp_path / "a.npy", np.ones(shape))
    field, grid = read_field(tmp_path / "a.npy")
    assert field.shape == shape
    assert grid.ndim == (2 if shape in ((6, 8), (2, 6, 8)) else 3)


def test_one_of_several_arrays_is_named(tmp_path):
    np.savez(tmp_path / "a.npz", w=VALUES, u=2 * VALUES)
    assert np.array_equal(read_field(tmp_path / "a.npz", "u")[0], 2 * VALUES)
    with pytest.raises(InputError, match="holds 2 arrays"):
        read_field(tmp_path / "a.npz")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["flow/w"] = VALUES
        file["times"] = np.arange(3.0)
    assert np.array_equal(read_field(tmp_path / "a.h5")[0], VALUES)
    with pytest.raises(InputError, match="no array 'q'"):
        read_field(tmp_path / "a.h5", "q")


def test_snapshots_keep_their_grid_and_an_index_means_its_last(tmp_path):
    grid = Grid((12, 20), 0.25, (-1.0, 2.0))
    (tmp_path / "fields").mkdir()
    for step in (0, 1):
        fields = {"vorticity": (1 + step) * VALUES, "chi": VALUES}
        write_snapshot(tmp_path / f"fields/0000000{step}.vtkhdf", grid, fields, step, step)
    field, found = read_field(tmp_path / "fields/00000000.vtkhdf")
    assert found == grid
    assert np.array_equal(field, VALUES)
    with h5py.File(tmp_path / "fields.vtkhdf", "w"):
        pass
    assert np.array_equal(read_field(tmp_path / "fields.vtkhdf")[0], 2 * VALUES)


def test_snapshots_on_blocks_are_told_on_their_finest_grid(tmp_path):
    mesh = AdaptiveMesh(grid=Grid((32, 32), 1.0, boundary="periodic"), levels=1, block=8)
    blocks = Blocks.uniform(mesh, 0)
    write_blocks(tmp_path / "a.vtkhdf", blocks, {"w": np.ones(blocks.shape)}, 0, 0.0)
    field, grid = read_field(tmp_path / "a.vtkhdf")
    assert grid == mesh.grid
    np.testing.assert_allclose(field, 1.0)


def test_images_are_luminance_with_y_up(tmp_path):
    from matplotlib.image import imsave

    pixels = np.zeros((10, 16, 3))
    pixels[0, :, 1] = 1.0  # the top row is green
    imsave(tmp_path / "a.png", pixels)
    field, grid = read_field(tmp_path / "a.png")
    assert grid.shape == (16, 10)
    np.testing.assert_allclose(field[:, -1], 0.7152)
    assert not field[:, :-1].any()


def test_what_is_no_field_is_refused(tmp_path):
    with pytest.raises(InputError, match="cannot tell what"):
        read_field(tmp_path / "a.txt")
    with pytest.raises(InputError, match="there is no file"):
        read_field(tmp_path / "a.npy")
    (tmp_path / "b.npy").write_bytes(b"\x93NUMPY cut")
    with pytest.raises(StorageError, match="cannot read"):
        read_field(tmp_path / "b.npy")
    (tmp_path / "c.png").write_bytes(b"no picture")
    np.savez_compressed(tmp_path / "f.npz", a=np.random.default_rng(1).normal(size=(40, 40)))
    whole = (tmp_path / "f.npz").read_bytes()
    middle = len(whole) // 2
    for broken in (whole[:middle], whole[:middle] + bytes(400) + whole[middle + 400 :]):
        (tmp_path / "f.npz").write_bytes(broken)
        with pytest.raises(StorageError, match="cannot read"):
            read_field(tmp_path / "f.npz")
    with pytest.raises(StorageError, match="cannot read"):
        read_field(tmp_path / "c.png")
    for bad in (np.ones(5), np.ones((2, 3)), np.ones((5, 6, 7, 8)), np.full((5, 5), "x")):
        np.save(tmp_path / "d.npy", bad)
        with pytest.raises(InputError, match="are no field"):
            read_field(tmp_path / "d.npy")
    np.save(tmp_path / "e.npy", np.full((8, 8), np.nan))
    with pytest.raises(InputError, match="not finite"):
        read_field(tmp_path / "e.npy")
