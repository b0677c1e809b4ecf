"""The "spherical" vortex ring in a linear flow: its linear evolution, solved exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmesh.vortex.exact.flow import Array, Triple, as_array, check, check_triple, relative
from remesh.errors import InputError

Matrix = tuple[Triple, Triple, Triple]
_STILL: Matrix = ((0.0, 0.0, 0.0),) * 3


@dataclass(frozen=True, kw_only=True)
class StrainedRing:
    """``w = curl(a exp(-|x - x0|^2/sigma^2))``, carried and strained by the flow ``U = A x``.

    It solves ``dw/dt + (U . grad) w = (w . grad) U + nu laplace(w)`` exactly, for any A without
    trace: with ``F = exp(A t)``,

    - ``w(x, t) = grad g x a(t)``, ``g = sigma^3/sqrt(det C) exp(-y . C^-1 y)``, ``y = x - F x0``;
    - ``a(t) = F^-T a``, a covector: ``F (k x a) = F^-T k x F^-T a`` as det F = 1;
    - ``dC/dt = A C + C A^T + 4 nu I``, ``C(0) = sigma^2 I``;
    - impulse ``1/2 int x cross w dV = pi^(3/2) sigma^3 a(t)``, hence ``dI/dt = -A^T I`` with any
      viscosity.

    For an irrotational A (symmetric) this is the whole linearised Navier-Stokes equation. With
    base vorticity Omega that one has ``(Omega . grad) u`` besides, which is left out here: u
    falls off as 1/r^3, the term spreads vorticity as 1/r^4 at once, the impulse then
    depends on the order of integration, and no law for it alone exists: in Fourier space
    ``dv/dt = -A v + 2 k (k . A v)/k^2`` along ``dk/dt = -A^T k``, and ``v = I - k (k . I)/k^2``
    solves it as k -> 0 in all directions only if A is symmetric.
    """

    strain: Matrix = _STILL  # A_ij = dU_i/dx_j [1/T], without trace
    amplitude: Triple = (0.0, 0.0, 1.0)  # a at t = 0 [L/T]
    width: float = 1.0  # sigma [L]
    center: Triple = (0.0, 0.0, 0.0)  # x0 at t = 0 [L]
    viscosity: float = 0.0  # nu [L^2/T]

    def __post_init__(self) -> None:
        """Refuse a width that is not positive and a flow that is no volume-preserving one."""
        check(self, positive=("width",), not_negative=("viscosity",))
        check_triple(self, "amplitude", "center")
        matrix = np.asarray(self.strain, float)
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
            raise InputError(
                f"StrainedRing: strain must be 3 rows of 3 numbers, got shape {matrix.shape}",
                hint="strain=((1, 0, 0), (0, -1, 0), (0, 0, 0))",
            )
        if abs(np.trace(matrix)) > 1e-12 * max(float(np.abs(matrix).max()), 1e-300):
            raise InputError(
                f"StrainedRing: the trace of strain must be zero, got {np.trace(matrix):.3g}",
                hint="strain=((1, 0, 0), (0, -1, 0), (0, 0, 0))",
            )

    @property
    def irrotational(self) -> bool:
        """Whether the base flow has no vorticity; the law then is the whole linearised one."""
        matrix = np.asarray(self.strain, float)
        return bool(np.allclose(matrix, matrix.T, rtol=0.0, atol=1e-14 * np.abs(matrix).max()))

    def base_velocity(self, points: Array) -> Array:
        """The linear flow A x (3, ...) [L/T] at ``points`` (3, ...) [L]."""
        points = relative(points, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)
        return as_array(np.tensordot(np.asarray(self.strain, points.dtype), points, axes=1))

    def deformation(self, time: float) -> NDArray[np.float64]:
        """F = exp(A t), (3, 3)."""
        from scipy.linalg import expm  # imported late: scipy is slow to load

        return np.asarray(expm(np.asarray(self.strain, float) * time))

    def shape(self, time: float = 0.0) -> NDArray[np.float64]:
        """C, (3, 3) [L^2]: the vorticity's Gaussian is exp(-y . C^-1 y)."""
        from scipy.linalg import expm

        # exp of the block matrix [[A, 4 nu I], [0, -A^T]] holds F and int F(t - s) 4 nu F(-s)^T ds
        matrix = np.asarray(self.strain, float)
        block = np.zeros((6, 6))
        block[:3, :3], block[3:, 3:] = matrix, -matrix.T
        block[:3, 3:] = 4.0 * self.viscosity * np.eye(3)
        whole = expm(block * time)
        turn = whole[:3, :3]
        spread = whole[:3, 3:] @ turn.T + self.width**2 * turn @ turn.T
        return np.asarray(0.5 * (spread + spread.T))

    def covector(self, time: float = 0.0) -> NDArray[np.float64]:
        """a(t) = exp(-A^T t) a, (3,) [L/T]."""
        return np.asarray(self.deformation(-time).T @ np.asarray(self.amplitude, float))

    def vorticity(self, points: Array, time: float = 0.0) -> Array:
        """Vorticity (3, ...) [1/T] at ``points`` (3, ...) [L], the base flow's left out."""
        center = (self.deformation(time) @ np.asarray(self.center, float)).tolist()
        local = relative(points, (center[0], center[1], center[2]), (0.0, 0.0, 0.0), 0.0)
        spread = self.shape(time)
        inverse = np.linalg.inv(spread).astype(local.dtype)
        slope = np.tensordot(inverse, local, axes=1)
        peak = self.width**3 / math.sqrt(float(np.linalg.det(spread)))
        bell = peak * np.exp(-np.sum(local * slope, axis=0))
        x, y, z = -2.0 * bell * slope
        a, b, c = self.covector(time).tolist()
        return as_array(np.stack([y * c - z * b, z * a - x * c, x * b - y * a]))

    def impulse(self, time: float = 0.0) -> NDArray[np.float64]:
        """1/2 int x cross w dV = pi^(3/2) sigma^3 a(t), (3,) [L^4/T]."""
        return np.asarray(math.pi**1.5 * self.width**3 * self.covector(time))

    def energy(self, time: float = 0.0) -> float:
        """Half the squared velocity that w induces, fluid at rest far away [L^5/T^2].

        ``sigma^6 (2 pi)^(3/2)/16 [|a|^2/sqrt(det C) - 1/3 sum a_i^2 R_D(c_j, c_k, c_i)]`` in the
        principal axes of C, c its eigenvalues, R_D Carlson's elliptic integral; at the start
        ``(2 pi)^(3/2)/24 sigma^3 |a|^2 = 0.6562 sigma^3 |a|^2``.
        """
        from scipy.special import elliprd

        axes, vectors = np.linalg.eigh(self.shape(time))
        square = (vectors.T @ self.covector(time)) ** 2
        part = sum(square[i] * elliprd(axes[i - 2], axes[i - 1], axes[i]) / 3.0 for i in range(3))
        whole = float(np.sum(square)) / math.sqrt(float(np.prod(axes)))
        return float(self.width**6 * (2.0 * math.pi) ** 1.5 / 16.0 * (whole - part))

    def enstrophy(self, time: float = 0.0) -> float:
        """Int w^2 dV [L^3/T^2]; at the start (2 pi)^(3/2)/4 sigma |a|^2."""
        spread, a = self.shape(time), self.covector(time)
        inverse = np.linalg.inv(spread)
        shear = float(np.trace(inverse) * (a @ a) - a @ inverse @ a)
        scale = self.width**6 * (2.0 * math.pi) ** 1.5 / 8.0
        return float(scale * shear / math.sqrt(float(np.linalg.det(spread))))
