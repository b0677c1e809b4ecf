"""Movies of vortices in space: one camera, one level, one scale; slices; what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from vortex_shots import shot

from pmesh.cases import surfaces
from pmesh.cases.frames import STRIP
from pmesh.cases.movie import centre, film, movie
from pmesh.cases.structures import dye_picture, ftle_picture
from pmesh.cases.vortex_figure import vortex_figure
from pmesh.run.snapshots import read_snapshots
from remesh.errors import InputError


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawn by plain loops: the same anywhere."""
    monkeypatch.setattr(surfaces, "can_render", lambda: False)


def make(folder: Path, **options: Any) -> Path:
    for step in (0, 1, 2):
        shot(folder, step, **options)
    return folder


def pictures(folder: Path, **options: Any) -> list[np.ndarray]:
    return list(film(read_snapshots(folder), pixels=120, **options).pixels)


def middle(image: np.ndarray) -> np.ndarray:
    """Mean (row, column) of what is darker than a shadow."""
    return np.argwhere(image[STRIP:].min(axis=-1) < 150).mean(axis=0)


def test_a_ring_rises_past_a_camera_that_stands_still(tmp_path: Path) -> None:
    found = pictures(make(tmp_path))
    assert len({image.shape for image in found}) == 1
    rows = [middle(image)[0] for image in found]
    first, second = -np.diff(rows)
    assert first > 2
    assert second == pytest.approx(first, rel=0.25)  # it rises evenly
    assert all((image[STRIP:][[0, -1]] > 250).all() for image in found)  # nothing is cut off


def test_a_camera_that_follows_the_body_sees_it_in_its_place(tmp_path: Path) -> None:
    for step in (0, 1, 2):
        shot(tmp_path, step, side=0.15 * step, chi=True)
    shots = read_snapshots(tmp_path)
    assert [centre(one) for one in shots] == [
        pytest.approx((0.15 * k, 0.0, 0.0), abs=1e-3) for k in range(3)
    ]
    columns = {
        follow: np.ptp([middle(image)[1] for image in pictures(
            tmp_path, field="vorticity", colour_by="none", follow=follow
        )])
        for follow in (False, True)
    }  # fmt: skip
    assert columns[True] < 1.5 < 0.3 * columns[False]


def test_a_slice_is_a_plane_movie_of_the_vorticity_across_it(tmp_path: Path) -> None:
    folder = make(tmp_path)
    found = pictures(folder, cut="y=0")
    assert found[0].ndim == 2  # entries of a palette
    path = movie(folder, cut="z=0.1", field="lambda2", pixels=100)
    with Image.open(path) as made:
        assert made.n_frames == 3


def test_a_movie_of_q_at_a_level_seen_from_a_view_is_written(tmp_path: Path) -> None:
    path = movie(
        make(tmp_path), field="q", level=(2.0,), colour_by="vorticity", limit=4.0, view=(0.0, 60.0),
        pixels=100,
    )  # fmt: skip
    with Image.open(path) as made:
        assert (made.n_frames, max(made.size) >= 100) == (3, True)


def test_what_cannot_be_shown_is_refused(tmp_path: Path) -> None:
    folder = make(tmp_path)
    with pytest.raises(InputError, match="reaches the level 99 in no snapshot"):
        movie(folder, level=(99.0,))
    with pytest.raises(InputError, match="no field 'pressure'"):
        movie(folder, field="pressure")
    with pytest.raises(InputError, match="are of surfaces in space"):
        movie(folder, cut="z=0", level=(1.0,))
    with pytest.raises(InputError, match="no body to follow"):
        movie(folder, follow=True)
    with pytest.raises(InputError, match="no snapshots below 'fields-2'") as said:
        movie(folder, name="fields-2")
    assert "try: fields" in str(said.value)
    assert not (folder / "movie.gif").exists()


def test_pictures_of_ftle_and_dye_are_of_the_plane_only(tmp_path: Path) -> None:
    for step in (0, 1):
        one = shot(tmp_path, step)
        shot(tmp_path, step, velocity=one["vorticity"])
    for draw in (ftle_picture, dye_picture):
        with pytest.raises(InputError, match="of flows in the plane, this run is in space"):
            draw(tmp_path)


def test_the_figure_of_a_flow_has_surfaces_and_two_cuts(tmp_path: Path) -> None:
    figure, look = vortex_figure(shot(tmp_path, 1, chi=True), pixels=150)
    titles = [axes.get_title() for axes in figure.axes]
    assert look.field == "lambda2"
    assert [title for title in titles if title][1:] == ["$y$ = 0", "$z$ = 0"]
