"""Movies: every snapshot in one window and one set of colours, bodies filled, files that play."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from made_run import make, shot
from PIL import Image

from pmesh.cases import frames as module
from pmesh.cases.frames import STRIP
from pmesh.cases.movie import BODY, LEVELS, RIM, centre, film, movie, palette, resampled
from pmesh.run.snapshots import read_snapshots, write_snapshot
from remesh.errors import InputError, StorageError
from remesh.grid import Grid


def body_at(picture: np.ndarray) -> float:
    """Middle of the body along x, as a part of the picture."""
    columns = np.flatnonzero(((picture == BODY) | (picture == RIM)).any(axis=0))
    return float(columns.mean() / picture.shape[1])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_resampling_is_exact_for_bilinear_fields_and_zero_beyond_the_mesh(dtype: type) -> None:
    grid = Grid((9, 7), 0.5, (-1.0, 2.0))
    px, py = grid.points()
    field = (1 + 2 * px - py + 0.5 * px * py).astype(dtype)
    x, y = np.linspace(-0.9, 2.9, 23), np.linspace(2.1, 4.9, 31)
    exact = 1 + 2 * x[:, None] - y + 0.5 * x[:, None] * y
    assert resampled(field, grid, x, y) == pytest.approx(exact, abs=1e-5)
    assert not resampled(field, grid, np.array([-9.0, 9.0]), y).any()


def test_resampling_wraps_a_periodic_axis() -> None:
    grid = Grid((8, 4), 0.5, boundary=("periodic", "unbounded"))
    field = np.arange(8.0)[:, None] * np.ones(4)
    found = resampled(field, grid, np.array([0.25, 3.75, 4.25, -0.25]), np.array([0.5]))
    assert found[:, 0] == pytest.approx([0.5, 3.5, 0.5, 3.5])


def test_all_pictures_have_one_window_and_one_scale(tmp_path: Path) -> None:
    shots = read_snapshots(make(tmp_path, moving=True))
    pictures = list(film(shots, pixels=200).pixels)
    assert len({picture.shape for picture in pictures}) == 1
    assert pictures[0].shape[1] == 200
    assert pictures[0].shape[0] % 2 == 0
    places = [body_at(picture) for picture in pictures]
    assert np.diff(places).min() > 0.04  # it moves to the right


def test_up_is_up_and_signs_have_their_colours(tmp_path: Path) -> None:
    one = shot(tmp_path / "1.vtkhdf", 0.0, bodies=False)  # negative above, positive below
    (picture,) = film([one], pixels=200).pixels
    field = picture[STRIP:]
    half = field.shape[0] // 2
    assert field[:half].min() == 0
    assert field[half:].max() == LEVELS - 1
    assert field[: half - 8].max() <= LEVELS // 2
    red, _, blue = palette(signed=True)[LEVELS - 1]
    assert red > 2 * blue


def test_following_keeps_the_body_in_its_place(tmp_path: Path) -> None:
    shots = read_snapshots(make(tmp_path, moving=True))
    assert [centre(one) for one in shots] == [
        pytest.approx((0.5 * one.time, 0.0), abs=2e-3) for one in shots
    ]
    places = [body_at(picture) for picture in film(shots, pixels=200, follow=True).pixels]
    assert np.ptp(places) < 0.02


def test_a_body_is_filled_with_a_rim_around_it(tmp_path: Path) -> None:
    one = shot(tmp_path / "1.vtkhdf", 0.0)
    (picture,) = film([one], pixels=300).pixels
    field = picture[STRIP:]
    inside = (field == BODY) | (field == RIM)
    scale = field.shape[1] / np.diff(_window(one)[:2])[0]
    assert inside.sum() / scale**2 == pytest.approx(np.pi * 0.55**2, rel=0.06)
    assert 0 < (field == RIM).sum() < 0.1 * inside.sum()


def _window(one: object) -> tuple[float, ...]:
    from pmesh.cases.wake import window

    return window([one])  # type: ignore[list-item]


def test_a_gif_plays_all_snapshots_again_and_again_and_is_small(tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    path = movie(folder, fps=10)
    assert path == folder / "movie.gif"
    assert path.stat().st_size < 4 * 80_000  # five megabytes for sixty
    with Image.open(path) as film_:
        assert film_.n_frames == 4
        assert film_.info["duration"] == 100
        assert film_.info["loop"] == 0
        assert film_.size[0] == 640
        film_.seek(2)
        grey = np.asarray(film_.convert("RGB"))[:STRIP, :120].min(axis=2)
    assert grey.min() < 80  # the time is written there


def test_a_movie_shows_the_field_and_goes_where_asked(tmp_path: Path) -> None:
    folder = make(tmp_path / "run")
    path = movie(folder, tmp_path / "speed.gif", field="velocity", pixels=128, limit=3.0)
    with Image.open(path) as film_:
        assert film_.size[0] == 128
    assert not (folder / "movie.gif").exists()


def test_what_cannot_be_shown_is_refused(tmp_path: Path) -> None:
    folder = make(tmp_path / "run", bodies=False)
    with pytest.raises(InputError, match="no field 'pressure'") as said:
        movie(folder, field="pressure")
    assert "velocity, vorticity" in str(said.value)
    with pytest.raises(InputError, match="holds no snapshots"):
        movie(tmp_path)
    with pytest.raises(InputError, match="no body to follow"):
        movie(folder, follow=True)
    with pytest.raises(InputError, match="one of gif, mp4"):
        movie(folder, kind="avi")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="fps must be"):
        movie(folder, fps=0)
    assert not (folder / "movie.gif").exists()


def test_an_mp4_without_ffmpeg_is_refused_with_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setattr(module.shutil, "which", lambda name: None)
    with pytest.raises(InputError, match="needs ffmpeg") as said:
        movie(make(tmp_path), kind="mp4")
    assert 'pip install "pmesh-flow[movie]"' in str(said.value)


def test_ffmpeg_is_given_every_picture_and_its_failure_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text(
        f'#!/bin/sh\nfor last; do :; done\ncat > "$last"\necho "$@" > {tmp_path}/said\n'
    )
    program.chmod(0o755)
    package = ModuleType("imageio_ffmpeg")
    package.get_ffmpeg_exe = lambda: str(program)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", package)
    folder = make(tmp_path / "run")
    path = movie(folder, kind="mp4", pixels=100, fps=5)
    size = (tmp_path / "said").read_text().split("-s ")[1].split()[0]
    width, height = map(int, size.split("x"))
    assert (width, width % 2, height % 2) == (100, 0, 0)
    assert path.stat().st_size == 4 * 3 * width * height
    program.write_text("#!/bin/sh\ncat > /dev/null\necho no such codec >&2\nexit 1\n")
    with pytest.raises(StorageError, match="no such codec"):
        movie(folder, kind="mp4")


def test_a_tall_window_gives_a_tall_picture(tmp_path: Path) -> None:
    grid = Grid((32, 128), 0.1)
    field = np.ones(grid.shape)
    one = write_snapshot(tmp_path / "1.vtkhdf", grid, {"vorticity": field}, 0, 0.0)
    (picture,) = film([one], pixels=200).pixels
    assert picture.shape[0] == 200 + STRIP
    assert picture.shape[1] < 80
