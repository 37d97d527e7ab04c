"""Data of a scene, in SI units, validated where they are made.

Of the default rope the source states Qb and Qc; everything marked [assumed] is ours, because the source's tables are
not available.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Literal, get_type_hints

from rope_model.parameter_table import (
    Bounds,
    Checked,
    Joint,
    at_least,
    choice,
    direction,
    parameter,
    parameters_of,
    require,
)
from rope_model.shaft_parameters import PARTS, Shaft

SwivelMode = Literal["locked", "free", "coulomb"]
SwivelStart = Literal["locked", "relaxed"]
Attachment = Literal["plumb", "clamped", "hinged"]
MeshKind = Literal["tmn", "eem", "auto"]
KernelForm = Literal["auto", "compiled", "portable"]
FidelityChoice = Literal["auto", "torsional", "spatial", "planar", "rigid"]
Trusted = Literal["all", "position_speed", "position", "speed"]

#: least value of parameters above 0, because tools know no open intervals
LEAST = 1e-15
#: more elements would be a mistake in the unit of their length
MOST_ELEMENTS = 20000
#: the segments whose element counts are given, and the least of them
SEGMENTS = {"II": 0, "III": 0, "IV": 2, "V": 0, "VI": 0}

_DATA_SHEET = "check the rope's data sheet"


def _added_curvature(where: str) -> float:
    cure = "give 1/R of the bend of radius R, below 0 for the other sense"
    return parameter(0.0, "1/m", f"permanent curvature added {where}", Bounds(-10.0, 10.0, cure))


def _coupling(rope: Any) -> tuple[Any, ...]:
    bound = (rope.Qa * rope.Qd) ** 0.5
    return (abs(rope.Qs) < bound,), rope.Qs, bound


def _multiple(segment: int, mesh: Any) -> tuple[Any, ...]:
    count, fine = mesh.counts[segment], 2 * (1 + (mesh.counts[0] > 0)) * (1 + (mesh.counts[1] > 0))
    multiple, least = (2, 4, fine, 4, 2)[segment], fine if segment == 2 else 0
    return (count >= least, count % multiple == 0), count, multiple


def _pattern(mesh: Any) -> tuple[Any, ...]:
    ii, iii, _, v, vi = (1 * (count > 0) for count in mesh.counts)
    return (ii == vi, iii == v, ii >= iii), mesh.counts


@dataclass(frozen=True)
class Rope(Checked):
    """A round wire rope: T = Qa e + Qb tau, M = Qc e + Qd tau and c2 d^2 Qa e tau, bending moment EI kappa."""

    length: float = parameter(
        120.0,
        "m",
        "length between the two swivels",
        Bounds(LEAST, 1e4, "give it in metres, as the rope's data sheet does"),
    )
    mass_per_length: float = parameter(8.0, "kg/m", "mass per length [assumed]", at_least(LEAST, _DATA_SHEET))
    Qa: float = parameter(1.2e8, "N", "axial stiffness, T = Qa e + Qb tau [assumed]", at_least(LEAST, _DATA_SHEET))
    Qb: float = parameter(2.336e5, "N.m", "tension per twist; default is the symmetric mean of the published pair")
    Qc: float = parameter(2.336e5, "N.m", "torque per axial strain, M = Qc e + Qd tau; default as Qb")
    Qd: float = parameter(3.3e3, "N.m2", "torsional stiffness [assumed]", at_least(LEAST, _DATA_SHEET))
    EI: float = parameter(
        300.0,
        "N.m2",
        "bending stiffness [assumed]; 74 with full slip of the wires, 2.4e4 with none",
        at_least(LEAST, _DATA_SHEET),
    )
    EI_stick: float = parameter(
        0.0,
        "N.m2",
        "bending stiffness while wires stick, above EI, that of wires that slide; 0: no friction between wires",
        at_least(0.0, "use 0 for no friction between the wires"),
    )
    slip_moment: float = parameter(
        1.0,
        "N.m",
        "moment of the friction between wires of the slack rope [assumed]",
        at_least(LEAST, "use a small one where only the tension presses the wires together"),
    )
    slip_factor: float = parameter(
        0.02,
        "1",
        "growth of that moment with the tension, over the diameter [assumed]",
        Bounds(0.0, 1.0, "use 0 for a moment that does not depend on the tension"),
    )
    rhoJ: float = parameter(
        1.94e-3,  # rho d^2/8
        "kg.m",
        "polar mass moment per length [assumed]",
        at_least(LEAST, _DATA_SHEET),
    )
    c2: float = parameter(
        0.0,
        "1",
        "growth of torsional stiffness with tension: c2 d^2 T",
        Bounds(0.0, 10.0, "use 0 where it is not known"),
    )
    beta_K: float = parameter(
        1.0e-3,
        "s",
        "material damping proportional to stiffness [assumed]",
        at_least(0.0, "use 0 for no material damping"),
    )
    torsion_damping: float = parameter(
        1.0, "1", "damping of torsion as a multiple of beta_K [assumed]", Bounds(0.0, 1e6, "use 1 for beta_K")
    )
    bending_damping: float = parameter(
        1.0, "1", "damping of bending as a multiple of beta_K [assumed]", Bounds(0.0, 1e6, "use 1 for beta_K")
    )
    diameter: float = parameter(0.044, "m", "rope diameter [assumed]", Bounds(LEAST, 1.0, "give it in metres"))
    installed_twist: float = parameter(
        0.0,
        "rad",
        "twist put in at the right end before it was fastened",
        Bounds(-1e3, 1e3, "give it in radians: a turn is 6.2832"),
    )
    initial_curvature: float = parameter(
        0.0,
        "1/m",
        "permanent curvature, as a reel leaves it; 0: straight",
        Bounds(0.0, 10.0, "take a part of 1/R of the reel of radius R, and turn its direction for the other sense"),
    )
    initial_curvature_angle: float = direction(
        "direction of that curvature at the left end, about the tangent; 0: as the loop bends"
    )
    curvature_left: float = _added_curvature("at the left end")
    curvature_middle: float = _added_curvature("at half the length")
    curvature_right: float = _added_curvature("at the right end")
    curvature_left_across: float = _added_curvature("at the left end, across")
    curvature_middle_across: float = _added_curvature("at half the length, across")
    curvature_right_across: float = _added_curvature("at the right end, across")

    joint = (
        Joint(
            "(Qb + Qc) / 2",
            "below sqrt(Qa Qd) = {:.4g} N m in size",
            "or the strain energy is not positive: check Qb, Qc, Qa and Qd",
            _coupling,
        ),
        Joint(
            "EI_stick",
            "0 or above EI = {!r} N m2",
            "use 0 for no friction between the wires; EI is that of wires that slide",
            lambda rope: (((rope.EI_stick == 0) + (rope.EI_stick > rope.EI) > 0,), rope.EI_stick, rope.EI),
        ),
    )

    @property
    def Qs(self) -> float:
        """Symmetric part of the coupling, N m."""
        return 0.5 * (self.Qb + self.Qc)

    @property
    def Qe(self) -> float:
        """Growth of the torsional stiffness per axial strain, N m^2."""
        return self.c2 * (self.diameter * self.diameter) * self.Qa  # as C: libm's square may differ in the last bit

    @property
    def Qk(self) -> float:
        """Non-conservative part of the coupling, N m."""
        return 0.5 * (self.Qb - self.Qc)


@dataclass(frozen=True)
class Layout(Checked):
    """Places of the ends: left at X = -spacing/2, right at +spacing/2, heights are inputs."""

    spacing: float = parameter(
        2.0,
        "m",
        "horizontal distance of the two suspension points [assumed]",
        at_least(LEAST, "give the distance between the conveyances"),
    )
    gravity: float = parameter(9.81, "m/s2", "acceleration of free fall", at_least(LEAST, "use 9.81"))


@dataclass(frozen=True)
class Swivel(Checked):
    """Balance rope suspension rotor: a bearing with Coulomb friction between the rope's end and the conveyance."""

    mode: SwivelMode = choice(
        "locked",
        SwivelMode,
        ("the end does not turn", "it turns without friction", "it turns against dry friction"),
        "how the {side} end is held: 0 locked, 1 free, 2 Coulomb friction",
        "choose how the end is held",
    )
    attachment: Attachment = choice(
        "plumb",
        Attachment,
        ("the rope leaves it plumb", "it leaves a clamp as that leans, an input", "it leaves it as it likes"),
        "how the rope leaves the {side} end: 0 plumb, 1 clamped as {side}.lean says, 2 hinged",
        "choose how the rope leaves it",
    )
    mean_diameter: float = parameter(
        0.090, "m", "mean diameter of the {side} swivel's bearing [assumed]", at_least(LEAST, "take the bearing's d_m")
    )
    mu_static: float = parameter(
        0.0018,  # a healthy rolling bearing
        "1",
        "coefficient of static friction of the {side} swivel [assumed]",
        at_least("mu_kinetic", "raise it, or lower mu_kinetic"),
        tunable=True,
    )
    mu_kinetic: float = parameter(
        0.0013,
        "1",
        "coefficient of kinetic friction of the {side} swivel [assumed]",
        at_least(0.0, "use 0 for no friction"),
        tunable=True,
    )
    seal_moment: float = parameter(
        0.0,
        "N.m",
        "friction moment of the {side} swivel at any tension [assumed]",
        at_least(0.0, "use 0 for none"),
        tunable=True,
    )
    inertia: float = parameter(
        0.05,
        "kg.m2",
        "inertia that turns with the rope's {side} end [assumed]",
        at_least(LEAST, "give the rotor's, 0.05 as a rule: without inertia a release is a jump in spin"),
    )
    release_time: float = parameter(0.0, "s", "time until which the {side} swivel is locked")
    start: SwivelStart = choice(
        "relaxed",
        SwivelStart,
        ("as it was hung up, held", "from where it has slid to, if it is released by then"),
        "where the {side} swivel starts: 0 locked, as it was hung up; 1 relaxed, where its friction can hold it",
        "choose where it starts",
    )


@dataclass(frozen=True)
class Mesh(Checked):
    """Partition of the rope into elements.

    EEM: ``elements`` of equal length.  TMN-ETM: seven segments with lengths l, l/2, l/4, l/8, l/4, l/2, l.  Without
    elements in III and V those of the loop, in IV, are l/4 long, without II and VI too l/2.  auto: the TMN-ETM that the
    rope's own lengths and the accuracy ask for, EEM on a short or stiff rope.  ``end_levels`` = 0 is the source's mesh.
    """

    kind: MeshKind = choice(
        "tmn",
        MeshKind,
        (
            "TMN-ETM: segments that follow the loop",
            "EEM: elements of equal length",
            "fitted to the rope: TMN-ETM, or EEM on a short or stiff rope",
        ),
        "0 TMN-ETM, segments that follow the loop; 1 EEM, equal lengths; 2 auto, fitted to the rope",
        "choose one",
    )
    elements: int = parameter(600, "", "number of elements, kind 1", Bounds(2, MOST_ELEMENTS, "use fewer or more"))
    coarse_length: float = parameter(
        2.0,
        "m",
        "element length of segments I and VII, kind 0; in the loop 1/8 of it, without III and V 1/4",
        at_least(LEAST, "2 m suits a 120 m rope"),
    )
    counts: tuple[int, int, int, int, int] = parameter(
        (2, 4, 40, 4, 2), "", "number of elements of segment {segment}, kind 0"
    )
    end_levels: int = parameter(
        2, "", "how often the outermost elements are halved, kind 0", Bounds(0, 8, "2 resolves the clamped ends")
    )
    grading_length: float = parameter(
        0.0,
        "m",
        "largest (element length)^2 in I and VII over distance from the loop, kind 0; 0: all l",
        Bounds(0.0, 1e4, "1 m suits a 1000 m rope"),
    )
    loop_error: float = parameter(
        0.0,
        "m",
        "error of the loop's place by the mesh, kind 2; 0: half of accuracy.loop",
        Bounds(0.0, 1.0, "0 suits most studies"),
    )

    joint = (
        *(
            Joint(
                f"element count of segment {name}",
                f"a {'positive ' if name == 'IV' else ''}multiple of {{!r}}",
                "a transformation moves whole coarse elements through the segment",
                partial(_multiple, segment),
            )
            for segment, name in enumerate(SEGMENTS)
        ),
        Joint(
            "counts",
            "all five segments, or none in III and V, or none in II and VI too",
            "the pattern is the same on both sides and leaves out no length",
            _pattern,
        ),
        Joint(
            "loop_error",
            "0 m unless mesh.kind = auto",
            "other kinds have the lengths that they are given: set kind = auto, or leave loop_error out",
            lambda mesh: (((mesh.kind == "auto") + (mesh.loop_error == 0) > 0,), mesh.loop_error),
        ),
    )

    def __post_init__(self) -> None:
        require(len(self.counts) == 5, "counts", self.counts, "five numbers", "give those of segments II to VI")
        self.require_in_bounds()


@dataclass(frozen=True)
class Accuracy(Checked):
    """Allowed error of a run: mesh and steps follow from it."""

    end_force: float = parameter(
        1e-3,
        "1",
        "RMS error of the end forces over a run, relative to the largest",
        Bounds(1e-6, 1.0, "1e-3 suits most studies"),
    )
    loop: float = parameter(
        0.01, "m", "largest error of the loop's place", Bounds(1e-5, 1.0, "0.01 m suits most studies")
    )


@dataclass(frozen=True)
class Solver(Checked):
    """Time integration: generalized-alpha with step control.

    Newton's tolerance is in m for positions and rad for twist angles; of r' it is the change over the shortest element.
    """

    step_max: float = parameter(
        0.02, "s", "largest time step", Bounds(LEAST, 1.0, "10 ms suits most ropes"), tunable=True
    )
    step_min: float = parameter(
        1.0e-5, "s", "smallest time step; below it a step fails", Bounds(LEAST, "step_max", "use 1e-5 s"), tunable=True
    )
    tolerance: float = parameter(
        1.0,
        "1",
        "largest local error of a step over that allowed; 1e6: no step is shortened for it",
        Bounds(LEAST, 1e6, "use 1"),
        tunable=True,
    )
    newton_tolerance: float = parameter(
        3e-6, "1", "error that Newton's method may leave, in m and rad", Bounds(LEAST, 1e-3, "use 3e-6"), tunable=True
    )
    rho_inf: float = parameter(
        0.6,
        "1",
        "spectral radius of generalized-alpha at infinite frequency",
        Bounds(0.0, 1.0, "0.6 damps waves that the mesh cannot resolve"),
    )
    work_max: int = parameter(
        0,
        "",
        "Newton iterations of a communication step beyond which it gives up accuracy; 0: any number",
        Bounds(0, 100_000, "60 serves steps of 10 ms"),
        tunable=True,
    )
    kernels: KernelForm = choice(
        "auto",
        KernelForm,
        ("compiled where there is a compiler", "compiled, else an error", "interpreted, everywhere the same"),
        "0 compiled when possible, 1 compiled, 2 portable",
        "'auto' compiles when it can",
    )


@dataclass(frozen=True)
class Model(Checked):
    """Fidelity of the model."""

    fidelity: FidelityChoice = choice(
        "auto",
        FidelityChoice,
        (
            "the lowest fidelity that the case needs",
            "all: tension, torsion and lateral motion, coupled",
            "lateral motion in space, without torsion",
            "motion in the plane of the loop",
            "end forces of an inextensible rope in closed form, without bending and waves",
        ),
        "how much of the rope is computed: 0 auto, 1 torsional (all), 2 spatial, 3 planar, 4 rigid",
        "'auto' takes the lowest that serves",
    )
    force_tolerance: float = parameter(
        0.0,
        "1",
        "relative error of the end forces that auto may trade for speed",
        Bounds(0.0, 1.0, "use 0 to leave nothing out"),
    )


@dataclass(frozen=True)
class Inputs(Checked):
    """Trust in the given motions, and the way in which the rope's ends follow them."""

    given: Trusted = choice(
        "all",
        Trusted,
        (
            "position, speed and acceleration",
            "position and speed; the acceleration is estimated",
            "position alone; speed and acceleration are estimated",
            "speed alone; it is integrated, and the acceleration estimated",
        ),
        "trusted inputs: 0 all, 1 position and speed, 2 position alone, 3 speed alone",
        "'all' is exact where it can be had",
    )
    bandwidth: float = parameter(
        0.0,
        "rad/s",
        "rate at which a misfit is drawn in; 0: sqrt(accuracy.end_force gravity / accuracy.loop), some 1 rad/s",
        Bounds(0.0, 100.0, "0 suits most hosts"),
    )
    estimate_bandwidth: float = parameter(
        0.0,
        "rad/s",
        "bandwidth of estimated inputs; 0: a third of the rope's slowest axial wave",
        Bounds(0.0, 1e3, "0 suits most ropes"),
    )
    misfit_max: float = parameter(
        0.5,
        "m",
        "largest misfit of a position (m, rad) and of a speed (m/s, rad/s)",
        Bounds(LEAST, 1e4, "0.5 admits motions that a rope can follow"),
    )
    acceleration_max: float = parameter(
        100.0, "m/s2", "largest acceleration of an end, m/s2 or rad/s2", Bounds(LEAST, 1e6, "100 is beyond any hoist")
    )
    hold_max: float = parameter(
        1.0,
        "s",
        "how long the sample of a moving end may be repeated",
        Bounds(LEAST, 1e4, "1 s is beyond any slower part's step"),
    )


_WHERE = "0 is the rope's left end, 1 its right end"


@dataclass(frozen=True)
class Stations(Checked):
    """Places in the rope of the outputs station.*; they stay in it while it flows through the loop."""

    first: float = parameter(
        0.0, "1", "place of the first station over the rope's length, from its left end", Bounds(0.0, "last", _WHERE)
    )
    last: float = parameter(1.0, "1", "place of the last station, likewise", Bounds(0.0, 1.0, _WHERE))


@dataclass(frozen=True)
class Scene:
    """Constant data of a run."""

    rope: Rope = field(default_factory=Rope)
    layout: Layout = field(default_factory=Layout)
    left: Swivel = field(default_factory=Swivel)
    right: Swivel = field(default_factory=Swivel)
    mesh: Mesh = Mesh(kind="auto")
    accuracy: Accuracy = field(default_factory=Accuracy)
    solver: Solver = field(default_factory=Solver)
    model: Model = field(default_factory=Model)
    inputs: Inputs = field(default_factory=Inputs)
    station: Stations = field(default_factory=Stations)
    shaft: Shaft = field(default_factory=Shaft)

    def with_(self, **parts: Any) -> Scene:
        """Return a copy with some parts replaced, as in ``scene.with_(mesh=Mesh(kind="eem"))``."""
        return replace(self, **parts)


#: group of the interface -> the data class that has its parameters
GROUPS: dict[str, type[Any]] = {
    f"{name}.swivel" if kind is Swivel else name: kind
    for name, kind in get_type_hints(Scene).items()
    if kind is not Shaft
} | PARTS
#: words of parameters that choose one of a few, with their meanings, by the last two parts of the name; the place of a
#: word is its code
CHOICES = {
    f"{group.rpartition('.')[2]}.{name}": p.choices
    for group, kind in GROUPS.items()
    for name, p in parameters_of(kind).items()
    if p.choices
}
