"""What the ledger of a flow on a uniform mesh tells, by name."""

from __future__ import annotations

import numpy as np

from pmesh.spectral.velocity import VelocitySolver
from pmesh.vortex import ledger
from pmesh.vortex.budget import Moments, dot, energy, potential_energy
from pmesh.vortex.buffers import Buffers
from pmesh.vortex.state import State
from remesh.stencils import divergence_ratio


def plane_columns(state: State) -> dict[str, float]:
    """Integrals of the vorticity of a plane flow, and what left its mesh.

    circulation [L^2/T], impulse_x, _y [L^3/T], angular_moment [L^4/T], enstrophy [L^2/T^2],
    lost_circulation [L^2/T], nodes.
    """
    impulse = ledger.impulse(state.vorticity, state.grid)
    return {
        "circulation": ledger.circulation(state.vorticity, state.grid),
        "impulse_x": impulse[0],
        "impulse_y": impulse[1],
        "angular_moment": ledger.angular_moment(state.vorticity, state.grid),
        "enstrophy": ledger.enstrophy(state.vorticity, state.grid),
        "lost_circulation": float(state.lost_circulation),
        "nodes": float(state.grid.size),
    }


def space_columns(
    state: State,
    solver: VelocitySolver,
    buffers: Buffers,
    *,
    viscosity: float,
    threads: int | None,
) -> dict[str, float]:
    """The same in space, with energies: costs a velocity solve, with mixed axes two.

    impulse_x, _y, _z [L^4/T], angular_impulse_x, _y, _z about the origin [L^5/T], energy
    [L^5/T^2], helicity [L^4/T^2], enstrophy [L^3/T^2], dissipation [L^5/T^3], divergence
    (rms div w over rms |grad w|), lost_vorticity [L^3/T], nodes.
    """
    vorticity, grid = state.vorticity, state.grid
    moments, enstrophy = Moments(vorticity, grid), dot(vorticity, vorticity) * grid.cell_volume
    speed = solver.velocity(vorticity, out=buffers.take(vorticity.shape, vorticity.dtype))
    held = energy(speed, vorticity, grid)
    helicity = dot(speed, vorticity) * grid.cell_volume
    if any(grid.periodic) and not all(grid.periodic):
        held = potential_energy(solver.stream(vorticity, out=speed), vorticity, grid)
    buffers.give(speed)
    columns: dict[str, float] = {}
    for name, vector in (
        ("impulse", moments.impulse), ("angular_impulse", moments.angular_impulse)
    ):  # fmt: skip
        columns |= {f"{name}_{axis}": float(x) for axis, x in zip("xyz", vector, strict=True)}
    return columns | {
        "energy": held,
        "helicity": helicity,
        "enstrophy": enstrophy,
        "dissipation": viscosity * enstrophy,
        "divergence": divergence_ratio(vorticity, grid, threads=threads),
        "lost_vorticity": float(np.linalg.norm(state.lost_circulation)),
        "nodes": float(grid.size),
    }
