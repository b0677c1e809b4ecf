"""The finest part of an adaptive mesh around bodies, and the velocity that they feel on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.body import Body
from pmesh.bodies.pose import Pose
from remesh.grid import Grid
from remesh.multires.blocks import Places
from remesh.multires.mesh import AdaptiveMesh

Array = NDArray[np.floating[Any]]
RIPPLE = tuple((-1) ** k * math.comb(12, k) / 2**12 for k in range(13))  # sin(k h / 2)^12
SKIN = 8  # nodes around a wall in which the mesh is as fine as it can be


def smoothed(velocity: Array) -> Array:
    """A velocity (c, nx, ny) without ripples: waves k lose sin(k h / 2)^12 of themselves.

    A regularised velocity has none, and a wall pushes hard against them without effect; the
    hierarchy's corrections have different taps at odd and even nodes, and leave some.
    """
    result = velocity
    for axis in range(1, velocity.ndim):
        count = velocity.shape[axis] - len(RIPPLE) + 1
        if count <= 0:
            continue
        parts = np.moveaxis(result, axis, 0)
        change = np.zeros_like(parts[:count])
        for k, weight in enumerate(RIPPLE):
            change += velocity.dtype.type(weight) * parts[k : k + count]
        result = result.copy()
        half = len(RIPPLE) // 2
        np.moveaxis(result, axis, 0)[half : half + count] -= change
    return result


def hull(boxes: Sequence[Grid]) -> Grid:
    """The smallest box of a lattice that holds some boxes of it."""
    one = boxes[0]
    low = np.min([box.origin for box in boxes], axis=0)
    high = np.max(
        [np.add(box.origin, np.multiply(box.shape, box.spacing)) for box in boxes], axis=0
    )
    shape = np.rint((high - low) / one.spacing).astype(int)
    return Grid(shape.tolist(), one.spacing, low.tolist(), one.boundary)


@lru_cache(maxsize=4)
def skin(bodies: tuple[Body, ...], places: tuple[Pose, ...], mesh: AdaptiveMesh) -> Places:
    """Places of the finest blocks within some nodes of the surfaces of bodies."""
    h, found = mesh.grid.spacing, []
    for body, pose in zip(bodies, places, strict=True):
        low, high = (np.asarray(corner) for corner in body.bounds(pose))
        first = np.floor((low - mesh.grid.origin) / h).astype(int) - 2 * SKIN
        last = np.ceil((high - mesh.grid.origin) / h).astype(int) + 2 * SKIN
        axes = [np.arange(a, b + 1, 4) for a, b in zip(first, last, strict=True)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"))
        shape = (mesh.ndim, *(1,) * mesh.ndim)
        points = np.reshape(mesh.grid.origin, shape) + h * nodes
        near = np.abs(body.distance(points, pose)) < (SKIN + 4) * h
        found.append(nodes[:, near].T // mesh.block)
    return np.unique(np.concatenate(found), axis=0)
