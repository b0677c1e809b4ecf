"""Forty and more kinds of input that cannot be meant: each has a clear error of its own.

A row is a function: what comes before its ``yield`` sets the scene, what comes after must raise.
The error must be of the row's type and match its text, advise what to try, and leave every file as
it was. The command line's own refusals (unknown keys, bad words, TOML files) are in test_cli.py.
"""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from toy import Decay, ToyCase

from levelset.polygon import Polygon
from levelset.shapes import Box, Disk, Sphere
from pmesh.bodies.body import RigidBody
from pmesh.bodies.penalise import Penalisation
from pmesh.cases.registry import find
from pmesh.cases.runner import run_case
from pmesh.run import checkpoint, files
from pmesh.run.loop import run
from pmesh.run.series import read_series
from pmesh.run.snapshots import Snapshots, read_snapshots
from pmesh.run.summary import Metric
from pmesh.run.watchers import Forces, Ledger
from pmesh.spectral.poisson import poisson, velocity
from pmesh.vortex.flow import VortexFlow
from remesh.errors import BlowUpError, InputError, PmeshError, StorageError
from remesh.grid import Grid
from remesh.kernels import get_kernel
from remesh.nodes import advect_nodes
from remesh.stencils import curl, derivative
from remesh.transfer import m2p, p2m

GRID = Grid((8, 9), 1 / 8)
WRAPPED = Grid((8, 8), 1 / 8, boundary="periodic")
ONES = np.ones(GRID.shape)
POINTS = np.full((5, 2), 0.5)
FLOW = Decay(grid=GRID)
START = FLOW.start()
LEAKY = replace(get_kernel("M4'"), name="leaky", pieces=((Fraction(1),), (Fraction(1),)))
NAN = float("nan")

Scene = Callable[[Path], Iterator[None]]


@dataclass
class Row:
    name: str
    error: type[PmeshError]
    text: str
    scene: Scene


ROWS: list[Row] = []


def refuses(error: type[PmeshError], text: str) -> Callable[[Scene], Scene]:
    """Add a row to the table."""

    def add(scene: Scene) -> Scene:
        ROWS.append(Row(scene.__name__.replace("_", " ").strip(), error, text, scene))
        return scene

    return add


def at_once(name: str, text: str, act: Callable[[], Any]) -> None:
    """Add a row that needs no scene."""

    def scene(_: Path) -> Iterator[None]:
        yield
        act()

    ROWS.append(Row(name, InputError, text, scene))


def with_nan() -> np.ndarray:
    return np.where(np.arange(ONES.size).reshape(ONES.shape) == 7, np.nan, ONES)


class Thing:
    """Nothing a state may hold."""


# The mesh
at_once("one axis", "2 or 3 axes, got shape", lambda: Grid((8,), 0.1))
at_once("four axes", "2 or 3 axes, got shape", lambda: Grid((8, 8, 8, 8), 0.1))
at_once("three nodes", "at least 4 nodes, got", lambda: Grid((3, 8), 0.1))
at_once("half a node", "whole numbers", lambda: Grid((8.5, 8), 0.1))  # type: ignore[arg-type]
at_once("negative spacing", "positive length, got -0.1", lambda: Grid((8, 8), -0.1))
at_once("spacing is nan", "positive length, got nan", lambda: Grid((8, 8), NAN))
at_once("origin of three", "2 finite numbers", lambda: Grid((8, 8), 0.1, (0, 0, 0)))
at_once("origin is nan", "2 finite numbers", lambda: Grid((8, 8), 0.1, (0, NAN)))
at_once("walls", "'periodic' or 'unbounded'", lambda: Grid((8, 8), 0.1, boundary="wall"))  # type: ignore[arg-type]

# Between particles and mesh
at_once("unknown kernel", 'unknown kernel "M5\'"', lambda: p2m(POINTS, ONES[0, :5], GRID, "M5'"))
at_once(
    "a kernel that does not sum to 1",
    "claims moments 0 to 2",
    lambda: p2m(POINTS, np.ones(5), GRID, LEAKY),
)
at_once(
    "positions transposed",
    r"positions must have shape \(n, 2\), got \(2, 5\)\n  try: positions\.T",
    lambda: p2m(POINTS.T, np.ones(5), GRID),
)
at_once(
    "positions are nan", "positions must be finite", lambda: p2m(POINTS * NAN, np.ones(5), GRID)
)
at_once("a particle outside", "outside the box", lambda: p2m(POINTS + 9, np.ones(5), GRID))
at_once("strengths of another count", "strengths must have", lambda: p2m(POINTS, np.ones(4), GRID))
at_once("strengths are nan", "strengths must be fin", lambda: p2m(POINTS, np.full(5, NAN), GRID))
at_once("a field of another grid", "field must have shape", lambda: m2p(ONES.T, POINTS, GRID))
at_once(
    "a displacement that is nan",
    "displacement must be finite",
    lambda: advect_nodes(ONES, np.full((2, *GRID.shape), NAN), GRID),
)
at_once(
    "differences of order 3", "order must be 2, 4 or 6", lambda: derivative(ONES, GRID, 0, order=3)
)
at_once("the curl of a scalar", "vector field must have", lambda: curl(np.ones((3, 8, 9)), GRID))

# Shapes
at_once("a disk of no radius", "radius must be a positive", lambda: Disk(radius=0.0))
at_once("a disk of nan", "radius must be a positive", lambda: Disk(radius=NAN))
at_once("a box with one side", "size must hold", lambda: Box(size=(1.0,)))
at_once("a polygon that crosses itself", "meet", lambda: Polygon([(0, 0), (2, 2), (2, 0), (0, 1)]))
at_once("a disk and a sphere", "2 and 3 dim", lambda: Disk(radius=1.0) | Sphere(radius=1.0))
at_once(
    "points in space for a disk", r"\(2, ...\)", lambda: Disk(radius=1.0).distance(np.ones((3, 4)))
)

# Solves
at_once("vorticity of another shape", "must have shape", lambda: velocity(ONES.T, GRID))
at_once("vorticity with a nan", "not finite", lambda: velocity(with_nan(), GRID))
at_once("a net source in a periodic box", "zero mean", lambda: poisson(np.ones((8, 8)), WRAPPED))
at_once("an unknown Green's function", "unknown Green's", lambda: poisson(ONES, GRID, kernel="FFT"))
at_once("a Green's function of order 3", "has order", lambda: poisson(ONES, GRID, order=3))
at_once("a free stream of three", "freestream must hold 2", lambda: velocity(ONES, GRID, (1, 0, 0)))

# Flows
BODY = RigidBody(Disk(radius=0.3, center=(0.5, 0.5)))
FAR = RigidBody(Disk(radius=0.3, center=(5.0, 0.5)))
FINE = Grid((40, 40), 1 / 32)


def vortices(**options: Any) -> VortexFlow:
    return VortexFlow(**{"grid": FINE, "viscosity": 0.01, **options})


at_once("negative viscosity", "viscosity must be .*, got -1", lambda: vortices(viscosity=-1.0))
at_once("viscosity is nan", "viscosity must be .*, got nan", lambda: vortices(viscosity=NAN))
at_once("a stretching in the plane", "does not stretch", lambda: vortices(stretching="classical"))
at_once("no deformation at all", "deformation must be pos", lambda: vortices(deformation=0.0))
at_once("a scheme of order 9", "time_scheme must be", lambda: vortices(time_scheme="RK9"))
at_once("a domain that shrinks", "domain must be one of", lambda: vortices(domain="shrink"))
at_once("a wind in space", "freestream must hold 2", lambda: vortices(freestream=(1, 0, 0)))
at_once("half precision", "dtype must be one of", lambda: vortices(dtype="float16"))
at_once("a body outside the domain", "outside the domain", lambda: vortices(bodies=[FAR]))
at_once("a body without viscosity", "0 here", lambda: vortices(viscosity=0, bodies=[BODY]))
at_once(
    "a body thinner than the mesh sees",
    "spacings thick",
    lambda: vortices(grid=GRID, bodies=[BODY]),
)
at_once("a sphere in a plane", "3 dimensions", lambda: vortices(bodies=[RigidBody(Sphere(0.3))]))
at_once("a shape for a body", "not a body", lambda: vortices(bodies=[Disk(radius=0.3)]))
at_once("a body without shape", "needs a shape", lambda: RigidBody("disk"))  # type: ignore[arg-type]
at_once("a penalisation of no strength", "from 10", lambda: Penalisation(strength=0.0))
at_once(
    "a start with nan",
    "vorticity must be finite, 1600 values are not",
    lambda: vortices().start(vorticity=np.full(FINE.shape, NAN)),
)
at_once(
    "a start of another shape",
    r"vorticity must have the shape \(40, 40\) on this grid, got \(8, 9\)",
    lambda: vortices().start(vorticity=ONES),
)

# Runs
at_once("an end that is nan", "until must be a finite time", lambda: run(FLOW, START, until=NAN))
at_once("an end in the past", "not lie before the state", lambda: run(FLOW, START, until=-1.0))
at_once("a step backwards", "dt must be a positive", lambda: run(FLOW, START, until=1.0, dt=-0.1))
at_once(
    "resume without a directory", "run directory", lambda: run(FLOW, START, until=1, resume=True)
)
at_once(
    "a start with a nan",
    "vorticity of the start is not finite",
    lambda: run(FLOW, replace(START, vorticity=with_nan()), until=1.0),
)
at_once(
    "checkpoints every minus one seconds",
    "checkpoint_every must be seconds",
    lambda: run(FLOW, START, until=1.0, checkpoint_every=-1.0),
)
at_once("snapshots every 0", "every must be a positive time, got 0", lambda: Snapshots(every=0))
at_once(
    "snapshots to nowhere", "run directory", lambda: run(FLOW, START, until=1, watch=[Snapshots(1)])
)
at_once("a metric without reference", "needs a reference", lambda: Metric("drag", 1.0))
at_once("a metric relative to 0", "no relative error", lambda: Metric("drag", 1.0, 0.0, 0.1))

# Cases
at_once("an unknown case", "no case 'cylindr', did you mean 'cylinder'", lambda: find("cylindr"))
at_once("an unknown key", "did you mean 'rate'", lambda: ToyCase.make({"raet": 1.0}))
at_once("a bad type", "nodes must be a whole number, got '8'", lambda: ToyCase.make({"nodes": "8"}))
at_once("a value out of range", "rate must be positive, got -1.0", lambda: ToyCase(rate=-1.0))
at_once("a word not in the list", "scheme must be one of", lambda: ToyCase(scheme="rk9"))
at_once("a parameter that is infinite", "until must be a finite", lambda: ToyCase(until=np.inf))


# Files and directories
def finished(folder: Path) -> Path:
    """A short run in a directory."""
    watch = [Forces(), Ledger(), Snapshots(every=0.1)]
    run(FLOW, START, until=0.2, out=folder / "r", watch=watch)
    return folder / "r"


@refuses(InputError, "already holds a run")
def another_run_in_the_directory(folder: Path) -> Iterator[None]:
    out = finished(folder)
    yield
    run(FLOW, START, until=1.0, out=out)


@refuses(InputError, "is a file")
def a_run_directory_that_is_a_file(folder: Path) -> Iterator[None]:
    (folder / "r").write_text("mine")
    yield
    run(FLOW, START, until=1.0, out=folder / "r")


@refuses(StorageError, "Not a directory")
def a_run_directory_below_a_file(folder: Path) -> Iterator[None]:
    (folder / "r").write_text("mine")
    yield
    run(FLOW, START, until=1.0, out=folder / "r/s")


@refuses(StorageError, "cut short or damaged")
def a_truncated_checkpoint(folder: Path) -> Iterator[None]:
    path = finished(folder) / "checkpoint.h5"
    path.write_bytes(path.read_bytes()[:-100])
    yield
    run(FLOW, START, until=1.0, out=folder / "r", resume=True)


@refuses(StorageError, "cut short or damaged")
def an_empty_checkpoint(folder: Path) -> Iterator[None]:
    (finished(folder) / "checkpoint.h5").write_bytes(b"")
    yield
    run(FLOW, START, until=1.0, out=folder / "r", resume=True)


@refuses(StorageError, "not a checkpoint of pmesh")
def a_checkpoint_that_is_a_letter(folder: Path) -> Iterator[None]:
    (finished(folder) / "checkpoint.h5").write_text("Dear Sir,")
    yield
    run(FLOW, START, until=1.0, out=folder / "r", resume=True)


@refuses(StorageError, "format 9, this pmesh reads format 2")
def a_checkpoint_from_the_future(folder: Path) -> Iterator[None]:
    path = finished(folder) / "checkpoint.h5"
    path.write_bytes(path.read_bytes().replace(b"checkpoint 2", b"checkpoint 9"))
    yield
    run(FLOW, START, until=1.0, out=folder / "r", resume=True)


@refuses(StorageError, "there is no checkpoint")
def a_missing_checkpoint(folder: Path) -> Iterator[None]:
    yield
    checkpoint.load(folder / "checkpoint.h5")


@refuses(InputError, "holds a tuple, the run has a ToyState")
def a_checkpoint_of_another_kind_of_state(folder: Path) -> Iterator[None]:
    checkpoint.save(finished(folder) / "checkpoint.h5", (1.0,), seconds=0.0, node_steps=0.0)
    yield
    run(FLOW, START, until=1.0, out=folder / "r", resume=True)


@refuses(StorageError, "series.csv is damaged")
def a_series_that_is_no_table(folder: Path) -> Iterator[None]:
    (finished(folder) / "series.csv").write_text("step,time\none,two\n")
    yield
    run(FLOW, START, until=1.0, out=folder / "r", resume=True, watch=[Ledger()])


@refuses(StorageError, "a row is cut short")
def a_series_with_half_a_row(folder: Path) -> Iterator[None]:
    path = finished(folder) / "series.csv"
    path.write_bytes(path.read_bytes()[:-30])
    yield
    read_series(folder / "r")


@refuses(StorageError, "cannot read")
def a_series_that_is_not_there(folder: Path) -> Iterator[None]:
    yield
    read_series(folder)


@refuses(StorageError, "missing, cut short or damaged")
def a_snapshot_cut_short(folder: Path) -> Iterator[None]:
    path = finished(folder) / "fields/00000000.vtkhdf"
    path.write_bytes(path.read_bytes()[:600])
    yield
    read_snapshots(folder / "r")


@refuses(InputError, "holds .*'vorticity'.*, got 'pressure'")
def a_field_that_was_not_written(folder: Path) -> Iterator[None]:
    finished(folder)
    yield
    read_snapshots(folder / "r")[0]["pressure"]


@refuses(InputError, "cannot hold a Thing")
def a_state_that_no_file_can_hold(folder: Path) -> Iterator[None]:
    yield
    checkpoint.save(folder / "c.h5", Thing())


@refuses(InputError, "rate was 1.0 and is now 2.0")
def a_resumed_case_with_another_parameter(folder: Path) -> Iterator[None]:
    run_case("toy", ToyCase.make({}, quick=True), folder / "r")
    yield
    run_case("toy", ToyCase.make({"rate": 2.0}, quick=True), folder / "r", resume=True)


def full(*_: Any) -> int:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextlib.contextmanager
def full_disk() -> Iterator[None]:
    """Every write fails as on a full disk."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(files.os, "write", full)
        yield


@refuses(StorageError, r"cannot write \S+c\.h5: No space left")
def a_full_disk_at_a_checkpoint(folder: Path) -> Iterator[None]:
    checkpoint.save(folder / "c.h5", START)
    yield
    with full_disk():
        checkpoint.save(folder / "c.h5", START)


@refuses(StorageError, "No space left")
def a_full_disk_at_the_start_of_a_run(folder: Path) -> Iterator[None]:
    yield
    with full_disk():
        run(FLOW, START, until=1.0, out=folder / "r", watch=[Ledger(), Snapshots(every=0.1)])


@refuses(StorageError, "No space left")
def a_full_disk_at_the_start_of_a_case(folder: Path) -> Iterator[None]:
    yield
    with full_disk():
        run_case("toy", ToyCase.make({}, quick=True), folder / "r")


def contents(folder: Path) -> dict[str, bytes | None]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_bad_input_gets_a_clear_error_of_its_own_and_nothing_half_written(
    row: Row, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = row.scene(tmp_path)
    next(scene)
    before = contents(tmp_path)
    with pytest.raises(row.error, match=row.text) as caught:
        next(scene)
    assert caught.value.hint, "an error says what to do"
    assert "  try: " in str(caught.value)
    assert contents(tmp_path) == before


def test_there_are_at_least_forty_kinds() -> None:
    assert len({row.name for row in ROWS}) == len(ROWS) >= 40


def test_a_disk_that_fills_up_in_mid_run_leaves_the_last_good_state_to_resume(
    tmp_path: Path,
) -> None:
    watch = [Ledger(), Snapshots(every=0.1)]
    whole = run(FLOW, START, until=1.0, out=tmp_path / "whole", watch=watch)
    with pytest.MonkeyPatch.context() as patch:
        count = iter(range(10**6))
        write = os.write
        patch.setattr(files.os, "write", lambda *a: write(*a) if next(count) < 30 else full())
        with pytest.raises(StorageError, match="No space left"):
            run(FLOW, START, until=1.0, out=tmp_path / "r", watch=watch, checkpoint_every=0)
    end = run(FLOW, START, until=1.0, out=tmp_path / "r", watch=watch, resume=True)
    assert end.time == whole.time
    assert (tmp_path / "r/series.csv").read_bytes() == (tmp_path / "whole/series.csv").read_bytes()


def test_a_run_that_breaks_says_so_with_advice() -> None:
    with pytest.raises(BlowUpError, match="  try: ") as caught:
        run(replace(FLOW, breaks_at=2), START, until=1.0)
    assert caught.value.hint
