"""Zalesak's slotted sphere, turned by particles near its surface without remeshing, or with it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from levelset.slotted import SlottedSphere
from pmesh.cases.case import Outcome
from pmesh.cases.style import name_panels, styled
from pmesh.cases.zalesak import BOX, PERIOD, Zalesak, in_turns, show_errors
from remesh.grid import Grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from levelset.interface import Interface
    from levelset.laws import Rotation
    from pmesh.run.snapshots import Snapshot

Values = NDArray[np.float64]
VIEW, BELOW = (-72.0, 14.0), (-58.0, -30.0)  # of the pictures: azimuth and elevation [degrees]
COLOURS = ("#c9d8e6", "#a9c4df", "#83abd6", "#5b9bd5")  # of the stages, the last the strongest


@dataclass(frozen=True, kw_only=True)
class ZalesakSphere(Zalesak):
    """A ball with a slot turns about an axis through the middle of a box."""

    title: ClassVar[str] = "Zalesak's sphere"
    source: ClassVar[str] = "Enright et al., J. Comput. Phys. 183 (2002) 83"
    short: ClassVar[Mapping[str, Any]] = {"nodes": 50, "until": PERIOD / 4}
    looks: ClassVar[int] = 8
    fine: ClassVar[int] = 2
    reach: ClassVar[float] = 1.0

    @property
    def shape(self) -> SlottedSphere:
        """Radius 15, the slot 5 wide and 12.5 deep."""
        return SlottedSphere(center=(0.5 * BOX, 0.5 * BOX, 0.75 * BOX))

    @property
    def law(self) -> Rotation:
        """About the line through the middle of the box along y, along the slot's walls."""
        from levelset.laws import Rotation

        return Rotation(center=(0.5 * BOX,) * 3, rate=(0.0, 2.0 * math.pi / PERIOD, 0.0))

    @styled
    def draw(self, outcome: Outcome) -> Figure:
        """The last turn, lit; the end close up, coloured by its distance from exact; errors."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(12.0, 6.0), layout="constrained")
        halves: Any = figure.subfigures(1, 2, width_ratios=(1.25, 1.0))
        turn = halves[0].subplots()
        close, errors = halves[1].subplots(2, 1, height_ratios=(1.7, 1.0))
        self._turn(turn, outcome)
        self._end(close, outcome.state)
        show_errors(errors, outcome.series, self.spacing)
        errors.legend(loc="lower right")
        name_panels([turn, close, errors])
        often = outcome.state.remeshings
        how = f"{often} times remeshed" if often else "without remeshing"
        figure.suptitle(
            f"Zalesak's sphere, {self.nodes}$^3$ cells, {outcome.state.size} particles: "
            f"{in_turns(outcome.state.time)} of {self.steps} steps, {how}",
            fontsize=11,
        )
        return figure

    def _turn(self, panel: Axes, outcome: Outcome) -> None:
        """Up to four stages of the last turn in one scene."""
        from pmesh.cases.surfaces import Layer, render, show_surface

        shots = outcome.snapshots()
        latest = [shot for shot in shots if shot.time > shots[-1].time - PERIOD + 1e-6][-4:]
        layers = [
            Layer(surface=self._refined(shot), colour=colour)
            for shot, colour in zip(latest, COLOURS[-len(latest) :], strict=True)
        ]
        reach = 0.25 * BOX + 16.0
        low, high = (0.5 * BOX + side * np.array((reach, 16.0, reach)) for side in (-1, 1))
        picture = render(
            *layers, view=VIEW, bounds=(tuple(low), tuple(high)), ground=False, size=(1200, 1100)
        )
        show_surface(panel, picture, title="the last turn, about the middle of the box")

    def _refined(self, shot: Snapshot) -> tuple[Values, Grid]:
        """The level set of a snapshot around the body, by cubic splines on half the spacing."""
        from scipy.ndimage import zoom

        center = self.law.flow(np.array([self.shape.center]), 0.0, shot.time)[0]
        first = np.floor((center - 17.0) / self.spacing).astype(int)
        last = first + math.ceil(34.0 / self.spacing) + 1
        part = shot["level_set"][tuple(slice(a, b) for a, b in zip(first, last, strict=True))]
        shape = tuple(2 * n - 1 for n in part.shape)
        factors = np.divide(shape, part.shape)
        fine = np.asarray(zoom(part.astype(np.float64), factors), np.float64)
        return fine, Grid(shape, 0.5 * self.spacing, tuple((self.spacing * first).tolist()))

    def _end(self, panel: Axes, state: Interface) -> None:
        """The rebuilt surface at the end, turned back; its distance from the exact one."""
        from levelset.surface import triangles
        from pmesh.cases.surfaces import Layer, render, show_surface

        surface = triangles(*self.field(state, 2))
        away = self.shape.distance(surface.vertices.T) / self.spacing
        top = 0.4
        layer = Layer(surface=surface, values=away, colours="RdBu_r", limits=(-top, top))
        picture = render(layer, view=BELOW, ground=False, size=(1000, 820))
        show_surface(
            panel, picture, title=f"rebuilt after {in_turns(state.time)}", colours="RdBu_r",
            limits=(-top, top), label="from exact [cells]",
        )  # fmt: skip
