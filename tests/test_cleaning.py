"""Divergence cleaning: what it takes and what it leaves."""

from __future__ import annotations

import numpy as np
import pytest

from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex.budget import Moments
from remesh.cleaning import STRENGTH, clean_divergence
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.stencils import curl, divergence, divergence_ratio, gradient

WRAPPED = Grid((12, 14, 16), 0.3, None, "periodic")
OPEN = Grid((26, 24, 28), 0.2, (-2.0, -2.2, -2.5))
MIXED = Grid((26, 24, 16), 0.2, None, ("unbounded", "unbounded", "periodic"))


def noise(grid: Grid, dtype: type = np.float64) -> np.ndarray:
    """Random values well inside unbounded edges."""
    field = np.random.default_rng(5).standard_normal((3, *grid.shape))
    for axis, wraps in enumerate(grid.periodic):
        ends = [slice(None)] * 4
        for ends[axis + 1] in () if wraps else (slice(None, 7), slice(-7, None)):
            field[tuple(ends)] = 0.0
    return field.astype(dtype)


@pytest.mark.parametrize("grid", [WRAPPED, OPEN, MIXED])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_the_loops_are_the_law(grid, dtype):
    field = noise(grid, dtype)
    downhill = gradient(divergence(field, grid, order=6, edge="zero"), grid, order=6, edge="zero")
    expected = field + STRENGTH * grid.spacing**2 * downhill
    clean_divergence(field, grid)
    assert field.dtype == dtype
    np.testing.assert_allclose(field, expected, atol=1e-13 if dtype == np.float64 else 1e-5)


def test_what_has_no_divergence_stays():
    field = curl(noise(WRAPPED), WRAPPED, order=6)
    cleaned = field.copy()
    clean_divergence(cleaned, WRAPPED)
    np.testing.assert_allclose(cleaned, field, atol=1e-12)


def test_a_wave_loses_the_part_of_its_divergence_that_its_length_says():
    for number in (1, 2, 4):
        x = WRAPPED.points()[0]
        k = 2 * np.pi * number / WRAPPED.length[0]
        field = np.stack([np.cos(k * x), 0 * x, np.cos(k * x)])
        h = WRAPPED.spacing
        symbol = 1.5 * np.sin(k * h) - 0.3 * np.sin(2 * k * h) + np.sin(3 * k * h) / 30
        expected = (1.0 - STRENGTH * symbol**2) * field[0]
        across = field[2].copy()
        clean_divergence(field, WRAPPED)
        np.testing.assert_allclose(field[0], expected, atol=1e-13)
        np.testing.assert_allclose(field[2], across, atol=1e-13)


def test_no_wave_grows_and_the_divergence_goes():
    field = noise(WRAPPED)
    ratios = [divergence_ratio(field, WRAPPED)]
    for _ in range(30):
        before = np.abs(np.fft.fftn(field, axes=(1, 2, 3)) ** 2).sum(axis=0)
        clean_divergence(field, WRAPPED)
        after = np.abs(np.fft.fftn(field, axes=(1, 2, 3)) ** 2).sum(axis=0)
        assert (after <= before * (1 + 1e-12) + 1e-9).all()
        ratios.append(divergence_ratio(field, WRAPPED))
    assert np.all(np.diff(ratios) < 0)
    assert ratios[-1] < 0.15 * ratios[0]


def test_sum_impulse_and_angular_impulse_stay():
    field = noise(OPEN)
    before = Moments(field, OPEN)
    clean_divergence(field, OPEN)
    after = Moments(field, OPEN)
    np.testing.assert_allclose(after.total, before.total, atol=1e-12)
    np.testing.assert_allclose(after.impulse, before.impulse, atol=1e-12)
    change = after.angular_impulse - before.angular_impulse
    lever = STRENGTH * OPEN.spacing**2 * before.total  # of a field whose sum is not zero
    np.testing.assert_allclose(change, -lever, atol=1e-12)


def test_the_velocity_that_it_induces_stays():
    solver = VelocitySolver(WRAPPED)
    field = noise(WRAPPED)
    field -= field.mean(axis=(1, 2, 3), keepdims=True)
    smooth = solver.diffuse(field, 0.5 * WRAPPED.spacing**2 * 16)
    before = solver.velocity(smooth)
    cleaned = smooth.copy()
    clean_divergence(cleaned, WRAPPED)
    assert np.abs(cleaned - smooth).max() > 1e-3 * np.abs(smooth).max()
    np.testing.assert_allclose(solver.velocity(cleaned), before, atol=1e-3 * np.abs(before).max())


def test_threads_change_no_bit():
    one, many = noise(MIXED), noise(MIXED)
    clean_divergence(one, MIXED, threads=1)
    clean_divergence(many, MIXED, threads=3, scratch=np.full(MIXED.shape, np.nan))
    np.testing.assert_array_equal(one, many)


def test_fields_that_are_not_in_space_are_refused():
    with pytest.raises(InputError, match="on a grid in space"):
        clean_divergence(np.zeros((2, 8, 8)), Grid((8, 8), 0.1))
    with pytest.raises(InputError, match="shape"):
        clean_divergence(np.zeros((3, 4, 4, 4)), WRAPPED)
    with pytest.raises(InputError, match="must hold floats"):
        clean_divergence(np.zeros((3, *WRAPPED.shape), int), WRAPPED)


@pytest.mark.parametrize(
    "scratch",
    [np.zeros((10, 14, 16)), np.zeros(WRAPPED.shape, np.float32), "the field itself"],
)
def test_a_scratch_that_does_not_fit_is_refused(scratch):
    field = noise(WRAPPED)
    before = field.copy()
    with pytest.raises(InputError, match="scratch must be"):
        clean_divergence(field, WRAPPED, scratch=field[0] if isinstance(scratch, str) else scratch)
    np.testing.assert_array_equal(field, before)
