"""The named cases: where each lives and what it is, as data: a list of them costs nothing."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from remesh.errors import InputError

if TYPE_CHECKING:
    from pmesh.cases.case import Case


@dataclass(frozen=True)
class Entry:
    """A case: its class as ``module:Class`` and one line that says what it is."""

    target: str
    line: str


CASES: dict[str, Entry] = {
    "cylinder": Entry(
        "pmesh.cases.cylinder:Cylinder",
        "impulsively started cylinder, drag beside Koumoutsakos & Leonard (1995)",
    ),
    "cylinder-wake": Entry(
        "pmesh.cases.cylinder_wake:CylinderWake",
        "long runs past a cylinder: steady wake or vortex street, beside published numbers",
    ),
    "sphere": Entry(
        "pmesh.cases.sphere:SphereCase",
        "a sphere set in motion at once: first drag, steady wake at Re = 100, hairpins at 300",
    ),
    "airfoil-start": Entry(
        "pmesh.cases.airfoil_start:AirfoilStart",
        "an aerofoil set in motion at once: starting vortex, lift beside Wagner's law",
    ),
    "taylor-green": Entry(
        "pmesh.cases.taylor_green:TaylorGreenCase",
        "decaying periodic vortices, beside the exact solution",
    ),
    "lamb-oseen": Entry(
        "pmesh.cases.lamb_oseen:LambOseenCase",
        "a vortex that spreads: core, circulation and angular moment, beside the exact solution",
    ),
    "perlman": Entry(
        "pmesh.cases.perlman:PerlmanCase",
        "Perlman's patch: velocity and order of accuracy, beside the exact solution",
    ),
    "ring": Entry(
        "pmesh.cases.ring:RingCase",
        "a thin vortex ring travels one diameter: its speed, and what it keeps",
    ),
    "leapfrog": Entry(
        "pmesh.cases.leapfrog:LeapfrogCase",
        "two vortex rings pass through each other in turn: period beside thin-ring theory",
    ),
    "ring-collision": Entry(
        "pmesh.cases.ring_collision:RingCollision",
        "two vortex rings collide head-on, stretch and reconnect, Lim & Nickels (1992)",
    ),
    "ring-7500": Entry(
        "pmesh.cases.ring_waves:RingWaves",
        "waves grow around a vortex ring at Re = 7500 until it breaks up",
    ),
    "elliptic-vortex": Entry(
        "pmesh.cases.elliptic_vortex:EllipticVortexCase",
        "axisymmetrisation of an elliptical vortex, Koumoutsakos (1997)",
    ),
    "elliptic-vortex-adaptive": Entry(
        "pmesh.cases.elliptic_vortex_adaptive:EllipticVortexAdaptive",
        "the same on an adaptive mesh: wavelets decide where it is fine",
    ),
    "cylinder-adaptive": Entry(
        "pmesh.cases.cylinder_adaptive:CylinderAdaptive",
        "the cylinder's start on an adaptive mesh, Re = 550 to 9500",
    ),
    "moving-cylinder": Entry(
        "pmesh.cases.moving_cylinder:MovingCylinder",
        "a cylinder towed in still fluid beside the same one in a free stream",
    ),
    "oscillating-cylinder": Entry(
        "pmesh.cases.oscillating_cylinder:OscillatingCylinder",
        "a cylinder that oscillates in fluid at rest, beside Dütsch et al. (1998)",
    ),
    "falling-disk": Entry(
        "pmesh.cases.falling_disk:FallingDisk",
        "a disk that falls or rises freely: added mass at once, terminal speed in the end",
    ),
    "swimmer": Entry(
        "pmesh.cases.swimmer:SwimmerCase",
        "free anguilliform swimmer: speed beside Kern & Koumoutsakos (2006), power, wake",
    ),
    "swimmer-pair": Entry(
        "pmesh.cases.swimmer_pair:SwimmerPair",
        "two swimmers in tandem: their speeds and power beside those of one alone",
    ),
    "taylor-green-3d": Entry(
        "pmesh.cases.taylor_green_cube:TaylorGreenCubeCase",
        "Taylor and Green's vortices break down: dissipation beside a spectral method's",
    ),
    "hill": Entry(
        "pmesh.cases.hill:HillCase",
        "Hill's spherical vortex travels unchanged: speed, shape, what Euler flow keeps",
    ),
    "strained-ring": Entry(
        "pmesh.cases.strained_ring:StrainedRingCase",
        "a vortex ring in a straining flow: impulse and energy beside its exact linear evolution",
    ),
    "swimmer-3d": Entry(
        "pmesh.cases.swimmer_in_space:SwimmerInSpace",
        "the swimmer in space: speed beside Kern & Koumoutsakos (2006), vortices it sheds",
    ),
    "dumbbell": Entry(
        "pmesh.cases.dumbbell:DumbbellCase",
        "a dumbbell collapses by its mean curvature: pinch-off, volume, beside a converged curve",
    ),
    "dumbbell-adaptive": Entry(
        "pmesh.cases.dumbbell_adaptive:DumbbellAdaptive",
        "the same on an adaptive mesh: particles of four spacings, fine at the neck and the tips",
    ),
    "surface-diffusion": Entry(
        "pmesh.cases.surface_diffusion:SurfaceDiffusionCase",
        "diffusion along a sphere or a torus: decay of waves, beside the exact rates",
    ),
    "zalesak-disk": Entry(
        "pmesh.cases.zalesak_disk:ZalesakDisk",
        "a slotted disk turns rigidly: 814 particles keep it exactly; or remeshed",
    ),
    "zalesak-sphere": Entry(
        "pmesh.cases.zalesak_sphere:ZalesakSphere",
        "a slotted sphere turns rigidly: exact without remeshing; or remeshed",
    ),
    "remeshing-effect": Entry(
        "pmesh.cases.remeshing_effect:RemeshingEffect",
        "a disk drawn out by a vortex: particles lose overlap, unless they are remeshed",
    ),
    "cutting": Entry(
        "pmesh.cases.cutting:CuttingCase",
        "virtual surgery: tools cut an organ that breathes; removed beside swept volume, pieces",
    ),
    "single-vortex": Entry(
        "pmesh.cases.single_vortex:SingleVortexCase",
        "a disk drawn out into a spiral and back: area, error and order of the interface",
    ),
    "enright": Entry(
        "pmesh.cases.enright:EnrightCase",
        "a ball drawn out into a thin sheet and back: volume, holes, error of the interface",
    ),
    "single-vortex-adaptive": Entry(
        "pmesh.cases.single_vortex_adaptive:SingleVortexAdaptive",
        "the spiral on particles of several spacings, fine where it is thin: area, how many",
    ),
    "enright-adaptive": Entry(
        "pmesh.cases.enright_adaptive:EnrightAdaptive",
        "the sheet on particles of several spacings: volume, how many, error of the interface",
    ),
    "compress": Entry(
        "pmesh.cases.compress:CompressCase",
        "any field from a file, held by wavelets: error and size over five decades of tolerance",
    ),
}


def find(name: str) -> type[Case]:
    """The class of a named case, or of one's own as ``module:Class`` or ``file.py:Class``."""
    if name in CASES:
        return _load(CASES[name].target)
    if ":" in name:
        return _load(name)
    from pmesh.cases.options import unknown

    raise unknown("case", name, CASES)


def _load(target: str) -> type[Case]:
    """The class at ``module:Class``, or at ``path/to/file.py:Class``."""
    from pmesh.cases.case import Case

    where, _, name = target.rpartition(":")
    try:
        by_file = where.endswith(".py")
        module = _module(Path(where)) if by_file else importlib.import_module(where)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{where}.".startswith(f"{error.name}."):
            raise
        raise InputError(
            f"there is no module {where!r} with a case", hint="module:Class, or file.py:Class"
        ) from error
    cls = getattr(module, name, None)
    if not (isinstance(cls, type) and issubclass(cls, Case)):
        raise InputError(
            f"{where} holds no case {name!r}", hint="a subclass of pmesh.cases.case.Case"
        )
    return cls


def _module(path: Path) -> object:
    """The module in a file."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise InputError(f"there is no file {path} with a case", hint="file.py:Class")
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module  # dataclasses look their module up while it is read
    spec.loader.exec_module(module)
    return module
