"""Compiled loops over nodes of several levels: their motion, and what they tell each other.

Meshes are ``(nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node. A table
of an axis gives the part of the flat index of each place, -2 to n + 1: wrapped, or mirrored.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

from numba import njit

from levelset import _curvature_flow
from levelset._curvature_flow import along, bend, slope
from remesh.compiled import drop_stale

drop_stale(__file__, _curvature_flow.__file__)


@njit(cache=True, nogil=True, inline="always")
def twist(field, at, u0, u1, u2, u3, v0, v1, v2, v3):
    """Mixed derivative from the places -2, -1, 1, 2 of two axes around ``at`` on the others."""
    near = (field[at + u2 + v2] + field[at + u1 + v1]) - (field[at + u2 + v1] + field[at + u1 + v2])
    far = (field[at + u3 + v3] + field[at + u0 + v0]) - (field[at + u3 + v0] + field[at + u0 + v3])
    steep = (field[at + u3 + v2] + field[at + u0 + v1]) - (
        field[at + u3 + v1] + field[at + u0 + v2]
    )
    shallow = (field[at + u2 + v3] + field[at + u1 + v0]) - (
        field[at + u2 + v0] + field[at + u1 + v3]
    )
    return (64.0 * near - 8.0 * (steep + shallow) + far) / 144.0


@njit(cache=True, nogil=True)
def motion2(first, pieces, step, size, nodes, shape, xs, ys, zs, field, scale, rates):
    """kappa |grad phi| of a plane phi at nodes: ``scale`` times h^2 (lap phi - n.Hess.n)."""
    columns = shape[2]
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, len(nodes))):
            i, k = nodes[n] // columns, nodes[n] % columns
            x, z = xs[i + 2], zs[k + 2]
            x0, x1, x2, x3 = xs[i], xs[i + 1], xs[i + 3], xs[i + 4]
            z0, z1, z2, z3 = zs[k], zs[k + 1], zs[k + 3], zs[k + 4]
            here = field[x + z]
            a, b, c, d = field[x0 + z], field[x1 + z], field[x2 + z], field[x3 + z]
            px, xx = slope(a, b, c, d), bend(a, b, c, d, here)
            a, b, c, d = field[x + z0], field[x + z1], field[x + z2], field[x + z3]
            pz, zz = slope(a, b, c, d), bend(a, b, c, d, here)
            xz = twist(field, 0, x0, x1, x2, x3, z0, z1, z2, z3)
            pure = px * px * xx + pz * pz * zz + 2.0 * (px * pz * xz)
            squares = xx * xx + zz * zz + 2.0 * (xz * xz)
            cube = xx * xx * xx + zz * zz * zz + 3.0 * (xx + zz) * (xz * xz)
            normal = along(px * px + pz * pz, pure, squares, cube)
            rates[n] = scale * (xx + zz - normal)


@njit(cache=True, nogil=True)
def motion3(first, pieces, step, size, nodes, shape, xs, ys, zs, field, scale, rates):
    """kappa |grad phi| of a phi in space at nodes: ``scale`` times h^2 (lap phi - n.Hess.n)."""
    row, columns = shape[1] * shape[2], shape[2]
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, len(nodes))):
            node = nodes[n]
            i, j, k = node // row, (node // columns) % shape[1], node % columns
            x, y, z = xs[i + 2], ys[j + 2], zs[k + 2]
            x0, x1, x2, x3 = xs[i], xs[i + 1], xs[i + 3], xs[i + 4]
            y0, y1, y2, y3 = ys[j], ys[j + 1], ys[j + 3], ys[j + 4]
            z0, z1, z2, z3 = zs[k], zs[k + 1], zs[k + 3], zs[k + 4]
            at = y + z
            here = field[x + at]
            a, b, c, d = field[x0 + at], field[x1 + at], field[x2 + at], field[x3 + at]
            px, xx = slope(a, b, c, d), bend(a, b, c, d, here)
            at = x + z
            a, b, c, d = field[y0 + at], field[y1 + at], field[y2 + at], field[y3 + at]
            py, yy = slope(a, b, c, d), bend(a, b, c, d, here)
            at = x + y
            a, b, c, d = field[z0 + at], field[z1 + at], field[z2 + at], field[z3 + at]
            pz, zz = slope(a, b, c, d), bend(a, b, c, d, here)
            xy = twist(field, z, x0, x1, x2, x3, y0, y1, y2, y3)
            xz = twist(field, y, x0, x1, x2, x3, z0, z1, z2, z3)
            yz = twist(field, x, y0, y1, y2, y3, z0, z1, z2, z3)
            pure = px * px * xx + py * py * yy + pz * pz * zz
            pure += 2.0 * (px * py * xy + px * pz * xz + py * pz * yz)
            squares = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz)
            cube = xx * xx * xx + yy * yy * yy + zz * zz * zz + 6.0 * (xy * xz * yz)
            cube += 3.0 * ((xx + yy) * (xy * xy) + (xx + zz) * (xz * xz) + (yy + zz) * (yz * yz))
            normal = along(px * px + py * py + pz * pz, pure, squares, cube)
            rates[n] = scale * (xx + yy + zz - normal)


@njit(cache=True, nogil=True)
def advance(first, pieces, step, size, nodes, weights, start, before, rates, initial, field):
    """A stage: ``field`` at the nodes goes on, ``before`` takes what it was."""
    last, earlier, whole, rate, base = weights
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, len(nodes))):
            node = nodes[n]
            value = field[node]
            field[node] = (
                last * value + earlier * before[n] + whole * start[n]
                + rate * rates[n] + base * initial[n]
            )  # fmt: skip
            before[n] = value


@njit(cache=True, nogil=True)
def whole(node, shape, xs, ys, zs, marks, known):
    """Whether all that the motion of a node is told by is known."""
    row, columns = shape[1] * shape[2], shape[2]
    i, j, k = node // row + 2, (node // columns) % shape[1] + 2, node % columns + 2
    for p in (-2, 2, -1, 1):
        for q in (-2, 2, -1, 1):
            if marks[xs[i + p] + ys[j] + zs[k + q]] & known == 0:
                return False
            if shape[1] > 1:
                if marks[xs[i + p] + ys[j + q] + zs[k]] & known == 0:
                    return False
                if marks[xs[i] + ys[j + p] + zs[k + q]] & known == 0:
                    return False
        if marks[xs[i + p] + ys[j] + zs[k]] & known == 0:
            return False
        if marks[xs[i] + ys[j] + zs[k + p]] & known == 0:
            return False
        if shape[1] > 1 and marks[xs[i] + ys[j + p] + zs[k]] & known == 0:
            return False
    return True


@njit(cache=True, nogil=True)
def part(nodes, ground, shape, below, xs, ys, zs, marks, coarse, flags, moved, told, under, pairs):
    """Part the nodes of a level: those that move, and those that the next coarser one tells.

    A node that moves tells the node of the coarser level, of shape ``below``, at its place: both
    into ``pairs`` and ``under``, and that one is flagged in ``coarse``. What a finer level told so
    before is left out. On the ``ground`` all others move. Returns how many there are of the three.
    """
    known, taken = flags
    row, columns = shape[1] * shape[2], shape[2]
    going, held, shared = 0, 0, 0
    for node in nodes:
        own = ground or whole(node, shape, xs, ys, zs, marks, known)
        if marks[node] & taken == 0:
            if own:
                moved[going] = node
                going += 1
            else:
                told[held] = node
                held += 1
                continue
        if ground:
            continue
        i, m, c = node // row, (node // columns) % shape[1], node % columns
        if i % 2 or m % 2 or c % 2:
            continue
        parent = ((i // 2) * below[1] + m // 2) * below[2] + c // 2
        coarse[parent] |= taken
        pairs[shared] = node
        under[shared] = parent
        shared += 1
    return going, held, shared


@njit(cache=True, nogil=True)
def prolong(first, pieces, step, size, nodes, shape, below, xs, ys, zs, coarse, predict, field):
    """Values at nodes, from those of the next coarser level, of shape ``below``, around them.

    ``xs``, ``ys``, ``zs`` are the tables of the coarser level.
    """
    row, columns = shape[1] * shape[2], shape[2]
    for piece in range(first, pieces, step):
        for n in range(piece * size, min((piece + 1) * size, len(nodes))):
            node = nodes[n]
            i, m, c = node // row, (node // columns) % shape[1], node % columns
            a, b, d = i % 2, m % 2, c % 2
            i, m, c = i // 2 + 2, m // 2 + 2, c // 2 + 2
            total = 0.0
            for p in range(-1 if a else 0, 3 if a else 1):
                x = xs[i + p]
                wx = predict[p + 1] if a else 1.0
                for q in range(-1 if b else 0, 3 if b else 1):
                    y = x + ys[m + q]
                    wy = wx * predict[q + 1] if b else wx
                    line = 0.0
                    if d:
                        line += (
                            predict[1] * coarse[y + zs[c]] + predict[2] * coarse[y + zs[c + 1]]
                        ) + (
                            predict[0] * coarse[y + zs[c - 1]] + predict[3] * coarse[y + zs[c + 2]]
                        )
                    else:
                        line = coarse[y + zs[c]]
                    total += wy * line
            field[node] = total


@njit(cache=True, nogil=True)
def hand_down(pairs, under, field, coarse):
    """Values at nodes of a level to those of the coarser one at the same places."""
    for n in range(len(pairs)):
        coarse[under[n]] = field[pairs[n]]


@njit(cache=True, nogil=True)
def table(count, wraps, stride, result):
    """The part of the flat index of places -2 to count + 1 along an axis: wrapped, or mirrored."""
    for place in range(-2, count + 2):
        here = place
        if wraps:
            here = place % count
        elif count == 1:
            here = 0
        elif place < 0:
            here = -place
        elif place >= count:
            here = 2 * (count - 1) - place
        result[place + 2] = here * stride
