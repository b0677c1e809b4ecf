"""Moments of a plane vorticity field: how it is spread, and how round it is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from remesh.grid import Grid

if TYPE_CHECKING:
    from pmesh.run.protocols import Moment

Numbers = dict[str, float]


def vortex_moments(vorticity: NDArray[Any], grid: Grid) -> Numbers:
    """Second moments about the origin and extremes of a vorticity (nx, ny).

    ``moment_xx``, ``moment_yy``, ``moment_xy``: integrals of w x^2, w y^2, w xy [L^4/T];
    ``largest`` and ``smallest`` vorticity [1/T]. Sums over nodes: spectrally accurate for fields
    that vanish smoothly towards the edges. Circulation, impulse and enstrophy are in the ledger.
    """
    x, y = grid.axes()
    strength = np.asarray(vorticity, np.float64) * grid.cell_volume
    return {
        "moment_xx": float(strength.sum(axis=1) @ (x * x)),
        "moment_yy": float(strength.sum(axis=0) @ (y * y)),
        "moment_xy": float(x @ strength @ y),
        "largest": float(np.max(vorticity)),
        "smallest": float(np.min(vorticity)),
    }


def watch_moments(moment: Moment) -> Numbers:
    """Watcher: the second moments of the state as columns of the series."""
    return vortex_moments(moment.state.vorticity, moment.state.grid)


def aspect_ratio(xx: Any, yy: Any, xy: Any) -> Any:
    """Ratio of the axes of the ellipse that has these second moments, at least 1.

    ``sqrt((J + D)/(J - D))`` with ``J = xx + yy``, ``D^2 = (xx - yy)^2 + 4 xy^2``.
    Source: P. Koumoutsakos, J. Comput. Phys. 138 (1997) 821, after Melander et al. (1987).
    """
    spread = np.sqrt((xx - yy) ** 2 + 4.0 * xy**2)
    return np.sqrt((xx + yy + spread) / (xx + yy - spread))


def relative_error(ours: NDArray[Any], exact: NDArray[Any]) -> float:
    """L2 norm of the difference over the L2 norm of the exact field."""
    apart = np.asarray(ours, np.float64) - exact
    return math.sqrt(float(np.vdot(apart, apart)) / float(np.vdot(exact, exact)))
