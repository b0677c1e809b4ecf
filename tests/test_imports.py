"""What an import costs, and that every public name is there."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from types import ModuleType

import pytest

import levelset
import pmesh
import remesh

HEAVY = (
    "h5py",
    "llvmlite",
    "matplotlib",
    "numba",
    "pyfftw",
    "pyvista",
    "rich",
    "scipy",
    "skfmm",
    "vtkmodules",
)
NAMES = {
    remesh: "Grid KERNELS Kernel p2m m2p remesh mollify InputError BlowUpError",
    levelset: "shapes laws Band ParticleLevelSet CurvatureFlow SurfaceDiffusion redistance volume "
    "area curvature normal closest_points contours triangles extend laplace_beltrami Cutting Tool",
    pmesh: "poisson velocity VortexFlow State Limit run RigidBody Fixed Forces Ledger Snapshots "
    "Progress Carrier",
}
SHAPES = (
    "Disk Box SlottedDisk SlottedSphere Sphere Dumbbell Torus Capsule Star TriangleMesh Polygon"
)


def python(*words: str) -> str:
    """What a fresh interpreter prints, with every warning an error."""
    done = subprocess.run(
        [sys.executable, "-W", "error", *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("package", ["remesh", "levelset", "pmesh"])
def test_an_import_loads_nothing_heavy(package: str) -> None:
    loaded = python("-c", f"import sys, {package}; print(*sys.modules)").split()
    assert not set(HEAVY) & set(loaded)


def test_help_and_the_list_of_cases_load_nothing_heavy() -> None:
    for words in (["--help"], ["cases"]):
        code = f"import sys, pmesh.cli\ntry: pmesh.cli.main({words})\nfinally: print(*sys.modules)"
        assert not (set(HEAVY) | {"numpy"}) & set(python("-c", code).split())


def test_an_import_takes_less_than_four_tenths_of_a_second() -> None:
    times = []
    for _ in range(3):
        start = time.perf_counter()
        python("-c", "import pmesh")
        times.append(time.perf_counter() - start)
    assert statistics.median(times) < 0.4


@pytest.mark.parametrize(
    ("package", "name"),
    [(package, name) for package, names in NAMES.items() for name in names.split()],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
def test_a_public_name_is_listed_and_there(package: ModuleType, name: str) -> None:
    assert name in package.__all__
    assert getattr(package, name) is not None


@pytest.mark.parametrize("name", SHAPES.split())
def test_a_shape_is_there(name: str) -> None:
    assert callable(getattr(levelset.shapes, name))


@pytest.mark.parametrize("package", [remesh, levelset, pmesh], ids=lambda p: p.__name__)
def test_every_listed_name_can_be_had_and_no_other(package: ModuleType) -> None:
    for name in package.__all__:
        assert getattr(package, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        package.nothing  # noqa: B018


def test_run_is_a_law_and_a_package_at_once() -> None:
    code = "import pmesh, pmesh.run.loop as loop; print(callable(pmesh.run), callable(loop.run))"
    assert python("-c", code).split() == ["True", "True"]


def test_modules_can_be_imported_in_any_order_without_a_warning() -> None:
    for first in ("pmesh.cases.cylinder", "pmesh.spectral.velocity", "levelset.shapes"):
        python("-c", f"import {first}, pmesh, remesh; pmesh.VortexFlow, remesh.remesh")


@pytest.mark.parametrize("package", [remesh, levelset, pmesh], ids=lambda p: p.__name__)
def test_a_public_name_is_a_law_whatever_was_imported_first(package: ModuleType) -> None:
    """Not the module of the same name: `pmesh.poisson` lives in `pmesh.spectral.poisson`."""
    name = package.__name__
    laws = [n for n in package.__all__ if n not in ("run", "KERNELS", "laws", "shapes")]
    homes = sorted({getattr(package, law).__module__ for law in laws})
    said = python(
        "-c",
        f"import {', '.join(homes)}, {name}; from types import ModuleType; "
        f"print([n for n in {laws} if isinstance(getattr({name}, n), ModuleType)])",
    )
    assert said.strip() == "[]"
    assert all(not isinstance(getattr(package, law), ModuleType) for law in laws)
