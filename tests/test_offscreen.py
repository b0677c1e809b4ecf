"""Drawing without a display: quiet where it can be done, a clear error where it cannot."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from pmesh.cases import offscreen
from pmesh.cases.offscreen import WINDOW, PictureError, can_render, window

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL is of Linux")
DRAW = """
import numpy as np
from pmesh.cases.surfaces import render
from remesh.grid import Grid
grid = Grid((12, 12, 12), 0.2, (-1.1, -1.1, -1.1))
print(render((np.sqrt((grid.points() ** 2).sum(axis=0)) - 0.7, grid), size=(64, 48)).shape)
"""


def drawn(**environment: str) -> subprocess.CompletedProcess[str]:
    """A fresh interpreter that draws a ball, with every warning an error."""
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", DRAW],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, **environment},
    )


@pytest.mark.skipif(not can_render(), reason="no OpenGL here")
def test_a_process_that_draws_says_nothing_and_ends_well() -> None:
    done = drawn(DISPLAY="")
    assert (done.returncode, done.stdout, done.stderr) == (0, "(48, 64, 3)\n", "")


@linux
@pytest.mark.skipif(WINDOW in os.environ, reason="the user chose a window")
def test_without_a_driver_a_process_draws_all_the_same() -> None:
    done = drawn(__EGL_VENDOR_LIBRARY_FILENAMES="/nowhere", DISPLAY="")
    assert (done.returncode, done.stdout, done.stderr) == (0, "(48, 64, 3)\n", "")


@linux
def test_a_machine_without_a_driver_is_told_before_vtk_is_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv(WINDOW, raising=False)
    monkeypatch.setattr(offscreen, "_has_egl", lambda: False)
    assert not can_render()
    with pytest.raises(PictureError, match="no EGL driver"), window():
        pass


def test_the_users_own_choice_of_a_window_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(WINDOW, "vtkXOpenGLRenderWindow")
    monkeypatch.setattr(offscreen, "_has_egl", lambda: False)
    with window():
        assert os.environ[WINDOW] == "vtkXOpenGLRenderWindow"
    assert os.environ[WINDOW] == "vtkXOpenGLRenderWindow"


@linux
def test_the_environment_is_left_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(WINDOW, raising=False)
    monkeypatch.setattr(offscreen, "_has_egl", lambda: True)
    with window():
        assert os.environ[WINDOW] == "vtkEGLRenderWindow"
    assert WINDOW not in os.environ
