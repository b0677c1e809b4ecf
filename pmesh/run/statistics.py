"""Statistics of a record: mean, rms, spectrum and cycles, each with its uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmesh.run.record import Record, Values, record
from remesh.errors import InputError

SAMPLES = 128  # per cycle
ROUND_OFF = 1e-6  # of the mean: what is smaller is no oscillation
LONGEST = 1 << 17  # samples of a spectrum


class Estimate(NamedTuple):
    """A value and its standard uncertainty; NaN where the record cannot tell it."""

    value: float
    uncertainty: float

    def __str__(self) -> str:
        """The value to the digits that its uncertainty leaves."""
        if not (math.isfinite(self.uncertainty) and self.uncertainty > 0):
            return f"{self.value:.5g}"
        digits = max(0, 1 - math.floor(math.log10(self.uncertainty)))
        if digits > 6 or abs(self.value) >= 1e6:
            small = abs(self.value) < 10 * self.uncertainty
            return f"{self.value:.{2 if small else 6}g} ± {self.uncertainty:.1g}"
        return f"{round(self.value, digits) + 0.0:.{digits}f} ± {self.uncertainty:.{digits}f}"


@dataclass(frozen=True)
class Spectrum:
    """Power spectral density of a record, one-sided: its sum times the spacing is the variance."""

    frequency: Values  # [1/T]
    power: Values  # [Q^2 T]
    resolution: float  # 1 / length of the record [1/T]

    def peak(self) -> Estimate:
        """The dominant frequency [1/T] that fits twice or more; uncertain by half the resolution.

        A parabola through the logarithm of the three highest values. :func:`periodic` is sharper.
        """
        first = int(np.searchsorted(self.frequency, 2.0 * self.resolution))
        place = first + int(np.argmax(self.power[first:]))
        shift = 0.0
        if 0 < place < self.power.size - 1 and self.power[place - 1 : place + 2].min() > 0:
            low, mid, high = np.log(self.power[place - 1 : place + 2])
            bend = low - 2 * mid + high
            shift = 0.5 * (low - high) / bend if bend < 0 else 0.0
        spacing = self.frequency[1] - self.frequency[0]
        return Estimate(
            float(self.frequency[place] + np.clip(shift, -1, 1) * spacing), 0.5 * self.resolution
        )


@dataclass(frozen=True, kw_only=True)
class Cycle:
    """The periodic part of a record, each number a mean over its whole cycles."""

    start: float  # from when the record is periodic [T]
    end: float  # of the last whole cycle [T]
    cycles: int
    period: Estimate  # [T]
    mean: Estimate  # [Q]
    amplitude: Estimate  # half of peak to peak within a cycle [Q]
    rms: Estimate  # about the mean of the cycle [Q]
    drift: float  # change of the mean from cycle to cycle [Q]

    @property
    def frequency(self) -> Estimate:
        """Cycles per time [1/T]."""
        f = 1.0 / self.period.value
        return Estimate(f, self.period.uncertainty * f * f)


@dataclass(frozen=True, kw_only=True)
class Statistics:
    """What can be said of a record: by whole cycles if it is periodic, else over its later half."""

    start: float  # of the part they are taken over [T]
    end: float  # [T]
    mean: Estimate  # [Q]
    rms: Estimate  # of the fluctuation [Q]
    cycle: Cycle | None  # None: not periodic
    note: str  # why not


def statistics(
    time: ArrayLike, value: ArrayLike, dt: ArrayLike | None = None, *, after: float | None = None
) -> Statistics:
    """Statistics of a column; columns as :func:`pmesh.run.record.record` takes them.

    By :func:`periodic` where the record is, else by :func:`mean` and :func:`rms` of what comes
    after ``after`` [T], its later half if not given.
    """
    curve = record(time, value, dt)
    try:
        found = _periodic(curve if after is None else curve.after(after))
    except InputError as error:
        later = curve.after(0.5 * (curve.start + curve.end) if after is None else after)
        return Statistics(
            start=later.start, end=later.end, mean=_mean(later), rms=_rms(later), cycle=None,
            note=error.problem,
        )  # fmt: skip
    return Statistics(
        start=found.start, end=found.end, mean=found.mean, rms=found.rms, cycle=found, note=""
    )


def mean(
    time: ArrayLike, value: ArrayLike, dt: ArrayLike | None = None, *, after: float | None = None
) -> Estimate:
    """The mean over time and its standard uncertainty, for records with any correlation in time.

    The uncertainty is sqrt(variance * c / n) with c the correlation time in samples, summed up to
    the first lag of five times itself (Sokal 1997, "Monte Carlo methods in statistical mechanics",
    section 3); NaN if the record is shorter than ten of them. Too large for a periodic record,
    whose cycles :func:`periodic` knows.
    """
    curve = record(time, value, dt)
    return _mean(curve if after is None else curve.after(after))


def rms(
    time: ArrayLike, value: ArrayLike, dt: ArrayLike | None = None, *, after: float | None = None
) -> Estimate:
    """Root mean square about the mean, with its uncertainty as :func:`mean` finds it."""
    curve = record(time, value, dt)
    return _rms(curve if after is None else curve.after(after))


def spectrum(
    time: ArrayLike, value: ArrayLike, dt: ArrayLike | None = None, *, after: float | None = None
) -> Spectrum:
    """Power spectral density: resampled evenly, less its linear trend, under a Hann window."""
    curve = record(time, value, dt)
    return _spectrum(curve if after is None else curve.after(after))


def periodic(
    time: ArrayLike,
    value: ArrayLike,
    dt: ArrayLike | None = None,
    *,
    after: float | None = None,
    least: int = 3,
    tolerance: float = 0.02,
) -> Cycle:
    """The periodic part of a record: from when, over how many whole cycles, and its numbers.

    Cycles are cut where the phase of the dominant frequency, demodulated under a Hann window of two
    periods (blind to the mean and all harmonics), has turned once. The record is periodic from the
    first cycle after which mean, amplitude and period stay within ``tolerance`` of those of the
    last ``least`` cycles (the mean relative to the larger of itself and the amplitude).
    Uncertainties are those of a mean over the cycles by their scatter, with the correlation of
    neighbours. Noise adds to the amplitude, which is one of extremes. Refuses a record that holds
    fewer than ``least`` + 2 cycles, does not oscillate, or whose last cycles still differ.
    """
    if least < 3 or not 0 < tolerance < 1:
        raise InputError(
            f"least must be at least 3 and tolerance a part of 1, got {least} and {tolerance}",
            hint="least=3, tolerance=0.02",
        )
    curve = record(time, value, dt)
    return _periodic(curve if after is None else curve.after(after), least, tolerance)


def _mean(curve: Record) -> Estimate:
    _, values = curve.even(_count(curve))
    average = float((curve.integral(curve.end) - curve.integral(curve.start)) / curve.span)
    return Estimate(average, _error(values))


def _rms(curve: Record) -> Estimate:
    middles, _ = curve.even(_count(curve))
    values = curve.at(middles)
    squares = (values - values.mean()) ** 2
    root = math.sqrt(float(squares.mean()))
    return Estimate(root, _error(squares) / (2 * root) if root > 0 else 0.0)


def _count(curve: Record) -> int:
    return min(max(64, round(curve.span / curve.step)), LONGEST)


def _error(values: Values) -> float:
    """The standard error of the mean of correlated samples."""
    n = values.size
    away = values - values.mean()
    variance = float(away @ away) / n
    if variance <= (1e-15 * float(np.abs(values).max())) ** 2:
        return 0.0
    image = np.fft.rfft(away, 2 * n)
    correlation = np.fft.irfft(np.abs(image) ** 2, 2 * n)[:n] / (n * variance)
    length = 2 * np.cumsum(correlation) - 1
    enough = np.arange(n) >= 5 * length
    window = int(np.argmax(enough)) if enough.any() else n
    samples = max(float(length[min(window, n - 1)]), 1.0 / n)
    if n < 10 * samples:
        return math.nan
    return math.sqrt(variance * samples / n * (1 + (2 * window + 1) / n))  # Wolff 2004, eq. 49


def _spectrum(curve: Record) -> Spectrum:
    n = _count(curve)
    middles, values = curve.even(n)
    line = np.polynomial.Polynomial.fit(middles, values, 1)
    away = values - line(middles)
    window = np.hanning(n + 1)[:-1]
    padded = 4 * n
    step = curve.span / n
    power = np.abs(np.fft.rfft(away * window, padded)) ** 2 * 2 * step / float(window @ window)
    power[0] *= 0.5
    return Spectrum(np.asarray(np.fft.rfftfreq(padded, step), np.float64), power, 1.0 / curve.span)


def _periodic(curve: Record, least: int = 3, tolerance: float = 0.02) -> Cycle:
    half = curve.after(0.5 * (curve.start + curve.end))
    frequency = _spectrum(half).peak().value
    for _ in range(3):
        if curve.span * frequency < least + 2:
            raise InputError(
                f"the record holds {curve.span * frequency:.1f} cycles of {1 / frequency:.4g}, "
                f"{least + 2} are needed",
                hint="a longer run",
            )
        time, phase = _phase(curve, frequency)
        late = time > 0.5 * (time[0] + time[-1])
        frequency = abs(_slope(time[late], phase[late])) / (2 * math.pi)
    edges = _edges(time, phase)
    if edges.size < least + 1:
        raise InputError(
            f"the record has {edges.size - 1} whole cycles of {1 / frequency:.4g} at its end, "
            f"{least + 2} are needed",
            hint="a longer run; `mean` and `rms` for what is not periodic",
        )
    return _settled(curve, edges, least, tolerance)


def _phase(curve: Record, frequency: float) -> tuple[Values, Values]:
    """Times, and the phase there of the part of the record near a frequency."""
    n = math.ceil(curve.span * frequency * SAMPLES)
    middles, values = curve.even(n)
    values = values - np.polynomial.Polynomial.fit(middles, values, 1)(middles)
    turned = values * np.exp(-2j * math.pi * frequency * middles)
    width = round(2 * n / (curve.span * frequency))
    window = np.hanning(width + 1)[:-1] if width % 2 else np.hanning(width + 1)
    amplitude = _convolve(turned, window)
    edge = window.size // 2
    inside = middles[edge : edge + amplitude.size]
    return inside, 2 * math.pi * frequency * inside + np.unwrap(np.angle(amplitude))


def _convolve(values: NDArray[np.complex128], window: Values) -> NDArray[np.complex128]:
    """Weighted sums of the values under the window, where it fits."""
    size = 1 << (values.size + window.size - 1).bit_length()
    full = np.fft.ifft(np.fft.fft(values, size) * np.fft.fft(window, size))
    return np.asarray(full[window.size - 1 : values.size], np.complex128)


def _edges(time: Values, phase: Values) -> Values:
    """Times of whole turns of the phase, counted back from the end while it only grows."""
    back = np.flatnonzero(np.diff(phase) <= 0)
    first = int(back[-1]) + 1 if back.size else 0
    time, phase = time[first:], phase[first:]
    turns = math.floor((phase[-1] - phase[0]) / (2 * math.pi) + 1e-9)
    wanted = phase[-1] - 2 * math.pi * np.arange(turns, -1, -1)
    return np.asarray(np.interp(wanted, phase, time), np.float64)


def _settled(curve: Record, edges: Values, least: int, tolerance: float) -> Cycle:
    """The last cycles that are alike, and their numbers."""
    periods, means = np.diff(edges), curve.means(edges)
    inner = edges[:-1, None] + periods[:, None] * np.arange(SAMPLES) / SAMPLES
    values = curve.at(inner)
    amplitudes = 0.5 * (values.max(axis=1) - values.min(axis=1))
    roots = np.sqrt(((values - values.mean(axis=1, keepdims=True)) ** 2).mean(axis=1))
    mean_at, amplitude, period = (float(x[-least:].mean()) for x in (means, amplitudes, periods))
    if amplitude <= ROUND_OFF * abs(mean_at) or amplitude == 0:
        raise InputError("the record does not oscillate", hint="`mean` and `rms`")
    off = np.maximum(
        np.abs(means - mean_at) / max(abs(mean_at), amplitude),
        np.maximum(np.abs(amplitudes / amplitude - 1), np.abs(periods / period - 1)),
    )
    odd = np.flatnonzero(off > tolerance)
    first = int(odd[-1]) + 1 if odd.size else 0
    kept = periods.size - first
    if kept < least:
        raise InputError(
            f"the last {least} cycles of {period:.4g} still differ by "
            f"{100 * off[-least:].max():.2g} %, more than {100 * tolerance:g} %",
            hint="a longer run, or a larger tolerance",
        )
    return Cycle(
        start=float(edges[first]), end=float(edges[-1]), cycles=kept,
        period=_over_cycles(periods[first:]), mean=_over_cycles(means[first:]),
        amplitude=_over_cycles(amplitudes[first:]), rms=_over_cycles(roots[first:]),
        drift=_slope(np.arange(kept), means[first:]),
    )  # fmt: skip


def _over_cycles(values: Values) -> Estimate:
    """The mean over cycles, and its standard error with the correlation of neighbours."""
    n = values.size
    average = float(values.mean())
    away = values - average
    variance = float(away @ away) / (n - 1)
    if variance <= (1e-14 * average) ** 2:
        return Estimate(average, math.sqrt(variance / n))
    neighbours = float(away[1:] @ away[:-1]) / float(away @ away) if n >= 4 else 0.0
    held = min(max(neighbours, -0.5), 1 - 2 / n)
    return Estimate(average, math.sqrt(variance / n * (1 + held) / (1 - held)))


def _slope(x: NDArray[np.generic], y: Values) -> float:
    """Of the straight line nearest to the points."""
    away = np.asarray(x, np.float64) - np.mean(np.asarray(x, np.float64))
    return float(away @ y) / float(away @ away)
