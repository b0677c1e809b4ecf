"""The penalised wall: the indicator, and that the flow sees the wall where the body ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from levelset.measure import Measure
from pmesh.bodies.motion import Prescribed
from pmesh.bodies.penalise import Penalisation
from pmesh.bodies.pose import Pose, still
from pmesh.bodies.wall import Ramp, channel, indicator, start_offset, wall_law
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

H = 1 / 16
NODES = 10  # along the plates; the flow does not vary there


@dataclass(frozen=True)
class Plate:
    """A plate between two heights that slides along itself."""

    low: float
    high: float
    speed: float = 0.0

    @property
    def ndim(self) -> int:
        return 2

    deforming, solenoidal, period, length = False, True, math.inf, 1.0

    @property
    def measure(self) -> Measure:
        return Measure(volume=1.0, center=(0.0, 0.0), inertia=1.0)

    @property
    def motion(self) -> Prescribed:
        return Prescribed(velocity=Slide(self.speed))

    def placed(self) -> Pose:
        return still((0.0, 0.0))

    def start(self) -> Pose:
        return self.motion.pose(self.placed(), 0.0)

    def inertia(self, pose: Pose) -> float:
        return 1.0

    def bounds(self, pose: Pose) -> tuple[tuple[float, ...], tuple[float, ...]]:
        return (0.0, self.low), ((NODES - 1) * H, self.high)

    def distance(self, points: np.ndarray, pose: Pose) -> np.ndarray:
        return np.maximum(self.low - points[1], points[1] - self.high)

    def deformation(self, points: np.ndarray, pose: Pose) -> None:
        return None

    divergence = deformation

    def outlines(self, pose: Pose, step: float) -> list[np.ndarray]:
        return []


@dataclass(frozen=True)
class Slide:
    """A law of time: the same velocity along x at all times."""

    speed: float

    def __call__(self, time: float) -> tuple[float, float]:
        return self.speed, 0.0


def couette(place: float, strength: float, dt: float = 0.05) -> tuple[float, float]:
    """How far beyond the plates' faces the walls act [h], from the steady flow between them.

    ``place``: of the lower face between two nodes [h]. One plate rests, the other slides.
    """
    below, above = -0.5 + place * H, 0.5 + (place + 0.37) * H
    grid = Grid((NODES, 64), H, (0.0, -1.5), ("periodic", "unbounded"))
    flow = VortexFlow(
        grid=grid,
        viscosity=1.0,
        bodies=[Plate(below - 9 * H, below), Plate(above, above + 9 * H, 1.0)],
        penalisation=Penalisation(strength=strength),
    )
    state = flow.start()
    for _ in range(round(1.2 / dt)):
        state = flow.step(state, dt)
    u, _ = flow.velocity(state)
    assert np.ptp(u, axis=0).max() < 1e-4, "the flow stays parallel"
    y = state.grid.axes()[1]
    open_ = (y > below + 4 * H) & (y < above - 4 * H)
    rise, at_zero = np.polyfit(y[open_], u[0][open_], 1)
    return (-at_zero / rise - below) / H, (above - (1 - at_zero) / rise) / H


@pytest.mark.parametrize("strength", [100.0, 1000.0])
def test_couette_flow_sees_its_walls_where_the_plates_end(strength):
    offsets = np.array([couette(place, strength) for place in (0.0, 0.25, 0.5, 0.75)])
    assert np.abs(offsets).max() < 0.25
    assert abs(offsets.mean()) < 0.05


def test_where_the_wall_acts_does_not_depend_on_dt():
    np.testing.assert_allclose(couette(0.3, 300.0, 0.05), couette(0.3, 300.0, 0.02), atol=2e-3)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_indicator_falls_from_one_to_zero_over_its_width(dtype):
    distance = np.linspace(-2, 2, 401, dtype=dtype)
    chi = indicator(distance, 1.0)
    assert chi.dtype == dtype
    assert (chi[distance <= -1] == 1).all()
    assert (chi[distance >= 1] == 0).all()
    assert (np.diff(chi) <= 0).all()
    np.testing.assert_allclose(chi + chi[::-1], 1.0, atol=4 * np.finfo(dtype).eps)
    assert chi[200] == 0.5


def test_the_indicator_is_twice_differentiable():
    step = 1e-3
    distance = np.arange(-1.2, 1.2, step)
    second = np.diff(indicator(distance, 1.0), 2) / step**2
    assert np.abs(np.diff(second)).max() < 10 * step  # third derivative at most pi^2/2
    assert np.abs(second).max() == pytest.approx(np.pi / 2, rel=1e-3)


@pytest.mark.parametrize("width", [1.0, 1.5, 2.5])
def test_a_shifted_indicator_keeps_its_area(width):
    nodes = np.arange(-10.0, 11.0)
    areas = [indicator(nodes - place, width).sum() for place in np.linspace(0, 1, 9)]
    np.testing.assert_allclose(areas - np.linspace(0, 1, 9), 10.5, atol=0.05)


def test_a_stronger_wall_acts_further_out_by_less_and_less():
    offsets = [
        wall_law(1.5, strength, 8, 2.0, sharp=False).offset for strength in (10, 100, 1000, 10_000)
    ]
    assert (np.diff(offsets) > 0).all()
    assert (np.diff(offsets, 2) < 0).all()


def test_the_offsets_do_not_change_when_asked_again():
    assert (
        wall_law(1.5, 1000, 8, 2.0, sharp=False).offset
        == wall_law(1.5, 1000, 8, 2.0, sharp=False).offset
    )
    assert start_offset(1.5, 1e3, 8, 2.0, sharp=False) == start_offset(
        1.5, 1e3, 8, 2.0, sharp=False
    )


@pytest.mark.parametrize("strength", [100.0, 1000.0])
def test_the_place_between_nodes_moves_a_sharp_wall_by_a_fortieth_of_a_spacing(strength):
    law = wall_law(2.5, strength, 8, 2.0, sharp=True)
    wall = Ramp(2.5, strength, 8, 2.0, True)
    outside, beside = np.transpose([channel(s, wall, law.blur) for s in np.arange(8) / 8])
    assert np.abs(outside - law.offset).max() < 1 / 40
    assert np.abs(beside).max() < 0.01
    assert abs(beside.mean()) < 1e-3


def test_fluid_passes_beside_a_wall_that_does_not_feel_its_blur():
    assert channel(0.0, Ramp(2.5, 1000.0, 8, 2.0, True), 0.0)[1] > 0.05
    assert wall_law(1.5, 1000.0, 8, 2.0, sharp=False).blur == 0.0
