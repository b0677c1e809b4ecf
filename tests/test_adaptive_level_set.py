"""Interfaces on adaptive meshes: as accurate as asked, closed, fine only where they need it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pmesh
from levelset.adaptive import AdaptiveLevelSet
from levelset.cutting import Cutting
from levelset.interface import AdaptiveInterface
from levelset.laws import Deformation, Rotation, SingleVortex, Uniform
from levelset.quadrature import measures
from levelset.seams import image_distance
from levelset.shapes import Box, Capsule, Disk, Sphere
from levelset.tool import Tool
from levelset.transport import ParticleLevelSet
from pmesh.cases.deformation import interface_error
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid
from remesh.multires.mesh import AdaptiveMesh

CIRCLE = Disk(0.15, center=(0.5, 0.75))


def mesh(cells: int, levels: int, tolerance: float = 1e-2, **more: Any) -> AdaptiveMesh:
    grid = Grid((cells,) * more.pop("ndim", 2), 1 / cells, boundary=more.pop("ends", "periodic"))
    return AdaptiveMesh(grid=grid, levels=levels, tolerance=tolerance, block=8, **more)


def carried(flow: Any, state: Any, until: float, steps: int) -> Any:
    dt = (until - state.time) / steps
    for _ in range(steps):
        state = flow.step(state, dt)
    return state


def swirled(tolerance: float, **settings: Any) -> tuple[Any, AdaptiveInterface, AdaptiveInterface]:
    """The single vortex of period 2 at the start and back there."""
    fine = mesh(256, 3, tolerance, refinement=2 * tolerance)
    flow = ParticleLevelSet(
        grid=fine, velocity=SingleVortex(period=2.0), kernel="L6,4", width=5.0, **settings
    )
    start = flow.start(CIRCLE)
    return flow, start, carried(flow, start, 2.0, 26)


def test_a_particle_level_set_on_an_adaptive_mesh_is_the_adaptive_one():
    flow = ParticleLevelSet(grid=mesh(64, 2), velocity=SingleVortex(period=8.0))
    assert type(flow) is AdaptiveLevelSet
    assert type(replace(flow, width=8.0)) is AdaptiveLevelSet
    uniform = ParticleLevelSet(grid=Grid((64, 64), 1 / 64), velocity=SingleVortex(period=8.0))
    assert type(uniform) is ParticleLevelSet


def test_the_error_of_a_carried_interface_is_in_proportion_to_the_tolerance():
    errors = []
    for tolerance in (4e-2, 1e-2, 2.5e-3):
        flow, _, end = swirled(tolerance)
        found = interface_error(flow.fields(end)["level_set"], end.grid, CIRCLE)
        errors.append(found / (tolerance * flow.reach))
    assert max(errors) < 2.0
    assert max(errors) < 6.0 * min(errors)


def test_the_area_is_kept_at_a_fraction_of_the_particles_of_a_uniform_mesh():
    flow, start, end = swirled(1e-2)
    half = carried(flow, start, 1.0, 13)
    for state in (start, half, end):
        assert flow.ledger(state)["volume"] == pytest.approx(CIRCLE.volume, rel=2e-3)
    uniform = ParticleLevelSet(
        grid=Grid((257, 257), 1 / 256), velocity=flow.velocity, kernel="L6,4", width=8.0
    )
    assert start.size < 0.15 * uniform.start(CIRCLE).size
    assert end.size < 0.5 * uniform.start(CIRCLE).size


def test_straight_parts_stay_coarse_and_corners_go_to_the_finest_level():
    fine = mesh(256, 3, 4e-3)
    flow = ParticleLevelSet(grid=fine, velocity=Rotation(center=(0.5, 0.5), rate=1.0))
    state = flow.start(Box((0.4, 0.4), center=(0.5, 0.5)))
    assert state.finest == 3
    fine = state.positions[state.of(3)]
    corners = np.abs(np.abs(fine - 0.5) - 0.2).max(axis=1)
    assert corners.max() < 0.1  # nothing so fine in the middle of an edge
    assert flow.start(Disk(0.3, center=(0.5, 0.5))).finest < 3


def test_a_filament_that_the_coarse_levels_do_not_see_is_carried_by_the_fine_ones():
    """A rod as thick as three finest spacings, of which a coarse cell has eight: it is kept."""
    rod = Capsule((0.3, 0.5), (0.7, 0.52), 1.5 / 256)
    law = Rotation(center=(0.5, 0.5), rate=2 * math.pi)
    flow = ParticleLevelSet(grid=mesh(256, 3, 2e-3), velocity=law, kernel="L6,4")
    start = flow.start(rod)
    assert start.finest == 3
    for state in (start, carried(flow, start, 1.0, 20)):
        assert flow.ledger(state)["volume"] == pytest.approx(rod.volume, rel=0.05)
        assert flow.ledger(state)["surface"] == pytest.approx(rod.surface, rel=0.01)


@pytest.mark.parametrize("courant", [1.0, 20.0])
def test_the_refined_region_goes_with_the_flow_at_any_courant_number(courant):
    law = Uniform(velocity=(0.5, 0.25))
    flow = ParticleLevelSet(grid=mesh(128, 2, 1e-3), velocity=law, kernel="L6,4")
    shape = Box((0.2, 0.2), center=(0.3, 0.3)) | Disk(0.1, center=(0.3, 0.45))
    start = flow.start(shape)
    steps = round(0.4 * 0.5 * 128 / courant) + 1
    end = carried(flow, start, 0.4, steps)
    moved = shape.moved((0.2, 0.1))
    points = end.positions[end.of(2)]
    off = np.abs(moved.distance(points.T))
    assert end.finest == 2
    assert off.max() < 12 / 128
    before = flow.ledger(start)["volume"]
    assert flow.ledger(end)["volume"] == pytest.approx(before, rel=2e-3)


def test_it_runs_in_three_dimensions_and_comes_back():
    ball = Sphere(0.15, center=(0.35, 0.35, 0.35))
    flow = ParticleLevelSet(
        grid=mesh(64, 2, 5e-3, ndim=3), velocity=Deformation(period=0.8), kernel="L6,4", width=4.0
    )
    start = flow.start(ball)
    end = carried(flow, start, 0.8, 8)
    for state in (start, end):
        assert flow.ledger(state)["volume"] == pytest.approx(ball.volume, rel=0.01)
        assert flow.ledger(state)["surface"] == pytest.approx(ball.surface, rel=0.02)
    assert interface_error(flow.fields(end)["level_set"], end.grid, ball) < 0.25 / 64


def test_the_ledger_tells_how_many_particles_are_active_and_how_fine_they_are():
    flow, _, end = swirled(1e-2)
    told = flow.ledger(end)
    assert told["active"] == end.size
    assert told["particles"] == len(end.nodes) > end.size
    assert told["compression"] == 256**2 / end.size
    assert told["finest_level"] == end.finest
    assert told["remeshings"] == 26
    places = {tuple(at) for at in np.rint(end.positions * 256).astype(int) % 256}
    assert len(places) == end.size


def test_the_level_set_is_given_on_the_nodes_of_any_level():
    flow, start, _ = swirled(1e-2)
    for level in (1, 3):
        field = flow.to_uniform(start, level)
        grid = flow.mesh.level_grid(level)
        assert field.shape == grid.shape
        assert measures(field, grid).volume == pytest.approx(CIRCLE.volume, rel=2e-3)
    assert flow.fields(start)["level_set"].shape == start.grid.shape
    shape = flow.shape(start)
    points = np.array([[0.5, 0.5, 0.6], [0.9, 0.61, 0.75]])
    np.testing.assert_allclose(shape.distance(points), CIRCLE.distance(points), atol=1e-3)
    near = flow.distance(start)
    exact = image_distance(CIRCLE, near.grid).ravel()[near.nodes]
    np.testing.assert_allclose(near.values, exact, atol=1e-3)


def test_a_level_set_on_the_finest_grid_starts_as_the_shape_does():
    flow = ParticleLevelSet(grid=mesh(128, 2), velocity=SingleVortex(period=8.0))
    phi = CIRCLE.distance(flow.finest.points())
    one, other = flow.start(phi * (2.0 + phi)), flow.start(CIRCLE)
    np.testing.assert_array_equal(one.nodes, other.nodes)
    near = np.abs(other.values) < 0.02
    np.testing.assert_allclose(one.values[near], other.values[near], atol=1e-5)


def test_the_velocity_gradient_is_measured_where_a_law_does_not_tell_it():
    law = SingleVortex(period=8.0)
    flow = ParticleLevelSet(grid=mesh(128, 2, 1e-3), velocity=lambda time, at: law(time, at))
    state = flow.start(CIRCLE)
    assert 0.5 * law.max_gradient(0.0) < state.gradient <= law.max_gradient(0.0)
    assert flow.limit(state).rule == "deformation"


def test_particles_may_be_remeshed_every_few_steps_or_when_distorted():
    often = swirled(1e-2, remeshing=2)[2]
    assert often.remeshings == 13
    flow, _, end = swirled(1e-2, remeshing="distorted", distortion=0.8)
    assert 0 < end.remeshings < 26
    assert flow.ledger(end)["volume"] == pytest.approx(CIRCLE.volume, rel=5e-3)


def test_the_same_bits_for_any_number_of_threads():
    ends = [swirled(1e-2, threads=threads)[2] for threads in (1, 3)]
    assert ends[0].starts == ends[1].starts
    np.testing.assert_array_equal(ends[0].values, ends[1].values)
    np.testing.assert_array_equal(ends[0].nodes, ends[1].nodes)


def test_a_run_that_is_resumed_repeats_an_unbroken_one(tmp_path: Path):
    flow = ParticleLevelSet(grid=mesh(128, 2), velocity=SingleVortex(period=2.0), kernel="L6,4")
    start = flow.start(CIRCLE)
    ends = {}
    for name, stops in (("whole", [0.5]), ("parts", [0.25, 0.5])):
        for stop in stops:
            ends[name] = pmesh.run(
                flow, start, until=stop, dt=1 / 16, out=tmp_path / name, resume=stop != stops[0],
                watch=[pmesh.Ledger(), pmesh.Snapshots(every=0.25)],
            )  # fmt: skip
    assert ends["whole"].starts == ends["parts"].starts
    np.testing.assert_array_equal(ends["whole"].values, ends["parts"].values)
    series = [(tmp_path / name / "series.csv").read_text() for name in ("whole", "parts")]
    assert series[0] == series[1]
    assert "active" in series[0].splitlines()[0]


def test_a_drop_that_is_squeezed_away_leaves_nothing_and_stops_nobody():
    def squeeze(time: float, at: np.ndarray) -> np.ndarray:
        return 4.0 * (0.5078125 - at)  # to a place between the nodes

    flow = ParticleLevelSet(grid=mesh(64, 2), velocity=squeeze)
    end = carried(flow, flow.start(Disk(0.1, center=(0.5, 0.5))), 1.0, 20)
    told = flow.ledger(end)
    assert (told["volume"], told["surface"]) == (0.0, 0.0)
    assert np.all(flow.fields(end)["level_set"] > 0)
    assert flow.step(end, 0.1).time == pytest.approx(1.1)


def test_a_state_is_a_value_that_a_step_leaves_alone():
    flow, start, _ = swirled(1e-2)
    kept = (start.nodes.copy(), start.positions.copy(), start.values.copy())
    flow.step(start, 0.05)
    for now, then in zip((start.nodes, start.positions, start.values), kept, strict=True):
        np.testing.assert_array_equal(now, then)


SETTINGS: dict[str, Any] = {"grid": mesh(64, 2), "velocity": SingleVortex(period=8.0)}


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"remeshing": "never"}, "follows the interface by remeshing, got remeshing='never'"),
        ({"redistancing": 5}, "an adaptive mesh is not redistanced, got redistancing=5"),
        ({"width": 2.0}, "width must be at least 3 spacings, what the kernel reads, got 2.0"),
        ({"velocity": Deformation()}, "of 2 dimensions, got Deformation"),
        ({"kernel": "M5"}, "kernel"),
        ({"grid": mesh(64, 2, most_blocks=400)}, "in bands, not in blocks, got most_blocks=400"),
    ],
)
def test_settings_that_make_no_sense_are_refused(change, match):
    with pytest.raises(InputError, match=match):
        ParticleLevelSet(**{**SETTINGS, **change})


@pytest.mark.parametrize(
    ("shape", "match"),
    [
        (Disk(0.1, center=(3.5, 3.5)), "empty|end of the box"),
        (Disk(0.001, center=(0.503, 0.503)), "the interface is empty"),
        (Disk(0.002, center=(0.5, 0.5)), "spacings thick: the mesh does not see it"),
        (Sphere(0.2), "the shape has 3 dimensions, the grid 2"),
        (np.ones((64, 64)), "sign"),
        (np.full((64, 64), np.nan), "finite"),
        (np.ones((16, 16)), r"must have shape \(64, 64\)"),
    ],
)
def test_interfaces_that_cannot_be_carried_are_refused(shape, match):
    with pytest.raises(InputError, match=match):
        ParticleLevelSet(**SETTINGS).start(shape)


def test_an_interface_at_the_end_of_an_unbounded_box_is_refused_by_the_coarsest_level():
    open_box = mesh(64, 2, ends="unbounded")
    flow = ParticleLevelSet(grid=open_box, velocity=Uniform(velocity=(0.0, 1.0)))
    with pytest.raises(InputError, match=r"comes within 2 spacings .* along axis 0"):
        flow.start(Disk(0.2, center=(0.25, 0.5)))
    with pytest.raises(BlowUpError, match="has reached the end of the box along axis 1"):
        pmesh.run(flow, flow.start(Disk(0.15, center=(0.5, 0.5))), until=1.0, dt=0.05)
    with pytest.raises(InputError, match="is not rebuilt from its particles"):
        flow.rebuild(flow.start(Disk(0.15, center=(0.5, 0.5))), np.zeros((1, 2)))


def test_a_state_of_another_kind_or_mesh_is_refused():
    law = SingleVortex(period=8.0)
    flows = [
        ParticleLevelSet(grid=grid, velocity=law)
        for grid in (mesh(64, 2), mesh(64, 1), Grid((64, 64), 1 / 64, boundary="periodic"),
                     Grid((65, 65), 1 / 64))
    ]  # fmt: skip
    states = [flow.start(Disk(0.2, center=(0.5, 0.5))) for flow in flows]
    said = {
        (0, 1): "the state's mesh differs from the flow's in levels",
        (0, 2): "of kind AdaptiveInterface, got Interface",
        (2, 0): "of kind Interface, got AdaptiveInterface",
        (2, 3): "the state's mesh differs from the flow's in shape, boundary",
    }
    for (own, other), words in said.items():
        flow = flows[own]
        for ask in (partial(flow.step, dt=0.01), flow.limit, flow.ledger, flow.fields):
            with pytest.raises(InputError, match=words):
                ask(states[other])


def test_tools_do_not_cut_what_an_adaptive_mesh_carries():
    carrier = ParticleLevelSet(**SETTINGS)
    with pytest.raises(InputError, match="tools cut on a uniform grid"):
        Cutting(carrier=carrier, tools=Tool(shape=Disk(0.1), shift=lambda t: (t, 0.5)))


def test_the_adaptive_recipe_refuses_a_uniform_grid():
    with pytest.raises(InputError, match=r"needs an AdaptiveMesh, got Grid\("):
        AdaptiveLevelSet(**(SETTINGS | {"grid": Grid((64, 64), 1 / 64)}))
    with pytest.raises(InputError, match="needs an AdaptiveMesh"):
        replace(ParticleLevelSet(**SETTINGS), grid=Grid((64, 64), 1 / 64))


def test_levels_that_the_mesh_has_not_are_refused():
    flow = ParticleLevelSet(**SETTINGS)
    state = flow.start(Disk(0.2, center=(0.5, 0.5)))
    for level in (-1, 3, 0.5):
        with pytest.raises(InputError, match="level must be a whole number"):
            flow.to_uniform(state, level)
