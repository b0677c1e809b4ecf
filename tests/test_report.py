"""The report: one page that holds everything a run has, and asks nothing of the network."""

from __future__ import annotations

import re
from functools import partial
from html.parser import HTMLParser
from pathlib import Path

import pytest
from made_run import make
from vortex_shots import ring

from pmesh.cases import report as module
from pmesh.cases import surfaces, vortex_figure
from pmesh.cases.report import Run, page, report
from pmesh.cases.runner import run_case
from pmesh.cases.taylor_green import TaylorGreenCase
from pmesh.run.snapshots import write_snapshot
from remesh.errors import InputError
from remesh.grid import Grid

VOID = {"meta", "img", "br", "link", "input"}
CLOSED = {"polyline"}


class Page(HTMLParser):
    """Tags must close; links, pictures and words are kept."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.words = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open[-1:] != ["style"]:
            self.words += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attrs for name, attrs in self.found if name == tag]


def sections(seen: Page) -> list[str]:
    return [str(attrs["id"]) for attrs in seen.all("section")]


def test_the_report_of_a_finished_run_shows_all_it_has(tmp_path: Path) -> None:
    folder = make(tmp_path)
    (folder / "figure.png").write_bytes(b"a picture")
    assert report(folder) == folder / "report.html"
    seen = Page((folder / "report.html").read_text(encoding="utf-8"))
    assert sections(seen) == [
        "metrics", "figure", "forces", "statistics", "spectrum", "wake", "movie", "series",
        "parameters", "cost-and-version",
    ]  # fmt: skip
    assert [attrs["href"] for attrs in seen.all("a")] == [f"#{name}" for name in sections(seen)]
    for words in (
        "Impulsively started cylinder", "1 of 2", "FAIL", "pass", "Somebody <1999> & others",
        "Koumoutsakos & Leonard 1995", "body 0, force y", "Reynolds number U D / nu", "0123abc",
        "only told",
    ):  # fmt: skip
        assert words in seen.words, words
    assert re.search(r"mean.*1\.3", seen.words, re.S)
    assert "power" in seen.words  # in the series, not among the forces
    assert "body 0, power" not in seen.words.split("Statistics")[2].split("Spectrum")[0]


def test_everything_is_inside_the_page(tmp_path: Path) -> None:
    text = page(Run(make(tmp_path)))
    seen = Page(text)
    pictures = seen.all("img")
    assert len(pictures) == 4  # forces, spectrum, wake, movie
    assert all(str(attrs["src"]).startswith("data:image/") for attrs in pictures)
    assert all(len(str(attrs["alt"])) > 10 for attrs in pictures)
    rest = re.sub(r'src="data:[^"]*"', "", text)
    assert not re.search(r"https?://|@import|url\(|<script|<link", rest)
    policy = [a["content"] for a in seen.all("meta") if "http-equiv" in a]
    assert policy == [
        "default-src 'none'; img-src data:; media-src data:; style-src 'unsafe-inline'"
    ]
    assert "$" not in re.sub(r"<style>.*?</style>", "", rest, flags=re.S).replace("$t$", "")


def test_a_run_without_bodies_has_no_forces_and_one_without_an_end_no_metrics(
    tmp_path: Path,
) -> None:
    seen = Page(page(Run(make(tmp_path / "a", bodies=False)), "none"))
    assert sections(seen) == ["metrics", "vorticity", "series", "parameters", "cost-and-version"]
    seen = Page(page(Run(make(tmp_path / "b", done=False)), "none"))
    assert "not finished" in seen.words
    assert "FAIL" not in seen.words


def test_a_case_that_is_not_here_any_more_still_has_its_page(tmp_path: Path) -> None:
    folder = make(tmp_path)
    (folder / "case.toml").write_text('case = "gone.py:Gone"\n[parameters]\nsize = 3.0\n')
    seen = Page(page(Run(folder), "none"))
    assert "gone.py:Gone" in seen.words
    assert "size" in seen.words


def test_the_report_of_a_real_run_is_written_where_asked(tmp_path: Path) -> None:
    case = TaylorGreenCase.make({}, quick=True)
    run_case("taylor-green", case, tmp_path / "run")
    out = report(tmp_path / "run", tmp_path / "page.html")
    seen = Page(out.read_text(encoding="utf-8"))
    assert "Taylor-Green" in seen.words
    assert {"metrics", "figure", "vorticity", "series", "parameters"} <= set(sections(seen))
    assert not (tmp_path / "run" / "report.html").exists()


def test_a_run_that_goes_on_or_starts_anew_takes_its_old_report_away(tmp_path: Path) -> None:
    case = TaylorGreenCase.make({}, quick=True)
    for again in ({}, {"resume": True}, {"overwrite": True}):
        run_case("taylor-green", case, tmp_path, **again)
        assert not (tmp_path / "report.html").exists()
        report(tmp_path, movie="none")
        (tmp_path / "notes.txt").write_text("mine")
    assert (tmp_path / "notes.txt").exists()


def test_a_script_s_run_has_a_page_and_moving_bodies_have_their_motion(tmp_path: Path) -> None:
    folder = make(tmp_path / "falling", moving=True, done=False)
    (folder / "case.toml").unlink()
    lines = (folder / "series.csv").read_text().splitlines()
    ends = [",body0_u,body0_spin", *(f",{0.5 + 0.01 * k},0.0" for k in range(len(lines) - 1))]
    text = "".join(f"{a}{b}\n" for a, b in zip(lines, ends, strict=True))
    (folder / "series.csv").write_text(text)
    seen = Page(page(Run(folder), "none"))
    assert "falling" in seen.words
    assert "not finished" not in seen.words
    assert sections(seen) == [
        "forces", "motion", "statistics", "spectrum", "wake", "series",
    ]  # fmt: skip
    assert "body 0, u" in seen.words.split("Statistics")[2]


def test_a_run_in_space_shows_its_surfaces_and_their_movie(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(surfaces, "can_render", lambda: False)
    monkeypatch.setattr(
        vortex_figure, "vortex_figure", partial(vortex_figure.vortex_figure, pixels=150)
    )
    monkeypatch.setattr(module, "film", partial(module.film, pixels=100))
    folder = make(tmp_path, bodies=False)
    for path in (folder / "fields").glob("*"):
        path.unlink()
    small = Grid((17, 17, 17), 1 / 8, (-1.0, -1.0, -1.0))
    for step in (0, 1):
        path = folder / f"fields/{step:08d}.vtkhdf"
        write_snapshot(path, small, {"vorticity": ring(small)}, step, float(step))
    seen = Page(page(Run(folder)))
    assert {"vorticity", "movie", "series"} <= set(sections(seen))
    assert "Where vorticity = " in seen.words
    assert "Vortices from t = 0 to 1" in seen.words
    for step in (0, 1):
        path = folder / f"fields/{step:08d}.vtkhdf"
        write_snapshot(path, small, {"vorticity": 0 * ring(small)}, step, float(step))
    assert not {"vorticity", "movie"} & set(sections(Page(page(Run(folder)))))


def test_a_picture_that_cannot_be_drawn_is_a_line_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*args: object) -> None:
        raise InputError("the field is <nowhere>", hint="another one")

    monkeypatch.setattr(module, "wake_figure", refuse)
    monkeypatch.setattr(module, "film", refuse)
    seen = Page(page(Run(make(tmp_path))))
    assert {"wake", "movie", "forces", "spectrum", "series"} <= set(sections(seen))
    assert seen.words.count("No picture: the field is <nowhere>.") == 2


def test_cuts_in_space_have_one_scale_and_show_what_is_alive(tmp_path: Path) -> None:
    wide = Grid((49, 33, 33), 1 / 16, (-1.0, -1.0, -1.0))
    held = {"vorticity": ring(wide) + 1e-6}
    one = write_snapshot(tmp_path / "1.vtkhdf", wide, held, 1, 0.0)
    figure, _ = vortex_figure.vortex_figure(one, pixels=150)
    cuts = [panel for panel in figure.axes if panel.images and panel.get_xlabel()]
    assert len({panel.images[0].get_clim() for panel in cuts}) == 1
    assert cuts[0].images[0].get_clim()[1] > 3.0
    assert all(panel.get_xlim()[1] < 1.2 for panel in cuts)


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no run"):
        report(tmp_path)
    with pytest.raises(InputError, match="movie must be"):
        report(make(tmp_path), movie="avi")  # type: ignore[arg-type]
    assert not (tmp_path / "report.html").exists()
