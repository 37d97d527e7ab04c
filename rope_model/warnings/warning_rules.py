"""Decision tables of the warnings: rules and bounds for warnings.result_warnings and its C."""

import math

from rope_model.boundary.input_detectors import MIN_BREAKS
from rope_model.boundary.input_filter import POSITION, InputFilter, filter_settings
from rope_model.fidelity.fidelity_rules import carries_torque
from rope_model.messages import warning_messages as texts
from rope_model.messages.rules import Rules
from rope_model.method import audit as audits
from rope_model.method import leg_waves
from rope_model.method.generalized_alpha import Coefficients, local_error
from rope_model.method.mesh_error import length_for, mesh_error, slip_factor, turned_by_mesh
from rope_model.method.mesh_fit import MAX_LENGTH
from rope_model.method.mesh_pattern import fine_share
from rope_model.parameters import Scene
from rope_model.physics.air import air_acts
from rope_model.physics.elementary import (
    SMALLEST_DIVISOR,
    Scalar,
    floor,
    logical_and,
    logical_or,
    maximum,
    minimum,
    sqrt,
    where,
)
from rope_model.physics.estimates import (
    bending_length,
    coupling_torque,
    curvature_torque,
    twist_torque,
)
from rope_model.physics.initial_curvature import max_curvature
from rope_model.shaft_parameters import FAR
from rope_model.state import RopeState

#: rad, yaw of a loop that is turned over
HALF_A_TURN = math.pi
#: rad, yaw at rest of a rope whose data should be checked
YAWED_FAR = math.pi / 6
#: s, longest step for motions that are extrapolated: in a winding end forces are 2 % off at 50 ms
MAX_EXTRAPOLATION = 0.02
#: samples of a moving end from which rounding can be recognised: the first of a trip lie on every
#: grid
MIN_SAMPLES = 20
#: m, rounding of positions below which it does no harm
COARSEST_ROUNDING = 0.99e-4
#: m/s, a rope with less kinetic energy than at this uniform speed is at rest
REST_SPEED = 1e-3


def rests(scene: Scene, state: RopeState) -> Scalar:
    """Return whether the rope is at rest."""
    data = scene.rope
    return state.energy_balance.kinetic < 0.5 * data.mass_per_length * data.length * (
        REST_SPEED * REST_SPEED
    )


def leaves_out(scene: Scene, state: RopeState) -> Scalar:
    """Return whether the rope moves in a way that its fidelity leaves out."""
    blown = logical_and(
        state.fidelity == "planar",
        air_acts(scene.shaft.air, scene.rope.diameter) > 0,
        abs(scene.shaft.air.vz) > 0,
    )
    return logical_or(state.fidelity == "rigid", carries_torque(scene), blown)


def yawed_far_at_rest(scene: Scene, state: RopeState, yaw: Scalar) -> Scalar:
    """Return whether the loop hangs out of its ends' plane by ``yaw`` (rad) at rest, and no worse warning applies."""
    free = logical_and(
        state.crossing.number == 0, state.crossing.overlap == 0, abs(yaw) < HALF_A_TURN
    )
    return logical_and(
        state.fidelity == "torsional", free, rests(scene, state), abs(yaw) > YAWED_FAR
    )


def _passages(state: RopeState) -> tuple[Scalar, ...]:
    return state.crossing.number, state.crossing.since, state.crossing.y


def _legs_press(state: RopeState) -> tuple[Scalar, ...]:
    x = state.crossing
    return logical_and(x.number == 0, x.overlap > 0), x.touched_at, x.overlap, x.touched_y


def _legs_touch(scene: Scene, state: RopeState, yaw: Scalar) -> tuple[Scalar, ...]:
    applies, *numbers = _legs_press(state)
    return logical_and(applies, scene.shaft.contact.rope_stiffness == 0), *numbers


def _torque_of_coupling(scene: Scene, turned: Scalar) -> tuple[Scalar, ...]:
    coupling, curvature, installed, ends = _torques(scene, turned)
    return (
        logical_and(coupling >= curvature, coupling >= installed, coupling >= ends),
        scene.rope.Qb,
        scene.rope.Qc,
    )


def _torque_of_curvature(scene: Scene, turned: Scalar) -> tuple[Scalar, ...]:
    _, curvature, installed, ends = _torques(scene, turned)
    return logical_and(curvature >= installed, curvature >= ends), max_curvature(scene.rope)


def _torque_of_twist(scene: Scene, turned: Scalar) -> tuple[Scalar, ...]:
    *_, installed, ends = _torques(scene, turned)
    return installed >= ends, scene.rope.installed_twist


def _torques(scene: Scene, turned: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the torques by coupling, permanent curvature, installed twist, and ends twisted by ``turned`` (rad)."""
    rope = scene.rope
    # the twist of the ends includes the installed twist
    ends = twist_torque(rope, turned) * (1 - 1e-9)
    coupling = coupling_torque(rope, scene.layout.gravity)
    return coupling, curvature_torque(rope), twist_torque(rope, rope.installed_twist), ends


def _missing(load: Scalar, bound: Scalar) -> tuple[Scalar, ...]:
    return load > bound, load, bound


def _shown_below(number: Scalar) -> Scalar:
    """Return ``number`` cut to two decimals, so that it looks different from a bound of less than 10 above it."""
    return floor(100.0 * number) / 100.0


def _waves_unresolved(scene: Scene, state: RopeState) -> tuple[Scalar, ...]:
    audit = state.audit
    steps = audits.signal_values(state.audit)[4]
    large = audits.LARGE_CHANGE * audit.force
    applies = logical_and(
        audit.period_fraction * audits.MIN_STEPS > 1.0, audit.force_change > large
    )
    return (
        applies,
        audit.force_change,
        _shown_below(steps),
        audits.MIN_STEPS,
        audits.axial_step(scene.rope),
    )


def _shaking_unresolved(scene: Scene, state: RopeState) -> tuple[Scalar, ...]:
    waves = state.waves
    force = leg_waves.leg_force_error(scene, waves, state.errors)
    place = leg_waves.leg_loop_error(scene, waves, state.errors.time)
    frequency = leg_waves.frequency(scene, waves)
    height = waves.height
    applies = logical_or(force > scene.accuracy.end_force, place > scene.accuracy.loop)
    wavelength = sqrt(scene.layout.gravity * height) / frequency
    return applies, frequency, wavelength, height, waves.length, force, place, frequency


def _shaking_lags(scene: Scene, state: RopeState) -> tuple[Scalar, ...]:
    waves = state.waves
    time = state.errors.time
    force = leg_waves.lag_force_error(scene, waves, state.errors)
    place = leg_waves.lag_loop_error(scene, waves, time)
    ratio = maximum(force / scene.accuracy.end_force, place / scene.accuracy.loop)
    constant = local_error(Coefficients(scene.solver.rho_inf), 1.0, 1.0)
    h = sqrt(waves.lag / (constant * maximum(time, SMALLEST_DIVISOR)))
    # both grow with h^2 at least
    step = h / sqrt(maximum(ratio, 1.0))
    return ratio > 1, leg_waves.frequency(scene, waves), h, force, place, step


def _bend_unresolved(scene: Scene, state: RopeState) -> tuple[Scalar, ...]:
    elements = audits.signal_values(state.audit)[5]
    required = audits.MIN_ELEMENTS
    return logical_and(state.audit.bend > 0, elements < required), _shown_below(elements), required


def _positions_rounded(scene: Scene, end_filter: InputFilter, step: Scalar) -> tuple[Scalar, ...]:
    x = end_filter
    on_grid = logical_and(
        x.grid.samples >= MIN_SAMPLES, x.grid.size >= COARSEST_ROUNDING, x.grid.size < 1
    )
    return logical_and(
        scene.inputs.given != "speed", on_grid, x.misfits.position > 0.25 * x.grid.size
    ), x.grid.size


def _motion_misfits(scene: Scene, end_filter: InputFilter, step: Scalar) -> tuple[Scalar, ...]:
    x = end_filter
    disturbs = x.misfits.acceleration > scene.accuracy.end_force * scene.layout.gravity
    return (
        logical_and(scene.inputs.given == "all", disturbs),
        x.misfits.position,
        x.misfits.speed,
        x.misfits.acceleration,
    )


def _estimates_lag(scene: Scene, end_filter: InputFilter, step: Scalar) -> tuple[Scalar, ...]:
    """Return whether an estimated motion was further from the given one than inputs.misfit_max admits given ones."""
    x = end_filter
    bandwidth = filter_settings(scene, POSITION).estimate
    lags = logical_and(scene.inputs.given != "all", x.misfits.position > scene.inputs.misfit_max)
    return lags, x.misfits.position, x.misfits.speed, bandwidth


def _loop_unresolved(scene: Scene, state: RopeState) -> tuple[Scalar, ...]:
    mesh = scene.mesh
    allowed = scene.accuracy.loop
    equal = mesh.kind == "eem"
    fine_length = where(
        equal, scene.rope.length / mesh.elements, mesh.coarse_length * fine_share(mesh.counts)
    )
    error = mesh_error(scene, fine_length, where(equal, 0.0, mesh.grading_length), 0.0)
    yaw = where(state.fidelity == "planar", 0.0, turned_by_mesh(scene, fine_length))
    # shorter than MAX_LENGTH, the loop slips less; a tenth is left to the legs
    share = 0.9 * allowed / slip_factor(MAX_LENGTH)
    sufficient = minimum(length_for(scene, share), MAX_LENGTH * bending_length(scene))
    applies = logical_and(mesh.kind != "auto", state.fidelity != "rigid", error > allowed)
    return applies, fine_length, error, allowed, yaw, sufficient


def _no_air(scene: Scene, state: RopeState) -> tuple[Scalar, ...]:
    air = scene.shaft.air
    moved = logical_or(air.vx != 0, air.vy != 0, air.vz != 0)
    return logical_and(air.density == 0, moved), air.vx, air.vy, air.vz


def _blind(state: RopeState, blind: Scalar, threshold: Scalar) -> tuple[Scalar, ...]:
    return logical_and(blind, threshold > 0), threshold, state.fidelity


PASSED_SIDES: Rules = {
    texts.sides_passed: lambda scene, state: (
        logical_and(state.crossing.number > 0, scene.shaft.contact.rope_stiffness == 0),
        *_passages(state),
    ),
    texts.sides_passed_in_spite: lambda scene, state: (
        state.crossing.number > 0,
        *_passages(state),
        scene.shaft.contact.rope_stiffness,
    ),
}
LEG_CONTACT: Rules = {
    # without passages a rope is turned as far over its height as its loop; passages have their own
    # warning
    texts.turned_around: lambda scene, state, yaw: (
        logical_and(state.crossing.number == 0, abs(yaw) >= HALF_A_TURN),
        yaw / (2 * math.pi),
    ),
    texts.legs_touch: _legs_touch,
    texts.legs_press: lambda scene, state, yaw: _legs_press(state),
}
TORQUE_SOURCE: Rules = {
    texts.torque_of_coupling: _torque_of_coupling,
    texts.torque_of_curvature: _torque_of_curvature,
    texts.torque_of_twist: _torque_of_twist,
    texts.torque_of_ends: lambda scene, turned: (True, turned),
}
OTHER_RESTS: Rules = {
    texts.other_rests: lambda scene, state: (
        logical_and(state.snap_twist != 0, rests(scene, state)),
        state.snap_twist,
    )
}
MISSING_LOADS: Rules = {
    texts.forces_missing: lambda scene, state: _missing(
        state.audit.missing_force, audits.MISSING_FORCE * state.audit.force
    ),
    texts.moments_missing: lambda scene, state: _missing(
        state.audit.missing_moment, audits.MISSING_MOMENT * state.audit.force * scene.layout.spacing
    ),
}
UNRESOLVED_WAVES: Rules = {
    texts.waves_unresolved: _waves_unresolved,
    texts.shaking_unresolved: _shaking_unresolved,
    texts.shaking_lags: _shaking_lags,
}
UNRESOLVED_BEND: Rules = {
    texts.bend_unresolved: _bend_unresolved,
    texts.loop_unresolved: _loop_unresolved,
}
LONG_EXTRAPOLATION: Rules = {
    # the interval is the difference of two instants, whose rounding grows with them
    texts.extrapolated_too_far: lambda scene, state: (
        logical_and(state.counts.steps > 0, state.last_interval > 1.001 * MAX_EXTRAPOLATION),
        state.last_interval,
        MAX_EXTRAPOLATION,
    )
}
NO_AIR: Rules = {
    texts.no_air: _no_air,
    texts.no_air_to_push: lambda scene, state: (
        logical_and(scene.shaft.air.density == 0, scene.shaft.air.buffet > 0),
        scene.shaft.air.buffet,
    ),
}
#: the guard that needs most of the model comes first: a model that serves it serves the others
BLIND_GUARDS: Rules = {
    texts.no_torque_to_guard: lambda scene, state: _blind(
        state, state.fidelity != "torsional", scene.shaft.guard.torque
    ),
    texts.no_turns_to_guard: lambda scene, state: _blind(
        state,
        logical_or(state.fidelity == "planar", state.fidelity == "rigid"),
        scene.shaft.guard.turns,
    ),
    texts.no_swing_to_guard: lambda scene, state: _blind(
        state, state.fidelity == "rigid", scene.shaft.guard.window
    ),
    texts.no_rise_to_guard: lambda scene, state: _blind(
        state,
        logical_and(state.fidelity == "rigid", scene.shaft.guard.rise_y <= -FAR),
        scene.shaft.guard.rise,
    ),
}
ACCURACY_GIVEN_UP: Rules = {
    texts.accuracy_given_up: lambda scene, state: (
        state.counts.given_up > 0,
        state.counts.given_up,
        state.given_up_since,
        scene.solver.work_max,
    )
}
#: rules of the inputs of an end
INPUTS: Rules = {
    texts.positions_rounded: _positions_rounded,
    texts.samples_repeated: lambda scene, end_filter, step: (
        logical_and(end_filter.repetitions.number > 0, end_filter.repetitions.sent_every > 0),
        end_filter.repetitions.number,
        step,
        end_filter.repetitions.sent_every,
    ),
    texts.table_too_coarse: lambda scene, end_filter, step: (
        logical_and(
            end_filter.table.breaks >= MIN_BREAKS, end_filter.grid.size < COARSEST_ROUNDING
        ),
        end_filter.table.piece,
        step,
    ),
    texts.motion_misfits: _motion_misfits,
    texts.estimates_lag: _estimates_lag,
}
