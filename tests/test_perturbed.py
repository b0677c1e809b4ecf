"""Vorticity in a base flow: impulse, energy and vorticity of the linear evolution, and refusals."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest

import pmesh
from pmesh.vortex import perturbed
from pmesh.vortex.cost import footprint
from pmesh.vortex.domain import SIGNIFICANT
from pmesh.vortex.exact import StrainedRing
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.perturbed import PerturbedFlow
from remesh.errors import InputError
from remesh.grid import Grid

STRAIN = ((0.8, 0.3, 0.0), (0.3, -0.5, 0.2), (0.0, 0.2, -0.3))
RING = StrainedRing(strain=STRAIN, amplitude=(0.6, -0.2, 0.8))


def box(h: float, half: float = 4.0) -> Grid:
    n = round(half / h)
    return Grid((2 * n,) * 3, h, (-n * h,) * 3)


def strained(
    h: float = 0.25, until: float = 0.4, **options: object
) -> tuple[PerturbedFlow, object]:
    flow = PerturbedFlow(grid=box(h), base=STRAIN, **options)  # type: ignore[arg-type]
    state = flow.start(vorticity=RING.vorticity)
    return flow, pmesh.run(flow, state, until=until)


def impulse(flow: PerturbedFlow, state: object) -> np.ndarray:
    row = flow.ledger(state)  # type: ignore[arg-type]
    return np.array([row[f"impulse_{axis}"] for axis in "xyz"])


@pytest.mark.parametrize("nonlinear", [False, True])
def test_the_impulse_obeys_its_linear_law_whether_or_not_the_ring_moves_itself(nonlinear):
    flow, end = strained(deformation=0.1, time_scheme="RK3", nonlinear=nonlinear)
    exact = RING.impulse(0.4)
    assert np.linalg.norm(impulse(flow, end) - exact) < 2e-3 * np.linalg.norm(exact)


@pytest.mark.parametrize("form", ["conservative", "classical"])
def test_the_vorticity_is_the_exact_one_carried_and_strained(form):
    _, end = strained(deformation=0.1, time_scheme="RK3", kernel="L6,4", stretching=form)
    exact = RING.vorticity(end.grid.points(), 0.4)
    assert np.linalg.norm(end.vorticity - exact) < 0.01 * np.linalg.norm(exact)


def test_a_viscous_ring_spreads_while_it_is_strained():
    ring = StrainedRing(strain=STRAIN, amplitude=(0.6, -0.2, 0.8), viscosity=0.05)
    flow = PerturbedFlow(grid=box(0.25), base=STRAIN, viscosity=0.05, deformation=0.1)
    end = pmesh.run(flow, flow.start(vorticity=ring.vorticity), until=0.2)
    assert flow.ledger(end)["enstrophy"] == pytest.approx(ring.enstrophy(0.2), rel=5e-3)
    lost = StrainedRing(strain=STRAIN, amplitude=(0.6, -0.2, 0.8)).enstrophy(0.2)
    assert abs(ring.enstrophy(0.2) / lost - 1) > 0.02  # viscosity matters here


def test_a_matrix_and_a_law_of_points_are_the_same_base_flow():
    ends = []
    for base in (STRAIN, RING.base_velocity):
        flow = PerturbedFlow(grid=box(0.4), base=base, domain="fixed")
        ends.append(flow.step(flow.start(vorticity=RING.vorticity), 0.1).vorticity)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-13)


def test_without_a_base_flow_it_is_the_vortex_flow():
    law = RING.vorticity
    none = PerturbedFlow(
        grid=box(0.4), base=lambda points: np.zeros_like(points), nonlinear=True, domain="fixed"
    )
    whole = VortexFlow(grid=box(0.4), domain="fixed")
    one = none.step(none.start(vorticity=law), 0.1).vorticity
    other = whole.step(whole.start(vorticity=law), 0.1).vorticity
    np.testing.assert_allclose(one, other, atol=1e-14)


def test_the_step_is_set_by_the_base_flow_and_the_speed_by_where_vorticity_is():
    flow = PerturbedFlow(grid=box(0.25, 8.0), base=STRAIN, deformation=0.2)
    state = flow.start(vorticity=RING.vorticity)
    norm = float(np.linalg.norm(np.array(STRAIN), 2))
    assert flow.limit(state).rule == "deformation"
    assert 0.2 / norm * 0.5 < flow.limit(state).dt < 0.2 / norm * 1.01
    assert state.speed < 4.5 * norm < 8.0 * math.sqrt(3.0) * norm


def test_a_constant_base_flow_is_a_free_stream():
    stream = (0.7, -0.4, 0.2)
    held = np.array(stream).reshape(3, 1, 1, 1)
    based = PerturbedFlow(
        grid=box(0.4), base=lambda points: np.zeros_like(points) + held, nonlinear=True,
        domain="fixed",
    )  # fmt: skip
    whole = VortexFlow(grid=box(0.4), freestream=stream, domain="fixed")
    ends = [flow.start(vorticity=dented) for flow in (based, whole)]
    for _ in range(2):
        ends = [flow.step(end, 0.1) for flow, end in zip((based, whole), ends, strict=True)]
    np.testing.assert_allclose(ends[0].vorticity, ends[1].vorticity, atol=1e-13)


def dented(points: np.ndarray) -> np.ndarray:
    """A ring with a divergence that a stretching by the whole way would feed."""
    values = RING.vorticity(points)
    values[0] *= 1.2
    return values


def test_the_speed_is_the_largest_where_vorticity_is_bit_for_bit_for_any_slabs(monkeypatch):
    rng = np.random.default_rng(3)
    velocity, vorticity = rng.standard_normal((2, 3, 9, 7, 8))
    vorticity *= 10.0 ** rng.uniform(-12, 0, (9, 7, 8))
    size = np.abs(vorticity).max(axis=0)
    there = (velocity**2).sum(axis=0)[size > SIGNIFICANT * size.max()]
    assert 0 < there.size < size.size
    for slab in (1, 2 * 7 * 8, 65_536):
        monkeypatch.setattr(perturbed, "SLAB", slab)
        found = perturbed._largest_among(velocity, vorticity)
        assert found == pytest.approx(math.sqrt(there.max()), rel=1e-15)
    assert perturbed._largest_among(velocity, np.zeros_like(vorticity)) == 0.0


def test_cleaning_is_on_and_can_be_switched_off():
    assert PerturbedFlow(grid=box(0.5), base=STRAIN).alone.cleaning
    ends = {}
    for cleaning in (True, False):
        flow = PerturbedFlow(grid=box(0.4), base=STRAIN, cleaning=cleaning)
        assert flow.alone.cleaning is cleaning
        end = flow.step(flow.start(vorticity=dented), 0.05)
        ends[cleaning] = flow.ledger(end)["divergence"]
    assert ends[True] < 0.8 * ends[False]


def test_single_precision_and_a_mesh_that_follows_tell_the_same_impulse():
    ends = {}
    for dtype, domain in (("float64", "grow"), ("float32", "follow")):
        flow, end = strained(0.4, 0.2, dtype=dtype, domain=domain, nonlinear=True)
        assert end.vorticity.dtype == dtype
        ends[dtype] = impulse(flow, end)
    np.testing.assert_allclose(ends["float32"], ends["float64"], rtol=1e-4)


def test_two_threads_that_step_one_flow_on_two_meshes_get_their_own_base():
    flow = PerturbedFlow(grid=box(0.5), base=STRAIN)
    grids = [box(0.5), box(0.5, 3.0)]
    wrong: list[Grid] = []

    def ask(grid: Grid) -> None:
        for _ in range(200):
            base = flow.engine._base(grid)
            if base.grid != grid or base.velocity.shape[1:] != grid.shape:
                wrong.append(grid)

    threads = [threading.Thread(target=ask, args=(grid,)) for grid in grids]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_its_fields_are_vorticity_and_the_whole_velocity():
    flow = PerturbedFlow(grid=box(0.5), base=STRAIN, nonlinear=True)
    state = flow.start(vorticity=RING.vorticity)
    fields = flow.fields(state)
    assert list(fields) == ["vorticity", "velocity"]
    assert fields["vorticity"] is state.vorticity
    base = RING.base_velocity(state.grid.points())
    whole = flow.alone.velocity(flow.alone.start(vorticity=RING.vorticity)) + base
    np.testing.assert_allclose(fields["velocity"], whole, atol=1e-14)


def test_its_memory_is_that_of_the_flow_without_the_base_and_the_base():
    flow = PerturbedFlow(grid=box(0.25), base=STRAIN, viscosity=0.01)
    own, alone = footprint(flow), footprint(flow.alone)
    base = flow.engine._base(flow.grid).velocity.nbytes
    assert own.kept - alone.kept == own.step - alone.step == own.start - alone.start == base


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"grid": Grid((16, 16), 0.1)}, "3 dimensions"),
        ({"base": ((1.0, 0.0), (0.0, -1.0))}, "3 rows of 3"),
        ({"base": ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))}, "trace is 3"),
        ({"grid": Grid((16,) * 3, 0.1, boundary="periodic")}, "no period"),
        ({"viscosity": -1.0}, "viscosity"),
        ({"cleaning": "no"}, "cleaning"),
    ],
)
def test_what_makes_no_sense_is_refused(options, said):
    with pytest.raises(InputError, match=said):
        PerturbedFlow(**({"grid": box(0.5), "base": STRAIN} | options))


def test_a_law_that_gives_no_velocity_is_refused():
    flow = PerturbedFlow(grid=box(0.5), base=lambda points: points[0])
    with pytest.raises(InputError, match="of shape"):
        flow.start(vorticity=RING.vorticity)
