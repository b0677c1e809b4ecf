"""Lifted interpolating wavelets N.N~: predict and update weights as a table of exact rationals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from types import MappingProxyType

from remesh.errors import InputError

Weights = tuple[Fraction, ...]
Filter = dict[int, Fraction]


@dataclass(frozen=True)
class Wavelet:
    """A pair of lifting steps on a line of nodes whose even ones are the coarser line.

    ``predict`` interpolates the odd node 2k + 1 from the even nodes around it, left to right:
    d_k = c_{2k+1} - sum predict c. ``update`` then adds details to an even node: c_k = c_{2k} +
    sum update d. Both hold an even number of weights (``update`` may be empty).
    ``order`` N: polynomials of degree < N have no details. ``moments`` N~: the wavelets have that
    many vanishing moments, so the coarse values keep the moments 0 to N~ - 1 of the line.
    """

    name: str
    order: int
    moments: int
    predict: Weights
    update: Weights
    source: str

    def __post_init__(self) -> None:
        """Hold the weights as exact fractions."""
        object.__setattr__(self, "predict", tuple(Fraction(w) for w in self.predict))
        object.__setattr__(self, "update", tuple(Fraction(w) for w in self.update))

    @property
    def support(self) -> tuple[float, float]:
        """Half widths of the scaling function and of the wavelet, in cells of the coarse line."""
        scaling = len(self.predict) - 1
        lifted = scaling + (len(self.update) - 1) / 2
        return float(scaling), lifted if self.update else scaling / 2

    def h(self) -> Filter:
        """Refinement: zeta_k^l = sum_j h_j zeta_{2k+j}^{l+1}; h_0 = 1, sum h = 2."""
        half = len(self.predict) // 2
        odd = {2 * i - 2 * half + 1: w for i, w in enumerate(reversed(self.predict))}
        return {0: Fraction(1), **odd}

    def g_dual(self) -> Filter:
        """g~, the details: d_k^l = sum_j g~_j c_{2k+j}^{l+1}."""
        half = len(self.predict) // 2
        even = {2 * (i - half + 1): -w for i, w in enumerate(self.predict)}
        return {1: Fraction(1), **even}

    def h_dual(self) -> Filter:
        """h~, the coarse values: c_k^l = sum_j h~_j c_{2k+j}^{l+1}."""
        half = len(self.update) // 2
        result = {0: Fraction(1)}
        for i, w in enumerate(self.update):
            _add(result, self.g_dual(), 2 * (i - half), w)
        return result

    def g(self) -> Filter:
        """The wavelet: psi_k^l = sum_j g_j zeta_{2k+j}^{l+1}."""
        half = len(self.update) // 2
        result = {1: Fraction(1)}
        for i, w in enumerate(self.update):
            _add(result, self.h(), 2 * (half - i), -w)
        return result


def _add(target: Filter, source: Filter, shift: int, factor: Fraction) -> None:
    """target += factor * source, moved by ``shift``."""
    for j, value in source.items():
        target[j + shift] = target.get(j + shift, Fraction(0)) + factor * value


def filter_moment(taps: Filter, degree: int, center: int) -> Fraction:
    """Exact sum_j taps_j (j - center)**degree."""
    return sum((w * (j - center) ** degree for j, w in taps.items()), Fraction(0))


def check(wavelet: Wavelet) -> None:
    """Refuse a wavelet whose weights do not give the order and the moments that it claims."""
    if len(wavelet.predict) % 2 or len(wavelet.update) % 2 or not wavelet.predict:
        raise InputError(
            f"wavelet {wavelet.name!r} must have an even number of weights in each step, got "
            f"{len(wavelet.predict)} and {len(wavelet.update)}",
            hint="as many to the left of a node as to its right",
        )
    if wavelet.moments > wavelet.order:
        raise InputError(
            f"wavelet {wavelet.name!r} claims {wavelet.moments} moments, more than its order "
            f"{wavelet.order}",
            hint="moments <= order",
        )
    claims = (
        ("order", wavelet.order, wavelet.g_dual(), "predict"),
        ("moments", wavelet.moments, wavelet.g(), "update"),
    )
    for claim, count, taps, which in claims:
        wrong = [degree for degree in range(count) if filter_moment(taps, degree, 1) != 0]
        if wrong:
            raise InputError(
                f"wavelet {wavelet.name!r} claims {claim} {count} but degree {wrong[0]} fails",
                hint=f"check {which}, or claim less; weights must be exact fractions",
            )


@lru_cache(maxsize=64)
def _checked(wavelet: Wavelet) -> Wavelet:
    check(wavelet)
    return wavelet


def get_wavelet(wavelet: str | Wavelet) -> Wavelet:
    """The wavelet of that name, or the user's own one after its claims were checked."""
    if isinstance(wavelet, Wavelet):
        return wavelet if WAVELETS.get(wavelet.name) is wavelet else _checked(wavelet)
    found = WAVELETS.get(wavelet) if isinstance(wavelet, str) else None
    if found is None:
        raise InputError(
            f"unknown wavelet {wavelet!r}",
            hint="one of " + ", ".join(f'"{name}"' for name in WAVELETS),
        )
    return found


def _row(denominator: int, row: str) -> Weights:
    """Weights over one denominator."""
    return tuple(Fraction(int(w), denominator) for w in row.split())


DUBUC = "predict: Deslauriers & Dubuc, Constr. Approx. 5 (1989) 49"
LIFTED = DUBUC + (
    "; update: Sweldens, Appl. Comput. Harmon. Anal. 3 (1996) 186, and SIAM J. Math. Anal. 29 "
    "(1998) 511; names N.N~ as in Gillis & van Rees, SIAM J. Sci. Comput. 44 (2022) C367"
)
COHEN = (
    "the spline pair of Cohen, Daubechies & Feauveau, Commun. Pure Appl. Math. 45 (1992) 485, "
    "as lifting steps by Sweldens, Appl. Comput. Harmon. Anal. 3 (1996) 186"
)

_DD2 = _row(2, "1 1")
_DD4 = _row(16, "-1 9 9 -1")
_DD6 = _row(256, "3 -25 150 150 -25 3")
_KEEP2 = _row(4, "1 1")
_KEEP4 = _row(32, "-1 9 9 -1")

WAVELETS: Mapping[str, Wavelet] = MappingProxyType(
    {
        wavelet.name: wavelet
        for wavelet in (
            Wavelet("2.0", 2, 0, _DD2, (), DUBUC),
            Wavelet("2.2", 2, 2, _DD2, _KEEP2, COHEN),
            Wavelet("4.0", 4, 0, _DD4, (), DUBUC),
            Wavelet("4.2", 4, 2, _DD4, _KEEP2, LIFTED),
            Wavelet("4.4", 4, 4, _DD4, _KEEP4, LIFTED),
            Wavelet("6.0", 6, 0, _DD6, (), DUBUC),
            Wavelet("6.2", 6, 2, _DD6, _KEEP2, LIFTED),
        )
    }
)
