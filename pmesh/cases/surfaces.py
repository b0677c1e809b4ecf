"""Surfaces in space, lit and drawn off-screen: a picture as an array, for a figure's panel."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.layer import COPPER, PLUM, SAGE, STEEL, Layer, Surface, Triangles, mesh_of
from pmesh.cases.offscreen import PictureError, can_render, window
from remesh.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.floating[Any]]
Image = NDArray[np.uint8]
Bounds = tuple[tuple[float, ...], tuple[float, ...]]

__all__ = [
    "COPPER",
    "PLUM",
    "SAGE",
    "STEEL",
    "Layer",
    "PictureError",
    "Surface",
    "Triangles",
    "can_render",
    "render",
    "show_surface",
]

EDGES, SHADE = "#9a9a9a", (40, 46, 56)
LENS = 22.0  # opening of the camera, from the lower to the upper edge [degrees]
MARGIN = 0.05  # of the picture that stays free at each edge
DROP = 0.03  # of the diagonal, from what is shown down to its shadow
# Lights seen from the camera (right, up, towards it), colour and strength: key, fill, two rims.
LIGHTS = (
    ((-0.75, 0.9, 0.8), "#fff6ea", 0.74),
    ((0.9, 0.1, 0.7), "#e6efff", 0.42),
    ((0.2, 0.8, -1.0), "#ffffff", 0.30),
    ((-0.9, -0.2, -0.6), "#dfe8ff", 0.18),
)


def render(
    *layers: Layer | Surface,
    view: tuple[float, float] = (-55.0, 22.0),
    bounds: Bounds | None = None,
    box: bool = False,
    ground: bool = True,
    background: str | None = "white",
    size: tuple[int, int] = (1200, 900),
) -> Image:
    """A picture of surfaces in space, ``(height, width, 3)``; with alpha if no background.

    ``view``: azimuth and elevation of the camera [degrees]; z points up, and from azimuth -90
    x points right. ``bounds``: lower and upper corner of what is shown, the same for every
    picture of a sequence; that around the surfaces if None. ``box`` draws the edges of the bounds,
    ``ground`` a soft shadow below (not if seen from there), ``size`` is width and height in pixels.
    Refuses surfaces that are empty or not finite, and fails with a PictureError, before VTK would
    break, on a machine without OpenGL (software will do).
    """
    told = [layer if isinstance(layer, Layer) else Layer(surface=layer) for layer in layers]
    if not told:
        raise InputError("render needs at least one surface", hint="render((phi, grid))")
    import pyvista

    meshes = [mesh_of(layer) for layer in told]
    points = np.concatenate([mesh.points for mesh in meshes]).astype(np.float64)
    low, high = (points.min(axis=0), points.max(axis=0)) if bounds is None else _corners(bounds)
    extent = float(np.linalg.norm(high - low))
    with window():
        plotter = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none")
        try:
            for layer, mesh in zip(told, meshes, strict=True):
                _add(plotter, layer, mesh)
            floor = float(low[2]) - DROP * extent
            shown = _eight(low, high) if box or bounds is not None else points
            if ground and view[1] > 0.0:
                _shade_ground(plotter, told, meshes, floor)
                shown = np.concatenate([shown, shown * (1, 1, 0) + (0, 0, floor)])
            if box:
                edges = pyvista.Box(bounds=tuple(np.stack([low, high], axis=1).ravel()))
                plotter.add_mesh(
                    edges, style="wireframe", color=EDGES, line_width=1.5, lighting=False
                )
            _light(plotter, extent)
            _aim(plotter, shown, view, size)
            plotter.set_background(background or "white")  # type: ignore[arg-type]
            picture = plotter.screenshot(return_img=True, transparent_background=not background)
        finally:
            plotter.close()
    return np.array(picture) if background else _without_white(np.asarray(picture))


def show_surface(
    axes: Axes,
    image: Image,
    *,
    title: str | None = None,
    colours: str = "viridis",
    limits: tuple[float, float] | None = None,
    label: str | None = None,
) -> None:
    """Put a picture into a panel, without frame and ticks; with ``limits`` a bar of its colours."""
    axes.imshow(image, interpolation="lanczos")
    axes.set_axis_off()
    if title is not None:
        axes.set_title(title)
    if limits is not None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        scale = ScalarMappable(Normalize(*limits), colours)
        bar = axes.figure.colorbar(scale, ax=axes, shrink=0.7, pad=0.02)
        bar.set_label(label or "")
        bar.outline.set_visible(False)


def _add(plotter: Any, layer: Layer, mesh: Any) -> None:
    """Put a surface on the stage: matt, with a soft highlight."""
    coloured = layer.values is not None
    plotter.add_mesh(
        mesh,
        color=None if coloured else layer.colour,
        scalars="values" if coloured else None,
        cmap=layer.colours if coloured else None,
        clim=layer.limits if coloured else None,
        show_scalar_bar=False,
        smooth_shading=False,  # the normals are there
        interpolation="phong",
        opacity=layer.opacity,
        ambient=0.40,
        diffuse=0.8,
        specular=0.16,
        specular_power=28.0,
    )


def _light(plotter: Any, extent: float) -> None:
    """Lights that stay with the camera, shade in the hollows, smooth edges."""
    import pyvista

    for place, colour, strength in LIGHTS:
        plotter.add_light(
            pyvista.Light(
                position=place, color=colour, intensity=strength, light_type="camera light"
            )
        )
    plotter.enable_ssao(radius=0.12 * extent, bias=0.004 * extent, kernel_size=32, blur=True)
    plotter.enable_anti_aliasing("ssaa")


def _shade_ground(
    plotter: Any, layers: Sequence[Layer], meshes: Sequence[Any], height: float
) -> None:
    """A soft shadow on a plane at this height: what surfaces cover seen from above, blurred."""
    import pyvista
    from scipy import ndimage

    solid = [mesh for layer, mesh in zip(layers, meshes, strict=True) if layer.opacity > 0.6]
    if not solid:
        return
    cover, middle, half = _cover(solid)
    near, wide = (ndimage.gaussian_filter(cover, share * len(cover)) for share in (0.024, 0.07))
    picture = np.zeros((*cover.shape, 4), np.uint8)
    picture[..., :3] = SHADE
    picture[..., 3] = np.round(255 * 0.34 * (0.55 * near + 0.45 * wide))
    plane = pyvista.Plane(
        center=(*middle, height), direction=(0, 0, 1), i_size=2 * half, j_size=2 * half
    )
    texture: Any = pyvista.Texture(picture)  # type: ignore[no-untyped-call]
    texture.interpolate = True
    plotter.add_mesh(plane, texture=texture, lighting=False)


def _cover(meshes: Sequence[Any]) -> tuple[Array, Array, float]:
    """Which pixels of a square, twice as wide as the surfaces, they cover seen from above."""
    import pyvista

    points = np.concatenate([mesh.points for mesh in meshes]).astype(np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), float((high - low)[:2].max())
    above = pyvista.Plotter(off_screen=True, window_size=[256, 256], lighting="none")
    try:
        for mesh in meshes:
            above.add_mesh(mesh, color="black", lighting=False)
        camera = above.camera
        camera.parallel_projection = True
        camera.parallel_scale = half
        camera.focal_point = tuple(middle)
        camera.position = (*middle[:2], high[2] + half)
        camera.up = (0.0, 1.0, 0.0)
        above.renderer.ResetCameraClippingRange()
        above.set_background("white")  # type: ignore[arg-type]
        picture = np.asarray(above.screenshot(return_img=True))
    finally:
        above.close()
    return 1.0 - picture[..., 0] / 255.0, middle[:2], half


def _aim(plotter: Any, points: Array, view: tuple[float, float], size: tuple[int, int]) -> None:
    """Place the camera so that all the points fill the picture."""
    azimuth, elevation = (math.radians(angle) for angle in view)
    back = np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )
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
    camera = plotter.camera
    camera.view_angle = LENS
    camera.position = tuple(eye)
    camera.focal_point = tuple(eye - (depth - float(z.mean())) * back)
    camera.up = tuple(up)
    plotter.renderer.ResetCameraClippingRange()


def _corners(bounds: Bounds) -> tuple[Array, Array]:
    """Both corners as arrays; refuses what is not a box in space."""
    low, high = (np.asarray(corner, np.float64) for corner in bounds)
    if low.shape != (3,) or high.shape != (3,) or not (low < high).all():
        raise InputError(
            f"bounds must be a lower and an upper corner in space, got {bounds}",
            hint="bounds=((0, 0, 0), (1, 1, 1))",
        )
    return low, high


def _without_white(picture: Image) -> Image:
    """The colours before they were blended with a white background by their alpha."""
    alpha = picture[..., 3:].astype(np.float64) / 255.0
    colours = 255.0 - (255.0 - picture[..., :3]) / np.maximum(alpha, 1.0 / 255.0)
    straight = np.round(np.clip(colours, 0.0, 255.0)).astype(np.uint8)
    return np.concatenate([straight, picture[..., 3:]], axis=-1)


def _eight(low: Array, high: Array) -> Array:
    """All corners of a box; the even ones are those below."""
    return np.array(list(itertools.product(*zip(low, high, strict=True))))
