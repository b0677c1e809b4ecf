"""Snapshots of the fields that ParaView, VTK and h5py open as they are.

Each snapshot is a VTKHDF image of its own, ``fields/<step>.vtkhdf``, on the grid of its moment.
Fields on the blocks of an adaptive mesh are VTKHDF overlapping AMR instead, see `pmesh.run.amr`.
The index ``fields.vtkhdf`` is one temporal VTKHDF image over the smallest box that holds them all:
its arrays are HDF5 virtual datasets that point into the snapshots, so it stays small, and where a
snapshot has no nodes, because the domain grew or moved, it reads NaN. A kill at any moment leaves
whole files: each is written beside its place and renamed.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pmesh.run.files import make_folder, reading, storing, write_atomic
from pmesh.run.protocols import Moment
from pmesh.run.rundir import FIELDS, SNAPSHOTS
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


class Snapshots:
    """A watcher that writes the flow's fields at every multiple of ``every`` [T], and at the start.

    ``fields`` names the fields to write, all of them by default; ``dtype`` (such as "float32") what
    they are stored as. Costs one copy of the fields per snapshot.
    """

    def __init__(
        self, every: float, *, fields: Sequence[str] | None = None, dtype: str | None = None
    ) -> None:
        if not (math.isfinite(every) and every > 0):
            raise InputError(
                f"every must be a positive time, got {every}", hint="Snapshots(every=0.1)"
            )
        self.every = float(every)
        self.fields = None if fields is None else tuple(fields)
        self.dtype = None if dtype is None else np.dtype(dtype)
        self._written: list[Snapshot] = []

    def open(self, moment: Moment) -> None:
        """Find the snapshots of the earlier part of the run; forget those that come after it."""
        if moment.out is None:
            raise InputError("Snapshots need a run directory", hint="run(..., out='out/my-run')")
        make_folder(moment.out / SNAPSHOTS)
        self._written = []
        for path in sorted((moment.out / SNAPSHOTS).glob("*.vtkhdf")):
            if int(path.stem) > moment.step:
                with storing(path):
                    path.unlink()
            else:
                self._written.append(read_snapshot(path))
        write_index(moment.out, self._written)

    def __call__(self, moment: Moment) -> None:
        """Write a snapshot if it is time for one."""
        if moment.out is None or not moment.on(self.every):
            return
        fields = self._chosen(moment.flow.fields(moment.state))
        path = moment.out / SNAPSHOTS / f"{moment.step:08d}.vtkhdf"
        snapshot = _written(path, moment, fields)
        self._written = [s for s in self._written if s.step < moment.step] + [snapshot]
        write_index(moment.out, self._written)

    def close(self) -> None:
        """Nothing is left open between snapshots."""

    def _chosen(self, fields: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        names = tuple(fields) if self.fields is None else self.fields
        if missing := [name for name in names if name not in fields]:
            raise InputError(
                f"the flow has the fields {sorted(fields)}, got {missing}",
                hint="one of these names",
            )
        kept = {name: np.asarray(fields[name]) for name in names}
        return {
            name: field.astype(np.uint8 if field.dtype == bool else self.dtype or field.dtype)
            for name, field in kept.items()
        }


def _written(path: Path, moment: Moment, fields: Mapping[str, NDArray[Any]]) -> Snapshot:
    """The snapshot of a moment, written: on the state's blocks if it has some, else on its grid."""
    blocks = getattr(moment.state, "blocks", None)
    if blocks is None:
        return write_snapshot(path, moment.state.grid, fields, moment.step, moment.time)
    from pmesh.run.amr import write_blocks

    return write_blocks(path, blocks, fields, moment.step, moment.time)


def write_snapshot(
    path: Path, grid: Grid, fields: Mapping[str, NDArray[Any]], step: int, time: float
) -> Snapshot:
    """Write fields on one grid as a VTKHDF image: scalars, and vectors of 3 components."""
    names: dict[str, tuple[int, np.dtype[Any]]] = {}
    image = io.BytesIO()
    with h5py.File(image, "w", libver=LIBRARY) as file:
        root = _image(file, grid.shape, grid.origin, grid.spacing)
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


def write_index(folder: Path, snapshots: Sequence[Snapshot]) -> None:
    """Write the index ``fields.vtkhdf``: all snapshots as one image that changes with time."""
    if not snapshots:
        with storing(folder / FIELDS):
            (folder / FIELDS).unlink(missing_ok=True)
        return
    if any(hasattr(snapshot, "blocks") for snapshot in snapshots):
        from pmesh.run.amr import write_block_index

        write_block_index(folder, snapshots)
        return
    starts = [_offset(s.grid, snapshots[0].grid) for s in snapshots]
    first = tuple(min(axis) for axis in zip(*starts, strict=True))
    ends = [tuple(np.add(a, s.grid.shape)) for a, s in zip(starts, snapshots, strict=True)]
    shape = tuple(int(max(e) - a) for e, a in zip(zip(*ends, strict=True), first, strict=True))
    grid = snapshots[0].grid
    origin = tuple(o + a * grid.spacing for o, a in zip(grid.origin, first, strict=True))
    image = io.BytesIO()
    with h5py.File(image, "w", libver=LIBRARY) as file:
        root = _image(file, shape, origin, grid.spacing)
        data, times = root.create_group("PointData"), root.create_group("Steps")
        times.attrs["NSteps"] = len(snapshots)
        times["Values"] = [s.time for s in snapshots]
        for name, (components, dtype) in snapshots[-1].names.items():
            tail = (components,) if components else ()
            layout = h5py.VirtualLayout((len(snapshots), *shape[::-1], *tail), dtype=dtype)
            for k, (start, s) in enumerate(zip(starts, snapshots, strict=True)):
                if s.names.get(name) != (components, dtype):
                    continue
                low = np.subtract(start, first)
                box = tuple(slice(a, a + n) for a, n in zip(low, s.grid.shape, strict=True))
                layout[(k, *box[::-1])] = h5py.VirtualSource(
                    f"{SNAPSHOTS}/{s.path.name}",
                    f"VTKHDF/PointData/{name}",
                    shape=(*s.grid.shape[::-1], *tail),
                    dtype=dtype,
                )
            fill = np.nan if dtype.kind == "f" else 0
            data.create_virtual_dataset(name, layout, fillvalue=fill)
            times[f"PointDataOffsets/{name}"] = np.arange(len(snapshots))
    write_atomic(folder / FIELDS, image.getbuffer())


def _image(
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
    """A vector field with a third component, which is zero in the plane."""
    missing = 3 - vector.shape[0]
    return np.concatenate([vector, np.zeros((missing, *vector.shape[1:]), vector.dtype)])


def _offset(grid: Grid, lattice: Grid) -> tuple[int, ...]:
    """Where a grid starts on the lattice of another one, in nodes."""
    away = np.subtract(grid.origin, lattice.origin) / lattice.spacing
    if grid.spacing != lattice.spacing or np.abs(away - np.rint(away)).max() > 1e-6:
        raise InputError(
            f"all snapshots of a run must share one lattice, got spacing {grid.spacing} and "
            f"origin {grid.origin} after {lattice.spacing} and {lattice.origin}",
            hint="grow and move the domain by whole cells",
        )
    return tuple(int(n) for n in np.rint(away))


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


def read_snapshots(folder: str | Path) -> list[Snapshot]:
    """The snapshots of a run directory in the order of their times."""
    return [read_snapshot(path) for path in sorted((Path(folder) / SNAPSHOTS).glob("*.vtkhdf"))]
