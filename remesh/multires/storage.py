"""Compressed fields in files: HDF5 that any reader opens, from which the same bits come back."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import numpy as np

from remesh.errors import InputError, StorageError
from remesh.grid import Grid
from remesh.multires.compression import Compressed
from remesh.multires.wavelets import WAVELETS, Wavelet

FORMAT = "remesh compressed field 1"


def save(path: str | Path, compressed: Compressed) -> Path:
    """Write a compressed field as HDF5, whole or not at all; returns the path.

    Datasets ``steps`` (indices as differences), ``levels``, ``values``, ``scale``, packed without
    loss; the rest are attributes.
    """
    import h5py

    target, grid = Path(path), compressed.grid
    content = io.BytesIO()
    with h5py.File(content, "w", libver=("v110", "v110")) as file:
        file.attrs.update(
            format=FORMAT, shape=grid.shape, spacing=grid.spacing, origin=grid.origin,
            boundary=list(grid.boundary), depth=compressed.depth, tolerance=compressed.tolerance,
            error_bound=compressed.error_bound, components=compressed.components,
            **wavelet_attributes(compressed.wavelet),
        )  # fmt: skip
        parts = {
            "steps": np.diff(compressed.indices, prepend=0),
            "levels": compressed.levels,
            "values": compressed.values,
        }
        for name, part in parts.items():
            file.create_dataset(name, data=part, compression="gzip", shuffle=True, chunks=True)
        file["scale"] = compressed.scale
    beside = target.with_name(f".{target.name}.part")
    try:
        with beside.open("wb") as out:
            out.write(content.getbuffer())
            out.flush()
            os.fsync(out.fileno())
        beside.replace(target)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise StorageError(
            f"cannot write {target}: {error.strerror or error}", hint="another place"
        ) from error
    return target


def load(path: str | Path) -> Compressed:
    """The compressed field in a file that `save` wrote; refuses other files."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("format") != FORMAT:
                raise InputError(f"{path} holds no compressed field", hint="a file of `save`")
            return _read(file)
    except (OSError, LookupError, ValueError, RuntimeError) as error:
        if isinstance(error, InputError):
            raise
        raise StorageError(
            f"cannot read {path}, it is missing, cut short or damaged: {error}",
            hint="a file of `save`",
        ) from error


def wavelet_attributes(wavelet: Wavelet) -> dict[str, Any]:
    """A wavelet as attributes of an HDF5 file: its weights as exact fractions."""
    import h5py

    steps = {"predict": wavelet.predict, "update": wavelet.update}
    rows = {
        name: np.array([str(w) for w in row], h5py.string_dtype()) for name, row in steps.items()
    }
    return {
        "wavelet": wavelet.name, "order": wavelet.order, "moments": wavelet.moments,
        "source": wavelet.source, **rows,
    }  # fmt: skip


def wavelet_of(attrs: Any) -> Wavelet:
    """The wavelet that is among the attributes of a file, that of the table if it is there."""
    predict: Any = tuple(str(w) for w in attrs["predict"])
    update: Any = tuple(str(w) for w in attrs["update"])
    name, source = str(attrs["wavelet"]), str(attrs["source"])
    found = Wavelet(name, int(attrs["order"]), int(attrs["moments"]), predict, update, source)
    known = WAVELETS.get(name)
    return known if known == found else found


def _read(file: Any) -> Compressed:
    attrs = file.attrs
    boundary: Any = [str(word) for word in attrs["boundary"]]
    grid = Grid([int(n) for n in attrs["shape"]], float(attrs["spacing"]),
                [float(x) for x in attrs["origin"]], boundary)  # fmt: skip
    return Compressed(
        grid=grid, wavelet=wavelet_of(attrs), depth=int(attrs["depth"]),
        tolerance=float(attrs["tolerance"]), components=tuple(int(n) for n in attrs["components"]),
        scale=file["scale"][()], indices=np.cumsum(file["steps"][()], dtype=np.int64),
        levels=file["levels"][()], values=file["values"][()],
        error_bound=float(attrs["error_bound"]),
    )  # fmt: skip
