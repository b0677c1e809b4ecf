"""Frames and their files: one palette for colours, the time as text."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from pmesh.cases.frames import BAR, STRIP, Frames, colour_strip, strip, written


def read(content: bytes) -> list[np.ndarray]:
    with Image.open(io.BytesIO(content)) as film:
        pictures = []
        for k in range(film.n_frames):
            film.seek(k)
            pictures.append(np.asarray(film.convert("RGB")))
    return pictures


def test_a_few_colours_come_back_as_they_were() -> None:
    rng = np.random.default_rng(3)
    colours = np.vstack([rng.integers(0, 255, (40, 3)), [255, 255, 255]]).astype(np.uint8)
    given = [colours[rng.integers(0, 41, (20, 30))] for _ in range(4)]
    for one, other in zip(read(written(Frames(pixels=iter(given)), "gif", 10)), given, strict=True):
        assert np.array_equal(one, other)


def test_a_faint_ramp_on_much_white_keeps_its_steps() -> None:
    picture = np.full((100, 300, 3), 255, np.uint8)
    picture[50, :, :] = np.linspace(120, 255, 300)[:, None]
    (found,) = read(written(Frames(pixels=iter([picture])), "gif", 10))
    assert (found[0] == 255).all()
    assert np.abs(found[50].astype(int) - picture[50]).max() <= 1


def test_a_palette_is_taken_as_it_is() -> None:
    palette = np.arange(768).reshape(256, 3).astype(np.uint8)
    entries = np.arange(200, dtype=np.uint8).reshape(10, 20)
    (found,) = read(written(Frames(pixels=iter([entries]), palette=palette), "gif", 10))
    assert np.array_equal(found, palette[entries])


def test_a_strip_holds_both_texts_or_the_left_one() -> None:
    both, narrow = strip(300, "t = 1", "vorticity"), strip(90, "t = 1", "vorticity")
    assert both.shape == (STRIP, 300)
    assert both[:, 200:].min() < 80
    assert narrow[:, :50].min() < 80
    assert narrow[:, 60:].min() == 255


def test_a_strip_with_colours_ends_in_a_bar_from_the_lowest_to_the_highest() -> None:
    picture = colour_strip(400, "t = 1", "speed", (0.0, 2.0), "RdBu")
    row = picture[STRIP // 2].astype(int)
    coloured = np.flatnonzero(np.ptp(row, axis=1) > 60)
    red, blue = row[coloured[0]], row[coloured[-1]]
    assert red[0] > red[2] + 60
    assert blue[2] > blue[0] + 60
    assert np.ptp(coloured) <= BAR
    assert picture.shape == (STRIP, 400, 3)
    narrow = colour_strip(120, "t = 1", "speed", (0.0, 2.0))
    assert (np.ptp(narrow.astype(int), axis=-1) == 0).all()  # no place for it


def test_shadows_in_one_palette_with_many_colours_stay_grey() -> None:
    rng = np.random.default_rng(1)
    picture = rng.integers(0, 255, (60, 200, 3)).astype(np.uint8)
    shade = np.linspace(1.0, 0.7, 200)[:, None] * np.array([255.0, 255.0, 255.0])
    picture[30] = shade.astype(np.uint8)
    (found,) = read(written(Frames(pixels=iter([picture])), "gif", 10))
    assert np.ptp(found[30].astype(int), axis=-1).max() <= 8
    assert np.abs(found[30].astype(int) - picture[30]).max() <= 8
