"""The adaptive mesh as a recipe: its finest grid, how often it is halved, and to what tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass

from remesh.errors import InputError, as_number
from remesh.grid import Grid
from remesh.multires.wavelets import Wavelet, get_wavelet

SIZES = (8, 16, 32)  # nodes along the edge of a block


@dataclass(frozen=True, kw_only=True)
class AdaptiveMesh:
    """A mesh that is as fine as ``grid`` where it must be, and up to 2^levels times coarser.

    Level ``levels`` has the spacing of ``grid``, level 0 is the coarsest and covers everything.
    Blocks of ``block``^ndim nodes are kept where a field has details beyond ``tolerance`` times
    its scale, and made one level finer where it has details beyond ``refinement`` times that. With
    ``most_blocks`` the tolerance is raised as far as that needs. Fields are zero beyond unbounded
    ends. Refuses a refinement threshold below the tolerance, and axes of the grid that are not
    whole numbers of blocks on the coarsest level.
    Source: blocks and thresholds as in Rossinelli et al., J. Comput. Phys. 288 (2015) 1.
    """

    grid: Grid  # the finest
    levels: int  # number of halvings
    tolerance: float = 1e-3  # details below it are let go; relative to the scale of the field
    refinement: float | None = None  # details beyond it are resolved one level finer
    wavelet: str | Wavelet = "4.4"
    block: int = 16  # nodes along its edge
    most_blocks: int | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be refined or coarsened."""
        get_wavelet(self.wavelet)
        tolerance = as_number("tolerance", self.tolerance, hint="tolerance=1e-3")
        if not 0 < tolerance < 1:
            raise InputError(
                f"tolerance must lie in (0, 1), got {tolerance}", hint="tolerance=1e-3"
            )
        if self.refinement is not None:
            finer = as_number("refinement", self.refinement, hint="refinement=None")
            if not (math.isfinite(finer) and finer >= tolerance):
                raise InputError(
                    f"the refinement threshold must not lie below the tolerance {tolerance}, under "
                    f"which blocks are coarsened again, got {finer}",
                    hint="refinement=None takes 4 times the tolerance",
                )
        if self.block not in SIZES:
            raise InputError(f"block must be one of {SIZES}, got {self.block}", hint="block=16")
        if isinstance(self.levels, bool) or int(self.levels) != self.levels or self.levels < 1:
            raise InputError(
                f"levels must be a whole number >= 1, got {self.levels}", hint="levels=4"
            )
        unit = self.block * 2**self.levels
        if any(n % unit for n in self.grid.shape):
            near = tuple(max(1, round(n / unit)) * unit for n in self.grid.shape)
            raise InputError(
                f"{self.levels} halvings into blocks of {self.block} nodes need multiples of "
                f"{unit} nodes on each axis, got {self.grid.shape}",
                hint=f"a grid of shape {near}, fewer levels, or smaller blocks",
            )
        if self.most_blocks is not None and self.most_blocks < math.prod(self.counts(0)):
            raise InputError(
                f"most_blocks must be at least {math.prod(self.counts(0))}, the number of blocks "
                f"on the coarsest level, got {self.most_blocks}",
                hint="more levels, or most_blocks=None",
            )

    @property
    def ndim(self) -> int:
        """Number of axes, 2 or 3."""
        return self.grid.ndim

    @property
    def thresholds(self) -> tuple[float, float]:
        """Details below the first are let go, beyond the second they are refined; relative."""
        finer = 4.0 * self.tolerance if self.refinement is None else self.refinement
        return self.tolerance, finer

    def spacing(self, level: int) -> float:
        """Spacing of a level [L]."""
        return float(self.grid.spacing * 2 ** (self.levels - level))

    def counts(self, level: int) -> tuple[int, ...]:
        """Number of blocks along each axis if a level covered the whole domain."""
        part: int = 2 ** (self.levels - level) * self.block
        return tuple(n // part for n in self.grid.shape)

    def level_grid(self, level: int) -> Grid:
        """The uniform grid of a level, over the whole domain."""
        shape = tuple(n * self.block for n in self.counts(level))
        return Grid(shape, self.spacing(level), self.grid.origin, self.grid.boundary)
