"""Two flows side by side: the same steps, each its own, restarts included."""

from __future__ import annotations

import pytest

from levelset.shapes import Disk
from pmesh.bodies.body import RigidBody
from pmesh.cases.twins import Pair, Twins
from pmesh.run import tree
from pmesh.run.loop import run
from pmesh.run.watchers import Forces, Ledger
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid


def alone(speed):
    grid = Grid((32, 32), 1 / 16, (-15.5 / 16,) * 2)
    body = RigidBody(Disk(0.5))
    return VortexFlow(
        grid=grid, viscosity=0.02, freestream=(speed, 0.0), bodies=(body,), threads=1,
        domain="follow",
    )  # fmt: skip


@pytest.fixture(scope="module")
def twins():
    return Twins(first=alone(1.0), second=alone(2.0), prefix="fast_")


def test_each_takes_its_own_step(twins):
    pair = twins.step(twins.start(), 0.05)
    assert (pair.time, pair.step) == (0.05, 1)
    assert tree.same(pair.first, twins.first.step(twins.first.start(), 0.05))
    assert tree.same(pair.second, twins.second.step(twins.second.start(), 0.05))
    assert pair.grid == pair.first.grid
    assert pair.size == pair.first.grid.size + pair.second.grid.size


def test_the_smaller_limit_is_that_of_both(twins):
    pair = twins.start()
    slow, fast = twins.first.limit(pair.first), twins.second.limit(pair.second)
    assert twins.limit(pair) == fast
    assert fast.dt < slow.dt


def test_columns_of_the_second_have_the_prefix(twins):
    pair = twins.step(twins.start(), 0.05)
    for both, one, other in (
        (twins.forces(pair), twins.first.forces(pair.first), twins.second.forces(pair.second)),
        (twins.ledger(pair), twins.first.ledger(pair.first), twins.second.ledger(pair.second)),
    ):
        assert both == {**one, **{f"fast_{name}": value for name, value in other.items()}}
    assert set(twins.fields(pair)) == set(twins.first.fields(pair.first))


def test_a_resumed_pair_goes_on_bit_for_bit(twins, tmp_path):
    def stop(moment):
        if moment.step == 4:
            raise KeyboardInterrupt

    watch = [Forces(), Ledger()]
    whole = run(twins, twins.start(), until=0.4, watch=watch, out=tmp_path / "whole")
    parts = tmp_path / "parts"
    with pytest.raises(KeyboardInterrupt):
        run(twins, twins.start(), until=0.4, watch=[*watch, stop], out=parts)
    end = run(twins, twins.start(), until=0.4, watch=watch, out=parts, resume=True)
    assert isinstance(end, Pair)
    assert tree.same(end, whole)
