"""Kept compiled loops go when a loop that they call has changed, and only then."""

from __future__ import annotations

import os
from pathlib import Path

from remesh.compiled import drop_stale


def kept(folder: Path, name: str, age: float) -> Path:
    """An index of numba, so many seconds old."""
    (folder / "__pycache__").mkdir(exist_ok=True)
    path = folder / "__pycache__" / name
    path.write_bytes(b"")
    os.utime(path, (1e9 - age, 1e9 - age))
    return path


def test_kept_loops_older_than_what_they_call_are_dropped(tmp_path):
    caller, leaf = tmp_path / "caller.py", tmp_path / "leaf.py"
    leaf.write_text("")
    os.utime(leaf, (1e9, 1e9))
    old = kept(tmp_path, "caller.move-33.py311.nbi", 10.0)
    new = kept(tmp_path, "caller.sort-90.py311.nbi", -10.0)
    other = kept(tmp_path, "caller2.move-33.py311.nbi", 10.0)
    drop_stale(str(caller), str(leaf))
    assert not old.exists()
    assert new.exists()
    assert other.exists()


def test_nothing_kept_and_nothing_readable_is_no_failure(tmp_path):
    drop_stale(str(tmp_path / "caller.py"), str(tmp_path / "missing.py"))
    (tmp_path / "leaf.py").write_text("")
    drop_stale(str(tmp_path / "caller.py"), str(tmp_path / "leaf.py"))
