"""Vorticity in a base flow: impulse, energy and vorticity of the linear evolution, and refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pmesh
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


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"grid": Grid((16, 16), 0.1)}, "3 dimensions"),
        ({"base": ((1.0, 0.0), (0.0, -1.0))}, "3 rows of 3"),
        ({"base": ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))}, "trace is 3"),
        ({"grid": Grid((16,) * 3, 0.1, boundary="periodic")}, "no period"),
        ({"viscosity": -1.0}, "viscosity"),
    ],
)
def test_what_makes_no_sense_is_refused(options, said):
    with pytest.raises(InputError, match=said):
        PerturbedFlow(**({"grid": box(0.5), "base": STRAIN} | options))


def test_a_law_that_gives_no_velocity_is_refused():
    flow = PerturbedFlow(grid=box(0.5), base=lambda points: points[0])
    with pytest.raises(InputError, match="of shape"):
        flow.start(vorticity=RING.vorticity)
