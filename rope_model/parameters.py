"""Data of a scene, in SI units, validated where they are made.

The lengths, Qb, Qc and observation points of ``rope_120`` and ``rope_240`` are stated in the source; everything
marked [assumed] is ours, because the source's tables are not available.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

SwivelMode = Literal["locked", "free", "coulomb"]
MeshKind = Literal["tmn", "eem", "auto"]
RungChoice = Literal["auto", "torsional", "spatial", "planar", "rigid"]

#: what must be above 0 is at least this, so that the bound can be told to tools, which know no open intervals
LEAST = 1e-15


def _require(ok: bool, what: str, value: Any, bound: str, cure: str) -> None:
    if not ok:
        raise ValueError(f"{what} = {value!r} is out of range: it must be {bound}; {cure}")


def _require_finite(data: Any) -> None:
    for f in fields(data):
        value = getattr(data, f.name)
        if isinstance(value, float):
            _require(math.isfinite(value), f.name, value, "finite", "give a number")


@dataclass(frozen=True)
class Rope:
    """A round wire rope: T = Qa e + Qb tau, M = Qc e + Qd tau, bending moment EI kappa."""

    length: float = 120.0  # m, between the two swivels
    mass_per_length: float = 8.0  # kg/m [assumed]
    Qa: float = 1.2e8  # N, axial stiffness [assumed]
    Qb: float = 2.336e5  # N m, tension per twist; default is the symmetric mean of the published pair
    Qc: float = 2.336e5  # N m, torque per strain
    Qd: float = 3.3e3  # N m^2, torsional stiffness [assumed]
    EI: float = 300.0  # N m^2, bending stiffness [assumed]: 74 with full slip of the wires, 2.4e4 with none
    rhoJ: float = 1.94e-3  # kg m, polar mass moment per length [assumed], rho d^2/8
    beta_K: float = 1.0e-3  # s, damping proportional to stiffness [assumed]
    diameter: float = 0.044  # m [assumed], used for nominal stresses only
    installed_twist: float = 0.0  # rad, turns put in at the right end before it was fastened

    def __post_init__(self) -> None:
        _require_finite(self)
        for name in ("length", "mass_per_length", "Qa", "Qd", "EI", "rhoJ", "diameter"):
            _require(
                getattr(self, name) >= LEAST, name, getattr(self, name), "at least 1e-15", "check the rope's data sheet"
            )
        _require(self.diameter <= 1.0, "diameter", self.diameter, "at most 1 m", "give it in metres")
        _require(self.length <= 1e4, "length", self.length, "at most 1e4 m", "give it in metres")
        twist = self.installed_twist
        _require(abs(twist) <= 1e3, "installed_twist", twist, "within +-1000 rad", "give it in radians")
        _require(self.beta_K >= 0, "beta_K", self.beta_K, ">= 0 s", "use 0 for no material damping")
        bound = math.sqrt(self.Qa * self.Qd)
        _require(
            abs(self.Qs) < bound,
            "(Qb + Qc) / 2",
            self.Qs,
            f"below sqrt(Qa Qd) = {bound:.4g} N m in size",
            "or the strain energy is not positive: check Qb, Qc, Qa and Qd",
        )

    @property
    def Qs(self) -> float:
        """Symmetric part of the coupling, N m."""
        return 0.5 * (self.Qb + self.Qc)

    @property
    def Qk(self) -> float:
        """Non-conservative part of the coupling, N m."""
        return 0.5 * (self.Qb - self.Qc)


@dataclass(frozen=True)
class Layout:
    """Where the ends hang: left at X = -spacing/2, right at +spacing/2, heights are inputs."""

    spacing: float = 2.0  # m, between the two suspension points [assumed]
    gravity: float = 9.81  # m/s^2

    def __post_init__(self) -> None:
        _require_finite(self)
        _require(
            self.spacing >= LEAST,
            "spacing",
            self.spacing,
            "at least 1e-15 m",
            "give the distance between the conveyances",
        )
        _require(self.gravity >= LEAST, "gravity", self.gravity, "at least 1e-15 m/s^2", "the rope must hang")


@dataclass(frozen=True)
class Swivel:
    """Balance rope suspension rotor: a bearing with Coulomb friction between the rope's end and the conveyance."""

    mode: SwivelMode = "locked"
    mean_diameter: float = 0.090  # m, d_m of the friction [assumed]
    mu_static: float = 0.0018  # - [assumed], healthy rolling bearing
    mu_kinetic: float = 0.0013  # - [assumed]
    seal_moment: float = 0.0  # N m, friction that does not depend on the tension [assumed]
    inertia: float = 0.05  # kg m^2, of what turns with the rope's end [assumed]
    release_time: float = 0.0  # s, locked before

    def __post_init__(self) -> None:
        _require_finite(self)
        modes = ("locked", "free", "coulomb")
        _require(self.mode in modes, "swivel mode", self.mode, f"one of {modes}", "choose how the end is held")
        _require(
            self.mean_diameter >= LEAST,
            "mean_diameter",
            self.mean_diameter,
            "at least 1e-15 m",
            "take the bearing's d_m",
        )
        _require(self.mu_kinetic >= 0, "mu_kinetic", self.mu_kinetic, ">= 0", "friction takes energy, never gives")
        _require(
            self.mu_static >= self.mu_kinetic,
            "mu_static",
            self.mu_static,
            f">= mu_kinetic = {self.mu_kinetic}",
            "a swivel that slips more easily than it slides cannot stick",
        )
        _require(self.seal_moment >= 0, "seal_moment", self.seal_moment, ">= 0 N m", "friction takes energy")
        _require(
            self.inertia >= LEAST,
            "inertia",
            self.inertia,
            "at least 1e-15 kg m^2",
            "without inertia a release is a jump in spin: give the rotor's (0.05 is typical)",
        )


@dataclass(frozen=True)
class Mesh:
    """EEM: ``elements`` of equal length.  TMN-ETM: seven segments with lengths l, l/2, l/4, l/8, l/4, l/2, l.

    Without elements in III and V the loop's, in IV, are l/4, without II and VI too l/2.

    auto: the TMN-ETM that the rope's own lengths and ``loop_error`` ask for, EEM on a short or stiff rope; see
    simulation.mesh.suited.
    """

    kind: MeshKind = "tmn"
    elements: int = 600  # EEM only
    coarse_length: float = 2.0  # m, l of segments I and VII; the loop's elements are an eighth of it
    counts: tuple[int, int, int, int, int] = (2, 4, 40, 4, 2)  # elements of segments II to VI
    end_levels: int = 2  # how often the outermost element is halved towards the clamped end; 0 is the source's mesh
    leg_growth: float = 0.0  # m, (length)^2 of elements in I and VII over their distance from the loop; 0: all l
    loop_error: float = 5e-3  # m, auto only: error of the loop's place that the mesh may bring

    def __post_init__(self) -> None:
        _require(self.kind in ("tmn", "eem", "auto"), "mesh kind", self.kind, "'tmn', 'eem' or 'auto'", "choose one")
        _require(
            1e-5 <= self.loop_error <= 1.0, "loop_error", self.loop_error, "1e-5 to 1 m", "5e-3 m suits most studies"
        )
        _require(2 <= self.elements <= 20000, "elements", self.elements, "2 to 20000", "use fewer or more")
        _require(
            math.isfinite(self.coarse_length) and self.coarse_length >= LEAST,
            "coarse_length",
            self.coarse_length,
            "at least 1e-15 m",
            "2 m suits a 120 m rope",
        )
        _require(0 <= self.end_levels <= 8, "end_levels", self.end_levels, "0 to 8", "2 resolves the clamped ends")
        _require(0 <= self.leg_growth <= 1e4, "leg_growth", self.leg_growth, "0 to 1e4 m", "1 m suits a 1000 m rope")
        _require(len(self.counts) == 5, "counts", self.counts, "five numbers", "give those of segments II to VI")
        ii, iii, _, v, vi = self.counts
        fine = 2 ** (1 + (ii > 0) + (iii > 0))
        multiples = (2, 4, fine, 4, 2)
        for name, count, multiple in zip(("II", "III", "IV", "V", "VI"), self.counts, multiples, strict=True):
            _require(
                count >= (multiple if name == "IV" else 0) and count % multiple == 0,
                f"element count of segment {name}",
                count,
                f"a {'positive ' if name == 'IV' else ''}multiple of {multiple}",
                "a transformation moves whole coarse elements through the segment",
            )
        _require(
            (ii > 0) == (vi > 0) and (iii > 0) == (v > 0) and (ii > 0 or iii == 0),
            "counts",
            self.counts,
            "all five segments, or none in III and V, or none in II and VI too",
            "the ladder is the same on both sides and leaves out no step",
        )


@dataclass(frozen=True)
class Solver:
    """Time integration: generalized-alpha with step control."""

    step_max: float = 0.02  # s
    step_min: float = 1.0e-5  # s, below it the run fails and says why
    tolerance: float = 1.0e-3  # local error per step: m for positions, rad for twist angles
    newton_tolerance: float = 1.0e-7  # same units; of r' the change over the shortest element
    rho_inf: float = 0.6  # spectral radius at infinite frequency
    kernels: Literal["auto", "compiled", "portable"] = "auto"

    def __post_init__(self) -> None:
        _require_finite(self)
        _require(LEAST <= self.step_max <= 1, "step_max", self.step_max, "in [1e-15, 1] s", "10 ms suits most ropes")
        _require(
            LEAST <= self.step_min <= self.step_max, "step_min", self.step_min, "in [1e-15, step_max]", "use 1e-5 s"
        )
        _require(LEAST <= self.tolerance <= 1, "tolerance", self.tolerance, "in [1e-15, 1]", "1e-3 is a good start")
        _require(
            LEAST <= self.newton_tolerance <= 1e-3,
            "newton_tolerance",
            self.newton_tolerance,
            "in [1e-15, 1e-3]",
            "1e-7 changes no digit that matters",
        )
        _require(0 <= self.rho_inf <= 1, "rho_inf", self.rho_inf, "in [0, 1]", "0.6 damps what the mesh cannot resolve")
        _require(
            self.kernels in ("auto", "compiled", "portable"),
            "kernels",
            self.kernels,
            "'auto', 'compiled' or 'portable'",
            "'auto' compiles when it can",
        )


@dataclass(frozen=True)
class Model:
    """How much of the rope is computed: the rungs are described in physics.element and simulation.rigid."""

    rung: RungChoice = "auto"  # the lowest rung that gives the same, or one by name
    force_tolerance: float = 0.0  # relative error of the end forces that 'auto' may trade for speed

    def __post_init__(self) -> None:
        _require_finite(self)
        rungs = ("auto", "torsional", "spatial", "planar", "rigid")
        _require(self.rung in rungs, "rung", self.rung, f"one of {rungs}", "'auto' takes the lowest that serves")
        _require(
            0 <= self.force_tolerance <= 1,
            "force_tolerance",
            self.force_tolerance,
            "in [0, 1]",
            "0 allows only rungs that leave nothing out",
        )


@dataclass(frozen=True)
class Scene:
    """Everything that does not change during a run."""

    rope: Rope = field(default_factory=Rope)
    layout: Layout = field(default_factory=Layout)
    left: Swivel = field(default_factory=Swivel)
    right: Swivel = field(default_factory=Swivel)
    mesh: Mesh = Mesh(kind="auto")
    solver: Solver = field(default_factory=Solver)
    model: Model = field(default_factory=Model)

    def with_(self, **parts: Any) -> Scene:
        """A copy with some parts replaced, as in ``scene.with_(mesh=Mesh(kind="eem"))``."""
        return replace(self, **parts)


Level = Literal["draft", "standard", "reference"]
#: mesh, solver and model of each level of accuracy, checked in docs/chart.md.  A draft is for end forces: it
#: may leave out torsion and what is out of plane, where that changes the forces by an estimated 0.2 % at most
LEVELS: dict[Level, dict[str, Any]] = {
    "draft": {
        "mesh": Mesh("auto", loop_error=0.05),
        "solver": Solver(step_max=0.04, newton_tolerance=1e-5),
        "model": Model(force_tolerance=2e-3),
    },
    "standard": {"mesh": Mesh("auto"), "solver": Solver(), "model": Model()},
    "reference": {
        "mesh": Mesh("auto", loop_error=2e-4),
        "solver": Solver(step_max=2.5e-3, tolerance=1e-5),
        "model": Model(),
    },
}


def at_level(scene: Scene, level: Level) -> Scene:
    """The scene with mesh, solver and model of one of LEVELS; what else these had is lost."""
    return scene.with_(**LEVELS[level])


@dataclass(frozen=True)
class Preset:
    """A scene and the winding it is meant for: the left end starts at height 0, the right end ``travel`` above it."""

    scene: Scene
    travel: float  # m
    speed: float  # m/s


def rope_120(level: Level = "standard") -> Preset:
    """The 120 m rope: swivels locked, 90 m of travel at up to 8 m/s."""
    return Preset(at_level(Scene(), level), travel=90.0, speed=8.0)


def rope_240(level: Level = "standard") -> Preset:
    """The 240 m rope: healthy swivels released at t = 20 s, 200 m of travel at up to 10 m/s."""
    swivel = Swivel(mode="coulomb", release_time=20.0)
    scene = Scene(rope=Rope(length=240.0), left=swivel, right=swivel)
    return Preset(at_level(scene, level), travel=200.0, speed=10.0)


PRESETS = {"rope-120": rope_120, "rope-240": rope_240}
