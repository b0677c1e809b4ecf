"""Histories of Taylor and Green's vortices by a Fourier method: the data that a case compares with.

    python benchmarks/taylor_green_spectral.py [--reynolds 400] [--nodes 96] [--until 9] [--dt 0.05]

Shares nothing with the particles: velocity in Fourier space, rotational form, the upper third of
the waves left out, Runge-Kutta of order 4 with the viscous decay exact. Prints rows of
pmesh/cases/data/taylor_green_cube.csv: time, energy and dissipation 2 nu Z per unit volume.
"""

from __future__ import annotations

import argparse

import numpy as np
from scipy import fft

Array = np.ndarray


class Box:
    """Waves in (0, 2 pi)^3."""

    def __init__(self, nodes: int, viscosity: float, dt: float) -> None:
        whole, half = fft.fftfreq(nodes, 1 / nodes), np.arange(nodes // 2 + 1.0)
        self.nodes, self.dt, self.viscosity = nodes, dt, viscosity
        self.k = (whole[:, None, None], whole[None, :, None], half[None, None, :])
        self.square = sum(k * k for k in self.k)
        self.inverse = 1.0 / np.where(self.square == 0, 1.0, self.square)
        self.kept = np.logical_and.reduce(
            np.broadcast_arrays(*(np.abs(k) < nodes / 3 for k in self.k))
        )
        self.fade = np.exp(-0.5 * viscosity * dt * self.square)
        self.twice = np.where((half == 0) | (half == nodes // 2), 1.0, 2.0)  # of each wave held

    def start(self) -> Array:
        """Taylor and Green's velocity."""
        x, y, z = np.meshgrid(*(np.arange(self.nodes) * 2 * np.pi / self.nodes,) * 3, indexing="ij")
        u, v = np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z)
        return self.waves(np.stack([u, v, np.zeros_like(u)]))

    def waves(self, field: Array) -> Array:
        """Amplitudes of a vector field, those above two thirds left out."""
        return fft.rfftn(field, axes=(1, 2, 3), norm="forward") * self.kept

    def field(self, waves: Array) -> Array:
        """The field of these amplitudes."""
        return fft.irfftn(waves, s=(self.nodes,) * 3, axes=(1, 2, 3), norm="forward")

    def rate(self, velocity: Array) -> Array:
        """Solenoidal part of u x w."""
        kx, ky, kz = self.k
        u, v, w = velocity
        spin = 1j * np.stack([ky * w - kz * v, kz * u - kx * w, kx * v - ky * u])
        force = self.waves(np.cross(self.field(velocity), self.field(spin), axis=0))
        along = sum(k * f for k, f in zip(self.k, force, strict=True)) * self.inverse
        for part, k in zip(force, self.k, strict=True):
            part -= k * along
        return force

    def step(self, u: Array) -> Array:
        """One Runge-Kutta step."""
        dt, fade = self.dt, self.fade
        a = self.rate(u)
        b = self.rate(fade * (u + 0.5 * dt * a))
        c = self.rate(fade * u + 0.5 * dt * b)
        d = self.rate(fade * (fade * u + dt * c))
        return fade * (fade * u + dt / 6 * (fade * a + 2 * (b + c))) + dt / 6 * d

    def budget(self, u: Array) -> tuple[float, float]:
        """Energy and dissipation per unit volume."""
        power = (np.abs(u) ** 2).sum(axis=0) * self.twice
        return 0.5 * float(power.sum()), self.viscosity * float((self.square * power).sum())


def main() -> None:
    """Print the rows."""
    parser = argparse.ArgumentParser(description="Taylor-Green vortices by a Fourier method")
    parser.add_argument("--reynolds", type=float, default=400.0)
    parser.add_argument("--nodes", type=int, default=96)
    parser.add_argument("--until", type=float, default=9.0)
    parser.add_argument("--dt", type=float, default=0.05)
    parser.add_argument("--every", type=float, default=0.2)
    given = parser.parse_args()
    box = Box(given.nodes, 1 / given.reynolds, given.dt)
    u, stride = box.start(), round(given.every / given.dt)
    for number in range(round(given.until / given.dt) + 1):
        if number % stride == 0:
            energy, lost = box.budget(u)
            row = f"{number * given.dt:.6g},{energy:.6e},{lost:.6e}"
            print(f"{given.reynolds:g},{given.nodes},{row}", flush=True)
        u = box.step(u)


if __name__ == "__main__":
    main()
