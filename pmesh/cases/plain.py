"""Surfaces lit and drawn without OpenGL: the nearest triangle of each pixel, then light on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.camera import Camera
from pmesh.cases.layer import Layer, Mesh

Values = NDArray[np.float64]
Image = NDArray[np.uint8]
FINE = 2  # pixels are drawn this many times finer along each side, then averaged
# Lights seen from the camera (right, up, towards it), colour and strength: key, fill, two rims.
LIGHTS = (
    ((-0.75, 0.9, 0.8), "#fff6ea", 0.74),
    ((0.9, 0.1, 0.7), "#e6efff", 0.42),
    ((0.2, 0.8, -1.0), "#ffffff", 0.30),
    ((-0.9, -0.2, -0.6), "#dfe8ff", 0.18),
)
AMBIENT, DIFFUSE, SPECULAR, POWER = 0.40, 0.8, 0.16, 28.0  # how matt a surface is
UNKNOWN = "darkgray"  # where values are not finite
LINE = (-0.5, 0.5)  # where the fine pixels of a line are beside its middle
SHADE, EDGES = (40, 46, 56), "#9a9a9a"  # of the shadow, of the box


class Shadow(NamedTuple):
    """A soft shadow on a level square."""

    alpha: Image  # (n, n), y downward as in a picture
    middle: Values  # (2,) of the square [L]
    half: float  # of its side [L]
    height: float  # [L]


def draw(
    layers: Sequence[Layer],
    meshes: Sequence[Mesh],
    camera: Camera,
    *,
    shadow: Shadow | None = None,
    edges: Values | None = None,
    background: str | None = "white",
) -> Image:
    """A picture (height, width, 3) of surfaces; (height, width, 4) if there is no background.

    ``edges``: lines to draw, both ends of each (n, 2, 3) [L]. Translucent surfaces show
    two sheets, of their far and of their near side; no shade in the hollows.
    """
    width, height = (FINE * side for side in camera.size)
    fine = camera._replace(size=(width, height))
    canvas = np.zeros((height, width, 4), np.float32)  # colours times alpha, and alpha
    near = np.zeros((height, width), np.float32)
    if shadow is not None:
        _lay(canvas, shadow, camera)
    places = [fine.project(mesh.points) for mesh in meshes]
    order = sorted(
        range(len(meshes)), key=lambda k: (layers[k].opacity < 1.0, places[k][:, 2].max())
    )
    if edges is not None:
        _rule(canvas, near, edges, fine)
    for k in order:
        _paint(canvas, near, layers[k], meshes[k], places[k], fine)
    return _developed(canvas, background)


def covered(meshes: Sequence[Mesh], side: int) -> tuple[NDArray[np.bool_], Values, float]:
    """Which of side x side pixels of a level square the meshes cover seen from above.

    The square is twice as wide as they are; also its middle and half its side.
    """
    points = np.concatenate([mesh.points for mesh in meshes])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), float((high - low)[:2].max())
    found = np.zeros((side, side), np.bool_)
    for mesh in meshes:
        places = (mesh.points - middle) * np.array([1.0, -1.0, 0.0]) / half
        places = 0.5 * side * (places + 1.0) - 0.5
        places[:, 2] = 1.0
        found |= _seen(places, mesh, np.zeros((side, side), np.float32))[0] >= 0
    return found, middle[:2], half


def _seen(places: Values, mesh: Mesh, near: NDArray[np.float32]) -> tuple[Any, Any]:
    """Triangle of each pixel, -1 for none, and the weights of its corners."""
    from pmesh.cases._raster import nearest

    which = np.zeros(near.shape, np.int32)
    which -= 1
    weights = np.empty((*near.shape, 3), np.float32)
    nearest(places, mesh.faces, near, which, weights)
    return which, weights


def _paint(
    canvas: Any, near: Any, layer: Layer, mesh: Mesh, places: Values, camera: Camera
) -> None:
    """Put a surface on the canvas where nothing hides it; if translucent, its far side first."""
    if layer.opacity == 1.0:
        return _sheet(canvas, near, layer, mesh, places, camera)
    first = mesh.faces[:, 0]
    away = np.einsum("ij,ij->i", mesh.normals[first], mesh.points[first] - camera.eye) > 0
    for side in (away, ~away):  # what is nearer is drawn later: nothing is hidden by them
        _sheet(canvas, near.copy(), layer, mesh._replace(faces=mesh.faces[side]), places, camera)
    return None


def _sheet(
    canvas: Any, near: Any, layer: Layer, mesh: Mesh, places: Values, camera: Camera
) -> None:
    """Put the nearest triangles on the canvas."""
    which, weights = _seen(places, mesh, near)
    pixels = which >= 0
    if not pixels.any():
        return
    corners, part = mesh.faces[which[pixels]], weights[pixels].astype(np.float64)
    normals = np.einsum("ij,ijk->ik", part, mesh.normals[corners])
    positions = np.einsum("ij,ijk->ik", part, mesh.points[corners])
    colours = _colours(layer, mesh, corners, part)
    lit = np.clip(_lit(colours, normals, camera.eye - positions, camera), 0.0, 1.0)
    full = np.pad(lit, ((0, 0), (0, 1)), constant_values=1.0)
    canvas[pixels] = (1.0 - layer.opacity) * canvas[pixels] + layer.opacity * full


def _colours(layer: Layer, mesh: Mesh, corners: NDArray[np.int64], part: Values) -> Values:
    """Colours before light, (n, 3), or one for all (3,)."""
    from matplotlib import colormaps
    from matplotlib.colors import Normalize, to_rgb

    if mesh.values is None:
        return np.array(to_rgb(layer.colour))
    finite = mesh.values[np.isfinite(mesh.values)]
    ends = layer.limits or ((finite.min(), finite.max()) if finite.size else (0.0, 1.0))
    shades = colormaps[layer.colours].with_extremes(bad=UNKNOWN)
    found = (part * mesh.values[corners]).sum(axis=1)
    return np.asarray(shades(Normalize(*ends)(np.ma.masked_invalid(found))), np.float64)[:, :3]


def _lit(colours: Values, normals: Values, towards: Values, camera: Camera) -> Values:
    """Colours under the lights, Phong's law, for either side of a surface."""
    from matplotlib.colors import to_rgb

    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    towards = towards / np.linalg.norm(towards, axis=1, keepdims=True)
    normals *= np.where((normals * towards).sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
    bright = np.full((len(normals), 3), AMBIENT)
    frame = np.stack([camera.right, camera.up, camera.back])
    for place, colour, strength in LIGHTS:
        light = np.array(place) @ frame / np.linalg.norm(place)
        falls = (normals @ light)[:, None]
        mirror = ((2.0 * falls * normals - light) * towards).sum(axis=1, keepdims=True)
        shine = np.where(falls > 0, SPECULAR * np.maximum(mirror, 0.0) ** POWER, 0.0)
        tint = strength * np.array(to_rgb(colour))
        bright += tint * (DIFFUSE * np.maximum(falls, 0.0) + shine)
    return bright * colours


def _lay(canvas: Any, shadow: Shadow, camera: Camera) -> None:
    """Put the shadow on the canvas, before all else; it is soft, whole pixels will do."""
    from scipy import ndimage

    rays = camera.rays()
    depth = (shadow.height - camera.eye[2]) / np.minimum(rays[..., 2], -1e-9)  # up: far away
    x, y = ((camera.eye[k] + depth * rays[..., k] - shadow.middle[k]) / shadow.half for k in (0, 1))
    side = len(shadow.alpha)
    rows, columns = (0.5 * side * (1.0 + place) - 0.5 for place in (-y, x))
    alpha = shadow.alpha.astype(np.float32) / 255.0
    found = ndimage.map_coordinates(alpha, [rows, columns], order=1, cval=0.0)
    found = found.repeat(FINE, axis=0).repeat(FINE, axis=1)
    canvas[...] = found[..., None] * np.array([*(c / 255.0 for c in SHADE), 1.0], np.float32)


def _rule(canvas: Any, near: Any, edges: Values, camera: Camera) -> None:
    """Put lines on the canvas."""
    from matplotlib.colors import to_rgb

    height, width = near.shape
    along = np.linspace(0.0, 1.0, 2 * max(height, width))[:, None, None]
    points = (edges[:, 0] + along * (edges[:, 1] - edges[:, 0])).reshape(-1, 3)
    places = camera.project(points)
    places = places[places[:, 2] > 0]
    for across in LINE:
        for down in LINE:
            column, row = np.rint(places[:, 0] + across), np.rint(places[:, 1] + down)
            here = (column >= 0) & (column < width) & (row >= 0) & (row < height)
            spot = row[here].astype(int), column[here].astype(int)
            np.maximum.at(near, spot, places[here, 2].astype(np.float32))
            canvas[spot] = (*to_rgb(EDGES), 1.0)


def _developed(canvas: Any, background: str | None) -> Image:
    """Fine pixels averaged, on their background."""
    from matplotlib.colors import to_rgb

    height, width = (side // FINE for side in canvas.shape[:2])
    whole: Values = canvas.reshape(height, FINE, width, FINE, 4).mean(axis=(1, 3), dtype=float)
    colours, alpha = whole[..., :3], whole[..., 3:]
    if background:
        flat = colours + (1.0 - alpha) * np.array(to_rgb(background))
    else:
        flat = np.concatenate([colours / np.maximum(alpha, 1e-6), alpha], axis=-1)
    picture: Image = np.rint(255.0 * np.clip(flat, 0.0, 1.0)).astype(np.uint8)
    return picture
