"""The velocity solvers that a flow keeps."""

from __future__ import annotations

from pmesh.vortex import solvers
from pmesh.vortex.solvers import KEPT, solver_for
from remesh.grid import Grid


def asked(*shape: int, origin: tuple[float, ...] | None = None) -> object:
    grid = Grid(shape, 0.1, origin)
    return solver_for(grid, order=8, radius=2.0, dtype="float64", threads=1)


def test_a_mesh_of_the_same_shape_has_the_same_solver_wherever_it_lies():
    assert asked(20, 24) is asked(20, 24, origin=(3.0, 4.0))
    assert asked(20, 24) is not asked(24, 20)


def test_the_one_asked_for_longest_ago_is_let_go_first():
    first = asked(10, 12)
    for n in range(KEPT - 1):
        asked(20 + n, 12)
    assert asked(10, 12) is first
    asked(50, 12)
    asked(51, 12)
    assert asked(10, 12) is first
    for n in range(KEPT):
        asked(60 + n, 12)
    assert asked(10, 12) is not first


def test_a_mesh_that_grows_lets_go_of_what_it_was(monkeypatch):
    monkeypatch.setattr(solvers, "KEPT_NODES", 2000)
    small = asked(8, 8)
    first = asked(50, 60)
    assert asked(8, 8) is small  # the largest is not counted
    assert asked(50, 60) is first
    asked(60, 60)
    assert asked(50, 60) is not first
