"""Rules of warnings that numbers decide: tables for simulation.messages.result_warnings and its C."""

from __future__ import annotations

import math
from typing import Any

from rope_model.physics.accuracy import length_for, mesh_error, turned_by_mesh
from rope_model.physics.elementary import both, either, floor, smaller, where
from rope_model.physics.estimates import bending_length, coupling_torque, curvature_torque, twist_torque
from rope_model.shaft_parameters import FAR
from rope_model.simulation.ends.following import FEWEST_BREAKS
from rope_model.simulation.mesh.mesh_fit import LONGEST, NATURAL_RADIUS
from rope_model.simulation.mesh.mesh_pattern import fine_share
from rope_model.simulation.messages import warning_messages
from rope_model.simulation.messages.fidelity_rules import carries_torque
from rope_model.simulation.messages.rules import Rules
from rope_model.simulation.outputs.audit import (
    FEWEST_ELEMENTS,
    FEWEST_STEPS,
    LARGE_CHANGE,
    MISSING_FORCE,
    MISSING_MOMENT,
    axial_step,
    signal_values,
)

#: rad: yaw of a loop that is turned over
HALF_A_TURN = math.pi
#: rad: yaw at rest of a rope whose data should be looked at
YAWED_FAR = math.pi / 6
#: s: steps beyond it are too long for motions that are extrapolated: in a winding end forces are 2 % off at 50 ms
LONGEST_EXTRAPOLATION = 0.02
#: samples of an end that moves from which rounding can be told: the first of a trip lie on every grid
FEWEST_SAMPLES = 20
#: m: positions rounded to less do no harm
COARSEST_ROUNDING = 0.99e-4
#: m/s: a rope with less kinetic energy than all of it has at this speed is at rest
REST_SPEED = 1e-3


def rests(scene: Any, state: Any) -> Any:
    """Whether the rope is at rest."""
    data = scene.rope
    return state.energy_balance.kinetic < 0.5 * data.mass_per_length * data.length * (REST_SPEED * REST_SPEED)


def leaves_out(scene: Any, state: Any) -> Any:
    """Whether the rope moves in a way that its fidelity leaves out."""
    blown = both(state.fidelity == "planar", scene.shaft.air.density > 0, abs(scene.shaft.air.vz) > 0)
    return either(state.fidelity == "rigid", carries_torque(scene), blown)


def yawed_far_at_rest(scene: Any, state: Any, yaw: Any) -> Any:
    """Whether the loop hangs out of its ends' plane, by ``yaw`` (rad), at rest, with nothing worse to say of it."""
    free = both(state.crossing.number == 0, state.crossing.overlap == 0, abs(yaw) < HALF_A_TURN)
    return both(state.fidelity == "torsional", free, rests(scene, state), abs(yaw) > YAWED_FAR)


def _sides_passed(scene: Any, state: Any) -> tuple[Any, ...]:
    crossing, open_to = state.crossing, scene.shaft.contact.rope_stiffness == 0
    return both(crossing.number > 0, open_to), crossing.number, crossing.since, crossing.y


def _sides_passed_in_spite(scene: Any, state: Any) -> tuple[Any, ...]:
    crossing = state.crossing
    return crossing.number > 0, crossing.number, crossing.since, crossing.y, scene.shaft.contact.rope_stiffness


def _turned_around(scene: Any, state: Any, yaw: Any) -> tuple[Any, ...]:
    # a rope without passages is turned as far over its height as its loop; passages have their own warning
    return both(state.crossing.number == 0, abs(yaw) >= HALF_A_TURN), yaw / (2 * math.pi)


def _legs_touch(scene: Any, state: Any, yaw: Any) -> tuple[Any, ...]:
    applies, *numbers = _legs_press(scene, state, yaw)
    return both(applies, scene.shaft.contact.rope_stiffness == 0), *numbers


def _legs_press(scene: Any, state: Any, yaw: Any) -> tuple[Any, ...]:
    x = state.crossing
    return both(x.number == 0, x.overlap > 0), x.overlap, x.touched_at, x.touched_y


def _torque_of_coupling(scene: Any, turned: Any) -> tuple[Any, ...]:
    coupling, curvature, installed, ends = _torques(scene, turned)
    largest = both(coupling >= curvature, coupling >= installed, coupling >= ends)
    return largest, scene.rope.Qb, scene.rope.Qc


def _torque_of_curvature(scene: Any, turned: Any) -> tuple[Any, ...]:
    _, curvature, installed, ends = _torques(scene, turned)
    largest = both(curvature >= installed, curvature >= ends)
    return largest, scene.rope.initial_curvature, scene.rope.initial_curvature_angle


def _torque_of_twist(scene: Any, turned: Any) -> tuple[Any, ...]:
    *_, installed, ends = _torques(scene, turned)
    return installed >= ends, scene.rope.installed_twist


def _torque_of_ends(scene: Any, turned: Any) -> tuple[Any, ...]:
    return True, turned


def _torques(scene: Any, turned: Any) -> tuple[Any, Any, Any, Any]:
    """Torques by coupling, permanent curvature, installed twist, and ends that twist the rope by ``turned`` (rad)."""
    rope = scene.rope
    # the installed twist is part of the last
    ends = twist_torque(rope, turned) * (1 - 1e-9)
    coupling = coupling_torque(rope, scene.layout.gravity)
    return coupling, curvature_torque(rope), twist_torque(rope, rope.installed_twist), ends


def _other_rests(scene: Any, state: Any) -> tuple[Any, ...]:
    return both(state.snapped_at != 0, rests(scene, state)), state.snapped_at


def _forces_missing(scene: Any, state: Any) -> tuple[Any, ...]:
    missing, bound = state.audit.missing_force, MISSING_FORCE * state.audit.force
    return missing > bound, missing, bound


def _moments_missing(scene: Any, state: Any) -> tuple[Any, ...]:
    missing, bound = state.audit.missing_moment, MISSING_MOMENT * state.audit.force * scene.layout.spacing
    return missing > bound, missing, bound


def _shown_below(number: Any) -> Any:
    """``number``, cut to two decimals: a number below a bound of less than 10 then looks different from it."""
    return floor(100.0 * number) / 100.0


def _waves_unresolved(scene: Any, state: Any) -> tuple[Any, ...]:
    audit, steps = state.audit, signal_values(state.audit)[4]
    applies = both(audit.share * FEWEST_STEPS > 1.0, audit.force_change > LARGE_CHANGE * audit.force)
    return applies, audit.force_change, _shown_below(steps), FEWEST_STEPS, axial_step(scene.rope)


def _bend_unresolved(scene: Any, state: Any) -> tuple[Any, ...]:
    elements = signal_values(state.audit)[5]
    return both(state.audit.bend > 0, elements < FEWEST_ELEMENTS), _shown_below(elements), FEWEST_ELEMENTS


def _positions_rounded(scene: Any, following: Any, step: Any) -> tuple[Any, ...]:
    x = following
    on_grid = both(x.samples >= FEWEST_SAMPLES, x.grid >= COARSEST_ROUNDING, x.grid < 1)
    return both(scene.inputs.given != "speed", on_grid, x.position > 0.25 * x.grid), x.grid


def _samples_repeated(scene: Any, following: Any, step: Any) -> tuple[Any, ...]:
    return following.repeats > 0, following.repeats, following.sent_every, step


def _table_too_coarse(scene: Any, following: Any, step: Any) -> tuple[Any, ...]:
    return both(following.breaks >= FEWEST_BREAKS, following.grid < COARSEST_ROUNDING), following.table_every, step


def _motion_misfits(scene: Any, following: Any, step: Any) -> tuple[Any, ...]:
    x = following
    disturbs = x.acceleration > scene.accuracy.end_force * scene.layout.gravity
    return both(scene.inputs.given == "all", disturbs), x.position, x.speed, x.acceleration


def _loop_unresolved(scene: Any, state: Any) -> tuple[Any, ...]:
    mesh, asked = scene.mesh, scene.accuracy.loop
    equal = mesh.kind == "eem"
    fine = where(equal, scene.rope.length / mesh.elements, mesh.coarse_length * fine_share(mesh.counts))
    error = mesh_error(scene, fine, where(equal, 0.0, mesh.grading_length))
    yaw = where(state.fidelity == "planar", 0.0, turned_by_mesh(scene, fine))
    would_do = smaller(length_for(scene, asked), LONGEST * NATURAL_RADIUS * bending_length(scene))
    applies = both(mesh.kind != "auto", state.fidelity != "rigid", error > asked)
    return applies, fine, error, asked, yaw, would_do


def _extrapolated_too_far(scene: Any, state: Any) -> tuple[Any, ...]:
    h = state.last_interval  # between two instants, which are rounded the more the later they are
    applies = both(state.counts.steps > 0, h > 1.001 * LONGEST_EXTRAPOLATION)
    return applies, h, LONGEST_EXTRAPOLATION


def _no_air(scene: Any, state: Any) -> tuple[Any, ...]:
    air = scene.shaft.air
    moved = either(air.vx != 0, air.vy != 0, air.vz != 0)
    return both(air.density == 0, moved), air.vx, air.vy, air.vz


def _no_air_to_push(scene: Any, state: Any) -> tuple[Any, ...]:
    air = scene.shaft.air
    return both(air.density == 0, air.buffet > 0), air.buffet


def _no_torque_to_guard(scene: Any, state: Any) -> tuple[Any, ...]:
    torque = scene.shaft.guard.torque
    return both(state.fidelity != "torsional", torque > 0), torque, state.fidelity


def _no_turns_to_guard(scene: Any, state: Any) -> tuple[Any, ...]:
    turns, flat = scene.shaft.guard.turns, either(state.fidelity == "planar", state.fidelity == "rigid")
    return both(flat, turns > 0), turns, state.fidelity


def _no_swing_to_guard(scene: Any, state: Any) -> tuple[Any, ...]:
    window = scene.shaft.guard.window
    return both(state.fidelity == "rigid", window > 0), window, state.fidelity


def _no_rise_to_guard(scene: Any, state: Any) -> tuple[Any, ...]:
    guard = scene.shaft.guard
    return both(state.fidelity == "rigid", guard.rise > 0, guard.rise_y <= -FAR), guard.rise, state.fidelity


def _accuracy_given_up(scene: Any, state: Any) -> tuple[Any, ...]:
    given_up = state.counts.given_up
    return given_up > 0, given_up, state.given_up_since, scene.solver.work_max


PASSED_SIDES: Rules = {
    warning_messages.sides_passed: _sides_passed,
    warning_messages.sides_passed_in_spite: _sides_passed_in_spite,
}
LEG_CONTACT: Rules = {
    warning_messages.turned_around: _turned_around,
    warning_messages.legs_touch: _legs_touch,
    warning_messages.legs_press: _legs_press,
}
TORQUE_SOURCE: Rules = {
    warning_messages.torque_of_coupling: _torque_of_coupling,
    warning_messages.torque_of_curvature: _torque_of_curvature,
    warning_messages.torque_of_twist: _torque_of_twist,
    warning_messages.torque_of_ends: _torque_of_ends,
}
OTHER_RESTS: Rules = {warning_messages.other_rests: _other_rests}
MISSING_LOADS: Rules = {
    warning_messages.forces_missing: _forces_missing,
    warning_messages.moments_missing: _moments_missing,
}
UNRESOLVED_WAVES: Rules = {warning_messages.waves_unresolved: _waves_unresolved}
UNRESOLVED_BEND: Rules = {
    warning_messages.bend_unresolved: _bend_unresolved,
    warning_messages.loop_unresolved: _loop_unresolved,
}
LONG_EXTRAPOLATION: Rules = {warning_messages.extrapolated_too_far: _extrapolated_too_far}
NO_AIR: Rules = {warning_messages.no_air: _no_air, warning_messages.no_air_to_push: _no_air_to_push}
#: the guard that needs most of the model comes first: a model that serves it serves the others
BLIND_GUARDS: Rules = {
    warning_messages.no_torque_to_guard: _no_torque_to_guard,
    warning_messages.no_turns_to_guard: _no_turns_to_guard,
    warning_messages.no_swing_to_guard: _no_swing_to_guard,
    warning_messages.no_rise_to_guard: _no_rise_to_guard,
}
ACCURACY_GIVEN_UP: Rules = {warning_messages.accuracy_given_up: _accuracy_given_up}

#: rules of the inputs of an end
INPUTS: Rules = {
    warning_messages.positions_rounded: _positions_rounded,
    warning_messages.samples_repeated: _samples_repeated,
    warning_messages.table_too_coarse: _table_too_coarse,
    warning_messages.motion_misfits: _motion_misfits,
}
