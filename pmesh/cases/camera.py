"""A camera: where it stands, and where in its picture points are."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
LENS = 22.0  # opening from the lower to the upper edge [degrees]
MARGIN = 0.05  # of the picture that stays free at each edge


class Camera(NamedTuple):
    """A camera in space; z is up."""

    eye: Array  # (3,) [L]
    right: Array  # (3,), unit, as the next two
    up: Array
    back: Array  # from what is seen to the eye
    focus: float  # distance to the middle of what is seen [L]
    size: tuple[int, int]  # width and height of the picture [pixels]

    @property
    def slopes(self) -> tuple[float, float]:
        """Half of the width and of the height that is seen, at distance 1."""
        tall = math.tan(math.radians(0.5 * LENS))
        return tall * self.size[0] / self.size[1], tall

    def project(self, points: Array) -> NDArray[np.float64]:
        """Columns, rows [pixels, whole in their middles] and nearness [1/L] of points, (n, 3).

        Nearness is 1 / depth, straight along every line of the picture; negative behind the eye.
        """
        away = np.asarray(points, np.float64) - self.eye
        near = -1.0 / (away @ self.back)
        wide, tall = self.slopes
        column = 0.5 * self.size[0] * (1.0 + (away @ self.right) * near / wide) - 0.5
        row = 0.5 * self.size[1] * (1.0 - (away @ self.up) * near / tall) - 0.5
        return np.stack([column, row, near], axis=1)

    def rays(self) -> NDArray[np.float64]:
        """Directions (height, width, 3) in which the pixels look, of depth 1."""
        (width, height), (wide, tall) = self.size, self.slopes
        x = wide * ((2.0 * np.arange(width) + 1.0) / width - 1.0)
        y = tall * (1.0 - (2.0 * np.arange(height) + 1.0) / height)
        return x[:, None] * self.right + y[:, None, None] * self.up - self.back


def aimed(points: Array, view: tuple[float, float], size: tuple[int, int]) -> Camera:
    """The camera for which all the points fill the picture.

    ``view``: azimuth and elevation of the camera [degrees]; from azimuth -90 x points right.
    """
    azimuth, elevation = (math.radians(angle) for angle in view)
    flat = math.cos(elevation)
    back = np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])
    right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    up = np.cross(back, right)
    tangent = math.tan(math.radians(0.5 * LENS)) * (1.0 - 2.0 * MARGIN)
    wide = tangent * size[0] / size[1]
    x, y, z = points @ right, points @ up, points @ back
    # a camera at (cx, cy, depth) sees |x - cx| <= wide (depth - z), |y - cy| <= tangent (depth - z)
    ends = [((x + wide * z).max(), (x - wide * z).min(), wide)]
    ends.append(((y + tangent * z).max(), (y - tangent * z).min(), tangent))
    depth = max((high - low) / (2.0 * slope) for high, low, slope in ends)
    cx, cy = (0.5 * (high + low) for high, low, _ in ends)
    eye = cx * right + cy * up + depth * back
    return Camera(eye, right, up, back, float(depth - z.mean()), size)
