"""A map draws the particles to a front and follows it: 30 times less error for as many, in 10 s.

Particles are uniform in xi, remeshed there, and carry the map x = f(xi, t). Above: Burgers'
equation beside its exact solution, a wave that steepens and travels. Below: a patch turns with a
flow. Repeats the idea of Bergdorf, Cottet & Koumoutsakos, Multiscale Model. Simul. 4 (2005) 328.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.linalg import lu_factor, lu_solve

import remesh
from pmesh.cases.style import OTHERS, OURS, REFERENCE, name_panels, panels, styled
from remesh.mapping import Mapping

options = argparse.ArgumentParser(description=__doc__)
options.add_argument("--quick", action="store_true", help="few particles and short times")
options.add_argument("--out", type=Path, default=Path("out/adaptive_mapping"))
args = options.parse_args()

NODES = 48 if args.quick else 64  # along the unit box, the same for all
UNTIL = 0.15 if args.quick else 0.4  # of the wave [T]
VISCOSITY, DRIFT = 1e-3, 0.5  # [L^2/T], and what carries the wave along [L/T]
TURNS, STEPS = (0.2, 4) if args.quick else (1.0, 20)  # of the patch
RADIUS, EDGE = 0.06, 0.008  # of the patch, and half the thickness of its front [L]


def wave(x, time):
    """Cole and Hopf's solution that begins as DRIFT + sin(2 pi x)."""
    if time == 0:
        return DRIFT + np.sin(2 * np.pi * x)
    away = np.linspace(-1.5, 1.5, 4001)
    start = 1 - np.cos(2 * np.pi * (np.ravel(x)[:, None] - DRIFT * time - away))
    cost = start / (2 * np.pi) + away**2 / (2 * time)
    weight = np.exp(-(cost - cost.min(axis=1, keepdims=True)) / (2 * VISCOSITY))
    return DRIFT + np.reshape(weight @ away / weight.sum(axis=1) / time, np.shape(x))


def diffused(u, mapping, dt):
    """Values on the thin mesh after dt of diffusion; two implicit stages, keeps the sum."""
    x, volume = mapping.points()[0, :, 0], mapping.volume()[:, 0] * mapping.grid.spacing
    gap = np.diff(x, append=x[0] + 1)
    flux = (np.eye(x.size) - np.roll(np.eye(x.size), 1, axis=1)) / gap[:, None]  # -du/dx between
    rate = -VISCOSITY * (flux - np.roll(flux, 1, axis=0)) * (1 / volume)[:, None]
    part = 1 - 0.5**0.5
    solver = lu_factor(np.eye(x.size) - part * dt * rate)
    first = lu_solve(solver, rate @ u)
    return u + dt * (
        (1 - part) * first + part * lu_solve(solver, rate @ (u + (1 - part) * dt * first))
    )


def slopes(mapping, values, weight):
    """The monitor: nodes gather where values are steep."""
    return 1 + weight * np.linalg.norm(mapping.gradient(values), axis=0)


def steepen(weight):
    """Burgers on a thin mesh: particles keep u and move with it; u times volume is remeshed."""
    grid = remesh.Grid((NODES, 4), 1 / NODES, boundary="periodic")
    mapping, time, paths = Mapping.identity(grid), 0.0, []
    for _ in range(20 if weight else 0):
        start = wave(mapping.points()[0], 0)
        mapping = mapping.driven(slopes(mapping, start, weight), 0.1, smooth=2)
    u = wave(mapping.points()[0], 0)
    while time < UNTIL:
        dt = min(2e-3, 0.25 / np.abs(mapping.gradient(u)[0]).max(), UNTIL - time)
        u = diffused(u, mapping, dt / 2)
        move = np.stack([dt * u, 0 * u])
        strength = u * mapping.volume(move)
        new = mapping
        if weight:  # nodes move along, and back towards where the monitor wants them
            new = Mapping(grid, mapping.offset + move)
            new = new.driven(slopes(new, u, weight), 10 * dt, smooth=2)
        shift = new.pull_back(mapping.points() + move)
        u = remesh.advect_nodes(strength, shift, grid, "L4,2").field / new.volume()
        mapping, time = new, time + dt
        u = diffused(u, mapping, dt / 2)
        paths.append((time, mapping.points()[0, :, 0]))
    return mapping, u, paths


def turned(points, time):
    """Where the flow takes points: round the middle of the box, at rest towards its edges."""
    x, y = points[0] - 0.5, points[1] - 0.5
    angle = 2 * np.pi * time * np.exp(-(((x**2 + y**2) / 0.42**2) ** 4))
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([0.5 + cos * x - sin * y, 0.5 + sin * x + cos * y])


def patch(points, time):
    x, y = turned(points, -time)
    return 0.5 - 0.5 * np.tanh((np.hypot(x - 0.5, y - 0.7) - RADIUS) / EDGE)


def turn(weight, nodes=NODES):
    """A passive patch: each node of the next map looks up its value where the flow had it."""
    grid = remesh.Grid((nodes, nodes), 1 / nodes, boundary="periodic")
    mapping, dt = Mapping.identity(grid), TURNS / STEPS
    for _ in range(40 if weight else 0):
        start = patch(mapping.points(), 0)
        mapping = mapping.driven(slopes(mapping, start, weight), 0.02, smooth=6)
    found = [(0.0, mapping, patch(mapping.points(), 0))]

    def look_up(new):
        """Values at the nodes of a map, a step later."""
        _, mapping, q = found[-1]
        shift = mapping.pull_back(turned(new.points(), -dt))
        return remesh.sample_nodes(q, shift, grid, "L6,4")

    for step in range(1, STEPS + 1):
        for _ in range(2 if weight else 0):  # towards where the patch will be
            mapping = mapping.driven(slopes(mapping, look_up(mapping), weight), 0.02, smooth=6)
        found.append((step * dt, mapping, look_up(mapping)))
    return found


def misses(mapping, values, exact):
    """Mean absolute error over the box."""
    return float((np.abs(values - exact) * mapping.volume()).mean())


ways = {"uniform": 0.0, "mapped": 0.5}
waves = {way: steepen(weight) for way, weight in ways.items()}
patches = {"uniform": turn(0.0), "mapped": turn(1.0)}
errors = {}
for way in ways:
    mapping, u, _ = waves[way]
    time, there, q = patches[way][-1]
    errors[way] = (misses(mapping, u, wave(mapping.points()[0] % 1, UNTIL)),
                   misses(there, q, patch(there.points(), time)))  # fmt: skip
    total = (u * mapping.volume()).mean() / DRIFT - 1
    print(f"{way:8}: wave, {NODES} particles: error {errors[way][0]:.1e}, sum {total:+.0e}; "
          f"patch, {NODES}^2 particles: error {errors[way][1]:.1e}")  # fmt: skip
gains = np.divide(errors["uniform"], errors["mapped"])
print(f"the map makes the error {gains[0]:.0f} and {gains[1]:.0f} times smaller")


@styled
def draw():
    figure, axes = panels(2, 3, (11.0, 7.4))
    line = np.linspace(0, 1, 2000)
    for panel, (way, colour) in zip(
        axes[0, :2], (("uniform", OTHERS[0]), ("mapped", OURS)), strict=True
    ):
        mapping, u, _ = waves[way]
        panel.plot(line, wave(line, UNTIL), color=REFERENCE, lw=1.2, label="exact")
        panel.plot(mapping.points()[0, :, 0] % 1, u[:, 0], "o", ms=3, color=colour, label=way)
        panel.set(title=f"{NODES} particles, {way}: error {errors[way][0]:.1e}", xlim=(0, 1),
                  xlabel="$x$", ylabel="$u$", ylim=(-0.8, 1.8))  # fmt: skip
        panel.legend(loc="lower left")
    times, lines = zip(*waves["mapped"][2], strict=True)
    for box in (-1, 0):
        axes[0, 2].plot(np.array(lines) + box, times, color=OURS, lw=0.5)
    axes[0, 2].set(title="paths of the nodes of the map", xlabel="$x$", ylabel="$t$", xlim=(0, 1),
                   ylim=(0, UNTIL))  # fmt: skip
    shown = [("mapped", STEPS // 4), ("mapped", STEPS), ("uniform", STEPS)]
    for panel, (way, number) in zip(axes[1], shown, strict=True):
        time, mapping, q = patches[way][number]
        error = misses(mapping, q, patch(mapping.points(), time))
        near = NODES // 4  # go on beyond the ends of the periodic mesh
        x, y = (np.pad(mapping.offset[a], near, mode="wrap") for a in (0, 1))
        steps = np.arange(-near, NODES + near) / NODES
        x, y, q = x + steps[:, None], y + steps, np.pad(q, near, mode="wrap")
        panel.pcolormesh(x, y, q, cmap="BuPu", vmin=0, vmax=1.2, shading="gouraud", rasterized=True)
        for lines in ((x, y), (x.T, y.T)):
            panel.plot(*lines, color="#808080", lw=0.25)
        panel.set(title=f"{way}, $t$ = {time:g}: error {error:.1e}", xlim=(0.1, 0.9),
                  ylim=(0.1, 0.9), xticks=[], yticks=[])  # fmt: skip
        panel.set_aspect("equal")
        panel.grid(False)
    name_panels(axes)
    return figure


args.out.mkdir(parents=True, exist_ok=True)
draw().savefig(args.out / "mapping.png", dpi=150)
