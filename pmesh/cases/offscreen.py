"""A place to draw without a display: which window VTK may open on this machine."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from remesh.errors import PmeshError

WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"  # the environment's word on how VTK makes a window


class PictureError(PmeshError, RuntimeError):
    """A surface could not be drawn on this machine."""


def can_render() -> bool:
    """Whether this machine can draw: on Linux, whether there is an EGL driver."""
    return WINDOW in os.environ or not sys.platform.startswith("linux") or _has_egl()


@contextmanager
def window() -> Iterator[None]:
    """While open, VTK makes windows that need no display."""
    if WINDOW in os.environ or not sys.platform.startswith("linux"):
        yield  # as the user says, or as the system does
        return
    if not can_render():
        raise PictureError(
            "surfaces in space are drawn by OpenGL, and this machine has no EGL driver",
            hint="apt install libegl1 libgl1-mesa-dri  (draws in software, needs no display)",
        )
    os.environ[WINDOW] = "vtkEGLRenderWindow"
    try:
        yield
    finally:
        del os.environ[WINDOW]


@cache
def _has_egl() -> bool:
    """Whether OpenGL can be had without a display; VTK crashes if the library is missing."""
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    from vtkmodules.vtkCommonCore import vtkLogger
    from vtkmodules.vtkRenderingOpenGL2 import vtkEGLRenderWindow

    told = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        return bool(vtkEGLRenderWindow().SupportsOpenGL())
    finally:
        vtkLogger.SetStderrVerbosity(told)
