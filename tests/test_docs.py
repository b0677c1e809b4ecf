"""The documents: links lead somewhere, scripts run as printed, every case and message is real."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from pmesh.cases.registry import CASES

ROOT = Path(__file__).parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]
DEMOS = sorted(path.name for path in (ROOT / "demos").glob("*.py"))


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def script(name: str, number: int) -> str:
    """A Python block of a page, as a reader would copy it."""
    return re.findall(r"```python\n(.*?)```", text(name), re.S)[number]


def run(code: str, folder: Path) -> str:
    """What a script prints; it must say nothing on stderr."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=folder, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return done.stdout


def headings(name: str) -> set[str]:
    """The anchors of a page."""
    lines = re.sub(r"```.*?```", "", text(name), flags=re.S).splitlines()
    titles = [line.lstrip("#").strip() for line in lines if line.startswith("#")]
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("name", NAMES)
def test_every_relative_link_leads_to_a_file_and_a_heading(name):
    for target in re.findall(r"\]\(([^)\s]+)\)", text(name)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = (ROOT / name).parent / path if path else ROOT / name
        assert there.exists(), target
        if anchor:
            assert anchor in headings(str(there.resolve().relative_to(ROOT))), target


@pytest.mark.parametrize("name", NAMES)
def test_every_picture_is_described_small_and_used(name):
    for words, target in re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", text(name)):
        assert len(words) > 20, target
        assert ((ROOT / name).parent / target).stat().st_size < 300_000, target


def test_no_picture_is_left_over():
    used = "".join(text(name) for name in NAMES)
    pictures = [path.name for path in (ROOT / "docs" / "images").iterdir()]
    assert [name for name in pictures if name not in used] == []


def test_the_front_page_begins_with_a_picture_and_its_script_gives_the_published_drag(tmp_path):
    assert text("README.md").startswith("![")
    said = run(script("README.md", 0), tmp_path)
    ours, published = re.search(r"drag.*: ([\d.]+), published ([\d.]+)", said).groups()
    assert float(published) == 1.287
    assert float(ours) == pytest.approx(1.287, rel=0.03)
    statements = [line for line in script("README.md", 0).splitlines() if line.strip()]
    assert len(statements) <= 10


def test_the_script_to_start_from_runs_and_keeps_its_circulation(tmp_path):
    said = run(script("docs/start.md", 0), tmp_path)
    assert abs(float(re.search(r"circulation (\S+)", said).group(1))) < 1e-12
    assert "rule='deformation'" in said


@pytest.mark.parametrize(
    ("page", "number"),
    [
        ("docs/start.md", 1),
        ("docs/start.md", 3),
        ("docs/moving.md", 0),
        ("docs/moving.md", 1),
        ("docs/swimmers.md", 1),
        ("docs/adaptive.md", 0),
        ("docs/adaptive.md", 1),
        ("docs/adaptive.md", 2),
        ("docs/space.md", 0),
        ("docs/space.md", 1),
        ("docs/space.md", 2),
        ("docs/space.md", 3),
        ("docs/space.md", 4),
        ("docs/space.md", 5),
        ("docs/space.md", 6),
        ("docs/space.md", 7),
        ("docs/space.md", 8),
    ],
)
def test_the_scripts_of_the_pages_run(page, number, tmp_path):
    run(script(page, number), tmp_path)


@pytest.mark.parametrize("case", CASES)
def test_every_case_is_on_the_front_page_and_in_the_gallery(case):
    assert f"`{case}`" in text("README.md")
    assert f"### {case}\n" in text("docs/gallery.md")
    assert f"`pmesh run {case}`" in text("docs/gallery.md")


@pytest.mark.parametrize("demo", DEMOS)
def test_every_demo_is_in_the_gallery(demo):
    assert f"`python demos/{demo}`" in text("docs/gallery.md")


def test_the_changes_begin_with_the_current_version():
    version = tomllib.loads(text("pyproject.toml"))["project"]["version"]
    assert re.search(r"^## (\S+)", text("CHANGELOG.md"), re.M).group(1) == version


def test_every_option_in_a_printed_command_exists():
    from pmesh.cases.options import options
    from pmesh.cases.registry import find

    common = {"--out", "--resume", "--overwrite", "--checkpoint-every", "--quick", "--help"}
    seen = 0
    for name in NAMES:
        for case, rest in re.findall(r"pmesh run ([a-z-]+)((?: --[^`\n|]+)?)", text(name)):
            if case not in CASES:
                continue
            known = {option.flag for option in options(find(case)).values()} | common
            assert set(re.findall(r"--[a-z-]+", rest)) <= known, (name, case, rest)
            seen += 1
    assert seen > 10


def test_every_target_of_make_that_is_named_exists():
    targets = set(re.findall(r"^([a-z]+):", text("Makefile"), re.M))
    for name in NAMES:
        named = re.findall(r"(?:^|`)make ([a-z]+)", text(name), re.M)
        assert set(named) <= targets, (name, named)


def test_every_message_among_the_troubles_is_one_that_the_sources_raise():
    files = [path for package in ("remesh", "levelset", "pmesh") for path in
             (ROOT / package).rglob("*.py")]  # fmt: skip
    sources = "".join(path.read_text(encoding="utf-8") for path in files)
    sources = re.sub(r'"\s*\n\s*f?"', "", sources)
    sources = re.sub(r"\{[^{}]*\}", "{}", sources)
    rows = re.findall(r"^\| (`[^|]*`) \|", text("docs/troubles.md"), re.M)
    assert len(rows) > 15
    for message in re.findall(r"`([^`]+)`", " ".join(rows)):
        for part in re.split(r"\.\.\.|\bN\b|\bM\b|\bDIR\b|\[0\]|\(n, 2\)", message):
            assert part.strip(" :()") in sources, message
