"""What this machine, and the limits on this process, leave to it."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

GROUPS = Path("/sys/fs/cgroup")
ENDLESS = 1 << 60  # a limit above this is none


def free_memory() -> int | None:
    """Bytes that this process may still take: of the machine's and of its group's; None unknown.

    Memory that only caches files counts as free. Groups are control groups of Linux, both versions.
    """
    known = [found for found in (_machine(), _group()) if found is not None]
    return min(known) if known else None


def used_memory() -> int:
    """Bytes of memory that this process holds now; 0 where it cannot be told."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    with contextlib.suppress(ImportError):
        import psutil

        return int(psutil.Process().memory_info().rss)
    return 0


def size_text(size: float) -> str:
    """Bytes in words: "41 GB", "1.2 GB", "350 MB"."""
    if size < 1e9:
        return f"{size / 1e6:.3g} MB"
    return f"{size / 1e9:.2g} GB" if size < 10e9 else f"{size / 1e9:.0f} GB"


def _machine() -> int | None:
    """Free memory of the whole machine."""
    with contextlib.suppress(ImportError):
        import psutil

        return int(psutil.virtual_memory().available)
    with contextlib.suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    with contextlib.suppress(OSError, ValueError, AttributeError):
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return None


def _group() -> int | None:
    """What the control groups that this process is in leave, the tightest of them."""
    left = []
    with contextlib.suppress(OSError):
        for line in Path("/proc/self/cgroup").read_text().splitlines():
            _, kind, path = line.split(":", 2)
            if kind == "":
                left += group_room(GROUPS, path, "memory.max", "memory.current", "inactive_file")
            elif "memory" in kind.split(","):
                left += group_room(
                    GROUPS / "memory", path, "memory.limit_in_bytes", "memory.usage_in_bytes",
                    "total_inactive_file",
                )  # fmt: skip
    return min(left, default=None)


def group_room(root: Path, path: str, limit: str, usage: str, cached: str) -> list[int]:
    """What a control group and those above it leave [bytes], none for those without a limit."""
    found = []
    here = root / path.strip("/")
    for folder in (here, *here.parents):
        with contextlib.suppress(OSError, ValueError):  # "max" is no number
            most = int((folder / limit).read_text())
            if most < ENDLESS:
                lines = (folder / "memory.stat").read_text().splitlines()
                stat = dict(line.split() for line in lines)
                used = int((folder / usage).read_text()) - int(stat.get(cached, 0))
                found.append(max(0, most - used))
        if folder == root:
            break
    return found
