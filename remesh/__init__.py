"""How values live on particles and meshes, and move between the two."""

from __future__ import annotations

from typing import TYPE_CHECKING

from remesh.lazy import lazy_names

if TYPE_CHECKING:
    from remesh.errors import BlowUpError as BlowUpError
    from remesh.errors import InputError as InputError
    from remesh.errors import PmeshError as PmeshError
    from remesh.errors import StorageError as StorageError
    from remesh.grid import Grid as Grid
    from remesh.kernels import KERNELS as KERNELS
    from remesh.kernels import Kernel as Kernel
    from remesh.mapping import Mapping as Mapping
    from remesh.mollifier import mollify as mollify
    from remesh.multires.adapt import adapt as adapt
    from remesh.multires.blocks import Blocks as Blocks
    from remesh.multires.carrying import transferred as transferred
    from remesh.multires.compression import Compressed as Compressed
    from remesh.multires.compression import compress as compress
    from remesh.multires.mesh import AdaptiveMesh as AdaptiveMesh
    from remesh.multires.sampling import sampled as sampled
    from remesh.multires.uniform import to_uniform as to_uniform
    from remesh.nodes import advect_nodes as advect_nodes
    from remesh.nodes import sample_nodes as sample_nodes
    from remesh.particles import Particles as Particles
    from remesh.particles import distortion as distortion
    from remesh.reconstruction import reconstruct as reconstruct
    from remesh.spreading import spread_nodes as spread_nodes
    from remesh.stencils import curl as curl
    from remesh.stencils import divergence as divergence
    from remesh.stencils import gradient as gradient
    from remesh.stencils import laplacian as laplacian
    from remesh.stretching import stretched as stretched
    from remesh.transfer import m2p as m2p
    from remesh.transfer import p2m as p2m
    from remesh.transfer import remesh as remesh

__all__ = [
    "KERNELS",
    "AdaptiveMesh",
    "Blocks",
    "BlowUpError",
    "Compressed",
    "Grid",
    "InputError",
    "Kernel",
    "Mapping",
    "Particles",
    "PmeshError",
    "StorageError",
    "adapt",
    "advect_nodes",
    "compress",
    "curl",
    "distortion",
    "divergence",
    "gradient",
    "laplacian",
    "m2p",
    "mollify",
    "p2m",
    "reconstruct",
    "remesh",
    "sample_nodes",
    "sampled",
    "spread_nodes",
    "stretched",
    "to_uniform",
    "transferred",
]

_HOME = {
    "AdaptiveMesh": "remesh.multires.mesh",
    "Blocks": "remesh.multires.blocks",
    "adapt": "remesh.multires.adapt",
    "sampled": "remesh.multires.sampling",
    "to_uniform": "remesh.multires.uniform",
    "transferred": "remesh.multires.carrying",
    "Mapping": "remesh.mapping",
    "Compressed": "remesh.multires.compression",
    "compress": "remesh.multires.compression",
    "BlowUpError": "remesh.errors",
    "InputError": "remesh.errors",
    "PmeshError": "remesh.errors",
    "StorageError": "remesh.errors",
    "Grid": "remesh.grid",
    "KERNELS": "remesh.kernels",
    "Kernel": "remesh.kernels",
    "mollify": "remesh.mollifier",
    "advect_nodes": "remesh.nodes",
    "sample_nodes": "remesh.nodes",
    "Particles": "remesh.particles",
    "distortion": "remesh.particles",
    "reconstruct": "remesh.reconstruction",
    "curl": "remesh.stencils",
    "divergence": "remesh.stencils",
    "gradient": "remesh.stencils",
    "laplacian": "remesh.stencils",
    "spread_nodes": "remesh.spreading",
    "stretched": "remesh.stretching",
    "m2p": "remesh.transfer",
    "p2m": "remesh.transfer",
    "remesh": "remesh.transfer",
}

__getattr__, __dir__ = lazy_names(globals(), _HOME)
