"""Smooth particles must overlap: the error of a mollified field, C1 eps^r + C2 (h/eps)^m, in 5 s.

Particles on a lattice of spacing h carry a Gaussian; the mollified sum is compared with it for
cutoffs of order r = 2, 4, 6 and radii eps from far below to far above h. Wide radii smooth (slopes
2, 4, 6); radii below h leave holes, and the error grows past the field itself. Repeats
Beale & Majda, J. Comput. Phys. 58 (1985) 188, and Cottet & Koumoutsakos (2000), section 2.3.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

from remesh.mollifier import mollify

matplotlib.use("Agg")
import matplotlib.pyplot as plt

SPACING = 1 / 20  # h [L]; the Gaussian exp(-|x|^2) has width 1 [L]
ORDERS = {2: "#4477aa", 4: "#ee6677", 6: "#228833"}


def lattice(half_length: float, spacing: float) -> np.ndarray:
    steps = np.arange(-round(half_length / spacing), round(half_length / spacing) + 1) * spacing
    return np.stack(np.meshgrid(steps, steps, indexing="ij"), -1).reshape(-1, 2)


def measure(h: float, radii: np.ndarray, order: int, points: np.ndarray) -> np.ndarray:
    """Largest error at the points, for each radius."""
    particles = lattice(4.5, h)
    values = np.exp(-(particles**2).sum(axis=1))
    exact = np.exp(-(points**2).sum(axis=1))
    return np.array(
        [
            np.abs(mollify(particles, values, h * h, points, e, order=order) - exact).max()
            for e in radii
        ]
    )


def fit_slope(radii: np.ndarray, errors: np.ndarray) -> float:
    """Slope over the widest part of the branch where smoothing alone acts."""
    smooth = (radii / SPACING > 2.2) & (radii < 0.35)
    return float(np.polyfit(np.log(radii[smooth]), np.log(errors[smooth]), 1)[0])


def panel(axis, radius: float, title: str) -> None:
    """The field that the particles make at this radius."""
    line = np.linspace(-0.36, 0.36, 180)
    points = np.stack(np.meshgrid(line, line, indexing="ij"), -1).reshape(-1, 2)
    particles = lattice(1.5, SPACING)
    values = np.exp(-(particles**2).sum(axis=1))
    field = mollify(particles, values, SPACING**2, points, radius).reshape(180, 180)
    axis.imshow(field.T, origin="lower", extent=(-0.36, 0.36) * 2, cmap="magma", vmin=0, vmax=1.6)
    axis.set(title=title, xticks=[], yticks=[])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/mollification"))
    parser.add_argument("--quick", action="store_true", help="fewer radii, for a check")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)

    radii = SPACING * np.geomspace(0.25, 12, 14 if options.quick else 60)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (60 if options.quick else 400, 2))
    figure = plt.figure(figsize=(10.5, 5.4), layout="constrained")
    (left, right) = figure.subfigures(1, 2, width_ratios=(2.5, 1))
    axis = left.subplots()
    axis.axvspan(radii[0] / SPACING, 1, color="0.93")
    axis.text(0.5, 3e-9, "particles do\nnot overlap", ha="center", color="0.4")
    for order, colour in ORDERS.items():
        errors = measure(SPACING, radii, order, points)
        slope = fit_slope(radii, errors)
        label = f"cutoff of order {order}, slope {slope:.2f}"
        axis.loglog(radii / SPACING, errors, "-", color=colour, lw=2, label=label)
        guide = radii[radii / SPACING > 2]
        anchor = errors[radii / SPACING > 2][0] * 0.45
        axis.loglog(guide / SPACING, anchor * (guide / guide[0]) ** order, ":", color=colour, lw=1)
        print(f"order {order}: measured slope {slope:.2f}, best error {errors.min():.1e}")
        if abs(slope - order) > 0.15 * order:
            raise SystemExit(f"the slope {slope:.2f} is not the cutoff's order {order}")
    # Poisson summation: the lattice's first harmonic, 4 exp(-(pi eps / h)^2) for order 2
    ratio = np.geomspace(0.4, 2.2, 60)
    alone = r"lattice alone, $4\,e^{-(\pi\varepsilon/h)^2}$"
    axis.loglog(ratio, 4 * np.exp(-((np.pi * ratio) ** 2)), "k--", lw=1, label=alone)
    axis.set(xlabel=r"radius / spacing,  $\varepsilon / h$", ylabel="largest error")
    axis.set(ylim=(1e-9, 30), xlim=(radii[0] / SPACING, radii[-1] / SPACING))
    axis.set_title("Smooth particles must overlap", loc="left", weight="bold")
    axis.spines[["top", "right"]].set_visible(False)
    axis.legend(frameon=False, loc="upper right")
    first, second = right.subplots(2, 1)
    panel(first, 0.5 * SPACING, r"$\varepsilon = h/2$: islands")
    panel(second, 1.5 * SPACING, r"$\varepsilon = 3h/2$: a field")
    figure.savefig(options.out / "mollification.png", dpi=150)
    print(f"picture: {options.out / 'mollification.png'}")


if __name__ == "__main__":
    main()
