"""Laws of the velocity laws: formulas, bounds of the time step, exact flows, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from levelset.laws import Deformation, Law, Rotation, Shear, SingleVortex, Uniform
from remesh.errors import InputError

Array = NDArray[np.float64]
RNG = np.random.default_rng(7)
AFFINE = [
    Uniform(velocity=(0.3, -1.2)),
    Uniform(velocity=(0.3, -1.2, 2.0)),
    Rotation(center=(0.2, 0.7), rate=1.5),
    Rotation(center=(0.2, 0.7, -0.1), rate=(1.5, -0.4, 0.9)),
    Shear(rate=-2.0, center=(0.5, 0.25)),
    Shear(rate=2.0, center=(0.5, 0.25, 0.1), along=2, across=0),
]
REVERSED = [SingleVortex(), Deformation()]
LAWS = [*AFFINE, *REVERSED]


def name(law: Law) -> str:
    return f"{type(law).__name__} {law.ndim}-D"


def places(law: Law, count: int = 500, spread: float = 3.0) -> Array:
    return spread * (RNG.random((count, law.ndim)) - 0.4)


def written(law: Law, time: float, positions: Array) -> Array:
    """The reversed fields as their docstrings write them."""
    s = np.sin(np.pi * positions.T) ** 2
    d = np.sin(2 * np.pi * positions.T)
    g = math.cos(math.pi * time / law.period)
    if law.ndim == 2:
        return g * np.stack([s[0] * d[1], -s[1] * d[0]], axis=1)
    return g * np.stack([2 * s[0] * d[1] * d[2], -d[0] * s[1] * d[2], -d[0] * d[1] * s[2]], axis=1)


def rows(law: Law, time: float, positions: Array) -> Array:
    """Row sums of the velocity gradient by central differences."""
    step, total = 1e-5, 0.0
    for axis in range(law.ndim):
        way = step * np.eye(law.ndim)[axis]
        change = law(time, positions + way) - law(time, positions - way)
        total = total + np.abs(change) / (2 * step)
    return np.asarray(total)


@pytest.mark.parametrize("law", REVERSED, ids=name)
@pytest.mark.parametrize("time", [0.0, 0.7, 5.0])
def test_a_reversed_field_is_its_formula_in_and_beyond_the_unit_box(law: Law, time: float) -> None:
    x = places(law, 2000, 6.0)
    assert np.abs(law(time, x) - written(law, time, x)).max() < 1e-14


def test_the_single_vortex_turns_anticlockwise_at_first_and_back_after_half_its_period() -> None:
    above = np.array([[0.5, 0.75]])
    assert SingleVortex()(0.0, above) == pytest.approx(np.array([[-1.0, 0.0]]), abs=1e-15)
    assert SingleVortex()(8.0, above) == pytest.approx(np.array([[1.0, 0.0]]), abs=1e-15)
    assert SingleVortex()(4.0, above) == pytest.approx(0.0, abs=1e-15)


def test_a_vortex_without_end_never_turns_back() -> None:
    above = np.array([[0.5, 0.75]])
    law = SingleVortex(period=math.inf)
    assert np.array_equal(law(0.0, above), law(1e6, above))


def test_nothing_crosses_the_faces_of_the_unit_box() -> None:
    for law in REVERSED:
        for axis in range(law.ndim):
            for face in (0.0, 1.0):
                x = RNG.random((100, law.ndim))
                x[:, axis] = face
                assert np.abs(law(0.0, x)[:, axis]).max() < 1e-30


@pytest.mark.parametrize("law", LAWS, ids=name)
def test_every_field_is_free_of_divergence(law: Law) -> None:
    x, step = places(law), 1e-4
    total = sum(
        (law(0.4, x + step * way) - law(0.4, x - step * way))[:, axis] / (2 * step)
        for axis, way in enumerate(np.eye(law.ndim))
    )
    assert np.abs(total).max() < 1e-6


@pytest.mark.parametrize("law", REVERSED, ids=name)
@pytest.mark.parametrize("time", [0.0, 1.0])
def test_the_largest_speed_and_gradient_of_a_reversed_field_are_met_and_not_passed(
    law: Law, time: float
) -> None:
    line = np.linspace(0.0, 1.0, 65)
    x = np.stack(np.meshgrid(*[line] * law.ndim), axis=-1).reshape(-1, law.ndim)
    speed = np.sqrt((law(time, x) ** 2).sum(axis=1)).max()
    gradient = rows(law, time, x).max()
    assert speed == pytest.approx(law.max_speed(time), rel=1e-12)
    assert law.max_gradient(time) * 0.998 < gradient < law.max_gradient(time) * (1 + 1e-8)


@pytest.mark.parametrize("law", AFFINE, ids=name)
def test_the_largest_speed_and_gradient_of_an_affine_field_are_those_of_its_box(law: Law) -> None:
    low, high = np.full(law.ndim, -1.0), np.full(law.ndim, 2.0)
    x = low + (high - low) * np.round(RNG.random((2000, law.ndim)) * 6) / 6
    x[0], x[1] = low, high
    bounds = (tuple(low.tolist()), tuple(high.tolist()))
    speeds = np.sqrt((law(0.0, x) ** 2).sum(axis=1))
    assert speeds.max() == pytest.approx(law.max_speed(0.0, bounds), rel=1e-12)
    assert rows(law, 0.0, x).max() == pytest.approx(law.max_gradient(), rel=1e-9, abs=1e-9)


def test_the_speed_of_a_rotation_has_no_bound_without_a_box() -> None:
    assert Rotation(center=(0, 0), rate=1.0).max_speed() == math.inf
    assert Uniform(velocity=(3.0, 4.0)).max_speed() == 5.0


@pytest.mark.parametrize("law", AFFINE, ids=name)
def test_the_flow_of_an_affine_field_moves_with_it_and_goes_back(law: Law) -> None:
    x, step = places(law), 1e-5
    ahead, behind = law.flow(x, 1.0, 1.0 + step), law.flow(x, 1.0, 1.0 - step)
    assert (ahead - behind) / (2 * step) == pytest.approx(law(1.0, x), abs=1e-8)
    there = law.flow(x, 0.3, 2.1)
    assert law.flow(there, 2.1, 0.3) == pytest.approx(x, abs=1e-13)
    assert law.flow(law.flow(x, 0.3, 1.0), 1.0, 2.1) == pytest.approx(there, abs=1e-13)
    assert law.flow(x.astype(np.float32), 0.3, 2.1).dtype == np.float32


def test_a_positive_rate_turns_anticlockwise_and_a_period_is_one_turn() -> None:
    disk = Rotation(center=(50.0, 50.0), rate=2 * math.pi / 628)
    assert disk.period == pytest.approx(628.0)
    quarter = disk.flow(np.array([[60.0, 50.0]]), 0.0, 157.0)
    assert quarter == pytest.approx(np.array([[50.0, 60.0]]), abs=1e-12)
    sphere = Rotation(center=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 1.0))
    assert sphere(0.0, np.array([[1.0, 0.0, 5.0]])) == pytest.approx(np.array([[0.0, 1.0, 0.0]]))


@pytest.mark.parametrize("law", LAWS, ids=name)
def test_single_precision_stays_and_keeps_its_digits(law: Law) -> None:
    x = places(law).astype(np.float32)
    single, double = law(0.3, x), law(0.3, x.astype(np.float64))
    assert (single.dtype, double.dtype) == (np.float32, np.float64)
    assert np.abs(single - double).max() < 2e-6


@pytest.mark.parametrize("law", LAWS, ids=name)
def test_the_number_of_threads_does_not_change_a_bit(law: Law) -> None:
    x = places(law, 5003)
    one, two = law(0.3, x, threads=1), law(0.3, x, threads=2)
    assert np.array_equal(one, two)
    assert np.array_equal(law(0.3, x[:1]), one[:1])


def test_no_particles_have_no_velocities_and_lists_of_whole_numbers_are_taken() -> None:
    assert SingleVortex()(0.0, np.zeros((0, 2))).shape == (0, 2)
    assert SingleVortex()(0.0, np.array([[0, 1]])).dtype == np.float64


def test_a_place_that_is_not_finite_has_a_velocity_that_is_not() -> None:
    for law in REVERSED:
        x = np.full((3, law.ndim), 0.3)
        x[1] = np.nan
        assert np.isnan(law(0.0, x)[1]).all()
        assert np.isfinite(law(0.0, x)[[0, 2]]).all()


def test_particles_in_the_reversed_vortices_come_back_after_a_period() -> None:
    for law in REVERSED:
        x = start = RNG.random((50, law.ndim))
        steps = 400
        dt = law.period / steps
        for n in range(steps):
            a = law(n * dt, x)
            b = law((n + 0.5) * dt, x + 0.5 * dt * a)
            c = law((n + 0.5) * dt, x + 0.5 * dt * b)
            d = law((n + 1) * dt, x + dt * c)
            x = x + dt / 6 * (a + 2 * b + 2 * c + d)
        assert np.abs(x - start).max() < 1e-5


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda: Uniform(velocity=(1.0,)), "velocity must hold 2 or 3 finite numbers"),
        (lambda: Rotation(center=(0.0, 0.0), rate=(0.0, 0.0, 1.0)), "rate must be a number"),
        (lambda: Rotation(center=(0.0, 0.0, 0.0), rate=1.0), "rate must hold 3 finite numbers"),
        (lambda: Rotation(center=(0.0, 0.0), rate=math.nan), "rate must hold 1 finite number"),
        (lambda: Shear(rate=1.0, along=1), "along and across must be two different axes"),
        (lambda: Shear(rate=math.inf), "rate must hold 1 finite number"),
        (lambda: SingleVortex(period=0.0), "period must be positive"),
        (lambda: Deformation(period=math.nan), "period must be positive"),
        (lambda: SingleVortex()(0.0, np.zeros((2, 5))), r"positions must have shape \(n, 2\)"),
        (lambda: Deformation()(math.inf, np.zeros((2, 3))), "time must be finite"),
    ],
)
def test_what_cannot_be_is_refused(wrong, told: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=told):
        wrong()
