"""Bodies in vortex flows on adaptive meshes: forces, motion, and blocks that stay at the wall."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.bodies.motion import Free, Prescribed
from pmesh.bodies.swimmer import Swimmer
from pmesh.cases.cylinder_adaptive import CylinderAdaptive
from pmesh.run.tree import same
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.window import Window
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.multires.blocks import ABSENT
from remesh.multires.mesh import AdaptiveMesh

DISK = RigidBody(Disk(radius=0.5))


def box(nx, ny, spacing):
    """A grid about the origin, which lies between nodes."""
    return Grid((nx, ny), spacing, ((0.5 - nx / 2) * spacing, (0.5 - ny / 2) * spacing))


def mesh_of(nx, ny, spacing, levels=2):
    return AdaptiveMesh(grid=box(nx, ny, spacing), levels=levels, tolerance=1e-3)


def advance(flow, state, dt, steps):
    for _ in range(steps):
        state = flow.step(state, dt)
    return state


def is_finest_at_the_wall(flow, state):
    """Whether finest blocks hold all points of all outlines."""
    grid, found = flow.lattice, []
    for body, pose in zip(flow.bodies, state.poses, strict=True):
        points = np.concatenate(body.outlines(pose, grid.spacing))
        places = np.floor((points - grid.origin) / grid.spacing / flow.grid.block).astype(np.int64)
        found.append(state.blocks.numbers_of(flow.grid.levels, places) != ABSENT)
    return bool(np.concatenate(found).all())


def finest_end(state, axis=0):
    """Where the finest blocks begin and end along an axis [L]."""
    blocks = state.blocks
    nodes = blocks.points()[axis, blocks.of(blocks.mesh.levels)]
    return float(nodes.min()), float(nodes.max())


# The started cylinder


@pytest.fixture(scope="module")
def cylinder():
    """Re = 550 at 48 nodes per diameter to T = 0.6, and the uniform flow by the same steps."""
    case = CylinderAdaptive.make({"mesh_tolerance": 1e-3}, quick=True)
    flow, state = case.build()
    h = flow.lattice.spacing
    uniform = replace(flow, grid=box(96, 96, h))
    states, rows = [state, uniform.start()], []
    while states[0].time < 0.6 - 1e-9:
        rest = 0.6 - states[0].time
        dt = rest / math.ceil(rest / flow.limit(states[0]).dt)
        states = [f.step(s, dt) for f, s in zip((flow, uniform), states, strict=True)]
        both = [f.forces(s) for f, s in zip((flow, uniform), states, strict=True)]
        rows.append((states[0].time, both))
    return flow, states[0], rows


def test_the_drag_is_within_a_percent_of_the_uniform_flows(cylinder):
    late = [both for time, both in cylinder[2] if time > 0.3]
    assert len(late) > 15
    for name in ("body0_force_x", "impulse_force_x"):
        ours, known = (np.array([row[name] for row in rows]) for rows in zip(*late, strict=True))
        np.testing.assert_allclose(ours, known, rtol=0.01)
        assert known.min() > 0.7


def test_force_from_momentum_and_from_impulse_agree(cylinder):
    for _, (row, _) in cylinder[2]:
        drag = row["body0_force_x"]
        assert row["impulse_force_x"] == pytest.approx(drag, rel=1e-3)
        assert row["impulse_force_y"] == pytest.approx(row["body0_force_y"], abs=2e-3 * drag)


def test_a_symmetric_flow_has_no_lift(cylinder):
    lift = [row["body0_force_y"] / row["body0_force_x"] for time, (row, _) in cylinder[2]
            if time > 0.1]  # fmt: skip
    assert np.abs(lift).max() < 5e-3


def test_the_wall_holds_as_well_as_on_a_uniform_mesh(cylinder):
    for _, (row, known) in cylinder[2]:
        assert row["slip"] == pytest.approx(known["slip"], rel=0.05)
        assert row["slip_residual"] < 2e-6


def test_no_circulation_comes_from_the_wall(cylinder):
    flow, state, _ = cylinder
    row = flow.ledger(state)
    strength = np.sqrt(row["enstrophy"])
    assert abs(row["circulation"]) < 1e-5 * strength
    assert is_finest_at_the_wall(flow, state)
    assert row["compression"] > 5


def test_fields_tell_the_body_too(cylinder):
    flow, state, _ = cylinder
    fields = flow.fields(state)
    assert fields["chi"].shape == state.blocks.shape
    inside = np.hypot(*state.blocks.points()) < 0.9
    assert (fields["chi"][inside] == 1).all()
    assert fields["velocity"].shape == (2, *state.blocks.shape)
    assert np.hypot(*fields["velocity"])[inside].max() < 0.05


@pytest.mark.parametrize("boundary", [("periodic", "unbounded"), ("unbounded", "periodic")])
def test_in_a_periodic_channel_the_drag_is_that_of_the_uniform_flow(boundary):
    mesh, rows = mesh_of(128, 64, 1 / 24), []
    across = replace(mesh.grid, boundary=boundary)
    for grid in (replace(mesh, grid=across), across):
        flow = VortexFlow(grid=grid, viscosity=1 / 100, bodies=[DISK], freestream=(1.0, 0.0),
                          domain="fixed")  # fmt: skip
        rows.append(flow.forces(advance(flow, flow.start(), 0.02, 6)))
    assert rows[1]["body0_force_x"] > 0.8
    assert rows[0]["body0_force_x"] == pytest.approx(rows[1]["body0_force_x"], rel=0.01)
    assert rows[0]["slip"] == pytest.approx(rows[1]["slip"], rel=0.05)


# Bodies that move


def test_the_finest_blocks_go_with_a_towed_cylinder_which_feels_what_a_held_one_feels():
    mesh = mesh_of(192, 128, 1 / 48)
    towed = RigidBody(Disk(radius=0.5), motion=Prescribed(shift=lambda t: (-t, 0.0)))
    held = VortexFlow(grid=mesh, viscosity=1 / 200, bodies=[DISK], freestream=(1.0, 0.0))
    moving = VortexFlow(grid=mesh, viscosity=1 / 200, bodies=[towed])
    states = [held.start(), moving.start()]
    first = finest_end(states[1])
    for _ in range(16):
        states = [flow.step(s, 0.0175) for flow, s in zip((held, moving), states, strict=True)]
        assert is_finest_at_the_wall(moving, states[1])
        if states[0].time < 0.15:
            continue
        drags = [
            flow.forces(state)["body0_force_x"]
            for flow, state in zip((held, moving), states, strict=True)
        ]
        assert drags[1] == pytest.approx(drags[0], rel=0.015)
    assert states[1].poses[0].center[0] == pytest.approx(-0.28)
    assert finest_end(states[1])[0] < first[0] - 0.15
    assert states[1].size < 0.55 * mesh.grid.size


def test_a_heavy_disk_falls_as_on_a_uniform_mesh():
    body = RigidBody(Disk(radius=0.25), motion=Free(density=2.0, gravity=(0.0, -1.0)))
    mesh, ends = mesh_of(128, 192, 1 / 48), []
    for grid in (mesh, mesh.grid):
        flow = VortexFlow(grid=grid, viscosity=1 / 100, bodies=[body])
        ends.append(advance(flow, flow.start(), 0.02, 15))
    ours, known = (end.poses[0] for end in ends)
    assert known.center[1] < -0.012
    assert ours.center[1] == pytest.approx(known.center[1], rel=1e-3)
    assert ours.velocity[1] == pytest.approx(known.velocity[1], rel=1e-3)
    assert abs(ours.center[0]) < 1e-5
    assert is_finest_at_the_wall(VortexFlow(grid=mesh, viscosity=0.01, bodies=[body]), ends[0])


def test_a_swimmer_that_keeps_its_area_swims_as_on_a_uniform_mesh():
    body = Swimmer.carling(length=1.0, period=1.0)
    assert body.solenoidal
    mesh, rows = mesh_of(256, 128, 1 / 112), []
    for grid in (mesh, mesh.grid):
        flow = VortexFlow(grid=grid, viscosity=1.4e-4, bodies=[body])
        state = advance(flow, flow.start(), 0.01, 4)
        rows.append(flow.forces(state))
        if grid is mesh:
            assert is_finest_at_the_wall(flow, state)
            assert state.size < 0.5 * mesh.grid.size
    for name in ("body0_v", "body0_spin", "body0_force_y", "impulse_force_y"):
        assert rows[0][name] == pytest.approx(rows[1][name], rel=5e-3)


def test_a_step_past_a_body_changes_nothing_it_is_given_and_threads_do_not_change_a_bit():
    ends = []
    for threads in (1, 2):
        body = RigidBody(Disk(radius=0.25), motion=Free(density=2.0, gravity=(0.0, -1.0)))
        flow = VortexFlow(grid=mesh_of(64, 64, 1 / 24, levels=1), viscosity=0.01, bodies=[body],
                          threads=threads)  # fmt: skip
        state = advance(flow, flow.start(), 0.02, 2)
        before = state.vorticity.copy(), state.constraint.force.copy()
        ends.append(flow.step(state, 0.02))
        np.testing.assert_array_equal(state.vorticity, before[0])
        np.testing.assert_array_equal(state.constraint.force, before[1])
    assert same(*ends)


def test_float32_feels_the_drag_of_float64():
    drags = []
    for dtype in ("float32", "float64"):
        flow = VortexFlow(grid=mesh_of(96, 64, 1 / 24, levels=1), viscosity=1 / 100, bodies=[DISK],
                          freestream=(1.0, 0.0), dtype=dtype)  # fmt: skip
        state = advance(flow, flow.start(), 0.02, 4)
        assert state.vorticity.dtype == dtype
        drags.append(flow.forces(state)["body0_force_x"])
    assert drags[0] == pytest.approx(drags[1], rel=1e-3)


# Refusals

MESH = mesh_of(128, 64, 1 / 24)


class Swelling(RigidBody):
    """A body that takes in fluid."""

    solenoidal = False


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"window": Window(lower=(3, 3), upper=(9, 3))}, "a window is for uniform grids"),
        ({"bodies": [Swelling(Disk(radius=0.5))]}, "deform without changing their volume"),
        ({"bodies": [RigidBody(Disk(radius=0.1))]}, "spacings thick"),
        ({"bodies": [RigidBody(Disk(radius=0.5, center=(2.5, 0)))]}, "outside the domain"),
        ({"viscosity": 0.0}, "holds the fluid by viscosity"),
    ],
)
def test_what_an_adaptive_mesh_cannot_do_with_bodies_is_refused(options, text):
    with pytest.raises(InputError, match=text) as caught:
        VortexFlow(**({"grid": MESH, "viscosity": 0.01, "bodies": [DISK]} | options))
    assert caught.value.hint


def test_a_body_too_near_the_end_of_the_mesh_breaks_the_run():
    near = RigidBody(Disk(radius=0.5, center=(2.1, 0.0)))
    flow = VortexFlow(grid=MESH, viscosity=0.01, bodies=[near])
    with pytest.raises(BlowUpError, match="out of the mesh") as caught:
        flow.start()
    assert "a larger grid" in caught.value.hint
