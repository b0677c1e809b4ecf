"""The memory that a vortex flow on a uniform mesh takes at its peak, told before anything is made.

The fields held are tables (`WORK`, `STEP`, `START`, `LEDGER`): how many, and by which flows.
What the transforms hold follows from the sizes that the convolver itself would use.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pmesh.bodies.mask import box_around
from pmesh.spectral.convolve import Convolver
from pmesh.spectral.symbols import Box
from pmesh.vortex.flow import VortexFlow
from pmesh.vortex.perturbed import PerturbedFlow
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.machine import free_memory, size_text
from remesh.paths import SCHEMES
from remesh.threads import thread_count


@dataclass(frozen=True)
class Held:
    """A row of a table: fields that are alive at the peak, in the flow's precision.

    ``vorticities`` have 1 component in the plane and 3 in space, ``velocities`` 2 and 3;
    ``per_stage`` counts velocities for each stage of the time scheme. ``when`` names the flows
    that hold it: "always", "viscous", "distorted", "plane", "cleaned", "based", or "late": of three
    stages and more.
    """

    what: str
    vorticities: float = 0.0
    velocities: float = 0.0
    per_stage: float = 0.0
    components: float = 0.0
    when: str = "always"


# Arrays that a step takes from those that lie idle; all but one, which the next state keeps, are
# given back. Stretched strengths and sampled velocities take no room: they work in the transforms'.
WORK = (
    Held("vorticity after half of the spread", vorticities=1, when="viscous"),
    Held("vorticity at a stage; in space its velocity takes its place", 1, when="plane"),
    Held("velocity at the particles, by stage; the last becomes their way", per_stage=1),
    Held("places, where the first velocity is needed again", velocities=1, when="late"),
    Held("scratch of the cleaning, where no other array is free by then", 1, when="cleaned"),
)
# Beside them, at the peak of a step.
STEP = (
    Held("vorticity before", vorticities=1),
    Held("particles that were not remeshed, before and after", 2, 2, when="distorted"),
    Held("what laws hold while they work", components=1),
)
KEPT = (Held("a base flow", velocities=1, when="based"),)
# While the ledger is written; the state before the step is still there.
LEDGER = (Held("vorticity before and after", vorticities=2), Held("a product", components=1))
# While the tables of the Green's function are made, or the first velocity solved.
START = (Held("vorticity of the start", vorticities=1),)
# Arrays of one component, of the size of the box around the bodies: measured in space, 75 to 88 at
# the start, 69 of a body held and 94 of a free one in a step.
BODIES = {"start": 80.0, "step": 85.0}
# Arrays in double precision while tables are made, in tables, by the number of unbounded axes.
MAKING = {0: 4.0, 1: 15.3, 2: 9.0, 3: 12.2}
PLANE = 12.2  # of a plane with two unbounded axes
SMALL = 100_000  # nodes of a mesh that fits wherever the program does


class Footprint(NamedTuple):
    """Bytes of a flow: what it keeps between steps, and at the peak of each thing it does."""

    state: int  # one state
    kept: int  # between steps: arrays of work, buffers and tables of the solver
    start: int  # the vorticity given, in double precision, included
    step: int
    ledger: int


def footprint(flow: VortexFlow | PerturbedFlow, grid: Grid | None = None) -> Footprint:
    """Memory of a flow on its uniform mesh at the start, without making anything.

    ``grid``: that it has grown to, instead. Of the fields, the solver and the bodies, not of the
    program. The mesh may grow, and the memory with it. Right within 20 % of what is measured (10 %
    without bodies) from 1e5 nodes on.
    """
    based, flow = not isinstance(flow, VortexFlow), _alone(flow)
    grid, number = grid or flow.lattice, np.dtype(flow.dtype).itemsize
    buffers, tables, making = _solver(flow, grid)
    solver, box = buffers + tables, _near(flow) * number

    def held(table: tuple[Held, ...]) -> int:
        return round(_fields(table, flow, based) * grid.size * number)

    state, given = held(START), _vorticities(grid) * grid.size * 8
    extra = making if _mixed(grid) else 0  # of the stream function's table, in the first ledger
    velocity, base = grid.ndim * grid.size * number, held(KEPT)
    kept = held(WORK) - state + base + solver
    return Footprint(
        state=state,
        kept=kept,
        start=given + state + base + max(making, velocity + solver) + round(BODIES["start"] * box),
        step=held(STEP) + state + kept + round(BODIES["step"] * box),
        ledger=held(LEDGER) + kept + extra,
    )


def refuse_without_room(flow: VortexFlow | PerturbedFlow) -> None:
    """Refuse a flow on a uniform mesh that has no room in memory, with the mesh that would fit."""
    grid = flow.grid
    if not isinstance(grid, Grid) or grid.size < SMALL:
        return
    own, free = footprint(flow), free_memory()
    peak = max(own.start, own.step, own.ledger)
    if free is None or peak <= free:
        return
    spacing = grid.spacing * (1.1 * peak / free) ** (1.0 / grid.ndim)
    raise InputError(
        f"the flow on {' x '.join(map(str, grid.shape))} nodes needs {size_text(peak)} of memory, "
        f"{size_text(free)} are free",
        hint=f"a spacing of {spacing:.3g} on this domain",
    )


def _alone(flow: VortexFlow | PerturbedFlow) -> VortexFlow:
    """The flow without its base."""
    return flow if isinstance(flow, VortexFlow) else flow.alone


def _vorticities(grid: Grid) -> int:
    return 1 if grid.ndim == 2 else 3


def _mixed(grid: Grid) -> bool:
    """Whether the ledger asks for the stream function too: in space, with axes of both kinds."""
    return grid.ndim == 3 and any(grid.periodic) and not all(grid.periodic)


def _fields(table: tuple[Held, ...], flow: VortexFlow, based: bool) -> float:
    """Arrays of one component that a table counts for a flow."""
    grid, stages = flow.lattice, len(SCHEMES[flow.time_scheme].weights)
    holds = {
        "always": True,
        "viscous": flow.viscosity > 0,
        "distorted": flow.remeshing == "distorted",
        "plane": grid.ndim == 2,
        "late": stages > 2,
        "cleaned": grid.ndim == 3 and stages == 2 and flow.cleaning and flow.projection != 1,
        "based": based,
    }
    return sum(
        row.components
        + row.vorticities * _vorticities(grid)
        + (row.velocities + row.per_stage * stages) * grid.ndim
        for row in table
        if holds[row.when]
    )


def _solver(flow: VortexFlow, grid: Grid) -> tuple[int, int, int]:
    """Bytes of the velocity solver: its buffers, its tables, and the peak of making those."""
    number, ndim = np.dtype(flow.dtype).itemsize, grid.ndim
    box, sources = Box.around(grid), _vorticities(grid)
    solved = ndim + (1 if _mixed(grid) else 0)
    compact = getattr(flow.engine, "compact", False)  # spreads on the nodes
    outputs = ndim + (sources if flow.viscosity > 0 and not compact else 0)
    table = math.prod(box.half)
    free = len(box.axes(periodic=False))
    doubles = PLANE if (ndim, free) == (2, 2) else MAKING[free] + (ndim - 1 if free == 0 else 0)
    tables = solved * table * number
    return (
        transforms(grid, flow.dtype, flow.threads, sources, outputs),
        tables,
        round(8 * table * doubles),
    )


def transforms(grid: Grid, dtype: str, threads: int | None, sources: int, outputs: int) -> int:
    """Bytes of a convolver's buffers: one half-complex array per field, and scratch of threads."""
    box = Box.around(grid)
    own = Convolver(box, dtype=dtype, threads=thread_count(threads))
    number, pair = own.dtype.itemsize, 2 * own.dtype.itemsize
    rows, middle = own.row_block
    n0, p0, last = box.shape[0], box.padded[0], box.padded[-1]
    storage = max(sources, outputs) * own.modes * own.middle * n0 * pair
    lines = rows * middle * (last * number + (last // 2 + 1) * pair)
    planes = (sources + 1) * own.mode_block * own.padded_middle * p0 * pair
    if own.padded_middle > 1:
        planes += own.mode_block * n0 * own.padded_middle * pair
    return storage + own.threads * (lines + planes)


def _near(flow: VortexFlow) -> int:
    """Nodes of the box around the bodies on which they are held."""
    if not flow.bodies:
        return 0
    poses = tuple(body.start() for body in flow.bodies)
    reach = flow.penalisation.width * flow.lattice.spacing
    return box_around(flow.bodies, poses, flow.lattice, reach).size
