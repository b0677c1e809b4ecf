"""Snapshots of adaptive meshes: VTKHDF overlapping AMR, each block a box of point data.

A box of block ``(B,) * ndim`` nodes has one more layer of points at its upper ends, which it shares
with its neighbours: pictures have no gaps between blocks, and every value stands at its node.
Blocks under finer ones are there too; readers blank them. VTK blanks boxes in space only: a plane
mesh is written as two layers of cells, -1 and 0, whose three layers of points are the same.
The index is one temporal overlapping AMR whose arrays are HDF5 virtual datasets into the snapshots.
"""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from pmesh.run.files import reading, write_atomic
from pmesh.run.rundir import SNAPSHOTS
from pmesh.run.shot import LIBRARY, Names, Snapshot
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.multires.blocks import Blocks
from remesh.multires.mesh import AdaptiveMesh

if TYPE_CHECKING:
    from remesh.multires.wavelets import Wavelet

VERSION = (2, 2)  # of VTKHDF: older readers know it, newer ones its names, which 2.3 changed
LAYERS = 3  # of points of a plane mesh
MOST = 2**22  # nodes of the uniform grid that a snapshot's fields are told on
RECIPE = ("levels", "tolerance", "refinement", "block", "most_blocks")  # of the mesh, as attributes


@dataclass(frozen=True)
class AdaptiveSnapshot(Snapshot):
    """A snapshot of fields on blocks.

    ``snapshot[name]`` is the field on ``grid``, the finest uniform level of at most 4 million
    nodes; ``on_blocks(name)`` as the run had it.
    """

    blocks: Blocks

    def on_blocks(self, name: str) -> NDArray[Any]:
        """A field on the blocks: ``(n, *(block,) * ndim)``, or a vector ``(ndim, n, ...)``."""
        self.check(name)
        mesh, parts = self.blocks.mesh, []
        size, ndim = mesh.block + 1, mesh.ndim
        with reading(self.path), h5py.File(self.path, "r") as file:
            for level in range(self.blocks.finest + 1):
                data = file[f"VTKHDF/Level{level}/PointData/{name}"][()]
                parts.append(data.T[:ndim] if data.ndim > 1 else data)
        points = np.concatenate(parts, axis=-1)
        layers = (size,) * 3 if ndim == 3 else (LAYERS, size, size)
        boxes = points.reshape(*points.shape[:-1], -1, *layers)
        boxes = boxes if ndim == 3 else boxes[..., 0, :, :]
        first = boxes.ndim - ndim
        boxes = boxes.transpose(*range(first), *reversed(range(first, boxes.ndim)))
        inner: Any = (..., *(slice(0, mesh.block),) * ndim)
        return np.ascontiguousarray(boxes[inner])

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A field on the nodes of ``grid``."""
        from remesh.multires.uniform import to_uniform

        level = _uniform_level(self.blocks.mesh)
        return to_uniform(self.on_blocks(name), self.blocks, level, outside="last")


def write_blocks(
    path: Path, blocks: Blocks, fields: Mapping[str, NDArray[Any]], step: int, time: float
) -> AdaptiveSnapshot:
    """Write fields on blocks as VTKHDF overlapping AMR: scalars, and vectors of 3 components."""
    mesh = blocks.mesh
    layers: dict[str, NDArray[Any]] = {}
    for name, field in fields.items():
        if field.shape not in (blocks.shape, (mesh.ndim, *blocks.shape)):
            raise InputError(
                f"the field {name!r} must have the blocks' shape {blocks.shape}, or one such per "
                f"component, got {field.shape}",
                hint=f"scalars {blocks.shape}, vectors {(mesh.ndim, *blocks.shape)}",
            )
        layers[name] = _points(field, blocks)
    names: Names = {
        name: (3 if points.ndim > 1 else 0, points.dtype) for name, points in layers.items()
    }
    image = io.BytesIO()
    with h5py.File(image, "w", libver=LIBRARY) as file:
        root = _root(file, mesh)
        file.attrs.update(step=step, time=time, boundary=list(mesh.grid.boundary))
        file.attrs.update(_recipe(mesh))
        for level in range(blocks.finest + 1):
            own = blocks.of(level)
            group = root.create_group(f"Level{level}")
            group.attrs["Spacing"] = _spacing(mesh, level)
            group["AMRBox"] = _boxes(blocks.places[own], mesh)
            count = _box_points(mesh)
            for name, points in layers.items():
                part = points[own.start * count : own.stop * count]
                group.create_dataset(f"PointData/{name}", data=part, **_packing(mesh, part))
    write_atomic(path, image.getbuffer())
    return AdaptiveSnapshot(path, step, time, _uniform_grid(mesh), names, blocks)


def read_blocks(path: Path, file: h5py.File) -> AdaptiveSnapshot:
    """Where a snapshot is, what it holds and on which blocks; the fields stay on the disk."""
    mesh = _mesh(file)
    root = file["VTKHDF"]
    places, starts = [], [0]
    for level in range(mesh.levels + 1):
        group = root.get(f"Level{level}")
        found = np.empty((0, 6), int) if group is None else group["AMRBox"][()]
        places.append(found[:, 0 : 2 * mesh.ndim : 2] // mesh.block)
        starts.append(starts[-1] + len(found))
    blocks = Blocks(mesh, np.concatenate(places).astype(np.int64), tuple(starts))
    data = root.get("Level0/PointData", {})
    names = {name: (3 if field.ndim > 1 else 0, field.dtype) for name, field in data.items()}
    attrs = file.attrs
    return AdaptiveSnapshot(
        path, int(attrs["step"]), float(attrs["time"]), _uniform_grid(mesh), names, blocks
    )


def write_block_index(folder: Path, written: Sequence[Snapshot], name: str = SNAPSHOTS) -> None:
    """Write the index ``fields.vtkhdf``: all snapshots as one overlapping AMR over time."""
    snapshots = [shot for shot in written if isinstance(shot, AdaptiveSnapshot)]
    if len(snapshots) < len(written):
        raise InputError("some snapshots of the run are on blocks, others on a grid")
    mesh = snapshots[0].blocks.mesh
    for other in (shot.blocks.mesh for shot in snapshots):
        if (other.grid, other.levels, other.block) != (mesh.grid, mesh.levels, mesh.block):
            raise InputError(
                "all snapshots of a run must share one adaptive mesh, got two of different grid, "
                "levels or block",
                hint="the mesh that the run began with",
            )
    image = io.BytesIO()
    with h5py.File(image, "w", libver=LIBRARY) as file:
        root = _root(file, mesh)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = len(snapshots)
        steps["Values"] = [shot.time for shot in snapshots]
        for level in range(max(shot.blocks.finest for shot in snapshots) + 1):
            _index_level(root, steps.create_group(f"Level{level}"), level, snapshots)
    write_atomic(folder / f"{name}.vtkhdf", image.getbuffer())


def _index_level(
    root: h5py.Group, steps: h5py.Group, level: int, snapshots: Sequence[AdaptiveSnapshot]
) -> None:
    """The boxes of a level at all times, and its data as they stand in the snapshots."""
    mesh = snapshots[0].blocks.mesh
    parts = [shot.blocks.places[shot.blocks.of(level)] for shot in snapshots]
    counts = np.array([len(part) for part in parts])
    starts = np.cumsum(counts) - counts
    group = root.create_group(f"Level{level}")
    group.attrs["Spacing"] = _spacing(mesh, level)
    group["AMRBox"] = _boxes(np.concatenate(parts), mesh)
    steps["NumberOfAMRBox"], steps["AMRBoxOffset"] = counts, starts
    nodes = _box_points(mesh)
    for name, (components, dtype) in snapshots[-1].names.items():
        tail = (components,) if components else ()
        layout = h5py.VirtualLayout((int(counts.sum()) * nodes, *tail), dtype=dtype)
        for shot, start, count in zip(snapshots, starts, counts, strict=True):
            if count and shot.names.get(name) == (components, dtype):
                layout[start * nodes : (start + count) * nodes] = h5py.VirtualSource(
                    f"{shot.path.parent.name}/{shot.path.name}",
                    f"VTKHDF/Level{level}/PointData/{name}",
                    shape=(int(count) * nodes, *tail),
                    dtype=dtype,
                )
        fill = np.nan if dtype.kind == "f" else 0
        group.require_group("PointData").create_virtual_dataset(name, layout, fillvalue=fill)
        steps[f"PointDataOffset/{name}"] = starts * nodes


def _points(field: NDArray[Any], blocks: Blocks) -> NDArray[Any]:
    """Values at the points of all boxes, x fastest: ``(points,)``, or ``(points, 3)``."""
    from remesh.multires.ghosts import padded

    mesh = blocks.mesh
    kept = field.dtype if field.dtype.kind == "f" else np.dtype(np.float32)
    upper: Any = (..., *(slice(1, None),) * mesh.ndim)
    values = padded(field.astype(kept, copy=False), blocks, 1, outside="last")[upper]
    first = values.ndim - mesh.ndim
    values = values.transpose(*range(first), *reversed(range(first, values.ndim)))
    if mesh.ndim == 2:
        values = np.stack([values] * LAYERS, axis=-3)
    if field.ndim == mesh.ndim + 1:
        return np.ravel(values)
    vectors = values.reshape(mesh.ndim, -1).T
    return np.asarray(np.pad(vectors, ((0, 0), (0, 3 - mesh.ndim))))


def _box_points(mesh: AdaptiveMesh) -> int:
    """Points of a box."""
    return int((mesh.block + 1) ** mesh.ndim) * (LAYERS if mesh.ndim == 2 else 1)


def _packing(mesh: AdaptiveMesh, data: NDArray[Any]) -> dict[str, Any]:
    """How an array is stored: that of a plane packed, since it repeats itself."""
    if mesh.ndim == 3 or not data.size:
        return {}
    return {"compression": "gzip", "compression_opts": 1, "shuffle": True}


def _spacing(mesh: AdaptiveMesh, level: int) -> NDArray[np.float64]:
    """Spacing of a level; a plane is as thick as the finest spacing on all of them."""
    plane = [mesh.grid.spacing] * (3 - mesh.ndim)
    return np.array([*(mesh.spacing(level),) * mesh.ndim, *plane])


def _boxes(places: NDArray[np.int64], mesh: AdaptiveMesh) -> NDArray[np.int32]:
    """First and last cell along each axis (n, 6)."""
    boxes = np.zeros((len(places), 6), np.int32)
    boxes[:, 4] = 2 - LAYERS
    boxes[:, 0 : 2 * mesh.ndim : 2] = places * mesh.block
    boxes[:, 1 : 2 * mesh.ndim : 2] = places * mesh.block + mesh.block - 1
    return boxes


def _root(file: h5py.File, mesh: AdaptiveMesh) -> h5py.Group:
    """The group that makes a file a VTKHDF overlapping AMR."""
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array(VERSION)
    root.attrs.create("Type", b"OverlappingAMR", dtype=h5py.string_dtype("ascii", 14))
    root.attrs.create("GridDescription", b"XYZ", dtype=h5py.string_dtype("ascii", 3))
    root.attrs["Origin"] = np.array([*mesh.grid.origin, *(0.0,) * (3 - mesh.ndim)])
    return root


def _recipe(mesh: AdaptiveMesh) -> dict[str, Any]:
    """The mesh as attributes of a file."""
    values = {name: getattr(mesh, name) for name in RECIPE}
    wavelet: str | Wavelet = mesh.wavelet
    if isinstance(wavelet, str):
        values["wavelet"] = wavelet
    else:
        from remesh.multires.storage import wavelet_attributes

        values |= wavelet_attributes(wavelet)
    values["shape"], values["spacing"] = list(mesh.grid.shape), mesh.grid.spacing
    return {name: value for name, value in values.items() if value is not None}


def _mesh(file: h5py.File) -> AdaptiveMesh:
    """The mesh whose recipe is among the attributes of a file."""
    attrs, ndim = file.attrs, len(file.attrs["shape"])
    origin = [float(x) for x in file["VTKHDF"].attrs["Origin"][:ndim]]
    boundary = [str(word) for word in attrs["boundary"]]
    grid = Grid([int(n) for n in attrs["shape"]], float(attrs["spacing"]), origin, boundary)  # type: ignore[arg-type]
    known = [part.name for part in dataclasses.fields(AdaptiveMesh) if part.name in attrs]
    values: dict[str, Any] = {
        name: attrs[name] if name == "wavelet" else attrs[name].item() for name in known
    }
    if "predict" in attrs:  # one of the user's own
        from remesh.multires.storage import wavelet_of

        values["wavelet"] = wavelet_of(attrs)
    return AdaptiveMesh(grid=grid, **values)


def _uniform_level(mesh: AdaptiveMesh) -> int:
    """The finest level whose uniform grid is not too large."""
    level = mesh.levels
    while level > 0 and mesh.level_grid(level).size > MOST:
        level -= 1
    return level


def _uniform_grid(mesh: AdaptiveMesh) -> Grid:
    return mesh.level_grid(_uniform_level(mesh))
