"""Redistancing: from any level set to the signed distance to its zero contour."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from levelset.band import Band
from levelset.closest import Front
from levelset.nodal import check_level_set, check_width
from remesh.errors import InputError
from remesh.grid import Grid

Array = NDArray[np.floating[Any]]
Nodes = NDArray[np.int64]
Method = Literal["closest-point", "fast-marching"]


def redistance(
    phi: Array,
    grid: Grid,
    *,
    width: float | None = None,
    method: Method = "closest-point",
    threads: int | None = None,
) -> Array:
    """The signed distance [L] to the contour phi = 0, on all nodes.

    ``phi`` has ``grid.shape``, is negative inside and may have any slope. With ``width`` [L]
    distances are computed up to it and are +-width beyond. The sign of a node never changes.
    ``"closest-point"`` measures to the contour of the cubic interpolant (`closest_points`): of
    order 4 for a smooth contour, slope 1 to order 3, wherever the distance is smooth.
    Between kinks on both sides, at corners and in filaments thinner than two spacings, no
    interpolant tells the contour to better than 0.4 spacings: what is a distance there to within
    that is left as it is, so that calls do not wear it off.
    ``"fast-marching"`` is scikit-fmm's second-order one (`fast_marching`), for comparison.
    Cost: O(nodes within width), and one look at every node. Refuses a phi of one sign or not
    finite.
    """
    if method not in ("closest-point", "fast-marching"):
        raise InputError(
            f"method must be 'closest-point' or 'fast-marching', got {method!r}",
            hint="method='closest-point'",
        )
    values = check_level_set(np.asarray(phi), grid)
    if width is not None:
        width = check_width(width)
    if method == "fast-marching":
        from levelset.fast_marching import fast_marching

        return fast_marching(values, grid, width=width)
    front = Front(values, grid, None, threads)
    front.run(width)
    front.keep()
    if width is None:
        result = np.empty(grid.shape, front.dtype)
    else:
        result = np.where(values < 0, -width, width).astype(front.dtype)
    found = front.signed(slice(None))
    result.reshape(-1)[front.nodes] = found if width is None else np.clip(found, -width, width)
    return result


def redistance_band(
    phi: Array | Band,
    grid: Grid | None = None,
    nodes: Nodes | None = None,
    width: float | None = None,
    *,
    threads: int | None = None,
) -> Band:
    """The signed distance [L] at all nodes within ``width`` [L] of the contour, as a new band.

    ``phi`` is known at ``nodes`` only: of shape ``(len(nodes),)``, or ``grid.shape`` with anything
    elsewhere; or it is a `Band`, which stands for all three; without nodes it is known everywhere.
    They should hold two layers of nodes on either side of the contour; where they do not, the
    contour is that of the multilinear interpolant. The new band may be wider or narrower than the
    old one; a node that was not in it takes the side of the node next to it. Accuracy as
    `redistance`. Cost: O(nodes, old and new). Refuses a phi of one sign or not finite at its nodes.
    """
    if width is None:
        raise InputError("a band needs a width", hint="width=4 * grid.spacing")
    width = check_width(width)
    front = Front(phi, grid, nodes, threads)
    front.run(width)
    front.keep()
    kept = front.within(width)
    return Band(front.grid, front.nodes[kept], front.signed(kept).astype(front.dtype))
