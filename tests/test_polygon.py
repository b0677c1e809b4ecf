"""Polygons: their distance against a plain text of it, and corners from a file."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.naca import Naca
from levelset.polygon import Polygon
from remesh.errors import InputError

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))


def plain_distance(polygon, points):
    """The nearest side, and a count of crossings to the right."""
    x, y = points
    nearest, inside = np.full(x.shape, np.inf), np.zeros(x.shape, bool)
    for (ax, ay), (bx, by) in zip(
        polygon.corners, polygon.corners[1:] + polygon.corners[:1], strict=True
    ):
        share = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
        share = np.clip(share, 0, 1)
        nearest = np.minimum(
            nearest, np.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay))
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = ax + (y - ay) * (bx - ax) / (by - ay)
        inside ^= ((ay > y) != (by > y)) & (x < crossing)
    return np.where(inside, -nearest, nearest)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_compiled_distance_is_that_of_the_plain_text(dtype):
    rays = np.random.default_rng(1).uniform(0.5, 1.5, 40)
    turns = 2 * np.pi * np.arange(40) / 40
    star = Polygon(tuple(zip(rays * np.cos(turns), rays * np.sin(turns), strict=True)))
    points = np.random.default_rng(2).uniform(-2, 2, (2, 30, 50)).astype(dtype)
    found = star.distance(points)
    assert found.dtype == dtype
    assert found == pytest.approx(plain_distance(star, points.astype(float)), abs=1e-6)


@pytest.mark.parametrize(
    "text",
    [
        "0 0\n2 0\n2 2\n0 2\n",
        "A square\n 0.0  0.0\n\n 2.0  0.0\n 2.0  2.0\n 0.0  2.0\n 0.0 0.0\n",
        "# x, y\n0, 0\n2, 0  # corner\n2, 0\n2, 2\n0, 2\n",
        "title\nx y\n0;0\n2;0\n2;2\n0;2",
    ],
)
def test_a_file_of_two_columns_is_a_polygon(tmp_path, text):
    path = tmp_path / "square.txt"
    path.write_text(text)
    assert Polygon.from_file(path) == Polygon(SQUARE)
    assert Polygon.from_file(str(path), scale=0.5).volume == pytest.approx(1.0)


@pytest.mark.parametrize("order", ["selig", "lednicer"])
def test_aerofoil_files_in_either_order_are_the_aerofoil(tmp_path, order):
    foil = Naca("2412", center=(0.5, 0.0))
    ring = foil.outline(160)
    nose = len(ring) // 2
    path = tmp_path / "foil.dat"
    if order == "selig":
        rows = ["NACA 2412", *(f" {x:.8f} {y:.8f}" for x, y in [*ring, ring[0]])]
    else:
        upper, lower = ring[: nose + 1][::-1], [*ring[nose:], ring[0]]
        rows = ["NACA 2412", f" {len(upper)}. {len(lower)}.", ""]
        rows += [f" {x:.8f} {y:.8f}" for x, y in upper] + [""]
        rows += [f" {x:.8f} {y:.8f}" for x, y in lower]
    path.write_text("\n".join(rows))
    polygon = Polygon.from_file(path)
    assert polygon.volume == pytest.approx(foil.volume, rel=1e-3)
    points = np.random.default_rng(1).uniform(-0.2, 1.2, (2, 400))
    assert polygon.distance(points) == pytest.approx(foil.distance(points), abs=2e-4)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "holds 0 corners, a polygon needs 3"),
        ("title only\n", "holds 0 corners"),
        ("0 0\n1 0\n0 0\n", "holds 2 corners"),
        ("0 0\n1 0\nend\n", "line 3: two numbers asked, got 'end'"),
        ("0 0\n1 0 0\n1 1\n", "line 2: two numbers asked"),
        ("0 0\n1 nan\n1 1\n", "line 2: two numbers asked"),
        ("0 0\n2 2\n2 0\n0 1\n", "sides 0 and 2 meet"),
        ("0 0\n1 1\n2 2\n", "no area"),
    ],
)
def test_what_is_no_polygon_is_refused_with_its_line(tmp_path, text, said):
    path = tmp_path / "bad.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=said):
        Polygon.from_file(path)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"cannot read .*none\.dat: No such file"):
        Polygon.from_file(tmp_path / "none.dat")


def test_crossing_sides_are_found_among_many():
    turns = 2 * np.pi * np.arange(500) / 500
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    assert Polygon(tuple(map(tuple, ring))).volume == pytest.approx(np.pi, rel=1e-4)
    ring[[100, 102]] = ring[[102, 100]]
    with pytest.raises(InputError, match="meet"):
        Polygon(tuple(map(tuple, ring)))
