"""Fields from files: arrays, HDF5 datasets, snapshots of runs, images."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError, StorageError
from remesh.grid import Grid

ARRAYS = (".npy", ".npz")
HDF5 = (".h5", ".hdf5", ".hdf")
SNAPSHOTS = (".vtkhdf",)
IMAGES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".gif", ".webp")
DAMAGED = (OSError, ValueError, EOFError, KeyError, RuntimeError, zlib.error, zipfile.BadZipFile)
LUMINANCE = (0.2126, 0.7152, 0.0722)  # of red, green and blue: ITU-R BT.709

Field = tuple[NDArray[np.float64], Grid]


def read_field(path: str | Path, dataset: str = "", boundary: str = "unbounded") -> Field:
    """A field and its grid from a file.

    ``.npy``; ``.npz`` and HDF5, of which ``dataset`` names the array (the only one if it is
    empty); a run's ``.vtkhdf``: a snapshot, or the index, which means its last one; images as
    luminance, x to the right and y up. Arrays are ``(nx, ny)`` or ``(nx, ny, nz)``, with up to 3
    components in front; their longest side is 1. Refuses other files, and values that are not
    finite.
    """
    found = Path(path)
    kind = found.suffix.lower()
    if kind not in (*ARRAYS, *HDF5, *SNAPSHOTS, *IMAGES):
        known = ", ".join((*ARRAYS, *HDF5, *SNAPSHOTS, *IMAGES))
        raise InputError(f"cannot tell what {found} is", hint=f"a file that ends in {known}")
    if not found.is_file():
        raise InputError(f"there is no file {found}", hint="--file path/to/field.npy")
    if kind in SNAPSHOTS:
        field, grid = _from_run(found, dataset)
    else:
        values = _image(found) if kind in IMAGES else _array(found, kind, dataset)
        field, grid = _on_grid(found, values, boundary)
    if not np.isfinite(field).all():
        raise InputError(
            f"{found} holds values that are not finite", hint="np.nan_to_num, or a part of it"
        )
    return field, grid


def _array(path: Path, kind: str, dataset: str) -> NDArray[Any]:
    try:
        if kind == ".npy":
            return np.asarray(np.load(path))
        if kind == ".npz":
            with path.open("rb") as whole, np.load(whole) as found:
                return np.asarray(found[_chosen(path, list(found), dataset)])
        import h5py

        with h5py.File(path, "r") as file:
            names: list[str] = []
            file.visititems(lambda name, item: names.append(name) if _holds(item) else None)
            return np.asarray(file[_chosen(path, names, dataset)][()])
    except DAMAGED as error:
        if isinstance(error, InputError):
            raise
        raise StorageError(f"cannot read {path}: {error}", hint="a whole file") from error


def _holds(item: Any) -> bool:
    """Whether an item of an HDF5 file may be a field."""
    return hasattr(item, "shape") and 2 <= len(item.shape) <= 4 and item.dtype.kind in "fiub"


def _chosen(path: Path, names: list[str], dataset: str) -> str:
    if dataset in names or (not dataset and len(names) == 1):
        return dataset or names[0]
    given = f"no array {dataset!r}" if dataset else f"{len(names)} arrays"
    listed = ", ".join(names[:8]) or "none"
    raise InputError(f"{path} holds {given}", hint=f"--dataset, one of: {listed}")


def _image(path: Path) -> NDArray[Any]:
    from matplotlib.image import imread

    try:
        pixels = np.asarray(imread(path))
    except (OSError, ValueError, SyntaxError) as error:
        raise StorageError(f"cannot read {path}: {error}", hint="a whole image") from error
    whole = 255.0 if pixels.dtype.kind in "ui" else 1.0
    values = pixels.astype(np.float64) / whole
    grey = (
        values[..., :3] @ np.array(LUMINANCE)
        if values.ndim == 3 and values.shape[2] > 2
        else (values[..., 0] if values.ndim == 3 else values)
    )
    return np.ascontiguousarray(grey[::-1].T)


def _on_grid(path: Path, values: NDArray[Any], boundary: str) -> Field:
    ndim = values.ndim
    if ndim in (3, 4) and values.shape[0] <= 3:
        ndim -= 1
    shape = values.shape[values.ndim - ndim :]
    if values.dtype.kind not in "fiub" or ndim not in (2, 3) or values.ndim > 4 or min(shape) < 4:
        raise InputError(
            f"{path} holds {values.dtype} values of shape {values.shape}, which are no field",
            hint="numbers of shape (nx, ny), (nx, ny, nz), or up to 3 of them in front",
        )
    sides: Any = boundary
    grid = Grid(shape, 1.0 / max(shape), boundary=sides)
    return np.ascontiguousarray(values, np.float64), grid


def _from_run(path: Path, dataset: str) -> Field:
    import h5py

    from pmesh.run.files import reading
    from pmesh.run.snapshots import read_snapshot, read_snapshots

    with reading(path), h5py.File(path, "r") as file:
        single = "step" in file.attrs
    shots = [read_snapshot(path)] if single else read_snapshots(path.parent, path.stem)
    if not shots:
        raise InputError(f"there are no snapshots beside {path}", hint="fields/<step>.vtkhdf")
    shot = shots[-1]
    name = dataset or ("vorticity" if "vorticity" in shot.names else "")
    return np.asarray(shot[_chosen(path, list(shot.names), name)], np.float64), shot.grid
