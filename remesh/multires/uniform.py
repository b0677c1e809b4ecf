"""Values on blocks as a field on uniform nodes of any level, and such fields onto the blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remesh.errors import InputError
from remesh.multires.blocks import ABSENT, Blocks, Numbers
from remesh.multires.ghosts import Outside, check_values, goes_on, layers, lifting_weights
from remesh.multires.mesh import AdaptiveMesh

Array = NDArray[np.floating[Any]]
Whole = NDArray[np.int64]
CUBIC = 4  # nodes that a cubic goes through


def to_uniform(
    values: Array,
    blocks: Blocks,
    level: int | None = None,
    *,
    region: Sequence[slice | range] | None = None,
    outside: Outside = "zero",
) -> Array:
    """Values ``(n, ...)`` or ``(c, n, ...)`` on the nodes of ``mesh.level_grid(level)``.

    By default of the finest level the mesh may have. ``region`` picks a box of those nodes, one
    slice or range per axis; a range may pass the ends: periodic axes go on, beyond others the
    field is zero, or as at the last node with ``outside="last"``. Where the mesh is finer, the
    restriction; where it is coarser, its subdivision by the wavelet's prediction, which near
    unbounded ends sees zeros too, or cubics through the last nodes. O(nodes of the box).
    """
    values = check_values(values, blocks)
    mesh = blocks.mesh
    asked = mesh.checked_level(level)
    first, shape = _box_of(region, mesh.level_grid(asked).shape)
    field = _Sampler(values, blocks, goes_on(outside)).box(asked, first, shape)
    return field.reshape(*values.shape[: -len(blocks.shape)], *shape[3 - mesh.ndim :])


def on_blocks(field: Array, blocks: Blocks) -> Array:
    """Values on the blocks of a complete pyramid: the field on its finest nodes, zeros below."""
    mesh = blocks.mesh
    result = np.zeros((*field.shape[: -mesh.ndim], *blocks.shape), field.dtype)
    finest: Any = (..., blocks.of(mesh.levels), *(slice(None),) * mesh.ndim)
    result[finest] = by_blocks(field, mesh, mesh.levels)
    return result


def by_blocks(field: Array, mesh: AdaptiveMesh, level: int) -> Array:
    """A field on all nodes of a level block by block, in the order of `Blocks`."""
    counts, size, ndim = mesh.counts(level), mesh.block, mesh.ndim
    parts = field.reshape(-1, *(n for count in counts for n in (count, size)))
    order = (0, *range(1, 2 * ndim, 2), *range(2, 2 * ndim + 1, 2))
    return parts.transpose(order).reshape(*field.shape[:-ndim], -1, *(size,) * ndim)


class _Sampler:
    """Values on blocks, read on boxes of the nodes of a level, x y z; in 2-D x has one node.

    Beyond unbounded ends they are zero, or ``last``: as at the last node.
    """

    def __init__(self, values: Array, blocks: Blocks, last: bool) -> None:
        self.blocks, self.last = blocks, last
        self.parts = layers(values, blocks)
        self.weights = lifting_weights(blocks, values.dtype)[0]
        flat = (True,) * (3 - blocks.mesh.ndim)
        self.deep = np.array([not flat, True, True])
        self.wraps = np.array([*flat, *blocks.mesh.grid.periodic])

    def box(self, level: int, first: Whole, shape: Whole) -> Array:
        """A box of so many nodes of a level from node ``first`` on."""
        from remesh.multires import _uniform

        start, size = self.within(level, first, shape, 1)
        result = np.zeros((len(self.parts), *size), self.parts.dtype)
        numbers, corner = _blocks_under(self.blocks, level, start, size)
        if (numbers == ABSENT).any():
            self.subdivide(level, start, size, result)
        _uniform.paste(self.parts, numbers, corner, start, 1, result)
        pads = zip(start - first, first + shape - start - size, strict=True)
        return _repeated(result, list(pads)) if self.last else result

    def subdivide(self, level: int, first: Whole, shape: Whole, result: Array) -> None:
        """Fill a box with predictions from the even nodes around it."""
        from remesh.multires import _ghosts, _uniform

        reach = len(self.weights) // 2
        low = np.where(self.deep, first // 2 - reach + 1, 0)
        size = np.where(self.deep, (first + shape - 1) // 2 + reach - low + 1, 1)
        start, inner = self.within(level - 1, low, size, CUBIC)
        even = self.box(level - 1, start, inner)
        numbers, corner = _blocks_under(self.blocks, level, 2 * start, 2 * inner - 1)
        _uniform.paste(self.parts, numbers, corner, start, 2, even)
        if self.last:
            even = _extended(even, start, low, size)
        slab = np.empty((shape[0], *size[1:]), even.dtype)
        plane = np.empty((*shape[:2], size[2]), even.dtype)
        before = tuple(int(-(node % 2)) for node in first)
        for nodes, target in zip(even, result, strict=True):
            _ghosts.subdivide(nodes, reach - 1, before, self.weights, slab, plane, target)

    def within(self, level: int, first: Whole, shape: Whole, least: int) -> tuple[Whole, Whole]:
        """The part of a box within unbounded ends, at least so many nodes where it passes one."""
        if not self.last:
            return first, shape
        mesh, end = self.blocks.mesh, first + shape
        nodes = np.ones(3, np.int64)
        nodes[3 - mesh.ndim :] = mesh.level_grid(level).shape
        start = np.where(end > nodes, np.minimum(first, nodes - least), first)
        stop = np.where(first < 0, np.maximum(end, least), end)
        start = np.where(self.wraps, first, np.maximum(start, 0))
        stop = np.where(self.wraps, end, np.minimum(stop, nodes))
        return start, stop - start


def _repeated(box: Array, pads: list[tuple[int, int]]) -> Array:
    """A box with so many nodes more before and after it, the last ones again; fewer if negative."""
    for axis, (before, after) in enumerate(pads, 1):
        if before or after:
            index = np.arange(-before, box.shape[axis] + after)
            box = box.take(index.clip(0, box.shape[axis] - 1), axis=axis)
    return box


def _extended(inner: Array, start: Whole, first: Whole, shape: Whole) -> Array:
    """A box from node ``start`` on, continued by cubics: so many nodes from ``first`` on."""
    low = np.minimum(start, first)
    high = np.maximum(start + inner.shape[1:], first + shape)
    result = np.empty((len(inner), *(high - low)), inner.dtype)
    parts = [slice(a, a + n) for a, n in zip(start - low, inner.shape[1:], strict=True)]
    result[(slice(None), *parts)] = inner
    with np.errstate(over="ignore", invalid="ignore"):  # as the compiled loops: any values pass
        for axis, part in enumerate(parts, 1):
            _go_on(np.moveaxis(result, axis, 0), part.start, part.stop)
    wanted = (slice(a, a + n) for a, n in zip(first - low, shape, strict=True))
    return np.ascontiguousarray(result[(slice(None), *wanted)])


def _go_on(rows: Array, low: int, high: int) -> None:
    """Rows before ``low`` and from ``high`` on by cubics through the four next to them."""
    for i in range(low - 1, -1, -1):
        rows[i] = 4 * (rows[i + 1] + rows[i + 3]) - 6 * rows[i + 2] - rows[i + 4]
    for i in range(high, len(rows)):
        rows[i] = 4 * (rows[i - 1] + rows[i - 3]) - 6 * rows[i - 2] - rows[i - 4]


def _box_of(region: Sequence[slice | range] | None, shape: tuple[int, ...]) -> tuple[Whole, Whole]:
    """First node and shape of a box, x y z; in 2-D x has one node."""
    picked = [slice(None)] * len(shape) if region is None else list(region)
    if len(picked) != len(shape):
        raise InputError(
            f"region must be {len(shape)} slices or ranges, got {len(picked)}",
            hint="region=(slice(0, 64), slice(0, 64))",
        )
    first, size = [0] * (3 - len(shape)), [1] * (3 - len(shape))
    for part, nodes in zip(picked, shape, strict=True):
        if not isinstance(part, slice | range):
            raise InputError(
                f"region must hold slices or ranges of nodes, got {part!r}", hint="slice(0, 64)"
            )
        found = range(*part.indices(nodes)) if isinstance(part, slice) else part
        if found.step != 1 or len(found) == 0:
            raise InputError(
                f"region must hold whole runs of nodes, got {part}", hint="slice(0, 64)"
            )
        first.append(found.start)
        size.append(len(found))
    return np.array(first, np.int64), np.array(size, np.int64)


def _blocks_under(blocks: Blocks, level: int, first: Whole, shape: Whole) -> tuple[Numbers, Whole]:
    """Numbers of the blocks of a level under a box, x y z, and the place of the first one."""
    flat = 3 - blocks.mesh.ndim
    size = np.array([1] * flat + [blocks.mesh.block] * blocks.mesh.ndim)
    corner = first // size
    last = (first + shape - 1) // size
    axes = [np.arange(a, b + 1) for a, b in zip(corner[flat:], last[flat:], strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return blocks.numbers_of(level, places).reshape(last - corner + 1), corner
