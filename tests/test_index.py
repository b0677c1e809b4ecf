"""The index of a run's snapshots: one image over the smallest box that holds them all."""

import h5py
import numpy as np
import pytest

from pmesh.run.index import write_index
from pmesh.run.shot import write_snapshot
from remesh.errors import InputError
from remesh.grid import Grid

H = 0.5


def shot_on(folder, shape, origin, step, **fields):
    """A snapshot whose fields, if none are given, tell the place of each node."""
    (folder / "fields").mkdir(exist_ok=True)
    grid = Grid(shape, H, origin)
    fields = fields or {"w": grid.points()[0] + 100 * grid.points()[1]}
    path = folder / "fields" / f"{step:08d}.vtkhdf"
    return write_snapshot(path, grid, fields, step, 0.25 * step)


def test_a_mesh_that_moves_and_grows_lies_in_one_image_with_nothing_where_it_was_not(tmp_path):
    shots = [
        shot_on(tmp_path, (4, 4), (0.0, 0.0), 0),
        shot_on(tmp_path, (5, 4), (-1.0, 0.5), 1),
        shot_on(tmp_path, (4, 5), (1.0, -0.5), 2),
    ]
    write_index(tmp_path, shots)
    with h5py.File(tmp_path / "fields.vtkhdf") as file:
        root = file["VTKHDF"]
        assert list(root["Steps/Values"]) == [0.0, 0.25, 0.5]
        assert list(root.attrs["Origin"]) == [-1.0, -0.5, 0.0]
        assert list(root.attrs["WholeExtent"]) == [0, 7, 0, 5, 0, 0]
        whole = root["PointData/w"][()]
    x = -1.0 + H * np.arange(8)
    y = -0.5 + H * np.arange(6)
    place = x[None, :] + 100 * y[:, None]
    for image, shot in zip(whole, shots, strict=True):
        seen = np.isfinite(image)
        assert seen.sum() == shot.grid.size
        np.testing.assert_allclose(image[seen], place[seen], atol=1e-12)
        assert (x[seen.any(axis=0)][0], y[seen.any(axis=1)][0]) == shot.grid.origin


def test_a_field_that_an_earlier_snapshot_does_not_hold_reads_as_nothing_there(tmp_path):
    ones = np.ones((4, 4))
    shots = [
        shot_on(tmp_path, (4, 4), (0.0, 0.0), 0, w=ones),
        shot_on(tmp_path, (4, 4), (0.0, 0.0), 1, w=ones, chi=ones.astype(np.uint8)),
    ]
    write_index(tmp_path, shots)
    with h5py.File(tmp_path / "fields.vtkhdf") as file:
        chi = file["VTKHDF/PointData/chi"][()]
    assert not chi[0].any()
    assert (chi[1] == 1).all()


def test_the_image_of_a_block_in_space_is_that_block(tmp_path):
    grid = Grid((4, 6, 5), H)
    values = np.random.default_rng(2).standard_normal((3, *grid.shape))
    write_index(tmp_path, [shot_on(tmp_path, grid.shape, grid.origin, 0, u=values)])
    with h5py.File(tmp_path / "fields.vtkhdf") as file:
        np.testing.assert_array_equal(file["VTKHDF/PointData/u"][0].T, values)


@pytest.mark.parametrize(
    ("spacing", "origin"), [(H, (0.2, 0.0)), (0.25, (0.0, 0.0))], ids=["shifted", "finer"]
)
def test_another_lattice_is_refused(spacing, origin, tmp_path):
    first = shot_on(tmp_path, (4, 4), (0.0, 0.0), 0)
    grid = Grid((4, 4), spacing, origin)
    path = tmp_path / "fields" / "00000001.vtkhdf"
    other = write_snapshot(path, grid, {"w": np.zeros((4, 4))}, 1, 0.25)
    with pytest.raises(InputError, match="one lattice"):
        write_index(tmp_path, [first, other])
    assert not (tmp_path / "fields.vtkhdf").exists()


def test_without_snapshots_there_is_no_index(tmp_path):
    write_index(tmp_path, [])
    write_index(tmp_path, [shot_on(tmp_path, (4, 4), (0.0, 0.0), 0)])
    assert (tmp_path / "fields.vtkhdf").exists()
    write_index(tmp_path, [])
    assert not (tmp_path / "fields.vtkhdf").exists()
