"""The checkpoint: a state, exactly, in one HDF5 file that a kill at any moment leaves whole.

The file's first 512 bytes, which HDF5 leaves to its users, name the format and hold a digest of all
the rest: a file that is cut, or differs by one bit, is refused before anything is read from it.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import struct
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pmesh.run import tree
from pmesh.run.files import write_atomic
from remesh.errors import InputError, StorageError

FORMAT = b"pmesh checkpoint"
HEADER = 512  # bytes
VERSION = 2
PACKAGES = ("pmesh", "remesh", "levelset")  # whose dataclasses a file may name
SCALARS = {"bool": bool, "int": int, "float": float, "str": str, "Fraction": Fraction}


def save(path: str | Path, state: Any, **notes: float) -> None:
    """Write the state, and some numbers beside it, to a new file renamed over the old one.

    Keeps dataclasses, tuples, lists, dicts with text keys, arrays, numbers, fractions, text and
    None, every bit of them; refuses anything else. Costs one copy of the state in memory.
    """
    image = io.BytesIO()  # a full disk then meets plain writes, never HDF5 in mid-air
    with h5py.File(image, "w", userblock_size=HEADER) as file:
        file.create_group("notes").attrs.update(notes)
        _write(file, "state", state)
    content = image.getbuffer()
    content[:HEADER] = _header(hashlib.sha256(content[HEADER:]).hexdigest())
    write_atomic(Path(path), content)


def load(path: str | Path, like: Any = None) -> Any:
    """The state that :func:`save` wrote.

    Builds dataclasses of pmesh, remesh and levelset, and those that occur in ``like``; refuses
    files that are missing, cut, damaged, foreign, of another version, or that name other classes.
    """
    return _open(Path(path), lambda file: _read(file["state"], _trusted(like)))


def notes(path: str | Path) -> dict[str, float]:
    """The numbers that were kept beside the state."""
    return _open(Path(path), lambda file: dict(file["notes"].attrs))  # type: ignore[no-any-return]


def _header(digest: str) -> bytes:
    text = b"%s %d sha256 %s\n" % (FORMAT, VERSION, digest.encode())
    return text.ljust(HEADER, b"\0")


def _verify(path: Path) -> None:
    """Refuse a file that is not a checkpoint, of another version, or not as it was written."""
    with path.open("rb") as file:
        header = file.read(HEADER)
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    if header[: len(FORMAT)] != FORMAT[: len(header)]:
        raise StorageError("it is not a checkpoint of pmesh", hint="another --out directory")
    words = header.rstrip(b"\0").split()
    if len(words) == 5 and words[2] != b"%d" % VERSION:
        raise StorageError(
            f"it has checkpoint format {words[2].decode()}, this pmesh reads format {VERSION}",
            hint="the version of pmesh that case.toml names",
        )
    if header != _header(digest):
        raise ValueError("its digest is not that of its content")


def _open(path: Path, use: Callable[[Any], Any]) -> Any:
    """Use a checkpoint file; everything that can be wrong with it becomes a StorageError."""
    fresh = "an earlier copy of the file, or --overwrite, which starts anew"
    if not path.is_file():
        raise StorageError(f"there is no checkpoint {path}", hint="a run without --resume")
    try:
        _verify(path)
        with h5py.File(path, "r") as file:
            return use(file)
    except StorageError as error:
        raise StorageError(f"{path}: {error.problem}", hint=error.hint) from error
    except (OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise StorageError(f"{path} is cut short or damaged: {error}", hint=fresh) from error


def _spelt(value: float) -> str:
    """Every bit of a float as text; NaNs are of many kinds."""
    return value.hex() if value == value else f"nan {struct.pack('>d', value).hex()}"


def _number(text: str) -> float:
    """The float that `_spelt` wrote."""
    if text.startswith("nan "):
        return float(struct.unpack(">d", bytes.fromhex(text[4:]))[0])
    return float.fromhex(text)


def _write(parent: h5py.Group, name: str, value: Any) -> None:
    """Write one node of the tree; its attribute ``kind`` says what it is."""
    if isinstance(value, np.ndarray | np.generic):
        array = np.ascontiguousarray(value) if np.ndim(value) else np.asarray(value)
        if array.dtype.kind not in "biufc":
            raise InputError(
                f"a state holds arrays of numbers, got dtype {array.dtype} in {parent.name}/{name}",
                hint="float64, float32, complex, integers or booleans",
            )
        node = parent.create_dataset(name, data=array)
        node.attrs["kind"] = "array" if isinstance(value, np.ndarray) else "scalar"
        if isinstance(value, np.ndarray):
            node.attrs["writeable"] = bool(value.flags.writeable)
        return
    node = parent.create_group(name, track_order=True)
    if value is None:
        node.attrs["kind"] = "none"
    elif type(value) in SCALARS.values():
        node.attrs["kind"] = type(value).__name__
        node.attrs["value"] = _spelt(value) if isinstance(value, float) else str(value)
    elif tree.is_record(value):
        node.attrs["kind"] = "record"
        node.attrs["class"] = f"{type(value).__module__}:{type(value).__qualname__}"
    elif type(value) in (tuple, list, dict) and _plain_keys(value):
        node.attrs["kind"] = type(value).__name__
    else:
        raise InputError(
            f"a state cannot hold a {type(value).__qualname__}, found at {node.name}",
            hint="dataclasses, tuples, lists, dicts with text keys, arrays, numbers, text, None",
        )
    for part_name, part in tree.children(value):
        _write(node, part_name.replace("/", "\N{FRACTION SLASH}"), part)


def _plain_keys(value: Any) -> bool:
    return not isinstance(value, Mapping) or all(
        isinstance(key, str) and key and "/" not in key and key != "." for key in value
    )


def _read(node: Any, trusted: dict[str, type]) -> Any:
    """Read one node of the tree."""
    kind = node.attrs["kind"]
    if kind in ("array", "scalar"):
        value = node[()]
        if kind == "scalar":
            return value
        array = np.asarray(value)
        array.flags.writeable = bool(node.attrs["writeable"])
        return array
    if kind == "none":
        return None
    if kind in SCALARS:
        text = str(node.attrs["value"])
        if kind == "float":
            return _number(text)
        return text == "True" if kind == "bool" else SCALARS[kind](text)
    parts = {name: _read(part, trusted) for name, part in node.items()}
    if kind == "record":
        return tree.rebuild(_class(node.attrs["class"], set(parts), trusted), parts)
    if kind == "dict":
        return parts
    ordered = [parts[str(i)] for i in range(len(parts))]
    return tuple(ordered) if kind == "tuple" else ordered


def _trusted(like: Any) -> dict[str, type]:
    """The dataclasses that occur in a value, by the name a file gives them."""
    return {f"{cls.__module__}:{cls.__qualname__}": cls for cls in tree.records(like)}


def _class(name: str, parts: set[str], trusted: dict[str, type]) -> type:
    """The dataclass of that name: one of ours or a trusted one, with exactly these fields."""
    cls: Any = trusted.get(name)
    module, _, path = name.partition(":")
    if cls is None and module.split(".")[0] in PACKAGES:
        try:
            cls = importlib.import_module(module)
            for step in path.split("."):
                cls = getattr(cls, step)
        except (ImportError, AttributeError):
            cls = None
    known = isinstance(cls, type) and is_dataclass(cls) and cls.__module__ == module
    if not known:
        raise StorageError(
            f"it holds a {name}, which is not a state of this pmesh",
            hint="the version of pmesh that case.toml names, or load(path, like=a_state)",
        )
    expected = {part.name for part in fields(cls)}
    if expected != parts:
        raise StorageError(
            f"its {name} has the fields {sorted(parts)}, this pmesh expects {sorted(expected)}",
            hint="the version of pmesh that case.toml names",
        )
    return cls  # type: ignore[no-any-return]
