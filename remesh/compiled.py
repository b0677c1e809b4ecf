"""Compiled loops that are kept on the disk: dropped when a file whose loops they call is newer.

numba keeps a compiled loop until its own file changes, though loops of other files are built into
it. Where sources are updated in place, as by ``git pull``, the old ones would go on being used.
"""

from __future__ import annotations

import contextlib
from pathlib import Path


def drop_stale(caller: str, *called: str) -> None:
    """Remove what numba kept for the file ``caller`` from before any file in ``called`` changed."""
    source = Path(caller)
    with contextlib.suppress(OSError):  # read-only, or another process was faster
        newest = max(Path(file).stat().st_mtime for file in called)
        for kept in (source.parent / "__pycache__").glob(f"{source.stem}.*.nbi"):
            if kept.stat().st_mtime <= newest:
                kept.unlink()
