"""Table of the rope's outputs, also those of the FMU: names, units and descriptions.

csrc/outputs/signals.c computes the values.
"""

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import NamedTuple

from rope_model.boundary.bodies import BODIES
from rope_model.physics.guard import CAUSES as CAUSES
from rope_model.physics.node import SIDES
from rope_model.physics.shaft import KINDS

SHAPE_POINTS = 81

_COORDINATES = tuple((axis, "m", f"coordinate {axis.upper()}") for axis in "xyz")


class Signal(NamedTuple):
    """Facts of an output."""

    unit: str  #: unit, '1' of a pure number
    description: str  #: meaning
    kind: str = "real"  #: real, integer or boolean


#: Names and facts of some outputs.
_Rows = Iterator[tuple[str, Signal]]


def _end_signals() -> _Rows:
    """Yield names and facts of the outputs on loads, swivel and added mass of both ends."""
    for side in SIDES:
        for k, axis in enumerate("xyz"):
            what = ("horizontal, in plane", "vertical", "horizontal, out of plane")[k]
            yield (
                f"{side}.f{axis}",
                Signal("N", f"force of the rope on the {side} conveyance, {what}"),
            )
        for axis in "xyz":
            yield (
                f"{side}.m{axis}",
                Signal("N.m", f"moment of the rope on the {side} conveyance about {axis.upper()}"),
            )
        yield f"{side}.fy_mean", Signal("N", f"mean of {side}.fy over the last communication step")
        yield (
            f"{side}.swivel.angle",
            Signal("rad", f"angle of the rope's {side} end against the conveyance"),
        )
        yield f"{side}.swivel.rate", Signal("rad/s", f"rate of {side}.swivel.angle")
        yield (
            f"{side}.swivel.torque",
            Signal("N.m", f"moment of the {side} swivel on the rope, about the tangent"),
        )
        yield f"{side}.swivel.slipping", Signal("1", f"whether the {side} swivel turns", "boolean")
        text = f"fall of {side}.fy per acceleration of the end that grows from 0 over the last communication step"
        yield f"{side}.added_mass", Signal("kg", text)


def _loop_signals() -> _Rows:
    """Yield names and facts of the outputs on place and form of the loop, and passages of its legs."""
    for axis in "xyz":
        yield f"loop.{axis}", Signal("m", f"{axis.upper()} of the rope's lowest point")
    yield (
        "loop.yaw",
        Signal("rad", "yaw of the loop at its lowest point, counted through full turns"),
    )
    yield (
        "loop.clearance",
        Signal("m", "smallest free distance between the legs, from one spacing above the bottom"),
    )
    text = "turns of one side (leg, conveyance and head ropes) about the other, over the height"
    yield "loop.turns", Signal("1", text)
    yield "loop.crossings", Signal("1", "passages of one side through the other so far")
    yield "loop.crossed_at", Signal("s", "time of the first passage; 0 before")
    yield "loop.crossed_y", Signal("m", "height of the first passage; 0 before")
    yield (
        "loop.overlap",
        Signal("m", "largest depth of the rope in itself so far, leg in leg or coil in coil"),
    )
    yield "loop.touched_at", Signal("s", "time at which the rope first touched itself; 0 before")
    yield "loop.touched_y", Signal("m", "height of loop.overlap")
    yield "loop.rise", Signal("m", "height of the lowest point over its quasi-static place")
    yield (
        "loop.sideways",
        Signal("m", "horizontal distance of the lowest point from midway between the ends"),
    )


def _guard_signals() -> _Rows:
    """Yield names and facts of the outputs on guards."""
    yield "guard.tripped", Signal("1", "whether a guard has tripped", "boolean")
    causes = ", ".join(f"{code} {cause}" for code, cause in enumerate(("none", *CAUSES)))
    yield "guard.cause", Signal("1", f"the first guard that has tripped: {causes}", "integer")
    yield "guard.time", Signal("s", "time of the first trip; 0 before")


def _stress_signals() -> _Rows:
    """Yield names and facts of the outputs on twist and stress."""
    for point in (*SIDES, "loop"):
        if point == "loop":
            where = "at the loop's lowest point"
        else:
            where = f"at the {point} end"
        yield f"{point}.twist", Signal("rad/m", f"twist {where}: change of the lay")
    yield (
        "stress.bending_max",
        Signal("Pa", "largest nominal bending stress, 32 EI kappa / (pi d^3)"),
    )
    yield "stress.torsion_max", Signal("Pa", "largest nominal torsional stress, 16 M / (pi d^3)")


def _energy_signals() -> _Rows:
    """Yield names and facts of the outputs on energies and their balance."""
    for name, what in (
        ("kinetic", "kinetic energy"),
        ("strain", "strain energy"),
        ("gravity", "potential energy of the weight, zero at height zero"),
        ("contact", "energy stored in contact"),
        ("total", "kinetic, strain, potential and contact energy"),
        ("work_ends", "work of the conveyances on the rope, blows included"),
        ("dissipated_material", "energy dissipated by material damping"),
        ("dissipated_swivel", "energy dissipated by swivel friction"),
        ("dissipated_contact", "energy dissipated in contact"),
        ("dissipated_wires", "energy dissipated between wires"),
        ("given_to_air", "energy given to the air; negative where it drives the rope"),
        ("nonconservative", "energy taken up by the difference of Qb and Qc"),
        ("transformations", "energy change by mesh transformations and rises of the fidelity"),
        ("residual", "residual of the energy balance: numerical dissipation is negative"),
    ):
        yield f"energy.{name}", Signal("J", what)


def _contact_signals() -> _Rows:
    """Yield names and facts of the outputs on contact with bodies, and of the rope with itself."""
    for kind in KINDS:
        words = "dividers" if kind == "divider" else kind.replace("_", " ")
        yield (
            f"contact.{kind}",
            Signal("N", f"pressure between rope and {words}, summed along the rope"),
        )
    yield "contact.rope", Signal("N", "pressure of the rope on itself, summed along it")
    for kind in (*KINDS, "rope"):
        text = f"impulse of contact.{kind} since the start; it hardly depends on contact.stiffness"
        yield f"contact.{kind}.impulse", Signal("N.s", text)


def _count_signals() -> _Rows:
    """Yield names and facts of the outputs on counts of work."""
    for name, what in (
        ("steps", "accepted time steps"),
        ("rejections", "rejected time steps and solutions of new meshes"),
        ("newton", "Newton iterations of time steps"),
        ("transformations", "mesh transformations"),
        ("swivel_events", "changes between stick and slip"),
    ):
        yield f"count.{name}", Signal("1", f"{what} since the start", "integer")


def _error_signals() -> _Rows:
    """Yield names and facts of the outputs on estimated errors."""
    text = "estimated RMS error of the end forces so far, relative to the largest"
    yield "status.end_force_error", Signal("1", text)
    yield "status.loop_error", Signal("m", "estimated largest error of the loop's place so far")
    text = "estimated RMS error of the bodies' pressure by mesh and steps as they press, relative to the largest"
    yield "status.contact_error", Signal("1", text)


def _input_signals() -> _Rows:
    """Yield names and facts of the outputs on misfits of given motions."""
    for name, unit in (("position", "m"), ("speed", "m/s"), ("acceleration", "m/s2")):
        text = f"misfit of given and followed {name} at an end so far"
        yield f"inputs.misfit.{name}", Signal(unit, f"largest {text}")
        yield f"inputs.misfit.{name}_rms", Signal(unit, f"RMS {text}")
    text = "communication steps so far that repeat the sample of a moving end"
    yield "inputs.repeated", Signal("1", text, "integer")


def _audit_signals() -> _Rows:
    """Yield names and facts of the outputs on the audit of momentum and steps, and accuracy that was given up."""
    for name, unit, what in (
        ("momentum", "N", "largest force missing in the balance of momentum so far"),
        ("moment", "N.m", "largest moment missing in the balance of angular momentum so far"),
        ("energy", "J", "largest change of energy.residual in a communication step so far"),
        ("force_change", "N", "largest change of an end's vertical force in a time step so far"),
        ("steps_per_period", "1", "fewest time steps in an axial period of the longer leg so far"),
        ("elements_per_bend", "1", "fewest elements in half a turn of the sharpest bend so far"),
    ):
        yield f"audit.{name}", Signal(unit, what)
    yield (
        "status.given_up",
        Signal("1", "time steps that gave up accuracy for solver.work_max", "integer"),
    )
    yield (
        "status.given_up_since",
        Signal("s", "time of the first step that gave up accuracy; 0 before"),
    )


def _clearance_signals() -> _Rows:
    """Yield names and facts of the outputs on distances from bodies."""
    for kind in KINDS:
        yield f"clearance.{kind}", Signal("m", f"least distance from {BODIES[kind]}; 1e6: none")
    for kind in KINDS:
        name = f"nearest.{kind}"
        yield f"{name}.clearance", Signal("m", f"smallest clearance.{kind} so far")
        yield f"{name}.time", Signal("s", f"time of {name}.clearance")
        yield (
            f"{name}.s",
            Signal("m", f"place of {name}.clearance along the rope, from its left end"),
        )
        yield f"{name}.y", Signal("m", f"height of {name}.clearance")
        yield f"{name}.touched_at", Signal("s", "time of the first contact; 0 before")


def _shape_signals() -> _Rows:
    """Yield names and facts of the outputs on the shape of the rope."""
    for name, unit, what in (
        *_COORDINATES,
        ("s", "m", "place along the rope, from its left end,"),
        ("tension", "N", "tension"),
        ("bending", "Pa", "nominal bending stress"),
        ("torsion", "Pa", "nominal torsional stress"),
    ):
        for i in range(1, SHAPE_POINTS + 1):
            yield (
                f"shape.{name}[{i}]",
                Signal(unit, f"{what} at point {i} of {SHAPE_POINTS} along the rope"),
            )


def _station_signals() -> _Rows:
    """Yield names and facts of the outputs on the stations, fixed in the rope."""
    for name, unit, what in (
        ("tension", "N", "tension"),
        ("curvature", "1/m", "curvature"),
        ("torque", "N.m", "torque about the tangent"),
        *_COORDINATES,
    ):
        for i in range(1, SHAPE_POINTS + 1):
            yield (
                f"station.{name}[{i}]",
                Signal(unit, f"{what} at station {i} of {SHAPE_POINTS}, fixed in the rope"),
            )


#: Groups of outputs, in the order of their value references.
_GROUPS = (
    _end_signals,
    _loop_signals,
    _guard_signals,
    _stress_signals,
    _energy_signals,
    _contact_signals,
    _count_signals,
    _error_signals,
    _input_signals,
    _audit_signals,
    _clearance_signals,
    _shape_signals,
    _station_signals,
)
#: Signal by name, in the order of the FMI interface
SIGNALS: dict[str, Signal] = dict(chain.from_iterable(group() for group in _GROUPS))


#: signals that can be differentiated with respect to the motions of the ends
LOADS = tuple(f"{side}.{kind}{axis}" for side in SIDES for kind in "fm" for axis in "xyz")
_CHEAP = tuple(name for name in SIGNALS if not name.endswith(".added_mass"))


def checked_names(names: Iterable[str] | None) -> tuple[str, ...]:
    """Return the names of signals; by default all but the added masses, which cost as much as a step."""
    if names is None:
        return _CHEAP
    if isinstance(names, str):
        raise ValueError(
            f"names = {names!r} is one text and must be a list of names of SIGNALS: "
            f"give [{names!r}]"
        )
    wanted = tuple(names)
    for name in wanted:
        if name not in SIGNALS:
            raise ValueError(
                f"{name!r} is no signal of the rope; SIGNALS has their names, left.fy for one"
            )
    return wanted
