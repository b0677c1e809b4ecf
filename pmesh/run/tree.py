"""Values as trees: walk, compare and rebuild nested dataclasses, tuples, dicts, arrays, scalars."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


def is_record(value: object) -> bool:
    """Whether the value is an instance of a dataclass."""
    return is_dataclass(value) and not isinstance(value, type)


def children(value: Any) -> Iterator[tuple[str, Any]]:
    """The parts of a dataclass, tuple, list or dict, by name; none for a leaf."""
    if is_record(value):
        yield from ((part.name, getattr(value, part.name)) for part in fields(value))
    elif isinstance(value, tuple | list):
        yield from ((str(i), part) for i, part in enumerate(value))
    elif isinstance(value, dict):
        yield from ((str(key), part) for key, part in value.items())


def arrays(value: Any, name: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Every array of the tree with its path, such as ``bodies.0.position``."""
    if isinstance(value, np.ndarray):
        yield name, value
        return
    for part_name, part in children(value):
        yield from arrays(part, f"{name}.{part_name}" if name else part_name)


def records(value: Any) -> Iterator[type]:
    """The type of every dataclass in the tree."""
    if is_record(value):
        yield type(value)
    for _, part in children(value):
        yield from records(part)


def first_not_finite(value: Any) -> str | None:
    """The path of the first array that holds a NaN or an infinity, if any."""
    for name, array in arrays(value):
        if array.dtype.kind in "fc" and not np.isfinite(array).all():
            return name
    return None


def rebuild(cls: type, values: dict[str, Any]) -> Any:
    """A dataclass with exactly these field values; its checks and defaults are not run again."""
    record: Any = object.__new__(cls)
    for name, value in values.items():
        object.__setattr__(record, name, value)
    return record


def settled(value: Any) -> Any:
    """The same tree with every array in C order, as a checkpoint gives it back.

    Sums over a strided view may round differently; a run and its resumption must not.
    """
    return _mapped(value, lambda array: np.ascontiguousarray(array) if array.ndim else array)


def _mapped(value: Any, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Any:
    """The tree with every array changed; parts in which nothing changes are kept as they are."""
    if isinstance(value, np.ndarray):
        return change(value)
    parts = dict(children(value))
    mapped = {name: _mapped(part, change) for name, part in parts.items()}
    if all(mapped[name] is parts[name] for name in parts):
        return value
    if is_record(value):
        return rebuild(type(value), mapped)
    if isinstance(value, dict):
        return dict(zip(value, mapped.values(), strict=True))
    if hasattr(value, "_fields"):  # a named tuple takes its parts one by one
        return type(value)(*mapped.values())
    return type(value)(mapped.values())


def same(one: Any, other: Any) -> bool:
    """Whether two trees are identical bit for bit: types, shapes, dtypes and all values."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        alike = one.shape == other.shape and one.dtype == other.dtype
        return bool(alike and one.tobytes() == other.tobytes())
    if isinstance(one, float | np.floating):
        return np.float64(one).tobytes() == np.float64(other).tobytes()
    parts, others = list(children(one)), list(children(other))
    if parts or others:
        return len(parts) == len(others) and all(
            name == other_name and same(part, other_part)
            for (name, part), (other_name, other_part) in zip(parts, others, strict=True)
        )
    return bool(one == other)
