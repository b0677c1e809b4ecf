"""The table of a run, ``series.csv``: one row per step, numbers with all their digits."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.run.files import storing, write_all, write_atomic
from remesh.errors import InputError, StorageError

Series = dict[str, NDArray[Any]]
TEXT = ("rule",)
FIRST = ("step", "time", "dt", "rule")


class SeriesFile:
    """A series.csv that grows row by row; what it holds beyond ``last_step`` is cut off first."""

    def __init__(self, path: Path, last_step: int | None = None) -> None:
        self.path = path
        self.columns: tuple[str, ...] = ()
        self._keep(last_step)
        with storing(path):
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)

    def _keep(self, last_step: int | None) -> None:
        """Cut off the rows after ``last_step``, or all of them, and a row only half written."""
        if last_step is None or not self.path.exists():
            self.path.unlink(missing_ok=True)
            return
        with storing(self.path):
            lines = self.path.read_bytes().splitlines(keepends=True)
        if not lines or not lines[0].endswith(b"\n"):
            self.path.unlink()
            return
        self.columns = tuple(next(csv.reader([lines[0].decode()])))
        try:
            kept = [line for line in lines[1:] if line.endswith(b"\n")]
            kept = [line for line in kept if int(line.split(b",", 1)[0]) <= last_step]
        except ValueError as error:
            raise StorageError(
                f"{self.path} is damaged: {error}", hint="--overwrite, which starts anew"
            ) from error
        write_atomic(self.path, b"".join([lines[0], *kept]))

    def append(self, row: Mapping[str, object]) -> None:
        """Write one row; the first one fixes the columns, which a later one must repeat."""
        if not self.columns:
            self._write([tuple(row), tuple(map(_text, row.values()))])
            self.columns = tuple(row)
            return
        if set(row) != set(self.columns):
            odd = sorted(set(row) ^ set(self.columns))
            raise InputError(
                f"every step must give the same columns, got {odd} in some rows only",
                hint="the same names for every state, nan where nothing is known yet",
            )
        self._write([tuple(_text(row[name]) for name in self.columns)])

    def _write(self, rows: list[tuple[str, ...]]) -> None:
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        with storing(self.path):
            write_all(self._descriptor, text.getvalue().encode())

    def sync(self) -> None:
        """Return when all rows are on the disk."""
        with storing(self.path):
            os.fsync(self._descriptor)

    def close(self) -> None:
        """Let go of the file."""
        os.close(self._descriptor)


def _text(value: object) -> str:
    """A number with all its digits, a word as it is."""
    if isinstance(value, str):
        return value
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        return str(int(value))
    return repr(float(value))  # type: ignore[arg-type]


def read_series(path: str | Path) -> Series:
    """The columns of a series.csv (or of the run directory that holds it) by name.

    ``rule`` comes as an array of words, all else as float64. Refuses a file that is missing or cut.
    """
    path = Path(path)
    path = path / "series.csv" if path.is_dir() else path
    try:
        with path.open(newline="", encoding="utf-8") as file:
            names, *rows = csv.reader(file)
        if any(len(row) != len(names) for row in rows):
            raise ValueError("a row is cut short")
        columns = dict(zip(names, zip(*rows, strict=True), strict=True)) if rows else {}
        return {name: _column(name, columns.get(name, ())) for name in names}
    except OSError as error:
        raise StorageError(
            f"cannot read {path}: {error.strerror}", hint="the directory of a run"
        ) from error
    except ValueError as error:
        raise StorageError(
            f"{path} is not a series: {error}", hint="--resume repairs it"
        ) from error


def _column(name: str, cells: tuple[str, ...]) -> NDArray[Any]:
    if name in TEXT:
        return np.array(cells, dtype=np.str_)
    return np.array([float(cell) for cell in cells], dtype=np.float64)
