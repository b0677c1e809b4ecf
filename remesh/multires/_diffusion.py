"""Compiled sums of symmetric stencils over blocks with ghosts, one axis after the other.

Blocks are ``(n, nx, nm, nc)``, the last axis contiguous; in 2-D the middle axis has one node.
"""

# mypy: disable-error-code="no-untyped-def, no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import njit

from remesh import _spreading
from remesh._spreading import blend
from remesh.compiled import drop_stale

drop_stale(__file__, _spreading.__file__)


@njit(cache=True, nogil=True)
def convolve(first, pieces, step, size, ghosts, width, levels, weights, out):
    """Each block's stencil, that of its level, along all axes; ``width`` ghosts on each side."""
    blocks, nx, nm = out.shape[:3]
    pm, pc = ghosts.shape[2:]
    one = np.empty(nx * pm * pc, out.dtype)
    two = np.empty(nx * nm * pc, out.dtype)
    for piece in range(first, pieces, step):
        for b in range(piece * size, min((piece + 1) * size, blocks)):
            source = ghosts[b].reshape(ghosts[b].size)
            row = weights[levels[b]]
            line = pm * pc
            for i in range(nx):
                part = one[i * line : (i + 1) * line]
                blend(source, (i + width) * line, line, row, part)
            across = one
            if nm > 1:
                for i in range(nx):
                    for m in range(nm):
                        n = i * nm + m
                        start = (i * pm + m + width) * pc
                        blend(one, start, pc, row, two[n * pc : (n + 1) * pc])
                across = two
            for i in range(nx):
                for m in range(nm):
                    blend(across, (i * nm + m) * pc + width, 1, row, out[b, i, m])
