"""The load on a body from the balance of momentum of a box of mesh nodes around it.

The box V, fixed over the step, is filled by fluid and body; its faces lie in fluid. There

    u_t + u.grad u = -grad p + nu laplace u + f,    div u = 0 on the faces,

and ``R = -int f dV`` is what the fluid gives to the constraint that holds the body. With the
outward normal n, the tangent t anticlockwise (n = (t_y, -t_x)) and the stress T = nu (grad u +
grad u^T), momentum gives ``R = -d/dt int u dV + oint [-u u_n - p n + T n] ds``. The pressure goes
by parts: ``oint p n ds = oint (-y, x) dp`` and ``oint p (x cross n) ds = oint r^2/2 dp``, and the
momentum equation along the face tells dp. With u.grad u = grad(u^2/2) + w (-v, u) that is

    d(p + u^2/2)/ds = -g,      g = t.u_t + w u_n - nu dw/dn,
    R = -d/dt int u dV       + oint [u^2/2 n - u u_n + T n + (-y, x) g] ds,
    M = -d/dt int x cross u  + oint x cross [u^2/2 n - u u_n + T n] + r^2/2 g ds.

No pressure, no far field, no free stream: the velocity is the whole one, whatever makes it. This
is the momentum form of Noca, Shiels & Jeon, J. Fluids Struct. 13 (1999) 551, in the plane, with
the torque. ``oint g ds`` is zero (Kelvin): what it is instead is spread evenly along the faces
and reported.

The hydrodynamic load on the body is ``R + d/dt int_B u dV`` over its inside B, because no momentum
crosses a body's own surface: for a rigid one add volume * dU/dt, and inertia * dOmega/dt to M. This
holds for any velocity inside the body, with a divergence or not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Bounds
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.stencils import gradient

Array = NDArray[np.floating[Any]]
Values = NDArray[np.float64]
Box = tuple[slice, slice]
ENDS = (3 / 8, 7 / 6, 23 / 24)  # Gregory's weights at the ends of a line: exact for cubics
REACH = 2  # nodes that a difference of fourth order reads beyond its own
CLEAR = 8  # nodes from a body to a face, at least: nearer, the smeared wall is felt
WANTED = 16  # nodes from a body to a face, if there is room


class Balance(NamedTuple):
    """What the fluid gave to the constraint in a box, mean over a step, per unit density."""

    force: tuple[float, float]  # R [L^3/T^2]; add volume * dU/dt for the load on the body
    torque: float  # M about the centre given [L^4/T^2]; add inertia * dOmega/dt
    mismatch: float  # rate at which circulation appears in the box from nowhere [L^2/T^2]


def momentum_balance(
    velocity: tuple[Array, Array],
    vorticity: tuple[Array, Array],
    grid: Grid,
    box: Box,
    *,
    dt: float,
    viscosity: float,
    center: Sequence[float],
) -> Balance:
    """Force and torque on what a box of nodes holds, from momentum and the flow on its faces.

    ``velocity`` (2, *shape) [L/T] and ``vorticity`` ``grid.shape`` [1/T], each before and after the
    step, on one mesh; ``box``: the nodes, faces included, as from `box_of`; ``center``: of the
    torque [L], a fixed point; for a moving body its centre at mid-step. Fourth order in the
    spacing, second in dt. Past a penalised cylinder, fixed, towed, shaken or spun, within 3e-4 of
    the penalisation's momentum with 16 nodes between body and faces, 2e-3 with 8. Costs one sum
    over the box and its four faces, 2 ms for 130 x 130 nodes. Refuses a box that lacks
    two nodes around it, and a mesh that is not plane.
    """
    _check(velocity, vorticity, grid, box, dt)
    arms = _arms(grid, box, center)
    along = [_weights(len(arm), grid.spacing) for arm in arms]
    gained = np.subtract(velocity[1][:, *box], velocity[0][:, *box], dtype=np.float64) / dt
    lines = [gained @ along[1], np.einsum("cij,i->cj", gained, along[0])]  # over y, over x
    force = -lines[0] @ along[0]
    torque = -float(lines[0][1] @ (along[0] * arms[0]) - lines[1][0] @ (along[1] * arms[1]))
    rates, levers, lengths = [], [], []
    for axis in (0, 1):
        for side in (0, 1):
            arm, flux, rate = _face(
                velocity, vorticity, grid, box, arms, (axis, side), dt, viscosity
            )
            weight = along[1 - axis]
            force = force + flux @ weight
            torque += float((arm[0] * flux[1] - arm[1] * flux[0]) @ weight)
            rates.append(rate)
            lengths.append(weight)
            levers.append(np.stack([-arm[1], arm[0], 0.5 * (arm[0] ** 2 + arm[1] ** 2)]))
    rate, length, lever = np.concatenate(rates), np.concatenate(lengths), np.hstack(levers)
    mismatch = float(rate @ length)
    parts = lever @ ((rate - mismatch / length.sum()) * length)
    return Balance(
        (float(force[0] + parts[0]), float(force[1] + parts[1])),
        torque + float(parts[2]),
        mismatch,
    )


def box_of(
    before: Bounds,
    after: Bounds,
    others: Sequence[Bounds],
    grid: Grid,
    margin: int = WANTED,
) -> Box | None:
    """Nodes of the box around a body over a step, or None if there is no room for one.

    ``before``, ``after``: its bounds [L]; ``others``: those of all other bodies, at both times; the
    box keeps `CLEAR` nodes from every body and two from the mesh's edge, and ``margin`` nodes
    from its own body where it can. It never crosses the seam of a periodic axis.
    """
    if margin < CLEAR:
        raise InputError(
            f"a control volume needs {CLEAR} nodes around the body, got {margin}",
            hint=f"margin={WANTED}",
        )
    low, high = _hull(before, after, grid)
    first = [max(a - margin, REACH) for a in low]
    last = [min(b + margin, n - 1 - REACH) for b, n in zip(high, grid.shape, strict=True)]
    for other in others:
        _withdraw(first, last, (low, high), _hull(other, other, grid))
    room = [min(a - i, j - b) for a, b, i, j in zip(low, high, first, last, strict=True)]
    if min(room) < CLEAR:
        return None
    return slice(first[0], last[0] + 1), slice(first[1], last[1] + 1)


def _withdraw(
    first: list[int],
    last: list[int],
    own: tuple[list[int], list[int]],
    other: tuple[list[int], list[int]],
) -> None:
    """Draw in the face that loses least, so that the box keeps clear of another body."""
    low, high = other
    if any(low[k] - CLEAR >= last[k] or high[k] + CLEAR <= first[k] for k in (0, 1)):
        return
    after = [(low[k] - CLEAR - own[1][k], k, 1) for k in (0, 1)]
    ahead = [(own[0][k] - high[k] - CLEAR, k, 0) for k in (0, 1)]
    _, axis, side = max(after + ahead)
    if side:
        last[axis] = low[axis] - CLEAR
    else:
        first[axis] = high[axis] + CLEAR


def _hull(before: Bounds, after: Bounds, grid: Grid) -> tuple[list[int], list[int]]:
    """First and last node of the lattice around a body at both times."""
    low, high = [], []
    for axis in range(grid.ndim):
        start = min(before[0][axis], after[0][axis]) - grid.origin[axis]
        end = max(before[1][axis], after[1][axis]) - grid.origin[axis]
        low.append(math.floor(start / grid.spacing))
        high.append(math.ceil(end / grid.spacing))
    return low, high


def _face(
    velocity: tuple[Array, Array],
    vorticity: tuple[Array, Array],
    grid: Grid,
    box: Box,
    arms: tuple[Values, Values],
    face: tuple[int, int],
    dt: float,
    viscosity: float,
) -> tuple[Values, Values, Values]:
    """Arms (2, n), momentum flux less pressure (2, n) and g (n) on one face, mean over the step."""
    axis, side = face
    sign = 2.0 * side - 1.0
    inner = box[axis].stop - 1 if side else box[axis].start
    other = box[1 - axis]
    wide: list[slice] = [slice(inner - REACH, inner + REACH + 1)] * 2
    wide[1 - axis] = slice(other.start - REACH, other.stop + REACH)
    strip = Grid([part.stop - part.start for part in wide], grid.spacing)
    middle: list[Any] = [REACH, REACH]
    middle[1 - axis] = slice(REACH, -REACH)
    flux, rate, spots = np.zeros((2, 1)), np.zeros(1), []
    for u, w in zip(velocity, vorticity, strict=True):
        fields = np.concatenate([u[:, *wide], w[None, *wide]]).astype(np.float64)
        slopes = gradient(fields, strip, order=4)[:, :, *middle]  # [j, i] is d_j of field i
        here, vortex = fields[:2, *middle], fields[2, *middle]
        stress = viscosity * sign * (slopes[axis, :2] + slopes[:, axis])
        flux = flux + 0.5 * (stress - sign * here[axis] * here)
        flux[axis] += 0.25 * sign * (here[0] ** 2 + here[1] ** 2)
        rate = rate + 0.5 * sign * (vortex * here[axis] - viscosity * slopes[axis, 2])
        spots.append(here)
    turn = sign if axis == 0 else -sign  # of the tangent, along the other axis
    rate = rate + turn * (spots[1] - spots[0])[1 - axis] / dt
    arm = [np.full(rate.size, arms[k][-1 if side else 0]) for k in (0, 1)]
    arm[1 - axis] = arms[1 - axis]
    return np.stack(arm), flux, rate


def _arms(grid: Grid, box: Box, center: Sequence[float]) -> tuple[Values, Values]:
    """Coordinates of the box's nodes along each axis, from the centre."""
    x, y = (
        axis[part] - float(middle)
        for axis, part, middle in zip(grid.axes(), box, center, strict=True)
    )
    return x, y


def _weights(count: int, spacing: float) -> Values:
    """Weights of the integral over a line of nodes, fourth order."""
    weights = np.full(count, spacing)
    for place, weight in enumerate(ENDS):
        weights[place] = weights[-1 - place] = weight * spacing
    return weights


def _check(
    velocity: tuple[Array, Array],
    vorticity: tuple[Array, Array],
    grid: Grid,
    box: Box,
    dt: float,
) -> None:
    if grid.ndim != 2:
        raise InputError(
            f"the control volume is a law of the plane, got {grid.ndim} dimensions",
            hint="a 2-D grid",
        )
    for name, pair, shape in (
        ("velocity", velocity, (2, *grid.shape)),
        ("vorticity", vorticity, grid.shape),
    ):
        if any(np.shape(one) != shape for one in pair):
            raise InputError(
                f"{name} before and after must have shape {shape}, got "
                f"{np.shape(pair[0])} and {np.shape(pair[1])}",
                hint="both on the mesh of the later time",
            )
    for part, nodes in zip(box, grid.shape, strict=True):
        if part.start < REACH or part.stop > nodes - REACH or part.stop - part.start < 6:
            raise InputError(
                f"the box takes nodes {part.start} to {part.stop - 1} of an axis of {nodes}",
                hint=f"at least 6 nodes, and {REACH} more around them: box_of(...)",
            )
    if not (math.isfinite(dt) and dt > 0):
        raise InputError(f"dt must be positive and finite, got {dt}", hint="the time of the step")
