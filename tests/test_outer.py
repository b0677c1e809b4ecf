"""The potential flow of bodies that swell and shrink as they bend."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pmesh.bodies.mask import swelling
from pmesh.bodies.swimmer import Swimmer
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.outer import swelling_flow
from remesh.grid import Grid
from remesh.stencils import curl, divergence

H = 1 / 128
GRID = Grid((176, 64), H, (-0.55, -31.5 * H))


def swum(section: str, steps: int = 12) -> VortexFlow:
    fish = Swimmer.carling(section=section)  # type: ignore[arg-type]
    return VortexFlow(grid=GRID, viscosity=1e-3, bodies=(fish,), domain="fixed")


def test_the_flow_has_the_divergence_of_the_bodies_and_no_curl():
    flow = swum("rigid")
    state = replace(flow.start(), poses=(replace(flow.bodies[0].start(), time=1.2),))
    wall = flow.engine.wall(state)
    u = swelling_flow(wall, flow.engine.solver(GRID))
    source = swelling(wall.bodies, wall.poses, GRID, wall.settings.width * H)
    inner = (slice(4, -4), slice(4, -4))
    told = divergence(u, GRID, order=6)[inner]
    assert np.linalg.norm(told - source[inner]) < 0.25 * np.linalg.norm(source)  # smoothed by 2 h
    assert abs(told.sum()) < 0.02 * np.abs(told).sum()
    assert np.abs(curl(u, GRID, order=6)[inner]).max() < 1e-3 * np.abs(source).max()


@pytest.mark.parametrize("section", ["rigid", "incompressible"])
def test_swimmers_with_either_section_are_held_as_well(section):
    flow = swum(section)
    state = flow.start()
    for _ in range(15):
        state = flow.step(state, 0.02)
    assert state.constraint.residual <= flow.penalisation.tolerance
    assert state.constraint.iterations < 100
    assert state.constraint.slip < 0.02


def test_the_two_sections_swim_alike():
    """The outlines differ by less than 0.2 % of the length, and so does what the fluid does."""
    ways = []
    for section in ("rigid", "incompressible"):
        flow = swum(section)
        state = flow.start()
        for _ in range(25):
            state = flow.step(state, 0.02)
        ways.append(state.poses[0])
    one, other = ways
    np.testing.assert_allclose(one.velocity, other.velocity, atol=2e-3)
    np.testing.assert_allclose(one.spin, other.spin, atol=2e-2)
