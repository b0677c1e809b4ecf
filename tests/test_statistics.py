"""Statistics: on signals whose mean, rms, period and uncertainty are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.run.statistics import Estimate, mean, periodic, rms, spectrum, statistics
from remesh.errors import InputError

PERIOD, W = 5.1, 2 * math.pi / 5.1
STEPS = 0.03 * (1 + 0.5 * np.random.default_rng(1).random(6000))
TIME = np.cumsum(STEPS)


def wave(t: np.ndarray) -> np.ndarray:
    """Mean 1.3, amplitude of the fundamental 0.3, an even and an odd harmonic."""
    return 1.3 + 0.3 * np.sin(W * t) + 0.05 * np.sin(2 * W * t + 1) + 0.02 * np.cos(3 * W * t)


def step_means(t: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """Exact means of the wave over steps."""

    def integral(x: np.ndarray) -> np.ndarray:
        return (
            1.3 * x
            - 0.3 / W * np.cos(W * x)
            - 0.05 / (2 * W) * np.cos(2 * W * x + 1)
            + 0.02 / (3 * W) * np.sin(3 * W * x)
        )

    return (integral(t) - integral(t - dt)) / dt


FINE = wave(np.linspace(0, PERIOD, 100_001))
AMPLITUDE, RMS = (
    0.5 * float(FINE.max() - FINE.min()),
    math.sqrt((0.3**2 + 0.05**2 + 0.02**2) / 2),
)


@pytest.mark.parametrize("by_steps", [False, True])
def test_a_periodic_signal_at_uneven_times_gives_its_exact_numbers(by_steps: bool) -> None:
    values, dt = (step_means(TIME, STEPS), STEPS) if by_steps else (wave(TIME), None)
    cycle = periodic(TIME, values, dt)
    assert cycle.period.value == pytest.approx(PERIOD, rel=1e-7)
    assert cycle.frequency.value == pytest.approx(1 / PERIOD, rel=1e-7)
    assert cycle.mean.value == pytest.approx(1.3, abs=1e-7)
    assert cycle.amplitude.value == pytest.approx(AMPLITUDE, rel=1e-3)  # 128 samples of extremes
    assert cycle.rms.value == pytest.approx(RMS, rel=1e-6)
    assert abs(cycle.drift) < 1e-8
    assert cycle.cycles == math.floor(TIME[-1] / PERIOD) - 2  # a period at each end
    assert cycle.end - cycle.start == pytest.approx(cycle.cycles * PERIOD, rel=1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_single_precision_columns_do_too(dtype: type) -> None:
    cycle = periodic(TIME, wave(TIME).astype(dtype))
    assert cycle.period.value == pytest.approx(PERIOD, rel=1e-5)
    assert cycle.mean.value == pytest.approx(1.3, abs=1e-5)


def test_the_start_of_the_periodic_part_is_where_the_transient_is_within_tolerance() -> None:
    decay = 0.5 * np.exp(-TIME / 10)  # 0.02 * 1.3 at t = 10 ln(0.5/0.026) = 29.6
    cycle = periodic(TIME, wave(TIME) + decay)
    assert 29.6 - PERIOD < cycle.start < 29.6 + PERIOD
    assert abs(cycle.mean.value - 1.3) < 3 * cycle.mean.uncertainty
    late = periodic(TIME, wave(TIME) + decay, after=100.0)
    assert late.start > 100
    assert abs(late.mean.value - 1.3) < 1e-4


def test_a_growing_oscillation_counts_from_when_it_has_grown() -> None:
    growth = 1 / (1 + np.exp(-(TIME - 60) / 5))  # within 2 % from t = 79.5 on
    cycle = periodic(TIME, growth * np.sin(W * TIME))
    assert 79.5 - PERIOD < cycle.start < 79.5 + PERIOD
    assert cycle.amplitude.value == pytest.approx(1.0, rel=1e-3)


def test_a_slow_drift_is_told() -> None:
    cycle = periodic(TIME, wave(TIME) + 1e-4 * TIME)
    assert cycle.drift == pytest.approx(1e-4 * PERIOD, rel=0.02)


def test_noise_is_within_the_uncertainty_of_mean_and_period() -> None:
    off = []
    for seed in range(30):
        noise = 0.003 * np.random.default_rng(seed).standard_normal(TIME.size)
        cycle = periodic(TIME, wave(TIME) + noise)
        off.append((cycle.mean.value - 1.3) / cycle.mean.uncertainty)
        assert abs(cycle.period.value - PERIOD) < 4 * cycle.period.uncertainty
    assert 0.6 < np.std(off) < 1.5


def test_the_error_of_the_mean_of_correlated_noise_is_the_exact_one() -> None:
    """x[i] = f x[i-1] + e[i]: the variance of the mean is 1 / (1 - f)^2 / n."""
    n, f, errors, told = 4000, 0.9, [], []
    rng = np.random.default_rng(3)
    for _ in range(100):
        noise = rng.standard_normal(n)
        values = np.empty(n)
        values[0] = noise[0] / math.sqrt(1 - f * f)
        for i in range(1, n):
            values[i] = f * values[i - 1] + noise[i]
        found = mean(np.arange(1.0, n + 1), values, np.ones(n))
        assert found.value == pytest.approx(values.mean(), abs=1e-12)
        errors.append(found.value)
        told.append(found.uncertainty)
    exact = 1 / (1 - f) / math.sqrt(n)
    assert np.mean(told) == pytest.approx(exact, rel=0.1)
    assert np.std(errors) == pytest.approx(exact, rel=0.25)


def test_rms_of_noise_has_its_exact_error() -> None:
    values = np.random.default_rng(5).standard_normal(20_000)
    found = rms(np.arange(1.0, 20_001), values, np.ones(20_000))
    whole = mean(np.arange(1.0, 20_001), values, np.ones(20_000))
    assert whole.uncertainty == pytest.approx(1 / math.sqrt(20_000), rel=0.2)
    assert found.value == pytest.approx(1.0, abs=0.25)  # of the curve through the noise
    assert found.uncertainty == pytest.approx(1 / math.sqrt(40_000), rel=0.5)


def test_a_mean_over_less_than_ten_correlation_times_has_no_uncertainty() -> None:
    assert math.isnan(mean(TIME[:100], TIME[:100]).uncertainty)


def test_the_mean_of_a_constant_is_certain() -> None:
    assert mean(TIME, np.full(TIME.size, 2.5)) == pytest.approx((2.5, 0.0), abs=1e-13)


def test_the_spectrum_holds_the_variance_and_peaks_at_the_frequency() -> None:
    found = spectrum(TIME, wave(TIME))
    held = found.power.sum() * (found.frequency[1] - found.frequency[0])
    assert held == pytest.approx(RMS**2, rel=1e-3)
    peak = found.peak()
    assert peak.value == pytest.approx(1 / PERIOD, rel=1e-3)
    assert peak.uncertainty == 0.5 * found.resolution


def test_statistics_go_by_cycles_where_there_are_some_and_say_why_not_elsewhere() -> None:
    found = statistics(TIME, wave(TIME))
    assert found.cycle == periodic(TIME, wave(TIME))
    assert (found.mean, found.rms, found.note) == (found.cycle.mean, found.cycle.rms, "")
    ramp = statistics(TIME, TIME)
    assert ramp.cycle is None
    assert ramp.note
    assert ramp.start == pytest.approx(0.5 * (TIME[0] + TIME[-1]))
    assert ramp.mean.value == pytest.approx(0.75 * TIME[-1], rel=1e-2)
    assert statistics(TIME, TIME, after=100.0).start == 100.0


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (np.full(TIME.size, 1.5), "does not oscillate"),
        (wave(TIME) * np.exp(TIME / 30), "still differ|whole cycles"),
        (np.random.default_rng(2).standard_normal(TIME.size), "still differ|whole cycles"),
    ],
)
def test_what_is_not_periodic_is_refused(values: np.ndarray, words: str) -> None:
    with pytest.raises(InputError, match=words):
        periodic(TIME, values)


def test_a_record_of_too_few_cycles_is_refused_with_their_number() -> None:
    short = TIME < 3.6 * PERIOD
    with pytest.raises(InputError, match=r"holds 3\.\d cycles of 5.*5 are needed"):
        periodic(TIME[short], wave(TIME[short]))
    with pytest.raises(InputError, match="least must be at least 3"):
        periodic(TIME, wave(TIME), least=1)


def test_an_estimate_shows_the_digits_that_its_uncertainty_leaves() -> None:
    assert str(Estimate(1.33852, 0.0021)) == "1.3385 ± 0.0021"
    assert str(Estimate(1.33852, math.nan)) == "1.3385"
    assert str(Estimate(12345.6, 30.0)) == "12346 ± 30"
    assert str(Estimate(-1e-5, 0.017)) == "0.000 ± 0.017"
    assert str(Estimate(5.4e-8, 1.2e-6)) == "5.4e-08 ± 1e-06"
