"""Moments of a plane vorticity field: what vortices keep, and how round they are."""

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
    """Circulation, moments about the origin, enstrophy and extremes of a vorticity (nx, ny).

    ``circulation`` [L^2/T]; ``moment_xx``, ``moment_yy``, ``moment_xy``: integrals of w x^2, w y^2,
    w xy [L^4/T]; ``angular_moment``: the sum of the first two; ``enstrophy``: integral of w^2;
    ``largest`` and ``smallest`` vorticity [1/T]. Sums over nodes: spectrally accurate for fields
    that vanish smoothly towards the edges, or are periodic.
    """
    x, y = grid.axes()
    strength = np.asarray(vorticity, np.float64) * grid.cell_volume
    columns, rows = strength.sum(axis=1), strength.sum(axis=0)
    xx, yy = float(columns @ (x * x)), float(rows @ (y * y))
    return {
        "circulation": float(columns.sum()),
        "moment_xx": xx,
        "moment_yy": yy,
        "moment_xy": float(x @ strength @ y),
        "angular_moment": xx + yy,
        "enstrophy": float(np.vdot(strength, strength)) / grid.cell_volume,
        "largest": float(np.max(vorticity)),
        "smallest": float(np.min(vorticity)),
    }


def watch_moments(moment: Moment) -> Numbers:
    """Watcher: the moments of the state as columns of the series."""
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
