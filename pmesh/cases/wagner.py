"""Wagner's law: the lift of a thin aerofoil set in motion at once, in an inviscid fluid."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError

Values = NDArray[np.float64]
WAGNER = "Wagner 1925, thin aerofoil in inviscid flow"
ENDS = (-32.0, 6.0)  # of the integral, in the logarithm of its variable
NODES = 1600  # of its trapezoidal sum, exponentially accurate


def wagner(s: float | NDArray[np.floating[Any]]) -> Values:
    """Lift over its steady value at a travel of ``s`` half chords after the start; 1/2 at s = 0.

    ``1 - int_0^inf exp(-s x) / {x^2 [(K0 - K1)^2 + pi^2 (I0 + I1)^2]} dx``, Bessel functions of x,
    to 1e-10. Source: H. Wagner, Z. angew. Math. Mech. 5 (1925) 17; in this form R. T. Jones, NACA
    Report 681 (1940). Refuses a negative travel.
    """
    travel = np.asarray(s, np.float64)
    if (travel < 0).any():
        raise InputError(f"travel must not be negative, got {travel.min():g}", hint="s = 2 U t / c")
    x, weights = _table()
    return np.asarray(1.0 - np.exp(-travel[..., None] * x) @ weights)


@cache
def _table() -> tuple[Values, Values]:
    """Points and weights of the integral, even in the logarithm of its variable."""
    from scipy.special import ive, kve

    logs = np.linspace(*ENDS, NODES)
    x = np.exp(logs)
    k = (kve(0, x) - kve(1, x)) * np.exp(-x)
    grown = (ive(0, x) + ive(1, x)) * np.exp(np.minimum(x, 300.0))
    weights = (logs[1] - logs[0]) / (x * (k**2 + np.pi**2 * grown**2))
    return x, np.asarray(weights, np.float64)
