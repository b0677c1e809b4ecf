"""The adaptive mesh as a recipe: its finest grid, how often it is halved, and to what tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass

from remesh.errors import InputError, as_number, as_whole
from remesh.grid import Grid
from remesh.multires.wavelets import Wavelet, get_wavelet

SIZES = (8, 16, 32)  # nodes along the edge of a block
CELL = 4  # nodes along the edge of the parts of a block in which details are told apart
BUFFER = 8  # nodes around a detail, or around where it moved, that stay as fine as they are


@dataclass(frozen=True, kw_only=True)
class AdaptiveMesh:
    """A mesh that is as fine as ``grid`` where it must be, and up to 2^levels times coarser.

    Level ``levels`` has the spacing of ``grid``, level 0 is the coarsest and covers everything.
    Blocks of ``block``^ndim nodes are kept where a field has details beyond ``tolerance`` times
    its scale, and made one level finer where it has details beyond ``refinement`` times that. With
    ``most_blocks`` the tolerance is raised as far as that needs whenever the mesh is adapted:
    within a step there may be more, as many as the flow spreads the blocks over, and while a law
    is sampled, as many as it has details for. Fields are zero beyond unbounded
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
        """Refuse what cannot be refined or coarsened; hold whole numbers as int."""
        if not isinstance(self.grid, Grid):
            raise InputError(
                f"grid must be a Grid, the finest, got {self.grid!r:.60}",
                hint="remesh.Grid((1024, 1024), 1/1024)",
            )
        get_wavelet(self.wavelet)
        self._check_thresholds()
        self._hold("levels", as_whole("levels", self.levels, least=1, hint="levels=4"))
        self._hold("block", as_whole("block", self.block, least=1, hint="block=16"))
        if self.block not in SIZES:
            raise InputError(f"block must be one of {SIZES}, got {self.block}", hint="block=16")
        unit = self.block * 2**self.levels
        if any(n % unit for n in self.grid.shape):
            near = tuple(max(1, round(n / unit)) * unit for n in self.grid.shape)
            raise InputError(
                f"{self.levels} halvings into blocks of {self.block} nodes need multiples of "
                f"{unit} nodes on each axis, got {self.grid.shape}",
                hint=f"a grid of shape {near}, fewer levels, or smaller blocks",
            )
        if self.most_blocks is not None:
            least, hint = math.prod(self.counts(0)), "more levels, or most_blocks=None"
            most = as_whole("most_blocks", self.most_blocks, least=1, hint=hint)
            if most < least:
                raise InputError(
                    f"most_blocks must be at least {least}, the number of blocks on the coarsest "
                    f"level, got {most}",
                    hint=hint,
                )
            self._hold("most_blocks", most)

    def _hold(self, name: str, value: int) -> None:
        """Take a number as it was checked."""
        object.__setattr__(self, name, value)

    def _check_thresholds(self) -> None:
        """Refuse a tolerance that is none, and refinement below it."""
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

    def checked_level(self, level: int | None) -> int:
        """The level that is asked for, the finest for None; refuses what is none of the mesh."""
        if level is None:
            return self.levels
        hint = "level=None takes the finest"
        asked = as_whole("level", level, least=0, hint=hint)
        if asked > self.levels:
            raise InputError(
                f"level must be a whole number from 0 to {self.levels}, got {level}", hint=hint
            )
        return asked
