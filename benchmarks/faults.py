"""Deliberate faults, one at a time, in a copy of the tree: the tests must catch each of them.

    python benchmarks/faults.py [NAME ...] [--list] [--fit] [--all-tests]

A fault replaces one piece of one file and runs the test files that should notice; "caught" means
that a test failed, "MISSED" that all passed. ``--fit`` only checks that every fault still finds
its place (a second); the whole takes about six minutes. Exits with 1 where a fault is missed.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PARTS = ("remesh", "levelset", "pmesh", "tests", "benchmarks", "pyproject.toml")


@dataclass(frozen=True)
class Fault:
    """A wrong program: ``old`` in ``file`` becomes ``new``; ``tests`` should notice."""

    name: str
    file: str
    old: str
    new: str
    tests: str


FAULTS = [
    Fault(
        "a kernel coefficient", "remesh/kernels.py",
        "    2 0 -5 3;\n    4 -8 5 -1\n", "    2 0 -5 3;\n    4 -8 5 -2\n", "kernels",
    ),
    Fault(
        "a kernel whose weights do not sum to 1 is taken", "remesh/kernels.py",
        "if not worst <= CLAIM_TOLERANCE * scale:", "if False:", "kernels refusals",
    ),
    Fault(
        "odd and even parts of the taps exchanged", "remesh/_rows.py",
        "left[n] = even + odd\n            right[n] = even - odd",
        "left[n] = even - odd\n            right[n] = even + odd", "transfer nodes",
    ),
    Fault(
        "a missing wrap of particles", "remesh/_rows.py",
        "return index % size", "return min(max(index, 0), size - 1)", "transfer nodes",
    ),
    Fault(
        "a missing wrap of differences", "remesh/stencils.py",
        "if grid.periodic[axis]:\n            target += weight * np.roll",
        "if False:\n            target += weight * np.roll", "stencils",
    ),
    Fault(
        "particles outside the box lost without a word", "remesh/_transfer.py",
        "dropped[band, p] += line\n", "dropped[band, p] += 0 * line\n", "transfer",
    ),
    Fault(
        "a mollifier of order 4 with a coefficient of order 6", "remesh/mollifier.py",
        "(2, 4): (2.0, -1.0, 0.0)", "(2, 4): (3.0, -1.0, 0.0)", "mollifier",
    ),
    Fault(
        "a Green's function of one order less", "pmesh/spectral/greens.py",
        "terms = order // 2\n", "terms = max(order // 2 - 1, 1)\n", "greens velocity",
    ),
    Fault(
        "free space that sees its images", "pmesh/spectral/symbols.py",
        "fast_length(2 * n - 1)", "fast_length(2 * n - 1 - n // 8)", "symbols velocity poisson",
    ),
    Fault(
        "reversed velocity", "pmesh/spectral/velocity.py",
        "[[_term(0, tables[1], firsts[1], 1)], [_term(0, tables[0], firsts[0], -1)]]",
        "[[_term(0, tables[1], firsts[1], -1)], [_term(0, tables[0], firsts[0], 1)]]",
        "velocity flow",
    ),
    Fault(
        "diffusion with 2 nu", "pmesh/spectral/smoothing.py",
        "np.exp(-amount * box.spread(axis))", "np.exp(-2 * amount * box.spread(axis))",
        "smoothing velocity flow",
    ),
    Fault(
        "only half a step of diffusion with 2 nu", "pmesh/vortex/uniform.py",
        "spread = 0.5 * dt * self.flow.viscosity\n        vorticity = state.vorticity",
        "spread = dt * self.flow.viscosity\n        vorticity = state.vorticity", "flow",
    ),
    Fault(
        "a mean over the step replaced by its end", "pmesh/spectral/smoothing.py",
        "values = np.where(z > 0, -np.expm1(-safe) / safe, 1.0)", "values = np.exp(-z)",
        "smoothing velocity",
    ),
    Fault(
        "an Euler path", "remesh/paths.py", "(0.0, 1.0), \"midpoint rule\"",
        "(1.0, 0.0), \"midpoint rule\"", "paths flow",
    ),
    Fault(
        "a wrong weight of RK3", "remesh/paths.py", "(2 / 9, 1 / 3, 4 / 9)",
        "(1 / 4, 1 / 4, 1 / 2)", "paths flow",
    ),
    Fault(
        "a stage sampled at home instead of where the particle is", "pmesh/vortex/schemes.py",
        "slopes.append(self._sampled(speed, place))",
        "slopes.append(speed)", "schemes flow",
    ),
    Fault(
        "what crosses an edge is not counted", "pmesh/vortex/uniform.py",
        "lost = state.lost_circulation + lost", "lost = state.lost_circulation + 0 * lost",
        "flow constraint",
    ),
    Fault(
        "impulse of the wrong sign", "pmesh/vortex/ledger.py",
        "-float(along_x @ x) * grid", "float(along_x @ x) * grid", "ledger flow constraint",
    ),
    Fault(
        "drag of the wrong sign", "pmesh/vortex/loads.py",
        "force=_plain((gain - sums[number, :n]) / dt)",
        "force=_plain((gain + sums[number, :n]) / dt)", "constraint",
    ),
    Fault(
        "drag that forgets the force of the first half step", "pmesh/vortex/passage.py",
        "sums = sums + moments(imposed.impulse", "sums = moments(imposed.impulse", "constraint",
    ),
    Fault(
        "drag by impulse that forgets the drift of circulation", "pmesh/vortex/ledger.py",
        "total = circulation(vorticity, grid)\n", "total = 0.0\n", "ledger constraint",
    ),
    Fault(
        "a force that forgets the body's own velocity", "pmesh/bodies/hold.py",
        "(held.mask.velocity.astype(velocity.dtype) - held.blurred(velocity))",
        "(-held.blurred(velocity))", "penalise constraint",
    ),
    Fault(
        "a slip residual that looks smaller than it is", "pmesh/bodies/hold.py",
        "residual=residual,", "residual=0.1 * residual,", "penalise constraint",
    ),
    Fault(
        "a wall that acts where its ramp has its middle", "pmesh/vortex/constraint.py",
        "return self.law(settings).offset", "return 0.0", "wall constraint",
    ),
    Fault(
        "an impulsive start that takes too much", "pmesh/vortex/constraint.py",
        "sharp=settings.sharp) - SHEET", "sharp=settings.sharp) - 1.0", "constraint",
    ),
    Fault(
        "a restart through float32", "pmesh/run/checkpoint.py",
        "create_dataset(name, data=array)",
        'create_dataset(name, data=array.astype("f4") if array.dtype == "f8" else array)',
        "checkpoint kill_resume",
    ),
    Fault(
        "a series that rounds", "pmesh/run/series.py", "return repr(float(value))",
        'return f"{float(value):.12g}"', "loop checkpoint kill_resume",
    ),
    Fault(
        "a resumed series that repeats a row", "pmesh/run/series.py",
        "<= last_step]", "<= last_step + 1]", "loop checkpoint kill_resume",
    ),
    Fault(
        "a checkpoint written over the good one", "pmesh/run/files.py",
        'part = path.with_name(f".{path.name}.part")', "part = path",
        "checkpoint refusals kill_resume",
    ),
    Fault(
        "a damaged checkpoint accepted in silence", "pmesh/run/checkpoint.py",
        "if header != _header(digest):", "if False:", "checkpoint",
    ),
    Fault(
        "a landing that overshoots", "pmesh/run/clock.py",
        "dt = remaining / steps", "dt = limit.dt", "loop",
    ),
    Fault(
        "a field that is not finite goes on", "pmesh/run/tree.py",
        "and not np.isfinite(array).all()", "and np.isnan(array).all()", "loop refusals",
    ),
    Fault(
        "a metric that passes outside its tolerance", "pmesh/run/summary.py",
        "<= self.tolerance", "<= 10 * self.tolerance", "summary",
    ),
    Fault(
        "a config typo accepted in silence", "pmesh/cases/options.py",
        'raise unknown("option", name, known)\n    return', "values = {}\n    return",
        "case cli",
    ),
    Fault(
        "a free body forgets the momentum it has", "pmesh/bodies/freedom.py",
        "given = momentum + hold", "given = hold", "freedom passage",
    ),
    Fault(
        "the force of a moving body forgets the fluid in its place", "pmesh/vortex/loads.py",
        "_plain((gain - sums[number, :n]) / dt)", "_plain((-sums[number, :n]) / dt)",
        "passage freedom routes",
    ),
    Fault(
        "the last force's impulse is not taken from a free body", "pmesh/vortex/passage.py",
        "self.push - sums", "self.push", "passage freedom",
    ),
    Fault(
        "free bodies are foreseen by Euler's rule", "pmesh/bodies/freedom.py",
        "gain = (dt / past if past > 0 else 0.0) * (speed", "gain = 0.0 * (speed", "freedom",
    ),
    Fault(
        "a deformation keeps its momentum on the mesh", "pmesh/bodies/mask.py",
        "change = change - _motion(drift, points, pose)", "change = change + 0.0", "mask",
    ),
    Fault(
        "a shape does not move with what its deformation lost", "pmesh/bodies/freedom.py",
        "for x in speed - drift]", "for x in speed]", "freedom passage outer",
    ),
    Fault(
        "swelling bodies take in fluid", "pmesh/spectral/velocity.py",
        "[[_term(0, table, name, -1)] for table, name",
        "[[_term(0, table, name, 1)] for table, name", "velocity outer",
    ),
    Fault(
        "the wake that left pushes the wrong way", "pmesh/vortex/window.py",
        "flux = -float(np.dot(gone.impulse", "flux = float(np.dot(gone.impulse", "window",
    ),
    Fault(
        "the torque has the other hand", "pmesh/vortex/loads.py",
        "torque=_plain((turn - sums[number, n:]) / dt)",
        "torque=_plain((turn + sums[number, n:]) / dt)",
        "routes passage constraint",
    ),
    Fault(
        "a prescribed velocity from differences of first order", "pmesh/bodies/motion.py",
        "STENCIL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))",
        "STENCIL = ((0, -1.0), (1, 1.0))", "motion",
    ),
    Fault(
        "a vortex that turns the other way", "levelset/_laws.py",
        "-swing * (squares[2 * p + 1] * doubles[2 * p])",
        "swing * (squares[2 * p + 1] * doubles[2 * p])", "laws transport",
    ),
    Fault(
        "a weight of RK4", "remesh/paths.py",
        "(1 / 6, 1 / 3, 1 / 3, 1 / 6)", "(1 / 6, 1 / 6, 1 / 2, 1 / 6)", "paths",
    ),
    Fault(
        "a coefficient of the profile", "levelset/profile.py",
        "width * x * (1.0 + square * (-2.0 / 3.0 + 0.2 *",
        "width * x * (1.0 + square * (-2.0 / 3.0 + 0.25 *", "profile",
    ),
    Fault(
        "a steep contour that falls out of its band", "levelset/_layers.py",
        "and level[near[n]] >= 0", "and level[near[n]] >= 1e300", "lookup transport",
    ),
    Fault(
        "a shape that is not seen across a seam", "levelset/seams.py",
        "nearest = np.minimum(nearest,", "nearest = np.maximum(nearest,", "seams transport",
    ),
    Fault(
        "a limit that looks at the start of a step only", "levelset/transport.py",
        "for share in SHARES)", "for share in SHARES[:1])", "transport",
    ),
    Fault(
        "curvature flow of the wrong sign", "levelset/curvature_flow.py",
        "    whole = _semi_implicit(phi, normal, grid, dt, threads)",
        "    normal = -normal\n    whole = _semi_implicit(phi, normal, grid, dt, threads)",
        "curvature_flow",
    ),
    Fault(
        "a mean curvature of the wrong sign", "levelset/_curvature.py",
        "out[m] = across(p, p, steep) / (", "out[m] = -across(p, p, steep) / (", "curvatures",
    ),
    Fault(
        "a cut that adds", "levelset/cutting.py",
        "np.maximum(moved.values, profile(-depth,", "np.minimum(moved.values, profile(-depth,",
        "cutting",
    ),
    Fault(
        "moving least squares without their weights", "remesh/_reconstruction.py",
        "weight = math.exp(-square)", "weight = 1.0", "reconstruction",
    ),
    Fault(
        "corners of blocks out of balance", "remesh/multires/_hashing.py",
        "(place[axis] + (1 if corner >> axis & 1 else -1)) >> 1",
        "(place[axis] + (1 if corner >> axis & 1 else 0)) >> 1", "blocks",
    ),
    Fault(
        "ghosts at a jump from the wrong half of a coarser block", "remesh/multires/_ghosts.py",
        "ay = ys + ((side[1] + oy) & 1) * hy", "ay = ys + (side[1] & 1) * hy", "ghosts",
    ),
    Fault(
        "details kept at a rim, where their lifting reaches out", "remesh/multires/_adapt.py",
        "target[x0:x1, y0:y1, z0:z1] = 0", "target[x0:x1, y0:y1, z0:z1] += 0", "adapt",
    ),
    Fault(
        "details at a rim that do not spill", "remesh/multires/adapt.py",
        "forward(values, blocks, spill=True,", "forward(values, blocks, spill=False,", "adapt",
    ),
    Fault(
        "a mesh that does not follow what was made ahead", "remesh/multires/adapt.py",
        "(found > low) | _ahead(found > high, target))", "found > low)", "adapt",
    ),
    Fault(
        "a raised tolerance that nobody is told", "remesh/multires/adapt.py",
        "return Adapted(target, result, low,",
        "return Adapted(target, result, blocks.mesh.tolerance,", "adapt adaptive_engine",
    ),
    Fault(
        "a landing without its buffer", "remesh/multires/_landing.py",
        "first = (low - buffer) // edge", "first = low // edge", "landing",
    ),
    Fault(
        "a coarser place looked up as if its node were even", "remesh/multires/_lookup.py",
        "odd = dtype.type(whole[axis, j] & 1)", "odd = dtype.type(0)", "block_lookup",
    ),
    Fault(
        "particles from the end of a region taken as complete", "remesh/multires/_rim.py",
        "seen[i, m, k] != INNER", "seen[i, m, k] == 0", "travel",
    ),
    Fault(
        "all levels spread by the stencil of the finest", "remesh/multires/diffusion.py",
        "stencil(diffused / steps / h**2, reach) for h in",
        "stencil(diffused / steps / spacings[-1]**2, reach) for _ in",
        "diffusion",
    ),
    Fault(
        "far taps dropped instead of folded", "pmesh/spectral/taps.py",
        "result[index] += np.linalg.solve(gram, pull)",
        "result[index] += 0.0 * np.linalg.solve(gram, pull)", "taps corrections",
    ),
    Fault(
        "no margin around the coarsest level", "pmesh/spectral/corrections.py",
        "margins = [(0, 0) if p else (MARGIN, MARGIN) for p in periodic]",
        "margins = [(0, 0) if p else (0, 2 * MARGIN) for p in periodic]", "corrections",
    ),
    Fault(
        "a coarse velocity that is not the fine one's", "pmesh/spectral/corrections.py",
        "for level in range(blocks.finest, 0, -1):", "for level in range(0, 0, -1):",
        "corrections",
    ),
    Fault(
        "a wall that feels ripples", "pmesh/vortex/skin.py",
        "np.moveaxis(result, axis, 0)[half : half + count] -= change",
        "np.moveaxis(result, axis, 0)[half : half + count] -= 0 * change", "skin",
    ),
    Fault(
        "finest blocks that do not wait for a body", "pmesh/vortex/adaptive.py",
        "target = target.joined(self.mesh.levels, keep)", "pass", "adaptive_bodies",
    ),
    Fault(
        "an adaptive step that spreads by 2 nu", "pmesh/vortex/adaptive.py",
        "flow.viscosity * tau)", "2.0 * flow.viscosity * tau)", "adaptive_engine",
    ),
    Fault(
        "stages of an adaptive step read at home", "pmesh/vortex/adaptive.py",
        "sampled_at(velocity, stage.blocks, blocks, place, flow.kernel, threads=flow.threads)",
        "sampled_at(velocity, stage.blocks, blocks, 0 * place, flow.kernel, threads=flow.threads)",
        "adaptive_engine",
    ),
    Fault(
        "stretching by the transposed gradient", "remesh/_stretching.py",
        "given = load(w[0 if e < 2 * REACH else 1], source + k, lanes)",
        "given = load(w[1 if e < 2 * REACH else 0], source + k, lanes)", "stretching schemes",
    ),
    Fault(
        "particles in space that are not stretched", "pmesh/vortex/schemes.py",
        "if self._ndim == 2:\n            return self._advected",
        "if self._ndim > 1:\n            return self._advected", "schemes flow_in_space",
    ),
    Fault(
        "a drift that stretches", "pmesh/vortex/schemes.py",
        'self.stretching == "conservative" and any(self.drift)', "False and any(self.drift)",
        "schemes",
    ),
    Fault(
        "compact diffusion with 2 nu", "remesh/spreading.py",
        "weights = stencil(diffused / steps", "weights = stencil(2 * diffused / steps", "spreading",
    ),
    Fault(
        "cleaning that feeds the divergence", "remesh/cleaning.py",
        "STRENGTH = 0.2", "STRENGTH = -0.2", "cleaning",
    ),
    Fault(
        "a projection that keeps off-diagonal divergence", "pmesh/spectral/solenoidal.py",
        "table = (-lines[i] * lines[j]) / square", "table = (lines[i] * lines[j]) / square",
        "solenoidal",
    ),
    Fault(
        "an impulse of the wrong hand", "pmesh/vortex/budget.py",
        "0.5 * (self.first(k, j) - self.first(j, k))",
        "0.5 * (self.first(j, k) - self.first(k, j))", "budget",
    ),
    Fault(
        "an angular impulse of the wrong sign", "pmesh/vortex/budget.py",
        "return -0.5 * np.array(squares)", "return 0.5 * np.array(squares)", "budget",
    ),
    Fault(
        "turns composed in the wrong order", "pmesh/bodies/turning.py",
        "rotation_vector(product(quaternion(by), quaternion(angle)))",
        "rotation_vector(product(quaternion(angle), quaternion(by)))", "turning",
    ),
    Fault(
        "an inertia that does not turn with its body", "pmesh/bodies/body.py",
        "np.eye(3) - turn @ second @ turn.T", "np.eye(3) - second", "body",
    ),
]  # fmt: skip


def copy_tree(target: Path) -> None:
    """The tree and its compiled kernels, which stay valid where a file keeps its time."""
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, target / part)
        else:
            shutil.copy2(ROOT / part, target / part)


def place(fault: Fault, tree: Path) -> str:
    """The file's text with the fault in it; refuses a fault that fits nowhere or twice."""
    text = (tree / fault.file).read_text(encoding="utf-8")
    found = text.count(fault.old)
    if found != 1:
        raise SystemExit(f'"{fault.name}" fits {found} places of {fault.file}: {fault.old!r}')
    return text.replace(fault.old, fault.new)


def run_tests(tree: Path, names: list[str], kernels: Path | None = None) -> tuple[int, str]:
    """Exit status of pytest on the copy, and what failed first; ``kernels``: another cache."""
    files = [f"tests/test_{name}.py" for name in names]
    words = [sys.executable, "-m", "pytest", "-x", "--no-header", "-p", "no:cacheprovider"]
    setting = {"PYTHONPATH": str(tree)} | ({"NUMBA_CACHE_DIR": str(kernels)} if kernels else {})
    done = subprocess.run(
        [*words, *files], cwd=tree, capture_output=True, text=True, check=False,
        stdin=subprocess.DEVNULL, env=os.environ | setting,
    )  # fmt: skip
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    said = failed[0] if failed else done.stdout[-2000:] + done.stderr[-2000:]
    return done.returncode, said


def try_fault(fault: Fault, tree: Path) -> bool:
    """Whether a test fails with the fault in place; a line about it."""
    original = tree / f"{fault.file}.original"
    path, began = tree / fault.file, time.perf_counter()
    text = place(fault, tree)
    path.rename(original)
    path.write_text(text, encoding="utf-8")
    # a compiled kernel that calls another does not see that the other has changed
    kernels = tree / f"kernels-{began}" if path.name.startswith("_") else None
    try:
        status, said = run_tests(tree, fault.tests.split(), kernels)
    finally:
        original.replace(path)  # with its time, so that its kernels are valid again
    if status not in (0, 1):
        raise SystemExit(f'"{fault.name}": the tests did not run\n{said}')
    word = "caught" if status else "MISSED"
    which = said.removeprefix("FAILED tests/").split(" - ")[0] if status else ""
    print(f"{word}  {fault.name:58} {time.perf_counter() - began:5.0f} s  {which}", flush=True)
    return status == 1


def main() -> None:
    parser = argparse.ArgumentParser(description="deliberate faults that the tests must catch")
    parser.add_argument("names", nargs="*", help="only faults with one of these words in the name")
    parser.add_argument("--list", action="store_true", help="list the faults")
    parser.add_argument("--fit", action="store_true", help="only check that every fault fits")
    options = parser.parse_args()
    chosen = [f for f in FAULTS if not options.names or any(n in f.name for n in options.names)]
    if options.list or options.fit:
        for fault in chosen:
            place(fault, ROOT)
            if options.list:
                print(f"{fault.name:58} {fault.file}")
        print(f"{len(chosen)} faults fit")
        return
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder)
        copy_tree(tree)
        files = sorted({name for fault in chosen for name in fault.tests.split()})
        status, said = run_tests(tree, files)
        if status:
            raise SystemExit(f"the tests fail without a fault\n{said}")
        print(f"without a fault {len(files)} test files pass", flush=True)
        missed = [fault.name for fault in chosen if not try_fault(fault, tree)]
    print(f"{len(chosen) - len(missed)} of {len(chosen)} faults caught")
    if missed:
        raise SystemExit("missed: " + "; ".join(missed))


if __name__ == "__main__":
    main()
