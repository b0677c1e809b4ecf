"""Remeshing kernels: piecewise polynomials that keep moments, as a table of exact rationals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import comb
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from remesh.errors import InputError

Pieces = tuple[tuple[Fraction, ...], ...]
CLAIM_TOLERANCE = 1e-12  # a user's kernel may be typed in as floats


@dataclass(frozen=True)
class Kernel:
    """An even kernel W(x), x in cells; ``pieces[i]`` is a polynomial in |x| on [i, i + 1].

    ``half_width`` is half of the support in cells, ``moments`` the highest degree kept,
    ``regularity`` the number of continuous derivatives, ``interpolating`` whether W(0) = 1 and
    W(k) = 0 at other nodes, so that remeshing particles that sit on nodes changes nothing.
    Coefficients run from low to high order and may be given as fractions, integers or floats.
    """

    name: str
    half_width: int
    moments: int
    regularity: int
    pieces: Pieces
    interpolating: bool
    source: str

    def __post_init__(self) -> None:
        """Hold the coefficients as exact fractions."""
        exact = tuple(tuple(Fraction(c) for c in piece) for piece in self.pieces)
        object.__setattr__(self, "pieces", exact)

    @property
    def degree(self) -> int:
        """Highest polynomial degree of the pieces."""
        return max(len(piece) for piece in self.pieces) - 1

    @property
    def width(self) -> int:
        """Number of nodes per axis that one particle reaches."""
        return 2 * self.half_width

    def __call__(self, x: ArrayLike) -> NDArray[np.floating[Any]]:
        """W(x), any shape, x in cells; float32 stays float32."""
        given = np.asarray(x)
        dtype = np.float32 if given.dtype == np.float32 else np.float64
        points = np.abs(given.astype(dtype))
        interval = np.floor(points)
        local = points - interval - dtype(0.5)
        values = np.zeros_like(points)
        for i, piece in enumerate(shifted(self)):
            inside = interval == i
            values[inside] = np.polynomial.polynomial.polyval(
                local[inside], np.array([float(c) for c in piece], dtype=dtype)
            )
        result: NDArray[np.floating[Any]] = values
        return result


@lru_cache(maxsize=64)
def shifted(kernel: Kernel) -> Pieces:
    """The pieces as polynomials in s = |x| - i - 1/2: there float32 keeps its digits."""
    size = kernel.degree + 1
    result = []
    for i, piece in enumerate(kernel.pieces):
        centre = Fraction(2 * i + 1, 2)
        result.append(
            tuple(
                sum(
                    (
                        c * comb(k, power) * centre ** (k - power)
                        for k, c in enumerate(piece)
                        if k >= power
                    ),
                    Fraction(0),
                )
                for power in range(size)
            )
        )
    return tuple(result)


@lru_cache(maxsize=128)
def table(kernel: Kernel, dtype: np.dtype[Any]) -> NDArray[np.floating[Any]]:
    """Shifted coefficients for compiled loops, ``(half_width, 2, terms)``: even, then odd powers.

    Taps i to the left and to the right of a particle are P_i(s) and P_i(-s), that is even + odd and
    even - odd: two Horner sums of half the length serve both.
    """
    terms = kernel.degree // 2 + 1
    values = np.zeros((kernel.half_width, 2, terms))
    for i, piece in enumerate(shifted(kernel)):
        for power, c in enumerate(piece):
            values[i, power % 2, power // 2] = float(c)
    result = values.astype(dtype)
    result.setflags(write=False)
    return result


def moment(kernel: Kernel, degree: int, offset: Fraction) -> Fraction:
    """Exact sum over nodes k of W(x - k) (x - k)**degree for x = ``offset`` in [0, 1]."""
    total = Fraction(0)
    for node in range(1 - kernel.half_width, kernel.half_width + 1):
        distance = offset - node
        piece = kernel.pieces[min(int(abs(distance)), kernel.half_width - 1)]
        weight = sum((c * abs(distance) ** k for k, c in enumerate(piece)), Fraction(0))
        total += weight * distance**degree
    return total


def check(kernel: Kernel) -> None:
    """Refuse a kernel whose pieces, weights, moments or node values are not as it claims."""
    if kernel.half_width < 1 or len(kernel.pieces) != kernel.half_width:
        raise InputError(
            f"kernel {kernel.name!r} claims half_width {kernel.half_width} "
            f"but has {len(kernel.pieces)} pieces",
            hint="one polynomial in |x| for each interval [i, i+1] up to half_width",
        )
    for power in range(kernel.moments + 1):
        # a polynomial identity in the offset: degree + power + 1 points prove it
        points = kernel.degree + power + 1
        wanted = 1 if power == 0 else 0
        scale = kernel.half_width**power
        worst = max(
            abs(float(moment(kernel, power, Fraction(i, points)) - wanted))
            for i in range(points + 1)
        )
        if not worst <= CLAIM_TOLERANCE * scale:
            what = "weights do not sum to 1" if power == 0 else f"moment {power} is not kept"
            raise InputError(
                f"kernel {kernel.name!r} claims moments 0 to {kernel.moments} but its {what} "
                f"(off by {worst:.3g})",
                hint="check its coefficients, or claim fewer moments",
            )
    nodes = [float(kernel.pieces[0][0] - 1)]
    nodes += [
        float(sum(c * (i + 1) ** k for k, c in enumerate(p))) for i, p in enumerate(kernel.pieces)
    ]
    if kernel.interpolating and not max(map(abs, nodes)) <= CLAIM_TOLERANCE:
        raise InputError(
            f"kernel {kernel.name!r} claims to interpolate but is not 1 at 0, 0 at other nodes",
            hint="interpolating=False",
        )


@lru_cache(maxsize=64)
def _checked(kernel: Kernel) -> Kernel:
    check(kernel)
    return kernel


def get_kernel(kernel: str | Kernel) -> Kernel:
    """The kernel of that name, or the user's own one after its claims were checked."""
    if isinstance(kernel, Kernel):
        return kernel if KERNELS.get(kernel.name) is kernel else _checked(kernel)
    found = KERNELS.get(kernel) if isinstance(kernel, str) else None
    if found is None:
        raise InputError(
            f"unknown kernel {kernel!r}",
            hint="one of " + ", ".join(f'"{name}"' for name in KERNELS),
        )
    return found


def _rows(denominator: int, rows: str) -> Pieces:
    """Coefficients over one denominator, low to high order in |x|; intervals end in semicolons."""
    return tuple(
        tuple(Fraction(int(c), denominator) for c in row.split()) for row in rows.split(";")
    )


LAMBDA = "Cottet, Etancelin, Perignon & Picard, ESAIM: M2AN 48 (2014) 1029, Lambda_{p,r}"
MONAGHAN = "Monaghan, J. Comput. Phys. 60 (1985) 253: (3 M4 + x M4')/2, equal to L2,1"
M6_PRIME = (
    "M*6 of van Rees et al., J. Comput. Phys. 230 (2011) 2794, in the form equal to L4,2: "
    "elsewhere M6' also names (15 M6 + 9 x M6' + x^2 M6'')/8, which keeps moments 0-3 "
    "only and does not interpolate; that one is not meant here"
)
M8_PRIME = (
    "(15 M8 + 9 x M8' + x^2 M8'')/8: Monaghan's extrapolation, applied twice to the M8 B-spline"
)

_LAMBDA_2_1 = _rows(
    2,
    """
    2 0 -5 3;
    4 -8 5 -1
    """,
)
_LAMBDA_4_2 = _rows(
    24,
    """
    24 0 -30 -70 126 -50;
    -96 450 -735 545 -189 25;
    432 -918 765 -313 63 -5
    """,
)
_M8PRIME_M2 = _rows(
    3360,
    """
    3020 0 -4900 0 2940 0 -1155 350;
    3090 -784 -1470 -7840 13230 -7840 2079 -210;
    -1390 24304 -56350 54880 -27930 7840 -1155 70;
    20480 -57344 62720 -35840 11760 -2240 231 -10
    """,
)
_LAMBDA_2_2 = _rows(
    2,
    """
    2 0 -2 -9 15 -6;
    -8 36 -58 43 -15 2
    """,
)
_LAMBDA_4_4 = _rows(
    24,
    """
    24 0 -30 0 6 -800 2730 -3540 2070 -460;
    -4776 32910 -98925 170550 -185859 132700 -62055 18330 -3105 230;
    141912 -535410 892755 -863370 533613 -218564 59325 -10290 1035 -46
    """,
)
_LAMBDA_6_4 = _rows(
    720,
    """
    720 0 -980 0 280 -17605 60145 -78085 45675 -10150;
    -126288 870996 -2618406 4514160 -4919670 3512943 -1642941 485331 -82215 6090;
    6260400 -23620716 39388090 -38094000 23545690 -9644621 2617945 -454097 45675 -2030;
    -20524032 54049536 -63077504 42814560 -18626300 5385983 -1035149 127511 -9135 290
    """,
)
_LAMBDA_6_6 = _rows(
    720,
    """
    720 0 -980 0 280 0 -20 -230545 1220415 -2723525 3275195 -2235310 819910 -126140;
    -6377904 62824356 -282804102 770097048 -1414890540 1851673152 -1775471256 1262724855
      -666083817 257392695 -70832223 13147890 -1475838 75684;
    2811957840 -15288467292 38226278650 -58196154408 60185421940 -44648070096 24442839520
      -9998313437 3055805025 -689215765 111503315 -12253766 819910 -25228;
    -36809588736 139838017536 -244733877248 261260767488 -189805743680 99096838512
      -38252217524 11053331675 -2390941623 382374895 -43946287 3437210 -163982 3604
    """,
)
_LAMBDA_8_4 = _rows(
    40320,
    """
    40320 0 -57400 0 19110 -778806 2661540 -3458700 2023630 -449694;
    -6209280 42863520 -128868880 222164040 -242129580 172909044 -80872680 23891280 -4047260
      299796;
    396149760 -1494735840 2492601200 -2410805880 1490163780 -610410276 165694200 -28740960
      2890900 -128484;
    -2273040000 5986145520 -6986182420 4742046540 -2063042835 596557269 -114655170 14123430
      -1011815 32121;
    2530800000 -5135050000 4622507500 -2422976500 814989525 -182421981 27172110 -2597150
      144545 -3569
    """,
)

KERNELS: Mapping[str, Kernel] = MappingProxyType(
    {
        kernel.name: kernel
        for kernel in (
            Kernel("M4'", 2, 2, 1, _LAMBDA_2_1, True, MONAGHAN),
            Kernel("M6'", 3, 4, 2, _LAMBDA_4_2, True, M6_PRIME),
            Kernel("M8'", 4, 5, 4, _M8PRIME_M2, False, M8_PRIME),
            Kernel("L2,1", 2, 2, 1, _LAMBDA_2_1, True, LAMBDA),
            Kernel("L2,2", 2, 2, 2, _LAMBDA_2_2, True, LAMBDA),
            Kernel("L4,2", 3, 4, 2, _LAMBDA_4_2, True, LAMBDA),
            Kernel("L4,4", 3, 4, 4, _LAMBDA_4_4, True, LAMBDA),
            Kernel("L6,4", 4, 6, 4, _LAMBDA_6_4, True, LAMBDA),
            Kernel("L6,6", 4, 6, 6, _LAMBDA_6_6, True, LAMBDA),
            Kernel("L8,4", 5, 8, 4, _LAMBDA_8_4, True, LAMBDA),
        )
    }
)
