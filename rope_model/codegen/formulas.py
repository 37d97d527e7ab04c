"""List of the formulas, structures and constants that C takes from Python; ``formula_functions`` prints them."""

from collections.abc import Callable
from itertools import accumulate
from types import ModuleType
from typing import Any

from rope_model.codegen.derivatives import path_change
from rope_model.numerics import conjugate_gradients, generalized_alpha, newton
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics import (
    accuracy,
    air,
    air_element,
    centreline,
    contact,
    contact_error,
    contact_points,
    curved_element,
    element,
    elementary,
    energy_balance,
    estimates,
    frame,
    guard,
    hermite,
    inextensible,
    initial_curvature,
    initial_shape,
    point_forces,
    rope_contact,
    shaft,
    stress,
    swivel,
    wire_element,
    wire_friction,
)
from rope_model.shaft_parameters import FAR, PARTS
from rope_model.simulation import rigid, simulator
from rope_model.simulation.contact import shaft as shaft_search
from rope_model.simulation.ends import ends, input_filter, misfit, paths, switching
from rope_model.simulation.ends.input_filter import InputFilter, filter_sample
from rope_model.simulation.ends.paths import EndMotion, EndPath
from rope_model.simulation.mesh import adaptation, mesh_fit, mesh_pattern
from rope_model.simulation.mesh import partition as mesh
from rope_model.simulation.messages import warning_rules
from rope_model.simulation.outputs import audit, diagnostics
from rope_model.simulation.outputs.audit import Audit
from rope_model.simulation.state import EnergyBalance
from rope_model.simulation.stepping import events, hang, statics, stepping
from rope_model.solver_parameters import Solver

#: C function -> formula.  An untyped parameter is a number, an array of numbers, or the structure of its name.  The
#: last parameter of a void function receives the results
FORMULAS: dict[str, Callable[..., Any]] = {
    "dot(a[3], b[3])": elementary.dot,
    "nearest_whole(x)": elementary.nearest_whole,
    "nearest_turn(angle, last)": adaptation.nearest_turn,
    "void conveyance_load(q[7], f[7], torque, load[6])": frame.conveyance_load,
    "right_offset(left[3], right[3])": ends.right_offset,
    "Path path_resting(t, EndMotion motion)": EndPath.at_rest,
    "InputFilter filter_resting(t, EndMotion motion)": InputFilter.at_rest,
    "FilterSettings filter_settings(scene, trusted)": input_filter.filter_settings,
    "InputFilter filter_sample(InputFilter state, FilterSettings settings, given_at, h, EndMotion end)": filter_sample,
    "Path filter_path(path, InputFilter state, stop, bandwidth)": input_filter.filter_path,
    "void path_measures(path, InputFilter state, measures[14])": input_filter.path_measures,
    "InputFilter add_misfit(InputFilter state, path, FilterSettings settings, rope, leg)": misfit.add_misfit,
    "Path path_coasting(path, t)": EndPath.at_constant_acceleration,
    "EndMotion path_at(path, t)": EndPath.at,
    "path_height(path, t)": EndPath.height,
    "void path_motion(path, t, motion[3][4])": EndPath.motion,
    "void held_end(path, t, nominal_x, sense, angle, rows[3][7])": ends.held_end,
    "void path_lean_motion(path, t, leans[2][3])": EndPath.lean_motion,
    "void clamp_axis(lean[3], lean_z[3], axis[3][3])": ends.clamp_axis,
    "EndMotion partly_placed(scene, EndMotion own, EndMotion other, sense, fraction)": ends.partly_placed,
    "void suspension_points(layout, EndMotion left, EndMotion right, points[2][3])": centreline.suspension_points,
    "void node_values(xi, l, nodes[14], values[7])": hermite.node_values,
    "void missing_load(start, stop, s, l, old_s, old_l, old[14], new[14], load[14])": hermite.missing_load,
    "void hermite_shape_functions(xi, l, N[4])": hermite.shape_functions,
    "void hermite_shape_products(l, products[10])": hermite.shape_products,
    "hermite_integral(l, r1, s1, r2, s2)": hermite.integral,
    "hermite_integral_to(xi, l, r1, s1, r2, s2)": hermite.integral_to,
    "sample_s(bottom_s, reach, fraction, loop)": centreline.sample_s,
    "least_squared_distance(a[6], b[6])": centreline.least_squared_distance,
    "squared_distance(point[3], start[3], along[3])": centreline.squared_distance,
    "void middle_of(length, a[6], b[6], middle[6])": centreline.middle,
    "void position_at(xi, length, a[6], b[6], point[3])": centreline.position_at,
    "turns_of(yaw, line, passages)": centreline.turns,
    "void enclosing_box(length, a[6], b[6], box[6])": centreline.enclosing_box,
    "lower_bound(known, length, a, slope_a, b, slope_b)": centreline.lower_bound,
    "upper_bound(known, length, a, slope_a, b, slope_b)": centreline.upper_bound,
    "void box_between(bounds[6], box[6])": centreline.box_between,
    "void heading(yaw, vector[2])": centreline.heading,
    "line_yaw(left[3], right[3])": centreline.line_yaw,
    "void plane_between(left[3], right[3], start[3], direction[2], normal[3])": centreline.plane_between,
    "side_gap(side, length, outer[6], inner[6], top, start[3], normal[3], diameter, above)": centreline.side_gap,
    "least_advance(length, a[6], b[6], direction[2])": centreline.least_advance,
    "angle_between(before[2], after[2])": centreline.angle_between,
    "body_distance(point[3], body)": shaft.distance,
    "body_least_distance(point[3], extent[3], body)": shaft.least_distance,
    "ContactTerms contact_law(contact, diameter, body, body_v[3], point[3], v[3], cq, cv)": contact.contact_law,
    "Probe contact_probe(xi, l, a[6], b[6], diameter, body)": contact_points.probe,
    "contact_turning(Probe start, Probe stop)": contact_points.turning,
    "contact_reaching(Probe outer, inner, level)": contact_points.reaching,
    "void contact_point(fraction, weight, start, stop, point[2])": contact_points.point_in,
    "number_of_points(l, diameter)": rope_contact.number_of_points,
    "points_skipped(distance, diameter, spacing, number)": rope_contact.points_skipped,
    "max_points(length, elements, diameter)": rope_contact.max_points,
    "nearer_xi(xi, l, point[3], a[6], b[6])": rope_contact.nearer_xi,
    "ContactTerms self_contact_law(contact, diameter, separation[3], v[3], cq, cv)": rope_contact.self_contact_law,
    "time_fraction(start, stop, t)": point_forces.time_fraction,
    "void point_load(point[3], force[3], load[6])": point_forces.point_load,
    "largest_motion(longest, q[6], before[6])": contact.largest_motion,
    "correction_motion(corrections, longest, shortest)": contact.correction_motion,
    "AirCoefficients air_coefficients(air, diameter, spacing)": air.air_coefficients,
    "wire_stiffness(rope)": wire_friction.wire_stiffness,
    "slip_curvature(rope, stiffness, e, tau)": wire_friction.slip_curvature,
    "void section_at(xi, l, nodes[14], section[7])": wire_friction.section_at,
    "BoucWenStep bouc_wen_step(before[10], after[7], k0)": wire_friction.bouc_wen_step,
    "max_curvature(rope)": initial_curvature.max_curvature,
    "void carried_director(e1[3], before[3], after[3], carried[3])": initial_curvature.carried_director,
    "void curvature_components(rope, s, l, components[6])": initial_curvature.curvature_components,
    "void curvature_vectors(components[6], l, nodes[14], start[3], vectors[12])": initial_curvature.curvature_vectors,
    "Body lining_body(lining)": shaft.lining,
    "Body conveyance_body(conveyance, end[3])": shaft.conveyance,
    "Body head_ropes_body(head_ropes, conveyance, end[3])": shaft.head_ropes,
    "Body divider_body(divider)": shaft.divider,
    "Body floor_body(sump)": shaft.floor,
    "has_guards(guard)": guard.has_guards,
    "loop_height(rope, layout, lowest, left, right)": guard.loop_height,
    "sideways(point[3], left[3], right[3])": guard.sideways,
    "off_plumb(height, a[3], b[3], end[3])": guard.off_plumb,
    "GuardState watch(guard, GuardState state, t, quantities[5])": guard.watch,
    "void material_values(rope, torsional, strains[5], values[4])": stress.material_values,
    f"void element_parameters(rope, gravity, P[{len(element.PARAMETERS)}])": element.parameters,
    "EnergyBalance with_energies(energy_balance, balance[7], double contact)": energy_balance.with_energies,
    "EnergyBalance account_of_step(energy_balance, h, before[2], after[2], losses[4], wires, double air)": (
        energy_balance.after_step
    ),
    "energy_total(energy_balance)": energy_balance.total,
    "energy_residual(energy_balance)": energy_balance.residual,
    "Flow rigid_flow(v1, v2)": inextensible.flow,
    "RigidTensions rigid_tensions(rope, layout, EndMotion left, EndMotion right)": inextensible.rigid_tensions,
    "rigid_min_tension(rigid_tensions)": inextensible.min_tension,
    "void rigid_energies(rope, layout, rigid_tensions, EndMotion left, EndMotion right, E[2])": inextensible.energies,
    "rigid_tension_at(rho, gravity, Flow rate, at_end, rise, s)": inextensible.tension,
    "loop_width(scene)": estimates.loop_width,
    "InitialShape initial_shape(length, middle, width, cell)": initial_shape.initial_shape,
    "void initial_node_row(initial_shape, left[3], across[3], s, row[7])": initial_shape.node_row,
    "FittedMesh fit_elements(scene, loop_error, decades)": mesh_fit.fit_elements,
    f"void divider_positions(scene, left, right, places[{len(mesh.NO_DIVIDERS)}])": mesh_fit.divider_positions,
    "void newton_coefficients(Coefficients method, h, c[3])": generalized_alpha.newton_coefficients,
    "void prediction_weights(Coefficients method, h, time_shift, ahead, w[6])": generalized_alpha.prediction_weights,
    "void auxiliary_weights(Coefficients method, time_shift, weights[4])": generalized_alpha.auxiliary_weights,
    "recentring_time(Coefficients method, h, before)": generalized_alpha.recentring_time,
    "local_error(Coefficients method, h, change)": generalized_alpha.local_error,
    "trial_x(bracket, width)": events.trial_x,
    "Bracket narrowed(bracket, x, value)": events.narrowed,
    "lacks_symmetry(Qs, Qk)": statics.lacks_symmetry,
    "relaxation(change, last)": statics.relaxation,
    "StepLimits step_limits(scene, ErrorSums sums, s, end_speed, error_constant)": accuracy.step_limits,
    "ErrorSums add_errors(scene, ErrorSums sums, s, end_speed, h, constant, strain_tt[2], position, force)": (
        accuracy.add_errors
    ),
    "step_error(StepLimits limits, h, position_error, strain_error)": accuracy.step_error,
    "NextStep next_step(solver, h, step_next, error, rejected, t, calm_since)": accuracy.next_step,
    "max_iterations(interval, step_max)": stepping.max_iterations,
    "substeps(interval, step_next, steps_left)": accuracy.substeps,
    "effective_tolerance(newton_tolerance, work_max, bounded_tolerance)": accuracy.effective_tolerance,
    "ContactSums add_contact(scene, ContactSums sums, h, pressures[6], longest)": contact_error.add_contact,
    "contact_error(ContactSums sums)": contact_error.contact_error,
    "add_contact_end_error(error, ContactSums sums, time, force)": contact_error.add_contact_end_error,
    "add_contact_loop_error(scene, error, ContactSums sums)": contact_error.add_contact_loop_error,
    "end_force_error(rope, ErrorSums sums)": accuracy.end_force_error,
    "add_misfit_error(error, ErrorSums sums, InputFilter left, InputFilter right)": misfit.add_misfit_error,
    "add_drift_error(error, InputFilter left, InputFilter right)": misfit.add_drift_error,
    "loop_error(scene, ErrorSums sums, l, grading_length)": accuracy.loop_error,
    "tension_along(sense, d[3], force[3])": swivel.tension_along,
    "friction_moment(mu, mean_diameter, seal_moment, tension)": swivel.friction_moment,
    "void end_load(q[7], f[7], torque, load[6])": audit.end_load,
    "axial_share(rope, bottom_s, h)": audit.axial_share,
    "void audit_values(audit, values[6])": audit.signal_values,
    "Audit audit_after_step(audit, Coefficients method, h, shift, load[8], force, change, ratio)": audit.after_step,
    "Audit audit_after_interval(audit, h, mass, gravity, sums[9], about[3], residual, bend)": audit.after_interval,
}
#: derivatives of formulas, which Python does not evaluate, written as in ``FORMULAS``
DERIVATIVES: dict[str, Callable[..., Any]] = {
    "void path_change(path, InputFilter state, FilterSettings settings, given_at, stop, EndMotion end, change[13], "
    "coefficients[6][6])": path_change
}
#: structures of results, which are generated for C
DEFINED_HERE: tuple[type[Any], ...] = (
    *(
        inextensible.Flow,
        inextensible.RigidTensions,
        initial_shape.InitialShape,
        shaft.Body,
        air.AirCoefficients,
    ),
    *(
        contact.ContactTerms,
        contact_points.Probe,
        wire_friction.BoucWenStep,
        input_filter.FilterSettings,
    ),
    *(
        events.Bracket,
        mesh_fit.FittedMesh,
        generalized_alpha.Coefficients,
        accuracy.StepLimits,
        accuracy.NextStep,
    ),
)
#: structures that a formula may take or return
STRUCTURES: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        *(Rope, Layout, Scene, Solver, *PARTS.values(), EndMotion),
        *(
            EnergyBalance,
            accuracy.ErrorSums,
            contact_error.ContactSums,
            Audit,
            guard.GuardState,
            InputFilter,
        ),
        *DEFINED_HERE,
    )
} | {"Path": EndPath}
#: constants of formulas and control flow: prefix of their names in C, module, names
_SHARED: tuple[tuple[str, ModuleType, str], ...] = (
    ("", accuracy, "ACCEPT_BELOW STEP_ITERATIONS BOUNDED_STEP_ERROR BOUNDED_MESH_ERROR"),
    ("", adaptation, "RELAXATION_TIME"),
    ("", contact, "CONTACT_MARGIN OWN_LENGTH"),
    ("", curved_element, "CURVATURE_SIZE"),
    ("", diagnostics, "PIECES FINE OUTLINE"),
    ("", element, "FRAME_SIZE"),
    ("", generalized_alpha, "MAX_GROWTH"),
    ("AUDIT_", audit, "LOADS END_LOADS"),
    ("", guard, "NEVER"),
    (
        "",
        hang,
        "FLOOR_STEP MAX_FLOOR_STEPS CURVATURE_STEPS PLACING_STEPS TWIST_STEP MIN_TWIST_STEP MAX_TURN MAX_CORRECTIONS",
    ),
    ("", input_filter, "MAX_LAG MIN_AIM_TIME MIN_MEAN_TIME"),
    ("", mesh, "LEG_LENGTHS GRADING MAX_OVERSHOOT"),
    ("", mesh_fit, "FADE_ERROR MESH_SHARE DUE"),
    ("", mesh_pattern, "DUE_EARLY WINDOW WINDOW_PARTS WINDOW_DUE"),
    ("", paths, "RESTS_BELOW"),
    ("", rigid, "SETTLING_TIME DIFFERENCE"),
    ("", rope_contact, "MIN_ARC MAX_STRANDS CORRECTIONS"),
    ("", shaft_search, "RESOLUTION TURNED_FAR MONITOR_INTERVAL"),
    ("", simulator, "MAX_START_TIME MAX_STEPS"),
    ("", statics, "SETTLED BALANCED MAX_MOVE PATIENCE REST_TOLERANCE"),
    ("", switching, "EVENT_WIDTH CHATTER_TIME"),
    ("", warning_rules, "YAWED_FAR"),
    ("CONTACT_", contact_points, "CELLS HALVINGS STEPS LEVELS PARTS WEIGHTS"),
    ("", conjugate_gradients, "CG_MAX_STEPS CG_TOLERANCE"),
    ("NEWTON_", newton, "SMOOTH KINKED HUGE UNKNOWN GOOD SMALL"),
    ("WIRE_", wire_element, "HISTORY_SIZE TANGENT_SIZE"),
    ("WIRE_", wire_friction, "POINT_STATE_SIZE"),
)
CONSTANTS: dict[str, float | tuple[Any, ...]] = {
    prefix + name: getattr(module, name)
    for prefix, module, names in _SHARED
    for name in names.split()
} | {
    "PARAMETERS": len(element.PARAMETERS),
    "BALANCE": element.BALANCE.index("damping_power"),
    "MOMENTUM": len(element.MOMENTUM),
    "STRAINS": len(element.STRAINS),
    "AIR_BALANCE": len(air_element.AIR_BALANCE),
    **{name.upper(): k for k, name in enumerate(element.BALANCE)},
    **{status.name: status.code for status in newton.NewtonStatus},
    **{f"P_{name.upper()}": k for k, name in enumerate(element.PARAMETERS)},
    "FAR": FAR,
    "DIVIDERS": len(mesh.NO_DIVIDERS),
    "SETTLING_TOLERANCE": rigid.NEWTON_TOLERANCE,
    "WIRE_CELLS": (0.0, *accumulate(element.WEIGHTS)),
    "MAX_PLACES": rope_contact.MAX_POINTS,
    "PROBES": len(rope_contact.PROBES),
    "PROBE_PLACES": rope_contact.PROBES,
    "DIRECTOR_START": initial_curvature.START,
    "DIRECTOR_PLUMB": initial_curvature.PLUMB,
    "WIRE_POINTS": len(element.POINTS),
    "WIRE_PLACES": element.POINTS,
    "WIRE_WEIGHTS": element.WEIGHTS,
    "NEWTON_TEXTS": tuple(status.text for status in newton.NewtonStatus),
    "CONTACT_POINTS": len(contact_points.PARTS),
}
