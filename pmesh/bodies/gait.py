"""The shape of a swimmer at an instant, in the axes in which its deformation has no momentum.

Everything is in body lengths and periods. A place in the body is s along the midline and an offset
rho along its left normal; the area element is (1 - kappa rho) ds drho, and integrals over rho are
done exactly. The bending alone gives velocities v; their momentum and angular momentum about the
centre of area are

    P = int v dA,    H = int (x - c) x v dA,

and the deformation is v - P/A - (H/I) x (x - c), in axes turned by the integral of H/I over time.

A body in space bends in the plane z = 0 of its own axes; all its slices z = const move by the same
law, nothing moves along z, and A, P, H and I are sums over the slices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from pmesh.bodies.midline import Midline
from pmesh.bodies.outline import Outline
from pmesh.bodies.profile import Profile
from pmesh.bodies.sheet import Sheet, sheet, split
from remesh.errors import InputError

Values = NDArray[np.float64]
Section = Literal["incompressible", "rigid"]
LAPSE = 0.125  # [T] longest piece of time that gets one set of nodes
TICKS = 12  # per piece of time
THINNEST = 0.1  # a section's inner side is no more squeezed than this, 1 - 2 |kappa| w


@dataclass(frozen=True, kw_only=True)
class Gait:
    """A midline that bends, with an outline; ``samples``: of the midline.

    ``profile``: its half-height, for a body in space with elliptic sections.

    ``section`` says what becomes of a section across the midline as that bends. "incompressible":
    its pieces keep their area, so that the velocity has no divergence and the centre of area moves
    with the momentum. "rigid": it keeps its length, so that matter is squeezed on the inner side.
    """

    midline: Midline
    outline: Outline
    samples: int = 400
    section: Section = "incompressible"
    profile: Profile | None = None

    @property
    def sheet(self) -> Sheet:
        """Quadrature along the midline."""
        return sheet(self.midline.breaks, self.outline, self.samples, self.profile)


class Shape(NamedTuple):
    """The body at an instant, at its stations, in its own axes."""

    stations: Values  # (m,)
    place: Values  # (m, 2)
    angle: Values  # (m,) of the tangent
    velocity: Values  # (m, 2)
    spin: Values  # (m,) rate of the angle
    curvature: Values  # (m,)
    rate: Values  # (m,) of the curvature
    below: Values  # (m,) offset of the outline, negative
    above: Values  # (m,)
    turn: float  # of the axes from those of the bending
    inertia: float  # about z
    second: Values  # (3, 3) int r r^T about the centre; no extent along z in the plane
    drift: tuple[float, float]  # the centre of area moves by this more than its momentum says

    @property
    def ring(self) -> Values:
        """The outline (2 m - 2, 2), anticlockwise from the nose."""
        normal = np.stack((-np.sin(self.angle), np.cos(self.angle)), axis=1)
        low = self.place + self.below[:, None] * normal
        high = self.place + self.above[:, None] * normal
        return np.concatenate((low, high[-2:0:-1]))


class _Moments(NamedTuple):
    """Integrals over the body, of the bending alone."""

    area: float
    center: Values
    momentum: Values
    inertia: float
    spin: float  # H / I
    second: Values  # (2, 2)
    tall: float  # int z^2


class _Raw(NamedTuple):
    """The bending alone, at the nodes."""

    angle: Values
    angle_rate: Values
    curvature: Values
    rate: Values
    place: Values  # (2, n)
    velocity: Values  # (2, n)


@lru_cache(maxsize=256)
def shape(gait: Gait, time: float) -> Shape:
    """The body at a time [T]; before 0 it rests as it is at 0. About 0.5 ms.

    Its linear and angular momentum are zero to 1e-12 of its own area and inertia.
    """
    if time < 0.0:
        first = shape(gait, 0.0)
        still = np.zeros_like(first.spin)
        return first._replace(
            velocity=np.zeros_like(first.velocity), spin=still, rate=still, drift=(0.0, 0.0)
        )
    along, raw = gait.sheet, _raw(gait, time)
    sums = _moments(gait, raw)
    told = gait.midline.bending(along.stations, time)
    angle = told.head + along.outer @ raw.curvature
    angle_rate = told.head_rate + along.outer @ raw.rate
    cos, sin = np.cos(raw.angle), np.sin(raw.angle)
    arm = along.outer @ np.stack((cos, sin), axis=1) - sums.center
    pull = np.stack((-sin * raw.angle_rate, cos * raw.angle_rate), axis=1)
    velocity = along.outer @ pull - sums.momentum / sums.area
    velocity -= sums.spin * np.stack((-arm[:, 1], arm[:, 0]), axis=1)
    turn = _turn(gait, time)
    c, s = math.cos(turn), math.sin(turn)
    axes = np.array([[c, -s], [s, c]])  # rows times this: seen in axes turned by `turn`
    below, above = offsets(gait.section, told.curvature, along.spread)
    return Shape(
        stations=along.stations,
        place=arm @ axes,
        angle=angle - turn,
        velocity=velocity @ axes,
        spin=angle_rate - sums.spin,
        curvature=told.curvature,
        rate=told.rate,
        below=below,
        above=above,
        turn=turn,
        inertia=sums.inertia,
        second=_in_space(axes.T @ sums.second @ axes, sums.tall),
        drift=_drift(gait, raw, sums, axes),
    )


@lru_cache(maxsize=32)
def straight(gait: Gait) -> tuple[float, float, float]:
    """Area, place of the centre along the midline and polar moment of the straight body.

    In space volume and the integral of r^2.
    """
    along = gait.sheet
    widths = along.shares[:, None] * along.width
    sections = (along.layers * 2 * widths).sum(0)
    area = float(along.weights @ sections)
    middle = float(along.weights @ (sections * along.nodes)) / area
    across = (along.layers * (2 / 3 * widths**3 + 2 * widths * along.levels**2)).sum(0)
    length = float(along.weights @ (sections * (along.nodes - middle) ** 2))
    return area, middle, length + float(along.weights @ across)


def offsets(section: Section, curvature: Values, width: Values) -> tuple[Values, Values]:
    """Offsets of the two sides of the body from its midline, right (negative) and left.

    An incompressible section keeps the area on each side: rho - kappa rho^2 / 2 = +-w.
    """
    if section == "rigid":
        return -width, width
    bent = 2 * curvature * width
    return -2 * width / (1 + np.sqrt(1 + bent)), 2 * width / (1 + np.sqrt(1 - bent))


@lru_cache(maxsize=32)
def check(gait: Gait) -> None:
    """Refuse an outline without width, and a section that would fold over in a sharp bend."""
    _check_height(gait)
    widths = gait.sheet.spread[1:-1]
    if not (np.isfinite(widths).all() and (widths > 0).all()):
        raise InputError(
            "the half-width of a swimmer must be positive between nose and tail",
            hint="half_width(s) > 0 for 0 < s < 1",
        )
    along = gait.sheet
    last = max(0.0, *gait.midline.times)
    for time in np.linspace(0.0, last + 1.0, 33 + 32 * math.ceil(last)):
        bent = 2 * np.abs(gait.midline.bending(along.nodes, float(time)).curvature) * along.width
        worst = int(np.argmax(bent))
        if not bent[worst] <= 1 - THINNEST:
            raise InputError(
                f"the body folds at s = {along.nodes[worst]:.2f} L: half-width times curvature is "
                f"{bent[worst] / 2:.2f} at t = {time:.2f} T, of at most {(1 - THINNEST) / 2:g}",
                hint="a thinner outline or a midline that bends less",
            )


def _check_height(gait: Gait) -> None:
    """Refuse a profile without height."""
    heights = gait.sheet.rise
    flat = gait.profile is not None and not (heights[1:-1] > 0).all()
    if flat or not (np.isfinite(heights).all() and (heights >= 0).all()):
        raise InputError(
            "the half-height of a swimmer must be positive between nose and tail",
            hint="half_height(s) > 0 for 0 < s < 1",
        )


def _raw(gait: Gait, time: float) -> _Raw:
    """The bending alone: the head's end stays at the origin."""
    along = gait.sheet
    told = gait.midline.bending(along.nodes, time)
    angle = told.head + along.inner @ told.curvature
    angle_rate = told.head_rate + along.inner @ told.rate
    cos, sin = np.cos(angle), np.sin(angle)
    place = np.stack((along.inner @ cos, along.inner @ sin))
    velocity = np.stack((along.inner @ (-sin * angle_rate), along.inner @ (cos * angle_rate)))
    return _Raw(angle, angle_rate, told.curvature, told.rate, place, velocity)


def _moments(gait: Gait, raw: _Raw) -> _Moments:
    """Integrals over the body: exact across it, by Gauss's rule along it."""
    along = gait.sheet
    w, kappa = along.weights, raw.curvature
    low, high = offsets(gait.section, kappa, along.shares[:, None] * along.width)
    slices = [along.layers * (high**n - low**n) / n for n in range(1, 5)]
    one, two, three, four = (part.sum(0) for part in slices)
    zeroth, first, second = one - kappa * two, two - kappa * three, three - kappa * four
    tangent = np.stack((np.cos(raw.angle), np.sin(raw.angle)))
    normal = np.stack((-tangent[1], tangent[0]))
    swell = 0.5 * raw.rate * three if gait.section == "incompressible" else 0.0 * w
    area = float(w @ zeroth)
    center = (zeroth * raw.place + first * normal) @ w / area
    flux = zeroth * raw.velocity - first * raw.angle_rate * tangent + swell * normal
    momentum = flux @ w
    arm = raw.place - center[:, None]
    inertia = zeroth * (arm**2).sum(0) + 2 * first * (arm * normal).sum(0) + second
    spin = _cross(arm, flux) + first * _cross(normal, raw.velocity) + second * raw.angle_rate
    mixed = (w * first * arm) @ normal.T
    matrix = (w * zeroth * arm) @ arm.T + mixed + mixed.T + (w * second * normal) @ normal.T
    tall = float(w @ ((slices[0] - kappa * slices[1]) * along.levels**2).sum(0))
    return _Moments(
        area=area,
        center=center,
        momentum=momentum,
        inertia=float(w @ inertia),
        spin=float(w @ spin / (w @ inertia)),
        second=matrix,
        tall=tall,
    )


def _in_space(second: Values, tall: float) -> Values:
    """Second moments in the plane and across it."""
    result = np.zeros((3, 3))
    result[:2, :2], result[2, 2] = second, tall
    return result


def _drift(gait: Gait, raw: _Raw, sums: _Moments, axes: Values) -> tuple[float, float]:
    """Velocity of the centre of area less momentum over area: the sources of a rigid section."""
    if gait.section == "incompressible":
        return (0.0, 0.0)
    along = gait.sheet
    cubes = along.shares**3 @ along.layers * along.width**3
    weight = -along.weights * raw.rate * (2 / 3) * cubes / sums.area
    x, y = np.array([-np.sin(raw.angle) @ weight, np.cos(raw.angle) @ weight]) @ axes
    return float(x), float(y)


def _turn(gait: Gait, time: float) -> float:
    """The integral of H/I from 0 to a time, from a table of Legendre series."""
    edges, series, sums = _turning(gait)
    whole = 0.0
    if time > edges[-1]:
        settled = edges[-1] - 1.0
        periods = math.floor(time - settled)
        per_period = sums[-1] - sums[int(np.argmin(np.abs(edges - settled)))]
        whole, time = periods * per_period, time - periods
    k = min(max(int(np.searchsorted(edges, time, side="right")) - 1, 0), len(series) - 1)
    u = 2 * (time - edges[k]) / (edges[k + 1] - edges[k]) - 1
    return float(whole + sums[k] + legendre.legval(u, series[k]))


@lru_cache(maxsize=32)
def _turning(gait: Gait) -> tuple[Values, list[Values], Values]:
    """Edges of pieces of time, the series of the turn within each, and its value at the edges."""
    last = max(0.0, *gait.midline.times)
    marks = sorted({0.0, *(t for t in gait.midline.times if t > 0), last, last + 1.0})
    edges = split(marks, LAPSE)
    x, w = legendre.leggauss(TICKS)
    to_series = (legendre.legvander(x, TICKS - 1) * w[:, None]).T * (np.arange(TICKS) + 0.5)[
        :, None
    ]
    series, sums = [], [0.0]
    for a, b in pairwise(edges):
        times = a + (b - a) * (x + 1) / 2
        spins = np.array([_moments(gait, _raw(gait, float(t))).spin for t in times])
        piece = legendre.legint(to_series @ spins, lbnd=-1) * (b - a) / 2
        series.append(piece)
        sums.append(sums[-1] + float(legendre.legval(1.0, piece)))
    return edges, series, np.array(sums)


def _cross(a: Values, b: Values) -> Values:
    return np.asarray(a[0] * b[1] - a[1] * b[0])
