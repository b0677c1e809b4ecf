"""Forces by control volume and by traction, asked of a flow between two states."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from levelset.shapes import Disk, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.motion import Prescribed
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.state import State
from remesh.errors import InputError
from remesh.grid import Grid

H = 1 / 16
TOWED = Prescribed(shift=lambda t: (-t, 0.0), velocity=lambda t: (-1.0, 0.0))
SHAKEN = Prescribed(shift=lambda t: (0.0, 0.2 * math.sin(t)), angle=lambda t: 0.3 * math.sin(2 * t))


@cache
def flow(motion: Prescribed | None = None, stream: float = 1.0, **options: object) -> VortexFlow:
    body = RigidBody(Disk(radius=1.0)) if motion is None else RigidBody(Disk(1.0), motion=motion)
    grid = Grid((48, 48), H, (-23.5 * H, -23.5 * H))
    return VortexFlow(
        grid=grid, viscosity=2 / 40, freestream=(stream, 0.0), bodies=(body,),
        **{"domain": "follow", **options},  # type: ignore[arg-type]
    )  # fmt: skip


@cache
def after(flow: VortexFlow, time: float) -> tuple[State, State]:
    """The state at a time, and the one a step before."""
    state = before = flow.start()
    while state.time < time:
        before, state = state, flow.step(state, min(flow.limit(state).dt, 0.03))
    return before, state


@pytest.mark.parametrize(
    ("case", "flux", "surface"),
    [
        (flow(), 1e-3, 0.03),
        (flow(TOWED, 0.0), 2e-3, 0.03),
        (flow(SHAKEN, 0.5), 5e-3, 0.15),
    ],
    ids=["in a stream", "towed", "shaken and twisted"],
)
def test_all_routes_tell_one_force(case, flux, surface):
    before, state = after(case, 1.5)
    told, known = case.routes(before, state), np.asarray(state.loads[0].force)
    size = float(np.hypot(*known))
    for route, apart in (("flux", flux), ("surface", surface)):
        force = np.array([told[f"body0_{route}_force_{axis}"] for axis in "xy"])
        assert float(np.hypot(*(force - known))) < apart * size
    assert told["body0_flux_torque"] == pytest.approx(
        state.loads[0].torque[0], abs=0.02 * max(abs(state.loads[0].torque[0]), 0.05 * size)
    )
    assert 0 < told["body0_routes_apart"] < (flux + surface) * size
    assert list(told) == case.route_names


def test_routes_see_a_mesh_that_grew_within_the_step():
    before, state = after(flow(), 1.5)
    grown = flow(domain="grow")
    wide = grown.step(before, state.time - before.time)
    assert wide.time == state.time
    told, same = grown.routes(before, wide), flow().routes(before, state)
    assert told["body0_flux_force_x"] == pytest.approx(same["body0_flux_force_x"], rel=1e-6)


def test_a_route_without_room_tells_no_number():
    """Two bodies a few spacings apart: no box between them, no line of points around one."""
    pair = (
        RigidBody(Disk(radius=0.5, center=(0.0, 0.56))),
        RigidBody(Disk(radius=0.5, center=(0.0, -0.56))),
    )
    close = VortexFlow(
        grid=Grid((48, 48), H, (-23.5 * H, -23.5 * H)), viscosity=2 / 40, freestream=(1.0, 0.0),
        bodies=pair,
    )  # fmt: skip
    state = close.start()
    told = close.routes(state, close.step(state, 0.01))
    assert math.isnan(told["body0_flux_force_x"])
    assert math.isnan(told["body1_routes_apart"])
    assert list(told) == close.route_names


@cache
def near_an_edge(nodes: float, axis: int, boundary: tuple[str, str]) -> tuple[float, float]:
    """Drag by flux and by surface, of a disk so many nodes from the end of an axis."""
    half = 0.5 * 63 * H
    center = [0.0, 0.0]
    center[axis] = half - 0.5 - nodes * H
    grid = Grid((64, 64), H, (-half, -half), boundary)
    body = RigidBody(Disk(radius=0.5, center=tuple(center)))
    near = VortexFlow(
        grid=grid, viscosity=2 / 40, freestream=(1.0, 0.0), bodies=(body,), domain="fixed",
        threads=1,
    )  # fmt: skip
    state = near.start()
    told = near.routes(state, near.step(state, 0.01))
    return told["body0_flux_force_x"], told["body0_surface_force_x"]


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("nodes", [11.0, 12.0, 12.5, 13.0])
@pytest.mark.parametrize("boundary", [("unbounded",) * 2, ("unbounded", "periodic")])
def test_a_body_near_an_edge_or_a_seam_stops_no_run(nodes, axis, boundary):
    """Traction reads 6.25 spacings off the wall and 6 nodes around that; a box needs 8 and 2."""
    flux, surface = near_an_edge(nodes, axis, boundary)
    assert math.isfinite(flux)
    assert math.isfinite(surface) == (nodes > 6.25 + 6)


def test_a_body_with_a_hole_tells_no_surface_force():
    ring = RigidBody(Disk(radius=1.0) - Disk(radius=0.4))
    holed = VortexFlow(
        grid=flow().grid, viscosity=2 / 40, freestream=(1.0, 0.0), bodies=(ring,), threads=1
    )
    state = holed.start()
    told = holed.routes(state, holed.step(state, 0.01))
    assert math.isnan(told["body0_surface_force_x"])
    assert math.isfinite(told["body0_flux_force_x"])


def test_routes_in_space_are_refused_before_the_first_step():
    flow = VortexFlow(
        grid=Grid((24, 24, 24), 1 / 10, (-1.15, -1.15, -1.15)), viscosity=0.01,
        bodies=[RigidBody(Sphere(radius=0.5))],
    )  # fmt: skip
    with pytest.raises(InputError, match="laws of the plane, the flow is in space"):
        _ = flow.route_names
