"""Compressed fields in files: the same bits come back, and other files are refused."""

import dataclasses

import numpy as np
import pytest

from remesh.errors import InputError, StorageError
from remesh.grid import Grid
from remesh.multires.compression import compress
from remesh.multires.storage import load, save
from remesh.multires.wavelets import WAVELETS, Wavelet


def bump(grid):
    points = grid.points()
    square = sum((x - 0.4 - 0.1 * k) ** 2 for k, x in enumerate(points))
    return np.exp(-square / 0.02)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize(
    "grid",
    [
        Grid((37, 64), 1 / 64, (0.1, -0.2)),
        Grid((32, 16, 21), 1 / 32, boundary=("periodic", "unbounded", "unbounded")),
    ],
    ids=["plane", "space"],
)
def test_a_compressed_field_comes_back_bit_for_bit(tmp_path, grid, dtype):
    field = np.stack([bump(grid), -2 * bump(grid)]).astype(dtype)
    packed = compress(field, grid, tolerance=1e-3, wavelet="4.2")
    assert save(tmp_path / "field.h5", packed) == tmp_path / "field.h5"
    again = load(tmp_path / "field.h5")
    for part in dataclasses.fields(packed):
        ours, theirs = getattr(packed, part.name), getattr(again, part.name)
        if isinstance(ours, np.ndarray):
            assert ours.dtype == theirs.dtype
            assert np.array_equal(ours, theirs)
        else:
            assert ours == theirs
    assert again.wavelet is WAVELETS["4.2"]
    assert np.array_equal(again.expand(), packed.expand())
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("update", [(), ("1/4", "1/4")])
def test_a_wavelet_of_ones_own_is_kept_with_it(tmp_path, update):
    own = Wavelet("mine", 2, len(update), ("1/2", "1/2"), update, "tests")
    grid = Grid((33, 33), 1 / 32)
    packed = compress(bump(grid), grid, tolerance=1e-2, wavelet=own)
    save(tmp_path / "field.h5", packed)
    again = load(tmp_path / "field.h5")
    assert again.wavelet == own
    assert np.array_equal(again.expand(), packed.expand())


def test_a_file_is_as_small_as_the_compression_says(tmp_path):
    grid = Grid((256, 256), 1 / 256)
    packed = compress(bump(grid), grid, tolerance=1e-4)
    size = save(tmp_path / "field.h5", packed).stat().st_size
    assert size < 12 * packed.size + 60_000 < 0.2 * 8 * grid.size


def test_other_files_are_refused(tmp_path):
    import h5py

    with pytest.raises(StorageError, match="missing, cut short or damaged"):
        load(tmp_path / "nothing.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["values"] = np.ones(3)
    with pytest.raises(InputError, match="holds no compressed field"):
        load(tmp_path / "other.h5")
    grid = Grid((33, 33), 1 / 32)
    whole = save(tmp_path / "cut.h5", compress(bump(grid), grid, tolerance=1e-2))
    whole.write_bytes(whole.read_bytes()[:2000])
    with pytest.raises(StorageError, match="damaged"):
        load(whole)
    with pytest.raises(StorageError, match="cannot write"):
        save(tmp_path / "no" / "folder.h5", compress(bump(grid), grid, tolerance=1e-2))
