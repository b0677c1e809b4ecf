"""How thick shapes are, however they lie."""

from __future__ import annotations

import numpy as np
import pytest

from levelset.ellipse import Ellipse
from levelset.shapes import Box, Disk, Sphere
from levelset.solids import Capsule
from levelset.thickness import thickness
from remesh.errors import InputError


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.7, 1.2])
@pytest.mark.parametrize("thick", [0.003, 0.01, 0.1])
def test_a_plate_is_as_thick_as_its_short_side_however_it_leans(angle: float, thick: float) -> None:
    plate = Box((thick, 0.5)).moved((0.2, -0.1), angle)
    assert thickness(plate) == pytest.approx(thick, abs=1e-3 * 0.5)
    assert thickness(plate) <= thick + 1e-12


@pytest.mark.parametrize("angle", [(0.0, 0.0, 0.0), (0.4, -0.3, 0.7), (0.0, 0.9, 0.0)])
def test_a_plate_in_space_is_as_thick_as_its_short_side(angle: tuple[float, ...]) -> None:
    plate = Box((0.02, 0.5, 0.3)).moved((0.2, -0.1, 0.3), angle)
    assert thickness(plate) == pytest.approx(0.02, abs=1e-3 * 0.5)


@pytest.mark.parametrize(
    ("shape", "exact"),
    [
        (Disk(0.3), 0.6),
        (Sphere(0.1, center=(0.3, 0.2, 0.1)), 0.2),
        (Box((1.0, 0.4, 0.3)), 0.3),
        (Ellipse((0.5, 0.02)), 0.04),
        (Capsule((-0.5, -0.4, 0.1), (0.6, 0.3, 0.2), 0.05), 0.1),
        (Disk(0.1) | Disk(0.2, center=(1.0, 0.3)), 0.4),
    ],
)
def test_a_shape_is_twice_as_thick_as_its_deepest_point_is_deep(shape, exact: float) -> None:
    size = float(np.ptp(shape.bounds(), axis=0).max())
    assert thickness(shape) == pytest.approx(exact, abs=1e-3 * size)
    assert thickness(shape.moved(angle=(0.6,) if shape.ndim == 2 else (0.1, 0.6, 0.2))) == (
        pytest.approx(exact, abs=1e-3 * size)
    )


def test_a_shape_without_an_inside_is_refused() -> None:
    with pytest.raises(InputError, match="the shape has no inside: Difference"):
        thickness(Disk(0.3) - Disk(0.4))
