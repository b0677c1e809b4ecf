"""What the ledger of a flow on a uniform mesh tells."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmesh.vortex.exact import BeltramiFlow, VortexRing
from pmesh.vortex.flow import VortexFlow
from remesh.grid import Grid

RING = VortexRing(radius=1.0, core=0.5, circulation=2.0, center=(0.1, -0.2, 0.3), axis=(1, 2, 2))


def test_in_the_plane_a_gaussian_vortex_tells_its_moments():
    """Circulation G, impulse (y0, -x0) G, second moment (|x0|^2 + 2 s^2) G, G^2/(4 pi s^2)."""
    gamma, size, (x, y) = 1.5, 0.3, (0.2, -0.1)

    def law(points):
        square = (points[0] - x) ** 2 + (points[1] - y) ** 2
        return gamma * np.exp(-0.5 * square / size**2) / (2 * math.pi * size**2)

    flow = VortexFlow(grid=Grid((64, 64), 0.075, (-2.4, -2.4)), viscosity=0.0)
    found = flow.ledger(flow.start(vorticity=law))
    wanted = {
        "circulation": gamma,
        "impulse_x": y * gamma,
        "impulse_y": -x * gamma,
        "angular_moment": (x**2 + y**2 + 2 * size**2) * gamma,
        "enstrophy": gamma**2 / (4 * math.pi * size**2),
        "lost_circulation": 0.0,
        "nodes": 64**2,
    }
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def test_in_space_a_ring_tells_its_impulse_and_energy():
    flow = VortexFlow(grid=Grid((44,) * 3, 0.125, (-2.7, -2.7, -2.5)), viscosity=0.01, order=10)
    found = flow.ledger(flow.start(vorticity=RING.vorticity))
    for axis, impulse, turning in zip(
        "xyz", RING.impulse, np.cross(RING.center, RING.impulse), strict=True
    ):
        assert found[f"impulse_{axis}"] == pytest.approx(impulse, rel=1e-5)
        assert found[f"angular_impulse_{axis}"] == pytest.approx(turning, rel=2e-5, abs=1e-5)
    assert found["energy"] == pytest.approx(RING.energy, rel=1e-3)
    assert abs(found["helicity"]) < 1e-6 * found["enstrophy"]
    assert found["dissipation"] == 0.01 * found["enstrophy"]


@pytest.mark.parametrize("boundary", ["periodic", ("periodic", "periodic", "unbounded")])
def test_a_periodic_axis_has_no_impulse_and_still_an_energy(boundary):
    flow = VortexFlow(grid=Grid((16,) * 3, math.pi / 8, None, boundary), viscosity=0.0, order=10)
    abc = BeltramiFlow(strengths=(1.0, 0.7, 0.4))
    if boundary != "periodic":  # vorticity that depends on z alone, gone at its ends
        flow = VortexFlow(
            grid=Grid((8, 8, 64), 0.25, (0, 0, -8.0), boundary), viscosity=0.0, order=10
        )

        def jet(points):
            z = points[2]
            return np.stack([0 * z, -2 * z * np.exp(-(z**2)), 0 * z])

        found = flow.ledger(flow.start(vorticity=jet))
        # u_x = exp(-z^2) over an area of 4: half of its square
        assert found["energy"] == pytest.approx(0.5 * 4 * math.sqrt(math.pi / 2), rel=2e-4)
    else:
        found = flow.ledger(flow.start(vorticity=abc.vorticity))
        volume = (2 * math.pi) ** 3
        assert found["energy"] == pytest.approx(0.5 * (1 + 0.49 + 0.16) * volume, rel=1e-6)
        assert found["helicity"] == pytest.approx((1 + 0.49 + 0.16) * volume, rel=1e-6)
    assert math.isnan(found["impulse_z"])
