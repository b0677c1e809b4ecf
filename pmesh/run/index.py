"""The index of a run's snapshots: one VTKHDF image that changes with time."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np

from pmesh.run.files import storing, write_atomic
from pmesh.run.rundir import SNAPSHOTS
from pmesh.run.shot import LIBRARY, Snapshot, image_group
from remesh.errors import InputError
from remesh.grid import Grid


def write_index(folder: Path, snapshots: Sequence[Snapshot], name: str = SNAPSHOTS) -> None:
    """Write the index ``fields.vtkhdf``: all snapshots as one image that changes with time."""
    path = folder / f"{name}.vtkhdf"
    if not snapshots:
        with storing(path):
            path.unlink(missing_ok=True)
        return
    if any(hasattr(snapshot, "blocks") for snapshot in snapshots):
        from pmesh.run.amr import write_block_index

        write_block_index(folder, snapshots, name)
        return
    starts = [_offset(s.grid, snapshots[0].grid) for s in snapshots]
    first = tuple(min(axis) for axis in zip(*starts, strict=True))
    ends = [tuple(np.add(a, s.grid.shape)) for a, s in zip(starts, snapshots, strict=True)]
    shape = tuple(int(max(e) - a) for e, a in zip(zip(*ends, strict=True), first, strict=True))
    grid = snapshots[0].grid
    origin = tuple(o + a * grid.spacing for o, a in zip(grid.origin, first, strict=True))
    image = io.BytesIO()
    with h5py.File(image, "w", libver=LIBRARY) as file:
        root = image_group(file, shape, origin, grid.spacing)
        data, times = root.create_group("PointData"), root.create_group("Steps")
        times.attrs["NSteps"] = len(snapshots)
        times["Values"] = [s.time for s in snapshots]
        for field, (components, dtype) in snapshots[-1].names.items():
            tail = (components,) if components else ()
            layout = h5py.VirtualLayout((len(snapshots), *shape[::-1], *tail), dtype=dtype)
            for k, (start, s) in enumerate(zip(starts, snapshots, strict=True)):
                if s.names.get(field) != (components, dtype):
                    continue
                low = np.subtract(start, first)
                box = tuple(slice(a, a + n) for a, n in zip(low, s.grid.shape, strict=True))
                layout[(k, *box[::-1])] = h5py.VirtualSource(
                    f"{name}/{s.path.name}",
                    f"VTKHDF/PointData/{field}",
                    shape=(*s.grid.shape[::-1], *tail),
                    dtype=dtype,
                )
            fill = np.nan if dtype.kind == "f" else 0
            data.create_virtual_dataset(field, layout, fillvalue=fill)
            times[f"PointDataOffsets/{field}"] = np.arange(len(snapshots))
    write_atomic(path, image.getbuffer())


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
