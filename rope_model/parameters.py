"""Scene and its parameters in SI units, validated when they are made.

The source gives Qb and Qc of the default rope; everything marked [assumed] is ours, because the
source's tables are not available.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_type_hints

from rope_model.parameter_table import (
    LEAST_POSITIVE,
    Bounds,
    CrossCheck,
    ParameterGroup,
    angle_parameter,
    at_least,
    choice,
    parameter,
    parameters_of,
)
from rope_model.shaft_parameters import PARTS, Shaft
from rope_model.solver_parameters import Accuracy, Inputs, Mesh, Model, Solver, Stations

SwivelMode = Literal["locked", "free", "coulomb"]
SwivelStart = Literal["locked", "relaxed"]
Attachment = Literal["plumb", "clamped", "hinged"]

_POSITIVE = at_least(LEAST_POSITIVE, "check the rope's data sheet")
_TIMES_BETA_K = Bounds(0.0, 1e6, "use 1 for beta_K")


def _added_curvature(where: str) -> float:
    cure = "give 1/R of the bend of radius R, below 0 for the other sense"
    return parameter(0.0, "1/m", f"permanent curvature added {where}", Bounds(-10.0, 10.0, cure))


def _coupling(rope: Rope) -> tuple[Any, ...]:
    bound = (rope.Qa * rope.Qd) ** 0.5
    return (abs(rope.Qs) < bound,), rope.Qs, bound


@dataclass(frozen=True)
class Rope(ParameterGroup):
    """A round wire rope: T = Qa e + Qb tau, M = Qc e + Qd tau and c2 d^2 Qa e tau, bending moment EI kappa."""

    length: float = parameter(
        120.0,
        "m",
        "length between the two swivels",
        Bounds(LEAST_POSITIVE, 1e4, "give it in metres, as the rope's data sheet does"),
    )
    mass_per_length: float = parameter(8.0, "kg/m", "mass per length [assumed]", _POSITIVE)
    Qa: float = parameter(1.2e8, "N", "axial stiffness, T = Qa e + Qb tau [assumed]", _POSITIVE)
    Qb: float = parameter(
        2.336e5, "N.m", "tension per twist; default is the symmetric mean of the published pair"
    )
    Qc: float = parameter(
        2.336e5, "N.m", "torque per axial strain, M = Qc e + Qd tau; default as Qb"
    )
    Qd: float = parameter(3.3e3, "N.m2", "torsional stiffness [assumed]", _POSITIVE)
    EI: float = parameter(
        300.0,
        "N.m2",
        "bending stiffness [assumed]; 74 with full slip of the wires, 2.4e4 with none",
        _POSITIVE,
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
        at_least(
            LEAST_POSITIVE, "use a small one where only the tension presses the wires together"
        ),
    )
    slip_factor: float = parameter(
        0.02,
        "1",
        "growth of that moment with the tension, over the diameter [assumed]",
        Bounds(0.0, 1.0, "use 0 for a moment that does not depend on the tension"),
    )
    # rho d^2/8
    rhoJ: float = parameter(1.94e-3, "kg.m", "polar mass moment per length [assumed]", _POSITIVE)
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
        1.0, "1", "damping of torsion as a multiple of beta_K [assumed]", _TIMES_BETA_K
    )
    bending_damping: float = parameter(
        1.0, "1", "damping of bending as a multiple of beta_K [assumed]", _TIMES_BETA_K
    )
    diameter: float = parameter(
        0.044, "m", "rope diameter [assumed]", Bounds(LEAST_POSITIVE, 1.0, "give it in metres")
    )
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
        Bounds(
            0.0,
            10.0,
            "take a part of 1/R of the reel of radius R, and turn its direction for the other sense",
        ),
    )
    initial_curvature_angle: float = angle_parameter(
        "direction of that curvature at the left end, about the tangent; 0: as the loop bends"
    )
    curvature_left: float = _added_curvature("at the left end")
    curvature_1: float = _added_curvature("at 1/6 of the length")
    curvature_2: float = _added_curvature("at 2/6 of the length")
    curvature_middle: float = _added_curvature("at half the length")
    curvature_4: float = _added_curvature("at 4/6 of the length")
    curvature_5: float = _added_curvature("at 5/6 of the length")
    curvature_right: float = _added_curvature("at the right end")
    curvature_left_across: float = _added_curvature("at the left end, across")
    curvature_1_across: float = _added_curvature("at 1/6 of the length, across")
    curvature_2_across: float = _added_curvature("at 2/6 of the length, across")
    curvature_middle_across: float = _added_curvature("at half the length, across")
    curvature_4_across: float = _added_curvature("at 4/6 of the length, across")
    curvature_5_across: float = _added_curvature("at 5/6 of the length, across")
    curvature_right_across: float = _added_curvature("at the right end, across")

    cross_checks = (
        CrossCheck(
            "(Qb + Qc) / 2",
            "below sqrt(Qa Qd) = {:.4g} N m in size",
            "or the strain energy is not positive: check Qb, Qc, Qa and Qd",
            _coupling,
        ),
        CrossCheck(
            "EI_stick",
            "0 or above EI = {!r} N m2",
            "use 0 for no friction between the wires; EI is that of wires that slide",
            lambda rope: (
                ((rope.EI_stick == 0) + (rope.EI_stick > rope.EI) > 0,),
                rope.EI_stick,
                rope.EI,
            ),
        ),
    )

    @property
    def Qs(self) -> float:
        """Symmetric part of the coupling, N m."""
        return 0.5 * (self.Qb + self.Qc)

    @property
    def Qe(self) -> float:
        """Growth of the torsional stiffness per axial strain, N m^2."""
        # as C: libm's square may differ in the last bit
        return self.c2 * (self.diameter * self.diameter) * self.Qa

    @property
    def Qk(self) -> float:
        """Non-conservative part of the coupling, N m."""
        return 0.5 * (self.Qb - self.Qc)


@dataclass(frozen=True)
class Layout(ParameterGroup):
    """Positions of the ends: left at X = -spacing/2, right at +spacing/2; heights are inputs."""

    spacing: float = parameter(
        2.0,
        "m",
        "horizontal distance of the two suspension points [assumed]",
        at_least(LEAST_POSITIVE, "give the distance between the conveyances"),
    )
    gravity: float = parameter(
        9.81, "m/s2", "acceleration of free fall", at_least(LEAST_POSITIVE, "use 9.81")
    )


#: s, a release before any run: MAX_START_TIME of the simulator before 0
AT_START = -1e10


@dataclass(frozen=True)
class Swivel(ParameterGroup):
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
        (
            "the rope leaves it plumb",
            "it leaves a clamp as that leans, an input",
            "it leaves it as it likes",
        ),
        "how the rope leaves the {side} end: 0 plumb, 1 clamped as {side}.lean says, 2 hinged",
        "choose how the rope leaves it",
    )
    mean_diameter: float = parameter(
        0.090,
        "m",
        "mean diameter of the {side} swivel's bearing [assumed]",
        at_least(LEAST_POSITIVE, "take the bearing's d_m"),
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
        at_least(
            LEAST_POSITIVE,
            "give the rotor's, 0.05 as a rule: without inertia a release is a jump in spin",
        ),
    )
    release_time: float = parameter(
        AT_START,
        "s",
        "time until which the {side} swivel is locked; -1e10: not locked, from the start of any run",
    )
    start: SwivelStart = choice(
        "relaxed",
        SwivelStart,
        ("as it was hung up, held", "from where it has slid to, if it is released by then"),
        "where the {side} swivel starts: 0 locked, as it was hung up; 1 relaxed, where its friction can hold it",
        "choose where it starts",
    )


@dataclass(frozen=True)
class Scene:
    """Constant data of a run."""

    rope: Rope = field(default_factory=Rope)
    layout: Layout = field(default_factory=Layout)
    left: Swivel = field(default_factory=Swivel)
    right: Swivel = field(default_factory=Swivel)
    mesh: Mesh = field(default_factory=lambda: Mesh(kind="auto"))
    accuracy: Accuracy = field(default_factory=Accuracy)
    solver: Solver = field(default_factory=Solver)
    model: Model = field(default_factory=Model)
    inputs: Inputs = field(default_factory=Inputs)
    station: Stations = field(default_factory=Stations)
    shaft: Shaft = field(default_factory=Shaft)

    def with_(self, **parts: Any) -> Scene:
        """Return a copy with some parts replaced, as in ``scene.with_(mesh=Mesh(kind="eem"))``."""
        return replace(self, **parts)


#: data class of each group of the interface
PARAMETER_GROUPS: dict[str, type[Any]] = {
    f"{name}.swivel" if kind is Swivel else name: kind
    for name, kind in get_type_hints(Scene).items()
    if kind is not Shaft
} | PARTS
#: words of parameters that are choices, with their meanings, by the last two parts of the name; the
#: index of a word is its code
CHOICES = {
    f"{group.rpartition('.')[2]}.{name}": p.choices
    for group, kind in PARAMETER_GROUPS.items()
    for name, p in parameters_of(kind).items()
    if p.choices
}
