"""Where an interface is: shapes, level sets on meshes and on particles, and what they measure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from remesh.lazy import lazy_names

if TYPE_CHECKING:
    from levelset import laws as laws
    from levelset import shapes as shapes
    from levelset.band import Band as Band
    from levelset.closest import closest_points as closest_points
    from levelset.curvature_flow import CurvatureFlow as CurvatureFlow
    from levelset.curvatures import curvature as curvature
    from levelset.curvatures import normal as normal
    from levelset.cutting import Cutting as Cutting
    from levelset.extension import extend as extend
    from levelset.quadrature import area as area
    from levelset.quadrature import centroid as centroid
    from levelset.quadrature import integrate as integrate
    from levelset.quadrature import measures as measures
    from levelset.quadrature import volume as volume
    from levelset.redistancing import redistance as redistance
    from levelset.redistancing import redistance_band as redistance_band
    from levelset.surface import contours as contours
    from levelset.surface import triangles as triangles
    from levelset.surface_diffusion import SurfaceDiffusion as SurfaceDiffusion
    from levelset.surface_operators import laplace_beltrami as laplace_beltrami
    from levelset.surface_operators import surface_gradient as surface_gradient
    from levelset.tool import Swept as Swept
    from levelset.tool import Tool as Tool
    from levelset.transport import ParticleLevelSet as ParticleLevelSet

_HOME = {
    "Swept": "levelset.tool",
    "Tool": "levelset.tool",
    "Cutting": "levelset.cutting",
    "Band": "levelset.band",
    "CurvatureFlow": "levelset.curvature_flow",
    "ParticleLevelSet": "levelset.transport",
    "SurfaceDiffusion": "levelset.surface_diffusion",
    "area": "levelset.quadrature",
    "centroid": "levelset.quadrature",
    "closest_points": "levelset.closest",
    "contours": "levelset.surface",
    "curvature": "levelset.curvatures",
    "extend": "levelset.extension",
    "integrate": "levelset.quadrature",
    "laplace_beltrami": "levelset.surface_operators",
    "laws": "levelset.laws",
    "measures": "levelset.quadrature",
    "normal": "levelset.curvatures",
    "redistance": "levelset.redistancing",
    "redistance_band": "levelset.redistancing",
    "shapes": "levelset.shapes",
    "surface_gradient": "levelset.surface_operators",
    "triangles": "levelset.surface",
    "volume": "levelset.quadrature",
}

__all__ = [
    "Band",
    "CurvatureFlow",
    "Cutting",
    "ParticleLevelSet",
    "SurfaceDiffusion",
    "Swept",
    "Tool",
    "area",
    "centroid",
    "closest_points",
    "contours",
    "curvature",
    "extend",
    "integrate",
    "laplace_beltrami",
    "laws",
    "measures",
    "normal",
    "redistance",
    "redistance_band",
    "shapes",
    "surface_gradient",
    "triangles",
    "volume",
]

__getattr__, __dir__ = lazy_names(globals(), _HOME)
