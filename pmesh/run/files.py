"""Files that are whole or not there: new content is written beside the old and renamed over it."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

from remesh.errors import PmeshError, StorageError

HINTS = {
    errno.ENOSPC: "free some space, or another --out directory; then --resume",
    errno.EDQUOT: "free some of your quota, or another --out directory; then --resume",
    errno.EFBIG: "a file system or a limit (ulimit -f) that allows larger files",
    errno.EACCES: "a directory you may write to",
    errno.EROFS: "a directory you may write to",
    errno.ENOTDIR: "a path whose parents are directories",
    errno.ENOENT: "a directory that exists",
}


@contextlib.contextmanager
def storing(path: Path) -> Iterator[None]:
    """Turn an error of the file system into a StorageError that names the file and what to do."""
    try:
        yield
    except StorageError:
        raise
    except OSError as error:
        reason = error.strerror or str(error)
        raise StorageError(
            f"cannot write {path}: {reason}",
            hint=HINTS.get(error.errno or 0, "another --out directory"),
        ) from error


@contextlib.contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn whatever is wrong with a file into a StorageError that names it."""
    try:
        yield
    except PmeshError:
        raise
    except (OSError, LookupError, ValueError, TypeError, AttributeError, RuntimeError) as error:
        raise StorageError(
            f"cannot read {path}, it is missing, cut short or damaged: {error}",
            hint="--overwrite, which starts the run anew",
        ) from error


def write_atomic(path: Path, content: bytes | memoryview) -> None:
    """Replace the file by ``content``; a kill or a full disk at any moment leaves the old one."""
    part = path.with_name(f".{path.name}.part")
    with storing(path):
        try:
            with part.open("wb", buffering=0) as file:
                write_all(file.fileno(), content)
                os.fsync(file.fileno())
            part.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
            raise
        sync_folder(path.parent)


def write_all(descriptor: int, content: bytes | memoryview) -> None:
    """Write every byte; a write may take only a part of what it is given."""
    rest = memoryview(content)
    while len(rest):
        rest = rest[os.write(descriptor, rest) :]


def sync_folder(folder: Path) -> None:
    """Make a rename last through a loss of power; not every system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def make_folder(folder: Path) -> None:
    """Create a directory and its parents."""
    with storing(folder):
        folder.mkdir(parents=True, exist_ok=True)
