"""The straight body of a swimmer in space: a table of its signed distance, and its surface."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.bodies.gait import Gait
from pmesh.bodies.outline import Outline
from pmesh.bodies.profile import Profile
from remesh.errors import InputError

Values = NDArray[np.float64]
PER_LENGTH = 250  # nodes of the table along the body
ACROSS, UP = 0.0025, 0.003  # [L] between its nodes
REACH = 0.1  # [L] of the table beyond the body; what is farther is told from its edge
SECTIONS = 1000  # from which it is made


class Table(NamedTuple):
    """Signed distance [L] of the straight body, even in its second and third coordinate."""

    values: NDArray[np.float32]  # (along, across, up)
    first: float  # place of its first node
    steps: tuple[float, float, float]  # between nodes


def table(gait: Gait) -> Table:
    """The table of a body with elliptic sections, made once, in a second; linear between nodes.

    It is then within 2e-4 L of the distance, 7e-4 L at the corners of the tail's edge. Refuses a
    plane body.
    """
    if gait.profile is None:
        raise InputError("a plane body has no height", hint="profile=Arch()")
    return _table(gait.outline, gait.profile)


@lru_cache(maxsize=8)
def _table(outline: Outline, profile: Profile) -> Table:
    from pmesh.bodies._solid import fill

    turn = np.linspace(0.0, math.pi, SECTIONS + 1)
    places = np.unique(np.concatenate((0.5 - 0.5 * np.cos(turn), outline.breaks, profile.breaks)))
    widths, heights = outline.half_width(places), profile.half_height(places)
    widths[0] = widths[-1] = 0.0
    beyond = math.ceil(REACH * PER_LENGTH)
    along = np.arange(-beyond, PER_LENGTH + beyond + 1) / PER_LENGTH
    across = ACROSS * np.arange(math.ceil((widths.max() + REACH) / ACROSS) + 1)
    up = UP * np.arange(math.ceil((heights.max() + REACH) / UP) + 1)
    values = np.empty((len(along), len(across), len(up)), np.float32)
    fill(places, widths, heights, along, across, up, values)
    values.setflags(write=False)
    return Table(values, float(along[0]), (1.0 / PER_LENGTH, ACROSS, UP))
