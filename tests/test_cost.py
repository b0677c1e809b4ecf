"""Memory that is predicted beside memory that is measured, in processes of their own."""

import subprocess
import sys

import numpy as np
import pytest

from pmesh.spectral.convolve import Convolver, Term
from pmesh.spectral.symbols import Box
from pmesh.vortex import cost
from pmesh.vortex.cost import _solver, footprint, transforms
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.perturbed import PerturbedFlow
from remesh.errors import InputError
from remesh.grid import Grid

MEASURE = """
import sys
import numpy as np
from pmesh.vortex.cost import footprint
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

nodes, ndim, boundary, dtype = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4]


def status(name):
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith(name))


def flow_on(nodes):
    grid = Grid((nodes,) * ndim, 1.0 / nodes, boundary=boundary)
    return VortexFlow(grid=grid, viscosity=1e-3, freestream=(0.0,) * ndim, dtype=dtype, threads=1)


def stepped(flow):
    axes = np.ix_(*(24 * (x - 0.5) for x in flow.grid.axes()))  # the curl of a Gaussian
    vorticity = np.zeros((1 if ndim == 2 else 3, *flow.grid.shape))
    for part, along, sign in ((0, 1, 1.0), (1, 0, -1.0))[: len(vorticity)]:
        vorticity[part] = sign * axes[along]
        for x in axes:
            vorticity[part] *= np.exp(-0.5 * x**2)
    state = flow.start(vorticity=vorticity[0] if ndim == 2 else vorticity)
    del vorticity
    for _ in range(5):  # until all arrays of work are in use
        state = flow.step(state, 1e-4)


stepped(flow_on(32))  # loads and compiles
before = status("VmRSS")
flow = flow_on(nodes)
stepped(flow)
own = footprint(flow)
print(max(own.start, own.step), status("VmHWM") - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
@pytest.mark.parametrize(
    ("nodes", "ndim", "boundary", "dtype"),
    [
        (1024, 2, "periodic", "float64"),
        (64, 3, "unbounded", "float32"),
        (64, 3, "unbounded", "float64"),
    ],
)
def test_the_memory_at_the_peak_is_predicted_within_a_fifth(nodes, ndim, boundary, dtype):
    words = [sys.executable, "-c", MEASURE, str(nodes), str(ndim), boundary, dtype]
    answer = subprocess.run(words, capture_output=True, text=True, check=True)
    predicted, measured = map(int, answer.stdout.split())
    assert predicted == pytest.approx(measured, rel=0.2)


@pytest.mark.parametrize("shape", [(96, 64), (24, 20, 16)])
@pytest.mark.parametrize("boundary", ["periodic", "unbounded"])
def test_buffers_are_those_that_the_convolver_makes(shape, boundary):
    grid = Grid(shape, 0.1, boundary=boundary)
    made = Convolver(Box.around(grid), dtype="float32", threads=1)
    field = np.zeros(shape, np.float32)
    made.run([field, field], [[Term(0)], [Term(1)], [Term(0)]], [field, field, field])
    (worker,) = made._workers
    arrays = [*made._storage, worker.line, worker.line_hat, *worker.spectra]
    if len(shape) == 3:
        arrays.append(worker.plane)
    assert transforms(grid, "float32", 1, 2, 3) == sum(array.nbytes for array in arrays)


@pytest.mark.parametrize("ndim", [2, 3])
@pytest.mark.parametrize("scheme", ["RK2", "RK3", "RK4"])
@pytest.mark.parametrize(
    "options", [{}, {"viscosity": 1e-3}, {"cleaning": False}, {"projection": 1}, {"projection": 2}]
)
def test_arrays_of_work_are_those_that_lie_idle_between_steps(ndim, scheme, options):
    if ndim == 2 and options and "viscosity" not in options:
        return
    grid = Grid((12,) * ndim, 0.1, boundary="periodic")
    flow = VortexFlow(grid=grid, time_scheme=scheme, threads=1, **options)
    wave = np.sin(2 * np.pi * grid.points()[0] / 1.2)
    state = flow.start(vorticity=wave if ndim == 2 else np.stack([0 * wave, 0 * wave, wave]))
    for _ in range(3):
        state = flow.step(state, 0.01)
    idle = sum(array.nbytes for array in flow.engine.buffers._spare)
    own, (buffers, tables, _) = footprint(flow), _solver(flow, grid)
    assert own.kept - buffers - tables == idle
    peak = own.step - own.kept  # beside them: both states, and what laws hold while they work
    assert peak == 2 * own.state + grid.size * 8


def test_with_axes_of_both_kinds_the_ledger_asks_for_one_table_more():
    """The stream function's, made while all arrays of work are there."""
    sides = (("periodic", "unbounded", "unbounded"), ("unbounded",) * 3)
    mixed, free = (
        footprint(VortexFlow(grid=Grid((16,) * 3, 0.1, boundary=side), viscosity=0.1))
        for side in sides
    )
    assert mixed.ledger > mixed.step
    assert free.ledger == free.step  # where it asks for none


def test_half_the_precision_is_half_of_what_is_kept():
    def kept(dtype):
        return footprint(VortexFlow(grid=Grid((256, 192), 0.1), viscosity=1e-3, dtype=dtype)).kept

    assert kept("float64") == 2 * kept("float32")


def test_predicting_makes_nothing_of_the_size_of_the_mesh():
    own = footprint(VortexFlow(grid=Grid((1 << 20, 1 << 20), 1e-3)))
    assert own.step > 1 << 43


def test_a_flow_without_room_in_memory_is_refused_with_a_mesh_that_has_it(monkeypatch) -> None:
    monkeypatch.setattr(cost, "free_memory", lambda: 4_000_000_000)
    grid = Grid((512,) * 3, 0.01)
    for flow in (
        VortexFlow(grid=grid, viscosity=1e-3),
        PerturbedFlow(grid=grid, viscosity=1e-3, base=np.diag([1.0, -0.5, -0.5])),
    ):
        with pytest.raises(InputError, match="4 GB are free") as told:
            flow.start(vorticity=lambda points: 0 * points)
        spacing = float(str(told.value).partition("a spacing of ")[2].partition(" ")[0])
        nodes = round(5.12 / spacing)
        own = footprint(VortexFlow(grid=Grid((nodes,) * 3, spacing), viscosity=1e-3))
        assert 2_000_000_000 < max(own.start, own.step) <= 4_000_000_000
