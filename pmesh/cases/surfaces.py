"""Surfaces in space, lit and drawn off-screen: a picture as an array, for a figure's panel."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pmesh.cases.camera import LENS, Camera, aimed
from pmesh.cases.layer import COPPER, PLUM, SAGE, STEEL, Layer, Mesh, Surface, Triangles, mesh_of
from pmesh.cases.offscreen import can_render, window
from pmesh.cases.plain import (
    AMBIENT,
    DIFFUSE,
    EDGES,
    LIGHTS,
    POWER,
    SHADE,
    SPECULAR,
    UNKNOWN,
    Shadow,
    covered,
    draw,
)
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
    "Surface",
    "Triangles",
    "can_render",
    "render",
    "show_surface",
]

DROP = 0.03  # of the diagonal, from what is shown down to its shadow
PEELS = 8  # sheets of glass that are told apart, one behind the other
COVER = 256  # pixels along a side of the shadow


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
    Drawn by VTK; where it cannot draw, on a machine without OpenGL (software will do), by plain
    loops over triangles and pixels: the same view, colours, light and shadow on the ground, but no
    shade in the hollows. Refuses surfaces that are empty or not finite.
    """
    told = [layer if isinstance(layer, Layer) else Layer(surface=layer) for layer in layers]
    if not told:
        raise InputError("render needs at least one surface", hint="render((phi, grid))")
    meshes = [mesh_of(layer) for layer in told]
    points = np.concatenate([mesh.points for mesh in meshes])
    low, high = (points.min(axis=0), points.max(axis=0)) if bounds is None else _corners(bounds)
    extent = float(np.linalg.norm(high - low))
    shown, shadow = _eight(low, high) if box or bounds is not None else points, None
    if ground and view[1] > 0.0:
        floor = float(low[2]) - DROP * extent
        shadow = _shadow(told, meshes, floor)
        shown = np.concatenate([shown, shown * (1, 1, 0) + (0, 0, floor)])
    camera = aimed(shown, view, size)
    if not can_render():
        edges = _edges(low, high) if box else None
        return draw(told, meshes, camera, shadow=shadow, edges=edges, background=background)
    corners = (low, high) if box else None
    return _by_vtk(told, meshes, camera, shadow, corners, extent, background)


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


def _by_vtk(
    layers: Sequence[Layer],
    meshes: Sequence[Mesh],
    camera: Camera,
    shadow: Shadow | None,
    box: tuple[Array, Array] | None,
    extent: float,
    background: str | None,
) -> Image:
    """The picture, drawn off-screen by OpenGL."""
    import pyvista

    with window():
        plotter: Any = pyvista.Plotter(
            off_screen=True, window_size=list(camera.size), lighting="none"
        )
        try:
            for layer, mesh in zip(layers, meshes, strict=True):
                _add(plotter, layer, mesh)
            if shadow is not None:
                _shade_ground(plotter, shadow)
            if box is not None:
                edges = pyvista.Box(bounds=np.stack(box, axis=1).ravel().tolist())
                plotter.add_mesh(
                    edges, style="wireframe", color=EDGES, line_width=1.5, lighting=False
                )
            if any(layer.opacity < 1.0 for layer in layers):
                plotter.enable_depth_peeling(PEELS)
            _light(plotter, extent)
            _aim(plotter, camera)
            plotter.set_background(background or "white")
            picture = plotter.screenshot(return_img=True, transparent_background=not background)
        finally:
            plotter.close()
    return np.array(picture) if background else _without_white(np.asarray(picture))


def _add(plotter: Any, layer: Layer, mesh: Mesh) -> None:
    """Put a surface on the stage: matt, with a soft highlight."""
    import pyvista

    faces: Any = mesh.faces
    surface = pyvista.PolyData.from_regular_faces(mesh.points, faces)
    surface.point_data["Normals"] = mesh.normals
    surface.point_data.active_normals_name = "Normals"
    coloured = mesh.values is not None
    if coloured:
        surface.point_data["values"] = mesh.values
    plotter.add_mesh(
        surface,
        color=None if coloured else layer.colour,
        scalars="values" if coloured else None,
        cmap=layer.colours if coloured else None,
        clim=layer.limits if coloured else None,
        nan_color=UNKNOWN,
        show_scalar_bar=False,
        smooth_shading=False,  # the normals are there
        interpolation="phong",
        opacity=layer.opacity,
        ambient=AMBIENT,
        diffuse=DIFFUSE,
        specular=SPECULAR,
        specular_power=POWER,
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


def _shade_ground(plotter: Any, shadow: Shadow) -> None:
    """Lay the shadow below."""
    import pyvista

    picture = np.zeros((*shadow.alpha.shape, 4), np.uint8)
    picture[..., :3] = SHADE
    picture[..., 3] = shadow.alpha
    plane = pyvista.Plane(
        center=(*shadow.middle, shadow.height),
        direction=(0, 0, 1),
        i_size=2 * shadow.half,
        j_size=2 * shadow.half,
    )
    texture: Any = pyvista.Texture(picture)  # type: ignore[no-untyped-call]
    texture.interpolate = True
    plotter.add_mesh(plane, texture=texture, lighting=False)


def _aim(plotter: Any, camera: Camera) -> None:
    """Place VTK's camera."""
    plotter.camera.view_angle = LENS
    plotter.camera.position = tuple(camera.eye)
    plotter.camera.focal_point = tuple(camera.eye - camera.focus * camera.back)
    plotter.camera.up = tuple(camera.up)
    plotter.renderer.ResetCameraClippingRange()


def _shadow(layers: Sequence[Layer], meshes: Sequence[Mesh], height: float) -> Shadow | None:
    """A soft shadow on a plane at this height: what surfaces cover seen from above, blurred."""
    from scipy import ndimage

    solid = [mesh for layer, mesh in zip(layers, meshes, strict=True) if layer.opacity > 0.6]
    if not solid:
        return None
    found, middle, half = covered(solid, COVER)
    near, wide = (ndimage.gaussian_filter(1.0 * found, part * COVER) for part in (0.024, 0.07))
    alpha = np.round(255 * 0.34 * (0.55 * near + 0.45 * wide)).astype(np.uint8)
    return Shadow(alpha, middle, half, height)


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


def _edges(low: Array, high: Array) -> NDArray[np.float64]:
    """The twelve edges of a box, both ends of each (12, 2, 3)."""
    corners = _eight(low, high)
    return np.array(
        [(a, b) for a, b in itertools.combinations(corners, 2) if (a != b).sum() == 1],
        np.float64,
    )
