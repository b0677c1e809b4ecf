"""Movies of interfaces: where the inside is, in the plane and in space, and what is left of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pmesh.cases.frames import STRIP
from pmesh.cases.interface_film import interface_film, interface_of
from pmesh.cases.movie import INK, PAPER, film, movie
from pmesh.run.rundir import SNAPSHOTS
from pmesh.run.snapshots import Snapshot, read_snapshots, write_snapshot
from remesh.errors import InputError
from remesh.grid import Grid

PLANE = Grid((41, 31), 0.05)
ROOM = Grid((29, 25, 25), 1 / 16)
OFFSETS = (0.0, 0.2, 0.4)


def ball(
    folder: Path, step: int, grid: Grid, *, x: float, radius: float = 0.25, name: str = "level_set",
    **more: Any,
) -> Snapshot:  # fmt: skip
    """A ball at (x, 0.75, ...)."""
    centre = np.array([x] + [0.75] * (grid.ndim - 1)).reshape(-1, *(1,) * grid.ndim)
    away = np.linalg.norm(grid.points() - centre, axis=0)
    path = folder / SNAPSHOTS / f"{step:08d}.vtkhdf"
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_snapshot(path, grid, {name: away - radius, **more}, step, 0.1 * step)


def moving(folder: Path, grid: Grid, **more: Any) -> Path:
    """Three snapshots of a ball that moves along x."""
    for step, offset in enumerate(OFFSETS):
        ball(folder, step, grid, x=0.6 + offset, **more)
    return folder


def pictures(folder: Path, **options: Any) -> list[np.ndarray]:
    return [p[STRIP:].astype(int) for p in film(read_snapshots(folder), **options).pixels]


def blue(picture: np.ndarray) -> np.ndarray:
    return picture[..., 2] > picture[..., 0] + 25


def test_the_inside_is_filled_and_goes_where_it_goes(tmp_path: Path) -> None:
    found = pictures(moving(tmp_path, PLANE), pixels=300)
    assert {picture.shape[1:] for picture in found} == {(300, 3)}
    places = np.array([np.argwhere(blue(picture)).mean(axis=0) for picture in found])
    scale = (places[2, 1] - places[0, 1]) / (OFFSETS[2] - OFFSETS[0])
    assert np.diff(places[:, 1]) == pytest.approx(0.2 * scale, abs=0.5)
    assert np.ptp(places[:, 0]) < 0.5
    for picture in found:
        assert blue(picture).sum() / scale**2 == pytest.approx(np.pi * 0.25**2, rel=0.05)


def test_up_is_up_in_the_plane(tmp_path: Path) -> None:
    x, y = PLANE.points()
    phi = np.maximum(np.maximum(abs(x - 1) - 0.5, abs(y - 0.75) - 0.5), 0.9 - y)  # high up
    low = np.maximum(np.maximum(abs(x - 1) - 0.5, abs(y - 0.75) - 0.5), y - 0.6)
    folder = tmp_path / SNAPSHOTS
    folder.mkdir()
    for step, field in enumerate((phi, low)):
        write_snapshot(folder / f"{step:08d}.vtkhdf", PLANE, {"phi": field}, step, float(step))
    first, second = (np.argwhere(blue(picture))[:, 0].mean() for picture in pictures(tmp_path))
    assert first < second - 100


def test_the_contour_at_the_start_stays_in_grey(tmp_path: Path) -> None:
    found = pictures(moving(tmp_path, PLANE), pixels=300)[2]
    grey = (np.ptp(found, axis=-1) < 6) & (found[..., 0] < 200)
    ring = np.argwhere(grey)
    assert len(ring) > 100
    assert ring[:, 1].max() < np.argwhere(blue(found))[:, 1].mean()


def test_following_keeps_it_in_its_place(tmp_path: Path) -> None:
    for grid, folder in ((PLANE, tmp_path / "2"), (ROOM, tmp_path / "3")):
        found = pictures(moving(folder, grid), pixels=160, follow=True)
        places = [np.argwhere(blue(picture)).mean(axis=0) for picture in found]
        assert np.ptp(places, axis=0) == pytest.approx(0.0, abs=1.5)


def test_an_interface_across_a_periodic_seam_is_whole(tmp_path: Path) -> None:
    grid = Grid((40, 40), 0.05, boundary="periodic")
    x, y = grid.points()
    far = np.hypot((x + 1) % 2 - 1, y - 1) - 0.3
    folder = tmp_path / SNAPSHOTS
    folder.mkdir()
    write_snapshot(folder / "00000000.vtkhdf", grid, {"level_set": far}, 0, 0.0)
    (found,) = pictures(tmp_path, pixels=600)
    scale = 600 / (2.05 * 1.12)  # a spacing more than the mesh, and a margin at each side
    assert blue(found).sum() / scale**2 == pytest.approx(np.pi * 0.3**2, rel=0.05)


def test_a_surface_in_space_moves_before_a_camera_that_stands_still(tmp_path: Path) -> None:
    found = pictures(moving(tmp_path, ROOM), pixels=160)
    assert len({picture.shape for picture in found}) == 1
    places = [np.argwhere(blue(picture))[:, 1].mean() for picture in found]
    assert np.diff(places).min() > 10
    assert all((picture[0, 0] == 255).all() for picture in found)


def test_a_movie_in_space_is_written_in_one_palette_with_white_in_it(tmp_path: Path) -> None:
    path = movie(moving(tmp_path, ROOM), pixels=128, fps=10)
    with Image.open(path) as film_:
        assert (film_.n_frames, max(film_.size[0], film_.size[1] - STRIP)) == (3, 128)
        film_.seek(2)
        last = np.asarray(film_.convert("RGB"))
    shown = pictures(tmp_path, pixels=128)[2]
    assert (last[STRIP, 0] == 255).all()
    assert np.abs(last[STRIP:] - shown).max() <= 24
    assert last[:STRIP, :60].min() < 90


def test_another_field_colours_the_surface(tmp_path: Path) -> None:
    x = ROOM.points()[0]
    field = np.where(np.abs(x - 0.8) < 0.6, x - 0.8, 1e9)  # what is far from it counts for nothing
    folder = moving(tmp_path, ROOM, heat=field)
    for picture in pictures(folder, field="heat", pixels=160)[1:2]:
        red = picture[..., 0] > picture[..., 2] + 25
        assert np.argwhere(red)[:, 1].mean() > np.argwhere(blue(picture))[:, 1].mean() + 10
    pale = pictures(folder, field="heat", pixels=160, limit=1e6)[1]
    assert not blue(pale).any()


def test_values_on_a_surface_colour_it_unless_another_field_is_asked_for(tmp_path: Path) -> None:
    shown = np.clip(2 * (ROOM.points()[0] - 0.4), -1e-6, 1.0)  # from 0 up, to round-off
    shots = [ball(tmp_path, 0, ROOM, x=0.8, values=shown)]
    (by_default,), (asked,), (plain,) = (
        list(film(shots, field, pixels=128).pixels) for field in (None, "values", "level_set")
    )
    assert np.array_equal(by_default, asked)
    strong = by_default[STRIP:].astype(int)
    yellow = (strong[..., :2].min(axis=-1) > strong[..., 2] + 60).sum()
    assert yellow > 100  # the upper end of the colours of what is not signed
    assert blue(plain[STRIP:].astype(int)).any()


def test_values_of_both_signs_have_colours_even_about_zero(tmp_path: Path) -> None:
    shots = [ball(tmp_path, 0, ROOM, x=0.8, values=ROOM.points()[0] - 0.7)]
    (picture,) = (p[STRIP:].astype(int) for p in film(shots, pixels=128).pixels)
    assert (picture[..., 0] > picture[..., 1] + 60).any()  # red


@pytest.mark.parametrize(("sign", "colour"), [(1.0, PAPER), (-1.0, INK)])
def test_an_interface_is_a_line_over_the_vorticity(
    tmp_path: Path, sign: float, colour: int
) -> None:
    x, y = PLANE.points()
    vorticity = sign * np.exp(-((x - 1.4) ** 2 + (y - 0.75) ** 2) / 0.02)
    shots = [ball(tmp_path, k, PLANE, x=place, vorticity=vorticity)
             for k, place in enumerate((0.5, 0.9))]  # fmt: skip
    middles = []
    for picture in film(shots, pixels=400).pixels:
        line = np.argwhere(picture[STRIP:] == colour)
        middle, size = line.mean(axis=0), np.ptp(line, axis=0)
        away = np.hypot(*(line - middle).T)
        assert np.ptp(size) <= 2
        assert away == pytest.approx(size.mean() / 2, abs=3)  # a ring, and empty
        middles.append((*middle, size.mean() / 0.5))
    (row, column, scale), (lower, further, _) = middles
    assert further - column == pytest.approx(0.4 * scale, rel=0.02)
    assert row == pytest.approx(lower, abs=0.5)


def test_an_interface_that_has_gone_leaves_an_empty_picture(tmp_path: Path) -> None:
    for grid, folder in ((PLANE, tmp_path / "2"), (ROOM, tmp_path / "3")):
        ball(folder, 0, grid, x=0.7)
        ball(folder, 1, grid, x=0.7, radius=-0.1)
        there, gone = pictures(folder, pixels=100)
        assert blue(there).any()
        assert not blue(gone).any()


def test_vorticity_is_shown_before_an_interface_in_the_plane(tmp_path: Path) -> None:
    more = {"vorticity": np.ones(PLANE.shape)}
    shots = [ball(tmp_path, 0, PLANE, x=0.7, **more)]
    assert film(shots).palette is not None
    assert film(shots, "level_set").palette is None
    assert (
        film([ball(tmp_path, 0, ROOM, x=0.7, vorticity=np.ones((3, *ROOM.shape)))]).palette is None
    )


def test_what_has_no_interface_is_refused(tmp_path: Path) -> None:
    shots = [ball(tmp_path, 0, ROOM, x=0.7, name="temperature")]
    assert interface_of(shots) is None
    with pytest.raises(InputError, match="hold no level set"):
        interface_film(shots, "phi")
    with pytest.raises(InputError, match="no field 'vorticity'"):
        film(shots)
    with pytest.raises(InputError, match="nothing is inside"):
        list(film([ball(tmp_path, 1, ROOM, x=0.7, radius=-1.0)]).pixels)
    with pytest.raises(InputError, match="no colours to limit"):
        film([ball(tmp_path, 2, ROOM, x=0.7)], limit=1.0)
