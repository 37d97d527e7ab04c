"""C text of the formulas that Python evaluates as they stand: the header formulas.h.

A formula is traced with a CasADi symbol for each number that it takes.  CasADi's simplifications are switched off
meanwhile: the C does the same operations in the same order as Python, and gives the same bits where libm does.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import accumulate, product
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

import casadi as ca

from rope_model.numerics import coupled_newton, generalized_alpha, newton
from rope_model.numerics.program import no_simplification
from rope_model.parameters import Accuracy, Inputs, Layout, Rope, Scene, Solver
from rope_model.physics import (
    accuracy,
    air,
    contact,
    contact_error,
    contact_places,
    element,
    elementary,
    energy_balance,
    estimates,
    frame,
    guard,
    hanging,
    hermite,
    inextensible,
    initial_curvature,
    outline,
    point_forces,
    rope_on_rope,
    shaft,
    stress,
    swivel,
    wire_element,
    wire_friction,
)
from rope_model.shaft_parameters import FAR, PARTS, Shaft
from rope_model.simulation import rigid, simulator
from rope_model.simulation.contact import shaft as shaft_search
from rope_model.simulation.ends import ends, following, misfit, paths, switching
from rope_model.simulation.ends.following import Following
from rope_model.simulation.ends.paths import EndMotion, EndPath
from rope_model.simulation.mesh import adaptation, mesh_fit, mesh_pattern
from rope_model.simulation.mesh import partition as mesh
from rope_model.simulation.messages import warning_rules
from rope_model.simulation.outputs import audit, diagnostics
from rope_model.simulation.outputs.audit import Audit
from rope_model.simulation.state import EnergyBalance
from rope_model.simulation.stepping import bracket, hang, statics, stepping
from rope_model.texts import c_string

#: prototype in C -> formula.  A structure of parameters is an object with the same fields in Python.  What is not
#: const, and last, takes the numbers of a formula that returns several
FORMULAS: dict[str, Callable[..., Any]] = {
    "double dot(const double a[3], const double b[3])": elementary.dot,
    "void conveyance_load(const double q[7], const double f[7], double torque, double load[6])": frame.conveyance_load,
    "double right_offset(const double left[3], const double right[3])": ends.right_offset,
    "Path path_resting(double t, const EndMotion *at)": EndPath.at_rest,
    "Following following_resting(double t, const EndMotion *at)": Following.at_rest,
    "Manner follow_manner(const Scene *scene, double trusted)": following.follow_manner,
    "Following follow_sample(const Following *now, const Manner *manner, double given_at, double h, "
    "const EndMotion *end)": following.follow_sample,
    "Path follow_path(const Path *path, const Following *now, double stop, double bandwidth)": following.follow_path,
    "void follow_limits(const Path *path, const Following *now, double limits[3][4])": following.follow_limits,
    "Following follow_account(const Following *now, const Path *path, const Manner *manner, const Rope *rope, "
    "double leg)": misfit.follow_account,
    "void sample_moves(const Manner *manner, double h, double ahead, const double sample[3], double moved[3])": (
        following.sample_moves
    ),
    "Path path_coasting(const Path *path, double t)": EndPath.at_constant_acceleration,
    "EndMotion path_at(const Path *path, double t)": EndPath.at,
    "double path_height(const Path *path, double t)": EndPath.height,
    "void path_motion(const Path *path, double t, double motion[3][4])": EndPath.motion,
    "void held_end(const Path *path, double t, double nominal_x, double sense, double angle, double rows[3][7])": (
        ends.held_end
    ),
    "void suspension_points(const Layout *layout, const EndMotion *left, const EndMotion *right, "
    "double points[2][3])": outline.suspension_points,
    "void node_values(double xi, double l, const double nodes[14], double values[7])": hermite.node_values,
    "void missing_load(double start, double stop, double s, double l, double old_s, double old_l, "
    "const double old[14], const double now[14], double load[14])": hermite.missing_load,
    "void hermite_shares(double xi, double l, double shares[4])": hermite.shares,
    "void hermite_products(double l, double products[10])": hermite.share_products,
    "double hermite_integral(double l, double r1, double s1, double r2, double s2)": hermite.integral,
    "double hermite_integral_to(double xi, double l, double r1, double s1, double r2, double s2)": (
        hermite.integral_to
    ),
    "double place_on_rope(double bottom, double reach, double part, double loop)": outline.place,
    "double least_squared_distance(const double a[6], const double b[6])": (outline.least_squared_distance),
    "double squared_distance(const double point[3], const double start[3], const double along[3])": (
        outline.squared_distance
    ),
    "void middle_of(double length, const double a[6], const double b[6], double middle[6])": outline.middle,
    "void place_between(double part, double length, const double a[6], const double b[6], double place[3])": (
        outline.place_between
    ),
    "double turns_of(double yaw, double line, double passages)": outline.turns,
    "void enclosing_box(double length, const double a[6], const double b[6], double box[6])": outline.enclosing_box,
    "double lowest_on(double known, double length, double a, double slope_a, double b, double slope_b)": outline.lowest,
    "double highest_on(double known, double length, double a, double slope_a, double b, double slope_b)": (
        outline.highest
    ),
    "void box_between(const double bounds[6], double box[6])": outline.box_between,
    "void heading(double yaw, double vector[2])": outline.heading,
    "double line_yaw(const double left[3], const double right[3])": outline.line_yaw,
    "void plane_between(const double left[3], const double right[3], const double start[3], const double direction[2], "
    "double normal[3])": outline.plane_between,
    "double side_gap(double side, double length, const double outer[6], const double inner[6], double top, "
    "const double start[3], const double normal[3], double diameter, double above)": outline.side_gap,
    "double least_advance(double length, const double a[6], const double b[6], const double direction[2])": (
        outline.least_advance
    ),
    "double turn_about_y(const double before[2], const double after[2])": outline.turn,
    "double body_distance(const double point[3], const Body *body)": shaft.distance,
    "double body_least_distance(const double point[3], const double extent[3], const Body *body)": (
        shaft.least_distance
    ),
    "Touch touch(const Contact *contact, double diameter, const Body *body, const double moves[3], "
    "const double point[3], const double speed[3], double cq, double cv)": contact.touch,
    "Probe contact_probe(double place, double l, const double a[6], const double b[6], double diameter, "
    "const Body *body)": contact_places.probe,
    "double contact_turning(const Probe *start, const Probe *stop)": contact_places.turning,
    "double contact_reaching(const Probe *outer, double inner, double level)": contact_places.reaching,
    "void contact_point(double part, double weight, double start, double stop, double point[2])": (
        contact_places.point_in
    ),
    "double places_of(double l, double diameter)": rope_on_rope.places,
    "double places_skipped(double distance, double diameter, double weight, double number)": (
        rope_on_rope.places_skipped
    ),
    "double most_places(double length, double elements, double diameter)": rope_on_rope.most_places,
    "double nearer_place(double xi, double l, const double point[3], const double a[6], const double b[6])": (
        rope_on_rope.nearer_place
    ),
    "Touch rope_touch(const Contact *contact, double diameter, const double apart[3], const double speed[3], "
    "double cq, double cv)": rope_on_rope.rope_touch,
    "double part_of_time(double start, double stop, double t)": point_forces.part_of_time,
    "void point_load(const double place[3], const double force[3], double load[6])": point_forces.point_load,
    "double largest_motion(double longest, const double q[6], const double before[6])": contact.largest_motion,
    "double moved_by(double corrections, double longest, double shortest)": contact.moved_by,
    "AirLaw air_law(const Air *air, double diameter, double spacing)": air.air_law,
    "double wire_stiffness(const Rope *rope)": wire_friction.wire_stiffness,
    "double slip_curvature(const Rope *rope, double stiffness, double e, double tau)": wire_friction.slip_curvature,
    "void section_at(double xi, double l, const double nodes[14], double section[7])": wire_friction.section_at,
    "Slid wire_slide(const double before[10], const double now[7], double k0)": wire_friction.slide,
    "void directors(double angle, double l, const double nodes[14], const double start[3], double found[12])": (
        initial_curvature.directors
    ),
    "Body lining_body(const Lining *lining)": shaft.lining,
    "Body conveyance_body(const Conveyance *conveyance, const double end[3])": shaft.conveyance,
    "Body head_ropes_body(const HeadRopes *head_ropes, const Conveyance *conveyance, const double end[3])": (
        shaft.head_ropes
    ),
    "Body divider_body(const Divider *divider)": shaft.divider,
    "Body floor_body(const Sump *sump)": shaft.floor,
    "double guarded(const Guard *guard)": guard.guarded,
    "double loop_height(const Rope *rope, const Layout *layout, double lowest, double left, double right)": (
        guard.loop_height
    ),
    "double sideways(const double point[3], const double left[3], const double right[3])": guard.sideways,
    "double off_plumb(double height, const double a[3], const double b[3], const double end[3])": guard.off_plumb,
    "GuardState watch(const Guard *guard, const GuardState *state, double t, const double seen[5])": guard.watch,
    "void material_values(const Rope *rope, double torsional, const double strains[3], double values[4])": (
        stress.material_values
    ),
    f"void element_parameters(const Rope *rope, double gravity, double P[{len(element.PARAMETERS)}])": (
        element.parameters
    ),
    "EnergyBalance with_energies(const EnergyBalance *energy_balance, const double balance[9], double contact)": (
        energy_balance.with_energies
    ),
    "EnergyBalance account_of_step(const EnergyBalance *energy_balance, double h, const double before[2], "
    "const double now[2], const double losses[4], double wires, double air)": (energy_balance.after_step),
    "double energy_total(const EnergyBalance *energy_balance)": energy_balance.total,
    "double energy_residual(const EnergyBalance *energy_balance)": energy_balance.residual,
    "Flow rigid_flow(double v1, double v2)": inextensible.flow,
    "Pull rigid_pull(const Rope *rope, const Layout *layout, const EndMotion *left, const EndMotion *right)": (
        inextensible.pull
    ),
    "double rigid_lowest(const Pull *pull)": inextensible.lowest,
    "void rigid_energies(const Rope *rope, const Layout *layout, const Pull *pull, const EndMotion *left, "
    "const EndMotion *right, double energies[2])": inextensible.energies,
    "double rigid_tension_at(double rho, double gravity, const Flow *rate, double at_end, double rise, double s)": (
        inextensible.tension
    ),
    "double loop_width(const Scene *scene)": estimates.loop_width,
    "Hanging hanging_shape(double length, double middle, double width, double cell)": hanging.hanging_shape,
    "void hanging_row(const Hanging *hanging, const double left[3], const double across[3], double s, double row[7])": (
        hanging.node_row
    ),
    "FittedMesh fit_elements(const Scene *scene, double loop_error, double decades)": mesh_fit.fit_elements,
    "void newton_coefficients(const Coefficients *method, double h, double c[3])": (
        generalized_alpha.newton_coefficients
    ),
    "void prediction_weights(const Coefficients *method, double h, double recentring, double ahead, "
    "double weights[6])": (generalized_alpha.prediction_weights),
    "void auxiliary_weights(const Coefficients *method, double recentring, double weights[4])": (
        generalized_alpha.auxiliary_weights
    ),
    "double recentring_time(const Coefficients *method, double h, double before)": generalized_alpha.recentring_time,
    "double local_error(const Coefficients *method, double h, double change)": generalized_alpha.local_error,
    "double trial_place(const Bracket *bracket, double width)": bracket.trial_place,
    "Bracket narrowed(const Bracket *bracket, double x, double value)": bracket.narrowed,
    "double relaxation(double change, double last)": statics.relaxation,
    "StepLimits step_limits(const Scene *scene, const ErrorSums *sums, double bottom, double apart, "
    "double error_constant)": (accuracy.step_limits),
    "ErrorSums add_errors(const Scene *scene, const ErrorSums *sums, double bottom, double apart, double h, "
    "double constant, const double paces[2], double place, double force)": accuracy.add_errors,
    "double step_error(const StepLimits *limits, double h, double place, double strain)": accuracy.step_error,
    "NextStep next_step(const Solver *solver, double h, double step_next, double error, double rejected, double t, "
    "double calm_since)": accuracy.next_step,
    "double most_work(double interval, double step_max)": stepping.most_work,
    "double parts_of(double way, double step_next, double left)": accuracy.parts_of,
    "ContactSums add_contact(const Scene *scene, const ContactSums *sums, double h, const double pressures[6], "
    "double longest)": contact_error.add_contact,
    "double contact_error(const ContactSums *sums)": contact_error.contact_error,
    "double with_contact_at_ends(double error, const ContactSums *sums, double time, double force)": (
        contact_error.with_contact_at_ends
    ),
    "double with_contact_of_place(const Scene *scene, double error, const ContactSums *sums)": (
        contact_error.with_contact_of_place
    ),
    "double end_force_error(const Rope *rope, const ErrorSums *sums)": accuracy.end_force_error,
    "double with_misfit(double error, const ErrorSums *sums, const Following *left, const Following *right)": (
        misfit.with_misfit
    ),
    "double with_drift(double error, const Following *left, const Following *right)": misfit.with_drift,
    "double loop_error(const Scene *scene, const ErrorSums *sums, double fine, double grading_length)": (
        accuracy.loop_error
    ),
    "double friction_moment(double mu, double mean_diameter, double seal_moment, double tension)": (
        swivel.friction_moment
    ),
    "void end_load(const double q[7], const double f[7], double torque, double load[6])": audit.end_load,
    "double axial_share(const Rope *rope, double bottom, double h)": audit.axial_share,
    "void audit_values(const Audit *audit, double values[6])": audit.signal_values,
    "Audit audit_after_step(const Audit *audit, const Coefficients *method, double h, double recentring, "
    "const double load[6], double force, double change, double share)": audit.after_step,
    "Audit audit_after_interval(const Audit *audit, double h, double mass, double gravity, const double sums[9], "
    "const double about[3], double residual, double bend)": audit.after_interval,
}
#: results: structures that C has from here
DEFINED_HERE: tuple[type[Any], ...] = (
    inextensible.Flow,
    inextensible.Pull,
    hanging.Hanging,
    bracket.Bracket,
    mesh_fit.FittedMesh,
    generalized_alpha.Coefficients,
    accuracy.StepLimits,
    accuracy.NextStep,
    shaft.Body,
    air.AirLaw,
    contact.Touch,
    contact_places.Probe,
    wire_friction.Slid,
    following.Manner,
)
#: structures that a formula may take or return
STRUCTURES: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        *(Rope, Layout, Scene, Solver, *PARTS.values(), EndMotion),
        *(EnergyBalance, accuracy.ErrorSums, contact_error.ContactSums, Audit, guard.GuardState, Following),
        *DEFINED_HERE,
    )
} | {"Path": EndPath}
#: numbers of the formulas and of the control flow
CONSTANTS: dict[str, float | tuple[Any, ...]] = {
    "PARAMETERS": len(element.PARAMETERS),
    "FARTHEST_START": simulator.FARTHEST_START,
    "MOST_STEPS": simulator.MOST_STEPS,
    "STEP_WORK": stepping.STEP_WORK,
    "LARGEST_GROWTH": generalized_alpha.LARGEST_GROWTH,
    "EVENT_WIDTH": switching.EVENT_WIDTH,
    "CHATTER_TIME": switching.CHATTER[1],
    "RESTS_BELOW": paths.RESTS_BELOW,
    "MESH_LATEST": mesh.LATEST,
    "DUE_EARLY": mesh_pattern.DUE_EARLY,
    "LEG_LENGTHS": mesh.LEG_LENGTHS,
    "GRADING": mesh.GRADING,
    "RELAXATION_TIME": adaptation.RELAXATION_TIME,
    "SETTLING_TIME": rigid.SETTLING_TIME,
    "SETTLING_TOLERANCE": rigid.NEWTON_TOLERANCE,
    "DIFFERENCE": rigid.DIFFERENCE,
    "SETTLED": statics.SETTLED,
    "BALANCED": statics.BALANCED,
    "CURVATURE_STEPS": hang.CURVATURE_STEPS,
    "TWIST_STEP": hang.TWIST_STEP,
    "LEAST_TWIST_STEP": hang.LEAST_TWIST_STEP,
    "MOST_TURN": hang.MOST_TURN,
    "MOST_CORRECTIONS": hang.MOST_CORRECTIONS,
    "WIRE_CELLS": (0.0, *accumulate(element.WEIGHTS)),
    "ACCEPT_BELOW": accuracy.ACCEPT_BELOW,
    "FADE_ERROR": mesh_fit.FADE_ERROR,
    "MESH_SHARE": mesh_fit.MESH_SHARE,
    "DUE": mesh_fit.DUE,
    "FAR": FAR,
    "NEVER": guard.NEVER,
    "RESOLUTION": shaft_search.RESOLUTION,
    "TURNED_FAR": shaft_search.TURNED_FAR,
    "PIECES": diagnostics.PIECES,
    "FINE": diagnostics.FINE,
    "OUTLINE": diagnostics.OUTLINE,
    "LOOK_EVERY": shaft_search.LOOK_EVERY,
    "YAWED_FAR": warning_rules.YAWED_FAR,
    "LOOK_AHEAD": contact.LOOK_AHEAD,
    "OWN_LENGTH": contact.OWN_LENGTH,
    "MOST_PLACES": rope_on_rope.MOST_PLACES,
    "APART": rope_on_rope.APART,
    "MOST_STRANDS": rope_on_rope.MOST_STRANDS,
    "PROBES": len(rope_on_rope.PROBES),
    "PROBE_PLACES": rope_on_rope.PROBES,
    "CORRECTIONS": rope_on_rope.CORRECTIONS,
    "DIRECTOR_START": initial_curvature.START,
    "WIRE_POINTS": len(element.POINTS),
    "WIRE_PLACES": element.POINTS,
    "WIRE_WEIGHTS": element.WEIGHTS,
    "WIRE_MEMORY": wire_friction.MEMORY,
    "WIRE_HISTORY": wire_element.HISTORY,
    "WIRE_LATEST": wire_element.LATEST,
    "NEWTON_SMOOTH": tuple(newton.SMOOTH),
    "NEWTON_KINKED": tuple(newton.KINKED),
    "NEWTON_HUGE": newton.HUGE,
    "NEWTON_TEXTS": tuple(status.text for status in newton.NewtonStatus),
    "GRADIENT_STEPS": coupled_newton.STEPS,
    "GRADIENT_LEFT": coupled_newton.LEFT,
    "CONTACT_CELLS": contact_places.CELLS,
    "CONTACT_HALVINGS": contact_places.HALVINGS,
    "CONTACT_STEPS": contact_places.STEPS,
    "CONTACT_LEVELS": contact_places.LEVELS,
    "CONTACT_POINTS": len(contact_places.PARTS),
    "CONTACT_PARTS": contact_places.PARTS,
    "CONTACT_WEIGHTS": contact_places.WEIGHTS,
}

_HEAD = """\
/* Formulas: generated by rope_model.codegen.formulas from the Python functions that are named above each.  Arrays that
   take results do not overlap arguments. */
#ifndef FORMULAS_H
#define FORMULAS_H

#include <math.h>

#include "core.h"

/* x where they are equal, or when y is not a number */
static inline double larger(double x, double y) {
    return y > x ? y : x;
}

static inline double smaller(double x, double y) {
    return y < x ? y : x;
}
"""
_CHOICE, _LOGIC, _COMPARISON, _SUM, _PRODUCT, _SIGN, _ATOM = range(7)
_OPERATORS = {ca.OP_ADD: ("+", _SUM), ca.OP_SUB: ("-", _SUM), ca.OP_MUL: ("*", _PRODUCT), ca.OP_DIV: ("/", _PRODUCT)}
_LOGICAL = {ca.OP_AND: "&&", ca.OP_OR: "||"}
_OPERATORS |= {ca.OP_LT: ("<", _COMPARISON), ca.OP_LE: ("<=", _COMPARISON)}
_OPERATORS |= {ca.OP_EQ: ("==", _COMPARISON), ca.OP_NE: ("!=", _COMPARISON)}
_CALLS = {
    ca.OP_SQRT: "sqrt",
    ca.OP_CEIL: "ceil",
    ca.OP_FLOOR: "floor",
    ca.OP_EXP: "exp",
    ca.OP_LOG: "log",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_ATAN2: "atan2",
    ca.OP_HYPOT: "hypot",
    ca.OP_FABS: "fabs",
    ca.OP_POW: "pow",
    ca.OP_CONSTPOW: "pow",
    ca.OP_COPYSIGN: "copysign",
    ca.OP_FMAX: "larger",
    ca.OP_FMIN: "smaller",
}
_INFINITE = {math.inf: "INFINITY", -math.inf: "-INFINITY"}
#: an expression longer than this gets a name
_LONG = 80


class Argument(NamedTuple):
    """A parameter of a prototype: constant or not, type, name and lengths, () for a number."""

    constant: bool
    kind: str
    name: str
    shape: tuple[int, ...]


class _Text(NamedTuple):
    """An expression, and how tightly it binds."""

    text: str
    binds: int
    #: parts of elementary.where, a sum of two: condition and value of the one, value of the other
    condition: str = ""
    value: str = ""

    def within(self, least: int) -> str:
        """Return the text as an operand of an operator that binds ``least``."""
        return self.text if self.binds >= least else f"({self.text})"


def formulas_code() -> str:
    """The text of formulas.h."""
    structures = (_definition(kind) for kind in DEFINED_HERE)
    functions = (function_code(prototype, formula) for prototype, formula in FORMULAS.items())
    constants = "".join(f"#define {name} {_value(value)}\n" for name, value in CONSTANTS.items())
    return "\n".join((_HEAD, constants, *structures, *functions, "#endif\n"))


def _value(value: float | str | tuple[Any, ...]) -> str:
    if isinstance(value, tuple):
        return f"{{{', '.join(map(_value, value))}}}"
    return c_string(value) if isinstance(value, str) else repr(value)


def _definition(kind: type[Any]) -> str:
    members = "".join(f"    double {name}{_lengths(hint)};\n" for name, hint in get_type_hints(kind).items())
    return f"/* {kind.__module__}.{kind.__name__} */\ntypedef struct {{\n{members}}} {kind.__name__};\n"


def shape_of(hint: Any) -> tuple[int, ...]:
    """() of a number, lengths of a tuple of numbers or of tuples alike."""
    parts = get_args(hint) if get_origin(hint) is tuple else ()
    return (len(parts), *shape_of(parts[0])) if parts else ()


def _lengths(hint: Any) -> str:
    return "".join(f"[{n}]" for n in shape_of(hint))


def function_code(prototype: str, formula: Callable[..., Any]) -> str:
    """The C function of a formula."""
    match = re.fullmatch(r"(\w+) \w+\((.*)\)", prototype)
    assert match, prototype
    result, arguments = match[1], [argument_of(text) for text in match[2].split(", ")]
    given = arguments[:-1] if result == "void" else arguments
    with no_simplification():
        symbols = [symbols_of(argument) for argument in given]
        inputs = [x for s in symbols for x in _numbers(s)]  # before objects keep results of the formula
        traced = ca.Function("formula", inputs, _numbers(formula(*symbols)))
        lines, texts = statements(traced)
    if result == "void":
        taker = arguments[-1]
        places = product(*map(range, taker.shape))
        lines += [f"{taker.name}{''.join(f'[{k}]' for k in at)} = {x};" for at, x in zip(places, texts, strict=True)]
    elif result == "double":
        lines += [f"return {texts[0]};"]
    else:
        lines += [f"const {result} result = {_initializer(STRUCTURES[result], texts)};", "return result;"]
    body = "".join(f"    {line}\n" for line in lines)
    return f"/* {formula.__module__}.{formula.__qualname__} */\nstatic inline {prototype} {{\n{body}}}\n"


def argument_of(text: str) -> Argument:
    """The argument that a prototype declares by ``text``."""
    match = re.fullmatch(r"(const )?(\w+) \*?(\w+)((?:\[\d+\])*)", text)
    assert match, text
    return Argument(bool(match[1]), match[2], match[3], tuple(int(n) for n in re.findall(r"\d+", match[4])))


def symbols_of(argument: Argument) -> Any:
    """Arguments of the formula: symbols with the names that the numbers have in C."""
    if argument.kind != "double":
        return structure_at(STRUCTURES[argument.kind], f"{argument.name}->")
    return _array(argument.name, argument.shape)


def _array(name: str, shape: tuple[int, ...]) -> Any:
    if not shape:
        return ca.SX.sym(name)
    return tuple(_array(f"{name}[{k}]", shape[1:]) for k in range(shape[0]))


def structure_at(kind: type[Any], prefix: str) -> Any:
    """An object of ``kind``, its numbers replaced by symbols, without its other members."""
    values: dict[str, Any] = {}
    for name, hint in get_type_hints(kind).items():
        if hint is float:
            values[name] = ca.SX.sym(prefix + name)
        elif get_origin(hint) is tuple:
            values[name] = _array(prefix + name, shape_of(hint))
        elif hint in (Rope, Layout, Accuracy, Inputs, Shaft, *PARTS.values()):
            values[name] = structure_at(hint, f"{prefix}{name}.")
    if issubclass(kind, tuple):
        return kind(**values)
    symbolic = object.__new__(kind)  # its checks are for numbers
    vars(symbolic).update(values)
    return symbolic


def _numbers(x: Any) -> list[ca.SX]:
    """The numbers of tuples, of objects and of these nested."""
    if isinstance(x, ca.SX | float):
        return [ca.SX(x)]
    return [number for part in (x if isinstance(x, tuple) else vars(x).values()) for number in _numbers(part)]


def texts_of(values: Sequence[Any]) -> tuple[list[str], list[str]]:
    """Return ``statements`` of expressions of symbols."""
    expressions = [ca.SX(value) for value in values]
    return statements(ca.Function("values", ca.symvar(ca.vertcat(*expressions)), expressions))


def statements(f: ca.Function, kind: str = "double") -> tuple[list[str], list[str]]:
    """Lines that name repeated terms, and the expressions of the results.

    Numbers are of the type ``kind``: of vectors V a quotient is a product with the reciprocal, computed once for each
    divisor, as division is what costs most.
    """
    inputs = [[x.name() for x in ca.vertsplit(f.sx_in(i))] for i in range(f.n_in())]
    uses = _uses(f)
    values: dict[int, _Text] = {}  # what each place of CasADi's work vector holds now
    results: dict[tuple[int, ...], str] = {}
    reciprocals: dict[str, _Text] = {}
    lines: list[str] = []

    def named(text: str) -> _Text:
        lines.append(f"const {kind} t{len(lines)} = {text};")
        return _Text(f"t{len(lines) - 1}", _ATOM)

    def reciprocal(x: _Text) -> _Text:
        if is_number(x.text):
            return _Text(repr(1.0 / float(x.text)), _SIGN)
        if x.text not in reciprocals:
            reciprocals[x.text] = named(f"1.0 / {x.within(_PRODUCT + 1)}")
        return reciprocals[x.text]

    for k in range(f.n_instructions()):
        operation, sources, target = f.instruction_id(k), f.instruction_input(k), f.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            results[tuple(target)] = values[sources[0]].text
            continue
        if operation == ca.OP_CONST:
            value = f.instruction_constant(k)
            text = "PI" if value == math.pi else _INFINITE.get(value, repr(value))
            made = _Text(text, _SIGN if value < 0 else _ATOM)
        elif operation == ca.OP_INPUT:
            made = _Text(inputs[sources[0]][sources[1]], _ATOM)
        else:
            operands = [values[s] for s in sources]
            if kind == "V" and operation in (ca.OP_DIV, ca.OP_INV):
                *above, below = operands
                made = _expression(ca.OP_MUL, [*above, reciprocal(below)], kind) if above else reciprocal(below)
            else:
                made = _expression(operation, operands, kind)
            if (uses[k] > 1 or len(made.text) > _LONG) and not made.value and operation != ca.OP_NOT:
                made = named(made.text)
        values[target[0]] = made
    return lines, [results[place] for place in sorted(results)]


def is_number(text: str) -> bool:
    """Whether an expression is a number as it stands."""
    return re.fullmatch(r"-?[\d.]+(e[-+]\d+)?", text) is not None


def _uses(f: ca.Function) -> Counter[int]:
    """Number of uses of the result of each instruction."""
    made_by: dict[int, int] = {}
    uses: Counter[int] = Counter()
    for k in range(f.n_instructions()):
        if f.instruction_id(k) not in (ca.OP_INPUT, ca.OP_CONST, ca.OP_NOT):
            uses.update(made_by[s] for s in f.instruction_input(k))
        if f.instruction_id(k) != ca.OP_OUTPUT:
            made_by[f.instruction_output(k)[0]] = k
    return uses


def _expression(operation: int, operands: Sequence[_Text], kind: str) -> _Text:
    if operation == ca.OP_NEG:
        return _Text(f"-{operands[0].within(_ATOM)}", _SIGN)
    if operation in _CALLS:
        name = _CALLS[operation] if kind == "double" else f"{_CALLS[operation].upper()}_{kind}"
        return _Text(f"{name}({', '.join(x.text for x in operands)})", _ATOM)
    if operation in (ca.OP_SQ, ca.OP_TWICE):
        twice = _Text("2.0", _ATOM) if operation == ca.OP_TWICE else operands[0]
        operation, operands = ca.OP_MUL, [twice, operands[0]]
    if operation == ca.OP_NOT:
        return _Text(f"!{operands[0].within(_ATOM)}", _SIGN)
    if operation == ca.OP_IF_ELSE_ZERO:
        condition, value = (x.within(_COMPARISON) for x in operands)
        return _Text(f"{condition} ? {value} : 0.0", _CHOICE, condition, value)
    left, right = operands
    if operation in _LOGICAL:  # compilers want brackets where both meet
        return _Text(f"{left.within(_COMPARISON)} {_LOGICAL[operation]} {right.within(_COMPARISON)}", _LOGIC)
    if left.value and right.value:
        return _Text(f"{left.condition} ? {left.value} : {right.value}", _CHOICE)
    sign, binds = _OPERATORS[operation]
    # the right side is computed first
    return _Text(f"{left.within(binds)} {sign} {right.within(binds + 1)}", binds)


def _initializer(kind: type[Any], texts: list[str]) -> str:
    """The members of ``kind`` in braces."""
    rest = iter(texts)

    def member(shape: tuple[int, ...]) -> str:
        return f"{{{', '.join(member(shape[1:]) for _ in range(shape[0]))}}}" if shape else next(rest)

    return f"{{{', '.join(member(shape_of(hint)) for hint in get_type_hints(kind).values())}}}"
