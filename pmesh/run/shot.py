"""One snapshot on the disk: fields on a uniform grid as a VTKHDF image."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pmesh.run.files import reading, write_atomic
from remesh.errors import InputError
from remesh.grid import Grid

LIBRARY = ("v110", "v110")  # the oldest HDF5 with all that is used here, for old readers
Names = Mapping[str, tuple[int, np.dtype[Any]]]  # of fields: components (0: scalar), dtype


@dataclass(frozen=True)
class Snapshot:
    """One snapshot on the disk; its fields are read when asked for."""

    path: Path
    step: int
    time: float  # [T]
    grid: Grid
    names: Names

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A field: a scalar of ``grid.shape``, or a vector ``(ndim, *grid.shape)``."""
        self.check(name)
        with reading(self.path), h5py.File(self.path, "r") as file:
            data: NDArray[Any] = file["VTKHDF/PointData"][name][()]
        if not self.names[name][0]:
            return np.ascontiguousarray(data.T)
        return np.ascontiguousarray(data.T[: self.grid.ndim])

    def check(self, name: str) -> None:
        """Refuse a name that the snapshot does not hold."""
        if name not in self.names:
            raise InputError(
                f"the snapshot holds {sorted(self.names)}, got {name!r}", hint="one of these names"
            )


def write_snapshot(
    path: Path, grid: Grid, fields: Mapping[str, NDArray[Any]], step: int, time: float
) -> Snapshot:
    """Write fields on one grid as a VTKHDF image: scalars, and vectors of 3 components."""
    names: dict[str, tuple[int, np.dtype[Any]]] = {}
    image = io.BytesIO()
    with h5py.File(image, "w", libver=LIBRARY) as file:
        root = image_group(file, grid.shape, grid.origin, grid.spacing)
        file.attrs.update(step=step, time=time, boundary=list(grid.boundary))
        data = root.create_group("PointData")
        for name, field in fields.items():
            if field.shape not in (grid.shape, (grid.ndim, *grid.shape)):
                raise InputError(
                    f"the field {name!r} must have the grid's shape {grid.shape}, or one such per "
                    f"component, got {field.shape}",
                    hint=f"scalars {grid.shape}, vectors {(grid.ndim, *grid.shape)}",
                )
            vector = field.ndim > grid.ndim
            names[name] = (3 if vector else 0, field.dtype)
            data[name] = _three(field).T if vector else field.T  # VTK: x runs fastest
    write_atomic(path, image.getbuffer())
    return Snapshot(path, step, time, grid, names)


def image_group(
    file: h5py.File, shape: Sequence[int], origin: Sequence[float], spacing: float
) -> h5py.Group:
    """The group that makes a file a VTKHDF image; VTK always counts three axes."""
    flat = 3 - len(shape)
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0])
    root.attrs.create("Type", b"ImageData", dtype=h5py.string_dtype("ascii", 9))
    root.attrs["WholeExtent"] = np.array([(0, n - 1) for n in (*shape, *(1,) * flat)]).ravel()
    root.attrs["Origin"] = np.array([*origin, *(0.0,) * flat])
    root.attrs["Spacing"] = np.full(3, spacing)
    root.attrs["Direction"] = np.eye(3).ravel()
    return root


def _three(vector: NDArray[Any]) -> NDArray[Any]:
    """A vector field with a third component, which is zero in the plane; in space as it is."""
    missing = 3 - vector.shape[0]
    if not missing:
        return vector
    return np.concatenate([vector, np.zeros((missing, *vector.shape[1:]), vector.dtype)])


def read_snapshot(path: Path) -> Snapshot:
    """Where a snapshot is, what it holds and on which grid; the fields stay on the disk."""
    with reading(path), h5py.File(path, "r") as file:
        root = file["VTKHDF"]
        if root.attrs["Type"] == b"OverlappingAMR":
            from pmesh.run.amr import read_blocks

            return read_blocks(path, file)
        data = root["PointData"]
        boundary = [str(word) for word in file.attrs["boundary"]]
        ndim = len(boundary)
        grid = Grid(
            shape=[int(n) + 1 for n in root.attrs["WholeExtent"][1 : 2 * ndim : 2]],
            spacing=float(root.attrs["Spacing"][0]),
            origin=[float(x) for x in root.attrs["Origin"][:ndim]],
            boundary=boundary,  # type: ignore[arg-type]
        )
        names = {name: (3 if field.ndim > ndim else 0, field.dtype) for name, field in data.items()}
        return Snapshot(path, int(file.attrs["step"]), float(file.attrs["time"]), grid, names)
