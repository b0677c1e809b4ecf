"""What a vortex flow takes and refuses; its refusals of other kinds are in test_refusals.py."""

from __future__ import annotations

import math

import numpy as np
import pytest

from levelset.shapes import Box, Disk, Ellipse
from pmesh.bodies.body import RigidBody
from pmesh.bodies.penalise import Penalisation
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.recipe import checked_vorticity
from pmesh.vortex.window import Window
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.kernels import get_kernel
from remesh.multires.mesh import AdaptiveMesh
from remesh.stencils import divergence_ratio

GRID = Grid((32, 32), 1 / 8, (-2.0, -2.0))
DISK = RigidBody(Disk(radius=0.6))
FINE = Grid((128, 128), 1 / 32, (-2.0, -2.0))
SPACE = Grid((16, 16, 16), 0.1)
THIN = Box(size=(1.5, 0.05)).moved(angle=math.pi / 4)  # its bounds are a square
WRAPPED = Grid((32, 32), 1 / 8, (-2.0, -2.0), "periodic")
WINDOW = Window(lower=(3, 3), upper=(9, 3))
EDGED = RigidBody(Disk(radius=0.6, center=(1.2, 0.0)))  # touches the last nodes


MESH = AdaptiveMesh(grid=FINE, levels=2)
THICK = AdaptiveMesh(grid=Grid((16, 32, 16), 1 / 8), levels=1, block=8)


def flow(**options: object) -> VortexFlow:
    return VortexFlow(**{"grid": GRID, "viscosity": 0.01, **options})  # type: ignore[arg-type]


def test_lists_and_arrays_become_tuples_so_that_a_flow_is_a_value():
    given = flow(bodies=[DISK], freestream=np.array([1, 0]))
    assert given.bodies == (DISK,)
    assert given.freestream == (1.0, 0.0)
    assert all(type(u) is float for u in given.freestream)
    assert hash(given) == hash(flow(bodies=(DISK,), freestream=(1.0, 0.0)))


def test_a_flow_on_an_adaptive_mesh_is_a_value_that_knows_its_finest_grid():
    one, two = (flow(grid=AdaptiveMesh(grid=FINE, levels=2), bodies=[DISK]) for _ in range(2))
    assert (hash(one), one) == (hash(two), two)
    assert one.lattice == FINE == flow(grid=FINE).lattice


def test_a_kernel_of_ones_own_is_as_good_as_a_name():
    assert flow(kernel=get_kernel("M4'")).kernel.name == "M4'"


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"grid": SPACE, "stretching": "none"}, "stretching must be one of"),
        ({"grid": SPACE, "remeshing": "distorted"}, "stretched in the classical form"),
        ({"grid": SPACE, "projection": -1}, "projection must be a whole number >= 0"),
        ({"projection": 1}, "no divergence to project"),
        ({"cleaning": "no"}, "cleaning must be True or False"),
        ({"stretching": "classical"}, "in the plane does not stretch"),
        ({"grid": MESH, "diffusion": "compact"}, "spreads level by level"),
        ({"diffusion": "fast"}, "diffusion must be one of"),
        ({"grid": SPACE, "freestream": (1.0, 0.0)}, "freestream must hold 3"),
        ({"viscosity": math.inf}, "viscosity must be zero or positive, got inf"),
        ({"deformation": math.nan}, "deformation must be positive"),
        ({"negligible": 0.0}, "negligible must be between 0 and 1"),
        ({"negligible": 1.0}, "negligible must be between 0 and 1"),
        ({"distortion": -0.1}, "distortion must be positive"),
        ({"largest_step": 0.0}, "largest_step must be positive"),
        ({"kernel": "M5'"}, "unknown kernel"),
        ({"order": 7}, "has order"),
        ({"radius": 0.0}, "radius"),
        ({"remeshing": "never"}, "remeshing must be one of 'always', 'distorted'"),
        ({"freestream": (1.0, math.nan)}, "2 finite velocities"),
        ({"freestream": 1.0}, "2 finite velocities"),
        ({"freestream": "east"}, "2 finite velocities"),
        ({"penalisation": 1e3}, "must be a Penalisation"),
        ({"bodies": DISK}, "bodies must be a list"),
        ({"grid": (32, 32)}, "needs a grid in 2 or 3 dimensions"),
        ({"bodies": [RigidBody(Box(size=(3.0, 0.5)))]}, "spacings thick, needs 8"),
        ({"bodies": [RigidBody(Disk(radius=0.6, center=(1.5, 0)))]}, "outside the domain"),
        ({"bodies": [RigidBody(Disk(radius=0.6) - Disk(radius=0.9))]}, "has no inside"),
        ({"bodies": [RigidBody(THIN)], "grid": FINE}, "spacings thick, needs 8"),
        ({"bodies": [DISK], "grid": WRAPPED}, "need an unbounded axis"),
        ({"bodies": [EDGED], "domain": "fixed"}, "nodes to the edges of a fixed domain"),
        ({"viscosity": "water"}, "viscosity must be a number, got 'water'"),
        ({"viscosity": None}, "viscosity must be a number"),
        ({"deformation": "small"}, "deformation must be a number"),
        ({"negligible": "little"}, "negligible must be a number"),
        ({"radius": "wide"}, "radius must be a number"),
        ({"threads": 0}, "threads must be"),
        ({"grid": THICK}, "on adaptive meshes are plane"),
        ({"grid": MESH, "remeshing": "distorted"}, "remeshed at every step"),
        ({"grid": MESH, "domain": "follow"}, "does not follow the vorticity"),
        ({"grid": MESH, "bodies": [DISK], "window": WINDOW}, "a window is for uniform grids"),
        ({"grid": MESH, "bodies": [RigidBody(THIN)]}, "spacings thick, needs 8"),
        ({"grid": MESH, "bodies": [RigidBody(Disk(0.6, center=(1.5, 0)))]}, "outside the domain"),
    ],
)
def test_what_cannot_run_is_refused_with_advice(options, text):
    with pytest.raises(InputError, match=text) as caught:
        flow(**options)
    assert caught.value.hint


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_start_is_a_copy_of_an_array_a_law_or_nothing(dtype):
    x, _ = GRID.points()
    mine = np.asfortranarray(x)
    values = checked_vorticity(mine, GRID, np.dtype(dtype))
    assert values.dtype == dtype
    assert values.flags.c_contiguous
    assert not np.may_share_memory(values, mine)
    np.testing.assert_array_equal(
        checked_vorticity(lambda points: points[0], GRID, np.dtype(dtype)), values
    )
    assert not checked_vorticity(None, GRID, np.dtype(dtype)).any()


def test_an_array_given_to_start_may_change_afterwards():
    values = np.ones(GRID.shape)
    state = flow().start(vorticity=values)
    values[:] = 7
    assert state.vorticity.max() == 1


def test_complex_vorticity_is_refused():
    with pytest.raises(InputError, match="must hold real numbers, got complex128"):
        checked_vorticity(np.zeros(GRID.shape, complex), GRID, np.dtype(float))


class Mutable:
    """A body that is no value."""

    ndim = 2
    motion, measure, start = DISK.motion, DISK.measure, DISK.start
    placed, inertia = DISK.placed, DISK.inertia
    __hash__ = None  # type: ignore[assignment]

    def bounds(self, pose):
        return DISK.bounds(pose)

    distance = bounds


def test_a_body_that_cannot_be_hashed_is_refused():
    with pytest.raises(InputError, match=r"bodies\[0\] cannot be hashed"):
        flow(bodies=[Mutable()])


@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5])
def test_how_thick_a_body_is_does_not_depend_on_where_nodes_lie(shift):
    h = 1 / 16
    grid = Grid((64, 64), h, (-2.0, -2.0))
    thick = RigidBody(Ellipse(axes=(1.0, 0.255), center=(0.3 * h, shift * h)))  # 8.16 spacings
    VortexFlow(grid=grid, viscosity=0.01, bodies=[thick])
    thin = RigidBody(Ellipse(axes=(1.0, 0.245), center=(0.3 * h, shift * h)))
    with pytest.raises(InputError, match=r"is 7\.8\d spacings thick"):
        VortexFlow(grid=grid, viscosity=0.01, bodies=[thin])


def test_a_thinner_body_is_taken_where_the_penalisation_says_so():
    grid, thin = Grid((64, 64), 1 / 16, (-2.0, -2.0)), RigidBody(Ellipse(axes=(1.0, 0.16)))
    for thinnest in (8.0, 5.3):
        with pytest.raises(InputError, match=f"5.12 spacings thick, needs {thinnest:g}"):
            VortexFlow(grid=grid, viscosity=0.01, bodies=[thin],
                       penalisation=Penalisation(thinnest=thinnest))  # fmt: skip
    VortexFlow(grid=grid, viscosity=0.01, bodies=[thin], penalisation=Penalisation(thinnest=5.0))
    with pytest.raises(InputError, match="thinnest must be a number from 3"):
        Penalisation(thinnest=2.0)


def test_bodies_that_begin_inside_each_other_are_refused():
    left, right = (RigidBody(Disk(radius=0.6, center=(x, 0.0))) for x in (-0.4, 0.4))
    with pytest.raises(InputError, match=r"bodies\[0\] and bodies\[1\] overlap") as caught:
        flow(bodies=[left, right])
    assert "union" in caught.value.hint


def test_a_precision_may_be_given_as_numpy_writes_it():
    assert flow(dtype=np.float32) == flow(dtype="float32")
    with pytest.raises(InputError, match="dtype must be one of"):
        flow(dtype=np.int64)


def test_a_start_in_space_that_has_a_divergence_is_refused_or_projected():
    def jet(points: np.ndarray) -> tuple[float, float, np.ndarray]:
        return 0.0, 0.0, np.exp(-4 * np.sum((points - 0.8) ** 2, axis=0) / 0.1)

    grid = Grid((24, 24, 24), 1.6 / 24)
    with pytest.raises(InputError, match="vorticity must have no divergence"):
        VortexFlow(grid=grid, threads=1).start(vorticity=jet)
    state = VortexFlow(grid=grid, projection=1, threads=1).start(vorticity=jet)
    assert divergence_ratio(state.vorticity, grid) < 1e-10


def test_a_state_of_another_precision_is_refused():
    state = flow(dtype="float32").start()
    with pytest.raises(InputError, match="the flow computes in float64, the state is in float32"):
        flow().step(state, 0.1)


def test_the_first_value_that_is_not_finite_is_told_by_its_place():
    with pytest.raises(InputError, match=r"the first at \(0.3, 0.0, 0.0\)"):
        VortexFlow(grid=SPACE).start(
            vorticity=lambda x: (np.where(x[0] > 0.25, np.nan, 0.0), 0.0, 0.0)
        )
