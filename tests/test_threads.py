"""Threads: every piece is done once, by whom the split says, in forked processes too."""

import multiprocessing
import os
import subprocess
import sys
import warnings

import numba
import numpy as np
import pytest

from pmesh.spectral.velocity import VelocitySolver
from remesh.errors import InputError
from remesh.grid import Grid
from remesh.nodes import advect_nodes
from remesh.threads import share, thread_count

GRID = Grid((512, 300), 0.1)


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("pieces", [1, 13])
def test_every_piece_is_worked_on_exactly_once_by_its_thread(threads, pieces):
    done = []

    def work(first, pieces, step, scale):
        done.extend((first, scale * piece) for piece in range(first, pieces, step))

    share(work, pieces, threads, 10)
    assert sorted(piece for _, piece in done) == [10 * piece for piece in range(pieces)]
    assert all(first == piece // 10 % min(threads, pieces) for first, piece in done)


def test_an_error_in_any_thread_reaches_the_caller():
    def work(first, pieces, step):
        if first == 1:
            raise ArithmeticError("piece 1")

    with pytest.raises(ArithmeticError, match="piece 1"):
        share(work, 2, 2)


def test_unless_asked_there_are_as_many_threads_as_numba_was_told():
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        assert thread_count(None) == 1
        assert VelocitySolver(GRID)._convolver.threads == 1
    finally:
        numba.set_num_threads(before)
    code = (
        "from remesh.grid import Grid\n"
        "from pmesh.spectral.velocity import VelocitySolver\n"
        "print(VelocitySolver(Grid((512, 300), 0.1))._convolver.threads)"
    )
    environment = os.environ | {"NUMBA_NUM_THREADS": "3"}
    told = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert told.stdout.strip() == "3"


@pytest.mark.parametrize("threads", [0, -1, 1.5])
def test_a_number_of_threads_that_is_none_is_refused(threads):
    with pytest.raises(InputError, match="threads must be a whole number >= 1"):
        thread_count(threads)


def _solve_and_move() -> tuple[np.ndarray, np.ndarray]:
    vorticity = np.random.default_rng(1).standard_normal(GRID.shape)
    velocity = VelocitySolver(GRID, threads=2).velocity(vorticity)
    return velocity, advect_nodes(vorticity, 0.01 * velocity, GRID, threads=2).field


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_solves_and_moves_with_the_same_bits():
    here = _solve_and_move()  # the threads of this process run now
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=lambda: theirs.send(_solve_and_move()), daemon=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # fork with threads: meant here
        child.start()
    try:
        assert ours.poll(20), "the forked process hangs"
        for one, other in zip(here, ours.recv(), strict=True):
            assert np.array_equal(one, other)
    finally:
        child.kill()
        child.join()
