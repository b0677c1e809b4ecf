"""What a machine and its control groups leave."""

from pathlib import Path

from remesh.machine import free_memory, group_room, size_text, used_memory


def write_group(folder: Path, most: str, used: int, cached: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "memory.max").write_text(most + "\n")
    (folder / "memory.current").write_text(f"{used}\n")
    (folder / "memory.stat").write_text(f"anon 1\ninactive_file {cached}\n")


def room(root: Path, path: str) -> list[int]:
    return group_room(root, path, "memory.max", "memory.current", "inactive_file")


def test_a_group_leaves_its_limit_less_what_is_used_and_not_a_cache(tmp_path: Path) -> None:
    write_group(tmp_path / "job", "1000", 400, 150)
    assert room(tmp_path, "/job") == [750]


def test_groups_above_count_and_those_without_a_limit_do_not(tmp_path: Path) -> None:
    write_group(tmp_path, "5000", 100, 0)
    write_group(tmp_path / "a", "max", 100, 0)
    write_group(tmp_path / "a/b", "2000", 1900, 0)
    assert room(tmp_path, "/a/b") == [100, 4900]
    write_group(tmp_path / "a/b", str((1 << 63) - 4096), 1900, 0)
    assert room(tmp_path, "/a/b") == [4900]


def test_a_group_that_holds_more_than_its_limit_leaves_nothing(tmp_path: Path) -> None:
    write_group(tmp_path, "1000", 1200, 0)
    assert room(tmp_path, "/") == [0]


def test_a_group_that_is_not_there_says_nothing(tmp_path: Path) -> None:
    assert room(tmp_path, "/nowhere") == []


def test_this_process_holds_memory_and_may_take_more() -> None:
    free = free_memory()
    assert free is None or free > 1 << 20
    assert used_memory() == 0 or used_memory() > 1 << 20


def test_sizes_are_told_in_units_that_suit_them() -> None:
    assert [size_text(x) for x in (3.5e8, 1.23e9, 41e9)] == ["350 MB", "1.2 GB", "41 GB"]
