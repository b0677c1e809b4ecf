"""The directory of a run: which files it holds, whose run they are, and how to go on from them."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from pmesh.run import checkpoint
from pmesh.run.files import make_folder, storing
from pmesh.run.series import SeriesFile
from remesh.errors import InputError

CASE = "case.toml"
SERIES = "series.csv"
CHECKPOINT = "checkpoint.h5"
FIELDS = "fields.vtkhdf"
SNAPSHOTS = "fields"
FIGURE = "figure.png"
SUMMARY = "summary.json"
# in the order in which they are removed: without its checkpoint a run is not one to go on from
RUN_FILES = (CHECKPOINT, SERIES, FIELDS, SNAPSHOTS, FIGURE, SUMMARY, CASE)
LOOKS = (
    "movie.gif",
    "movie.mp4",
    "ftle.png",
    "dye.png",
    "report.html",
    "compressed.h5",
)  # of a run as it was then


class RunFolder:
    """A run directory in use: the series grows, the checkpoint follows it."""

    series: SeriesFile

    def __init__(self, path: Path, *, resume: bool = False, overwrite: bool = False) -> None:
        if not resume:
            refuse_another_run(path, overwrite=overwrite)
        self.path = path
        self.resumed = resume and (path / CHECKPOINT).exists()
        self._replaced = RUN_FILES[:-1] if resume else RUN_FILES  # the case of one to resume stays
        self._opened = False
        self._made = not path.exists()

    def restore(self, state: Any) -> tuple[Any, float, int]:
        """The state to start from, with the seconds and node steps it has cost so far."""
        if not self.resumed:
            return state, 0.0, 0
        kept = checkpoint.load(self.path / CHECKPOINT, like=state)
        if type(kept) is not type(state):
            raise InputError(
                f"{self.path / CHECKPOINT} holds a {type(kept).__name__}, "
                f"the run has a {type(state).__name__}",
                hint="the flow this checkpoint was written by, or another directory",
            )
        cost = checkpoint.notes(self.path / CHECKPOINT)
        return kept, float(cost["seconds"]), int(cost["node_steps"])

    def begin(self, step: int) -> None:
        """Clear the way and open series.csv; of a resumed run the rows after ``step`` are cut."""
        make_folder(self.path)
        clear(self.path, (FIGURE, SUMMARY) if self.resumed else self._replaced)
        self.series = SeriesFile(self.path / SERIES, step if self.resumed else None)
        self._opened = True

    def save(self, state: Any, seconds: float, node_steps: int) -> None:
        """Write the checkpoint, once everything it stands on is on the disk."""
        self.series.sync()
        checkpoint.save(
            self.path / CHECKPOINT, state, seconds=seconds, node_steps=float(node_steps)
        )

    def close(self, *, forget: bool) -> None:
        """Let go of the files; of a run that never started leave nothing."""
        if self._opened:
            self.series.close()
        if forget and self.path.exists():
            clear(self.path)
            if self._made and not any(self.path.iterdir()):
                self.path.rmdir()


def refuse_another_run(path: Path, *, overwrite: bool) -> None:
    """Refuse a path that is a file, or a directory with a run in it that may not be replaced."""
    if path.exists() and not path.is_dir():
        raise InputError(f"the run directory {path} is a file", hint="another directory")
    found = [name for name in RUN_FILES if (path / name).exists()]
    if found and not overwrite:
        raise InputError(
            f"{path} already holds a run ({', '.join(found)})",
            hint="resume (--resume), overwrite (--overwrite), or another directory (--out)",
        )


def clear(path: Path, names: tuple[str, ...] = RUN_FILES) -> None:
    """Remove files of a run, with the pictures that were made of it, and no others."""
    half_written = [*path.glob(".*.part"), *path.glob(f"{SNAPSHOTS}*/.*.part")]
    others = _other_snapshots(path) if SNAPSHOTS in names else []
    for item in (*(path / name for name in (*LOOKS, *names)), *others, *half_written):
        with storing(item):
            if item.is_dir():
                shutil.rmtree(item)
            else:
                item.unlink(missing_ok=True)


def _other_snapshots(path: Path) -> list[Path]:
    """What watchers wrote below names of their own, ``fields-2``: folders of snapshots, indices."""
    found = []
    for item in path.glob(f"{SNAPSHOTS}-*"):
        inside = item.iterdir() if item.is_dir() else [item]
        if all(one.suffix in (".vtkhdf", ".part") for one in inside):
            found.append(item)
    return found
