"""Snapshots of the fields that ParaView, VTK and h5py open as they are.

Each snapshot is a VTKHDF image of its own, ``fields/<step>.vtkhdf``, on the grid of its moment or
on every second, fourth, ... node of it, then in a folder and an index of its own (``fields-2``).
Fields on the blocks of an adaptive mesh are VTKHDF overlapping AMR instead, see `pmesh.run.amr`.
The index ``fields.vtkhdf`` is one temporal VTKHDF image over the smallest box that holds them all:
its arrays are HDF5 virtual datasets that point into the snapshots, so it stays small, and where a
snapshot has no nodes, because the domain grew or moved, it reads NaN. A kill at any moment leaves
whole files: each is written beside its place and renamed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.run.files import make_folder, storing
from pmesh.run.index import write_index
from pmesh.run.protocols import Moment
from pmesh.run.rundir import SNAPSHOTS
from pmesh.run.shot import Snapshot, read_snapshot, write_snapshot
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.halving import halved, halved_grid

__all__ = [
    "Snapshot",
    "Snapshots",
    "read_snapshot",
    "read_snapshots",
    "snapshot_names",
    "write_index",
    "write_snapshot",
]

REDUCED = (1, 2, 4, 8, 16)
NAME = re.compile(r"fields(-\w+)?")


class Snapshots:
    """A watcher that writes the flow's fields at every multiple of ``every`` [T], and at the start.

    ``fields`` names the fields to write, all of them by default: of a flow that computes fields
    when they are asked for, the others cost nothing. ``dtype`` (such as "float32"): what they are
    stored as. ``reduce`` 2, 4, ... keeps only every second, fourth, ... node along each axis, of
    fields smoothed by the half-band weights of `remesh.halving`, which keep moments below the
    fourth; of yes and no what more than half of it says. The nodes kept stay on one lattice when
    the domain grows or moves. Snapshots are written below ``name``, by default "fields", "fields-2"
    if reduced by 2: each watcher of a run a name of its own, ``fields`` or ``fields-word``. Costs
    the file's image in memory, and a copy of one field. Refuses to reduce the blocks of an adaptive
    mesh, and periodic axes that ``reduce`` does not divide.
    """

    def __init__(
        self,
        every: float,
        *,
        fields: Sequence[str] | None = None,
        dtype: str | None = None,
        reduce: int = 1,
        name: str | None = None,
    ) -> None:
        if not (math.isfinite(every) and every > 0):
            raise InputError(
                f"every must be a positive time, got {every}", hint="Snapshots(every=0.1)"
            )
        if reduce not in REDUCED:
            raise InputError(
                f"reduce must be one of {', '.join(map(str, REDUCED))}, got {reduce}",
                hint="reduce=2: every second node along each axis",
            )
        self.every = float(every)
        self.fields = None if fields is None else tuple(fields)
        self.dtype = None if dtype is None else np.dtype(dtype)
        self.reduce = int(reduce)
        self.name = name or (SNAPSHOTS if reduce == 1 else f"{SNAPSHOTS}-{reduce}")
        if not NAME.fullmatch(self.name):
            raise InputError(
                f"snapshots are written below 'fields' or 'fields-word', got {self.name!r}",
                hint="name='fields-coarse'",
            )
        self._written: list[Snapshot] = []

    def open(self, moment: Moment) -> None:
        """Find the snapshots of the earlier part of the run; forget those that come after it."""
        if moment.out is None:
            raise InputError("Snapshots need a run directory", hint="run(..., out='out/my-run')")
        if self.reduce > 1:
            if getattr(moment.state, "blocks", None) is not None:
                raise InputError(
                    "an adaptive mesh is reduced already, by its tolerance",
                    hint="Snapshots(every=...) without reduce",
                )
            halved_grid(moment.state.grid, REDUCED.index(self.reduce))  # refuses before the run
        make_folder(moment.out / self.name)
        self._written = []
        for path in sorted((moment.out / self.name).glob("*.vtkhdf")):
            if int(path.stem) > moment.step:
                with storing(path):
                    path.unlink()
            else:
                self._written.append(read_snapshot(path))
        write_index(moment.out, self._written, self.name)

    def __call__(self, moment: Moment) -> None:
        """Write a snapshot if it is time for one."""
        if moment.out is None or not moment.on(self.every):
            return
        path = moment.out / self.name / f"{moment.step:08d}.vtkhdf"
        if path.exists() and moment.step not in [shot.step for shot in self._written]:
            raise InputError(
                f"two watchers write snapshots below {self.name!r}",
                hint="Snapshots(every=..., name='fields-other')",
            )
        snapshot = self._stored(path, moment)
        self._written = [s for s in self._written if s.step < moment.step] + [snapshot]
        write_index(moment.out, self._written, self.name)

    def close(self) -> None:
        """Nothing is left open between snapshots."""

    def _stored(self, path: Path, moment: Moment) -> Snapshot:
        """The snapshot, written: on the state's blocks if it has some, else on its grid."""
        fields = self._chosen(moment.flow.fields(moment.state))
        blocks = getattr(moment.state, "blocks", None)
        if blocks is not None:
            from pmesh.run.amr import write_blocks

            return write_blocks(path, blocks, self._typed(fields), moment.step, moment.time)
        grid = moment.state.grid
        if self.reduce > 1:
            fields, grid = self._reduced(fields, grid)
        return write_snapshot(path, grid, self._typed(fields), moment.step, moment.time)

    def _chosen(self, fields: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        names = tuple(fields) if self.fields is None else self.fields
        if missing := [name for name in names if name not in fields]:
            raise InputError(
                f"the flow has the fields {sorted(fields)}, got {missing}",
                hint="one of these names",
            )
        return {name: np.asarray(fields[name]) for name in names}

    def _typed(self, fields: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        return {
            name: field.astype(
                np.uint8 if field.dtype == bool else self.dtype or field.dtype, copy=False
            )
            for name, field in fields.items()
        }

    def _reduced(
        self, fields: Mapping[str, NDArray[Any]], grid: Grid
    ) -> tuple[dict[str, NDArray[Any]], Grid]:
        """The fields on the nodes kept, of those on which the first snapshot lies."""
        times = REDUCED.index(self.reduce)
        first = None
        if self._written:
            away = np.subtract(self._written[0].grid.origin, grid.origin) / grid.spacing
            first = [int(n) % self.reduce for n in np.rint(away)]
        found = {}
        for name, field in fields.items():
            value = halved(field, grid, times, first)
            found[name] = value > 0.5 if field.dtype == bool else value.astype(field.dtype)
        return found, halved_grid(grid, times, first)


def read_snapshots(folder: str | Path, name: str | None = None) -> list[Snapshot]:
    """The snapshots of a run directory in the order of their times.

    ``name``: of the watcher that wrote them; "fields" if not given, in a run without those the
    first of the others.
    """
    path = Path(folder)
    if name is None:
        held = [SNAPSHOTS, *snapshot_names(path)]
        name = next((one for one in held if any((path / one).glob("*.vtkhdf"))), SNAPSHOTS)
    return [read_snapshot(shot) for shot in sorted((path / name).glob("*.vtkhdf"))]


def snapshot_names(folder: str | Path) -> list[str]:
    """The names below which watchers of a run wrote snapshots."""
    found = (item.name for item in Path(folder).glob(f"{SNAPSHOTS}*") if item.is_dir())
    return sorted(name for name in found if NAME.fullmatch(name))
