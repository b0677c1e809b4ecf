from __future__ import annotations

import contextlib
import hashlib
import resource
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from toy import Body, Decay

from pmesh.run import checkpoint, files, tree
from remesh.errors import InputError, StorageError
from remesh.grid import Grid

STATE = Decay(grid=Grid((6, 5), 0.1, boundary="periodic")).start()


@dataclass(frozen=True)
class Box:
    content: Any


@contextlib.contextmanager
def tampered(path: Path) -> Iterator[h5py.File]:
    """Change a checkpoint, and make its digest fit again."""
    with h5py.File(path, "r+") as file:
        yield file
    content = path.read_bytes()[checkpoint.HEADER :]
    header = checkpoint._header(hashlib.sha256(content).hexdigest())
    path.write_bytes(header + content)


leaves = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(st.characters(codec="utf-8", exclude_characters="\x00"))
    | hnp.arrays(
        st.sampled_from(["f4", "f8", "c16", "i4", "u1", "bool"]), hnp.array_shapes(max_side=4)
    )
    | st.floats(width=32).map(np.float32)
    | st.fractions()
)
names = st.text(st.characters(codec="ascii", categories=["L"]), min_size=1)
trees = st.recursive(
    leaves,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.lists(inner, max_size=3).map(tuple)
        | st.dictionaries(names, inner, max_size=3)
        | inner.map(Box)
    ),
    max_leaves=6,
)


@settings(max_examples=80, deadline=None)
@given(content=trees)
def test_what_is_saved_comes_back_bit_for_bit(
    content: Any, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "tree.h5"
    checkpoint.save(path, Box(content))
    assert tree.same(checkpoint.load(path, like=Box(content)), Box(content))


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("shape", [(7, 6), (5, 4, 6)])
def test_a_state_with_a_grid_comes_back_with_its_types(
    tmp_path: Path, dtype: str, shape: tuple[int, ...]
) -> None:
    state = Decay(grid=Grid(shape, 1 / 3, boundary="periodic"), dtype=dtype).start()
    checkpoint.save(tmp_path / "c.h5", state, seconds=1.5)
    back = checkpoint.load(tmp_path / "c.h5", like=state)
    assert tree.same(back, state)
    assert back.grid == state.grid
    assert back.vorticity.dtype == dtype
    assert checkpoint.notes(tmp_path / "c.h5") == {"seconds": 1.5}


def test_arrays_that_may_not_be_written_stay_so(tmp_path: Path) -> None:
    array = np.arange(3.0)
    array.flags.writeable = False
    checkpoint.save(tmp_path / "c.h5", (array, array.copy()))
    one, other = checkpoint.load(tmp_path / "c.h5")
    assert (one.flags.writeable, other.flags.writeable) == (False, True)


def test_every_cut_of_a_checkpoint_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.h5"
    checkpoint.save(path, STATE)
    whole = path.read_bytes()
    for size in (0, 1, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:size])
        with pytest.raises(StorageError, match="cut short or damaged"):
            checkpoint.load(path, like=STATE)


def test_a_changed_bit_anywhere_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "c.h5"
    checkpoint.save(path, STATE)
    whole = path.read_bytes()
    for at in np.random.default_rng(1).integers(0, len(whole), 60):
        content = bytearray(whole)
        content[at] ^= 1 << int(at) % 8
        path.write_bytes(content)
        with pytest.raises(StorageError):
            checkpoint.load(path, like=STATE)


def test_foreign_files_other_versions_and_missing_ones_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "c.h5"
    with pytest.raises(StorageError, match="there is no checkpoint"):
        checkpoint.load(path)
    path.write_text("not HDF5 at all")
    with pytest.raises(StorageError, match="not a checkpoint of pmesh"):
        checkpoint.load(path)
    with h5py.File(path, "w") as file:
        file["x"] = 1.0
    with pytest.raises(StorageError, match="not a checkpoint of pmesh"):
        checkpoint.load(path)
    checkpoint.save(path, STATE)
    path.write_bytes(path.read_bytes().replace(b"checkpoint 2", b"checkpoint 7", 1))
    with pytest.raises(StorageError, match="format 7, this pmesh reads format 2"):
        checkpoint.load(path)


def test_only_dataclasses_that_are_ours_or_trusted_are_built(tmp_path: Path) -> None:
    path = tmp_path / "c.h5"
    checkpoint.save(path, STATE)
    with pytest.raises(StorageError, match="toy:Body, which is not a state of this pmesh"):
        checkpoint.load(path)
    for name in ("os:system", "pmesh.run.loop:run", "remesh.grid:math", "pmesh.nowhere:X"):
        with tampered(path) as file:
            file["state"].attrs["class"] = name
        with pytest.raises(StorageError, match="not a state of this pmesh"):
            checkpoint.load(path, like=STATE)


def test_a_class_whose_fields_have_changed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.h5"
    checkpoint.save(path, Body(np.zeros(2)))
    with tampered(path) as file:
        file["state"].move("angle", "tilt")
    with pytest.raises(StorageError, match=r"has the fields .*'tilt'.*expects .*'angle'"):
        checkpoint.load(path, like=Body(np.zeros(2)))


def test_what_cannot_be_kept_exactly_is_refused_and_the_old_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "c.h5"
    checkpoint.save(path, STATE)
    before = path.read_bytes()
    for bad in (object(), {1: "a"}, np.array(["a"]), np.array([None]), lambda: 0, {"a/b": 1}):
        with pytest.raises(InputError, match="a state"):
            checkpoint.save(path, Box(bad))
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["c.h5"]


def test_a_full_disk_leaves_the_old_checkpoint_and_no_rest(tmp_path: Path) -> None:
    path = tmp_path / "c.h5"
    checkpoint.save(path, STATE)
    before = path.read_bytes()
    large = Box(np.zeros(100_000))
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, limits[1]))
    try:
        with pytest.raises(StorageError, match=r"cannot write \S+c\.h5: File too large"):
            checkpoint.save(path, large)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, ignored)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["c.h5"]


def test_a_kill_between_writing_and_renaming_leaves_the_old_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "c.h5"
    checkpoint.save(path, STATE)
    before = path.read_bytes()

    def killed(*_: object) -> None:
        raise SystemExit

    monkeypatch.setattr(files.os, "fsync", killed)
    with pytest.raises(SystemExit):
        checkpoint.save(path, Box(1.0))
    assert path.read_bytes() == before
