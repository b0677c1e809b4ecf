"""Interfaces in vortex flows: they go where exact flows carry them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import pmesh
from levelset.shapes import Disk, Sphere
from levelset.transport import ParticleLevelSet
from pmesh.run.snapshots import Snapshots, read_snapshots
from pmesh.run.watchers import Forces, Ledger
from pmesh.vortex.carrier import Carriage, Carrier
from pmesh.vortex.exact.patches import PerlmanPatch
from pmesh.vortex.exact.viscous import LambOseen
from remesh.errors import BlowUpError, InputError
from remesh.grid import Grid

STREAM = (0.3, 0.1)
VORTEX = LambOseen(circulation=1.0, core=0.2, viscosity=4e-3)
OWN = Grid((71, 71), 1 / 40, (-0.5, -0.75))  # of the interface


def flow(spacing: float = 1 / 40, freestream: tuple[float, float] = STREAM) -> pmesh.VortexFlow:
    half = round(1.5 / spacing)
    grid = Grid((2 * half + 1,) * 2, spacing, (-half * spacing,) * 2)
    return pmesh.VortexFlow(
        grid=grid, viscosity=VORTEX.viscosity, freestream=freestream, deformation=10.0
    )


def exact_paths(places: np.ndarray, time: float) -> np.ndarray:
    """Where the spreading vortex in the free stream takes points from time 0 on."""
    x, w = np.polynomial.legendre.leggauss(24)
    square = np.sum(places**2, axis=1)
    turn = np.zeros(len(places))
    for t, share in zip(0.5 * time * (x + 1), 0.5 * time * w, strict=True):
        core = VORTEX.radius(t) ** 2
        turn += share * VORTEX.circulation * -np.expm1(-square / core) / (2 * math.pi * square)
    x, y = places.T
    cos, sin = np.cos(turn), np.sin(turn)
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + time * np.array(STREAM)


def carried(dt: float, **options) -> tuple[Carrier, Carriage, Carriage]:
    recipe = Carrier(flow=flow(), grid=OWN, options={"remeshing": "never", **options})
    start = recipe.start(Disk(0.15, center=(0.3, 0.01)), vorticity=VORTEX.vorticity)
    return recipe, start, pmesh.run(recipe, start, until=0.8, dt=dt)


def test_particles_follow_an_unsteady_exact_flow_to_second_order() -> None:
    """A vortex that spreads while a stream carries it: straight in time between a step's ends."""
    errors = []
    for dt in (0.1, 0.05, 0.025):
        _, start, end = carried(dt)
        exact = exact_paths(start.interface.positions, 0.8)
        errors.append(np.abs(end.interface.positions - exact).max())
    assert errors[-1] < 2e-4
    assert math.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.25)


def test_an_interface_is_where_the_exact_flow_takes_it_and_keeps_its_area() -> None:
    recipe, _, end = carried(0.05, remeshing="always")
    assert recipe.ledger(end)["interface_volume"] == pytest.approx(math.pi * 0.15**2, rel=5e-3)
    around = np.linspace(0, 2 * math.pi, 200, endpoint=False)
    ring = np.array([0.3, 0.01]) + 0.15 * np.stack([np.cos(around), np.sin(around)], axis=1)
    shape = recipe.level_set.shape(end.interface)
    assert np.abs(shape.distance(exact_paths(ring, 0.8).T)).max() < 0.1 * OWN.spacing


def test_a_round_interface_about_a_steady_vortex_stays() -> None:
    """Perlman's patch turns it on itself; the sign of the turn is in the test above."""
    patch = PerlmanPatch()
    grid = Grid((85, 85), 1 / 28, (-1.5, -1.5))
    still = pmesh.VortexFlow(grid=grid, deformation=10.0)
    recipe = Carrier(flow=still, options={"remeshing": 2})
    start = recipe.start(Disk(0.6), vorticity=patch.vorticity)
    assert start.grid == grid, "the flow's own mesh, if none is given"
    end = pmesh.run(recipe, start, until=2.0, dt=0.25)
    area = recipe.ledger(end)["interface_volume"]
    assert area == pytest.approx(math.pi * 0.36, rel=2e-4)
    near = np.abs(recipe.level_set.distance(end.interface).values) < 2 * grid.spacing
    band = recipe.level_set.distance(end.interface)
    exact = Disk(0.6).distance(grid.points()).ravel()[band.nodes]
    assert np.abs(band.values - exact)[near].max() < 0.02 * grid.spacing


def test_the_flow_does_not_feel_the_interface() -> None:
    _, start, end = carried(0.1, deformation=0.5)
    alone = pmesh.run(flow(), start.flow, until=0.8, dt=0.1)
    assert np.array_equal(end.flow.vorticity, alone.vorticity)
    assert end.size == alone.size + end.interface.size


def test_a_run_has_its_series_and_snapshots_and_is_resumed_bit_for_bit(tmp_path) -> None:
    recipe = Carrier(flow=flow(), grid=OWN, options={"remeshing": "distorted"})

    def start() -> Carriage:
        return recipe.start(Disk(0.15, center=(0.3, 0.0)), vorticity=VORTEX.vorticity)

    every = [Snapshots(0.3)]
    whole = pmesh.run(recipe, start(), until=0.6, dt=0.1, out=tmp_path / "whole", watch=every)

    def stop(moment) -> None:
        if moment.step == 3:
            raise KeyboardInterrupt

    ledger, shots = Ledger(), Snapshots(0.3)
    watch = [ledger, Forces(), Snapshots(0.3), stop]
    with pytest.raises(KeyboardInterrupt):
        pmesh.run(recipe, start(), until=0.6, dt=0.1, out=tmp_path / "cut", watch=watch)
    watch = [ledger, Forces(), shots]
    end = pmesh.run(
        recipe, start(), until=0.6, dt=0.1, out=tmp_path / "cut", watch=watch, resume=True
    )
    assert np.array_equal(end.interface.positions, whole.interface.positions)
    assert np.array_equal(end.flow.vorticity, whole.flow.vorticity)
    assert {"circulation", "interface_volume", "interface_particles"} <= ledger.series.keys()
    last = read_snapshots(tmp_path / "cut")[-1]
    assert set(last.names) == {"level_set", "vorticity", "velocity"}
    assert last["velocity"].shape == (2, *OWN.shape)


def test_fields_of_the_flow_are_seen_on_the_interfaces_mesh() -> None:
    recipe, start, _ = carried(0.4)
    fields = recipe.fields(start)
    assert fields["vorticity"] == pytest.approx(VORTEX.vorticity(OWN.points()), abs=2e-2)
    speed = VORTEX.velocity(OWN.points()) + np.reshape(STREAM, (2, 1, 1))
    assert fields["velocity"] == pytest.approx(speed, abs=2e-3)
    assert np.array_equal(fields["level_set"] < 0,
                          Disk(0.15, center=(0.3, 0.01)).distance(OWN.points()) < 0)  # fmt: skip


def test_a_history_of_snapshots_carries_as_the_flow_itself(tmp_path) -> None:
    """Velocities written by a run, read again: a velocity law for a level set."""
    swirl = flow()
    pmesh.run(
        swirl, swirl.start(vorticity=VORTEX.vorticity), until=0.8, dt=0.1,
        watch=[Snapshots(0.1)], out=tmp_path,
    )  # fmt: skip
    history = pmesh.VelocityHistory(read_snapshots(tmp_path), kernel="M6'")
    level_set = ParticleLevelSet(grid=OWN, velocity=history, remeshing="never")
    start = level_set.start(Disk(0.15, center=(0.3, 0.01)))
    end = start
    for _ in range(8):
        end = level_set.step(end, 0.1)
    exact = exact_paths(start.positions, 0.8)
    assert np.abs(end.positions - exact).max() < 2e-3


def test_band_distance_and_shape_are_those_of_the_interface_in_it() -> None:
    recipe, _, end = carried(0.1, remeshing="always")
    band, distance = recipe.band(end), recipe.distance(end)
    level_set = recipe.fields(end)["level_set"]
    assert np.array_equal(band.values, level_set.ravel()[band.nodes])
    shape = recipe.shape(end)
    near = np.abs(distance.values) < 2 * OWN.spacing
    there = OWN.points().reshape(2, -1)[:, distance.nodes[near]]
    assert shape.distance(there) == pytest.approx(distance.values[near], abs=0.01 * OWN.spacing)


def test_options_go_to_the_interface() -> None:
    recipe = Carrier(flow=flow(), options={"remeshing": "distorted", "kernel": "M8'"})
    assert (recipe.level_set.remeshing, recipe.level_set.kernel) == ("distorted", "M8'")


def test_the_smaller_limit_rules() -> None:
    recipe, start, _ = carried(0.4)
    assert recipe.limit(start).rule == "interface"
    calm = replace(recipe, options={**recipe.options, "deformation": 1e9})
    assert calm.limit(start).rule == "deformation"
    assert recipe.forces(start) == {}


def test_an_interface_that_leaves_the_flows_mesh_is_a_blow_up() -> None:
    fixed = replace(flow(freestream=(2.0, 0.0)), domain="fixed")
    far = Grid((121, 41), 1 / 30, (-0.5, -0.6))
    recipe = Carrier(flow=fixed, grid=far, options={"remeshing": "never"})
    start = recipe.start(Disk(0.2), vorticity=lambda x: 0 * x[0])
    with pytest.raises(BlowUpError, match="the interface has left the flow's mesh"):
        pmesh.run(recipe, start, until=1.0, dt=0.1)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Carrier(flow="fast"), "flow must be a VortexFlow, got 'fast'"),
        (lambda: Carrier(flow=flow(), options={"velocity": None}), r"may not hold \['velocity'\]"),
        (lambda: Carrier(flow=flow(), options={"remesh": 3}), "options of the interface: .*remesh"),
        (lambda: Carrier(flow=flow(), options={"width": -1.0}), "width must be positive"),
        (lambda: Carrier(flow=flow(), options=None), "options of the interface must be a dict"),
        (lambda: Carrier(flow=flow(), grid="x"), "grid of the interface must be a Grid, got 'x'"),
        (
            lambda: Carrier(flow=flow(), grid=Grid((9, 9, 9), 0.1)),
            "grid has 3 dimensions, the flow's 2",
        ),
        (
            lambda: Carrier(flow=flow()).start(Sphere(0.2), vorticity=VORTEX.vorticity),
            "the shape has 3 dimensions, the grid 2",
        ),
    ],
)
def test_what_cannot_be_carried_is_refused(make, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()


@pytest.mark.parametrize("dt", [-0.1, 0.0, math.nan, "a"])
def test_steps_that_are_none_are_refused(dt) -> None:
    recipe, start, _ = carried(0.4)
    with pytest.raises(InputError, match="dt must be"):
        recipe.step(start, dt)
