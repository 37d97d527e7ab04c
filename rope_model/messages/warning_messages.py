"""Warnings about valid results: texts as in messages."""

from rope_model.messages.text import Template

passed_into = Template(
    "{body:s} from t = {touched:.6g} s on (deepest by {depth:.3g} m at {t:.6g} s, {s:.4g} m along it, at y = {y:.4g} m)"
)
and_another = Template("{before:.380} and {passed:.120}")
rope_struck = Template("the rope has struck {what:.430}; the outputs contact.* are the forces")
rope_pressed_into = Template(
    "the rope was pressed into {what:.330}, by more than its diameter: contact.stiffness = {stiffness:g} is too soft"
)
rope_passed_into = Template(
    "the rope has passed into {what:.400}; contact is not computed: later results describe no real rope"
)
sides_passed = Template(
    "the rope's legs have passed through each other, or one of them through the conveyance and head ropes above the "
    "other: {number:g} times (loop.crossings), first at t = {since:.6g} s around y = {y:.4g} m; contact is not "
    "computed: later results describe no real rope; set contact.rope_stiffness = 1e7, lower Qb, Qc, installed_twist "
    "or curvature, free swivels that are held, or widen the spacing"
)
sides_passed_in_spite = Template(
    "one side of the rope has passed through the other {number:g} times (loop.crossings), first at t = {since:.6g} s "
    "around y = {y:.4g} m: contact.rope_stiffness = {stiffness:g} is too soft, or the scene lacks conveyance and "
    "head_ropes; later results describe no real rope; raise or give these, lower Qb, Qc, installed_twist or "
    "curvature, or free swivels that are held"
)
turned_around = Template(
    "the rope is turned around itself: one leg has swung {turns:.3g} turns about the other and the conveyance and head "
    "ropes above it (loop.turns; at half a turn the loop is turned over); lower Qb, Qc, installed_twist or curvature, "
    "free swivels that are held, or widen the spacing"
)
legs_touch = Template(
    "the rope's legs have touched each other, first at t = {since:.6g} s, and overlapped by up to {overlap:.3g} m "
    "(loop.overlap) around y = {y:.4g} m; contact is not computed: set contact.rope_stiffness = 1e7, keep the legs "
    "taut, lower Qb, Qc, installed_twist or curvature, free swivels that are held, or widen the spacing"
)
legs_press = Template(
    "the rope's legs have pressed each other, first at t = {since:.6g} s, by up to {overlap:.3g} m (loop.overlap) "
    "around y = {y:.4g} m; contact.rope is the force; keep the legs taut, lower Qb, Qc, installed_twist or curvature, "
    "free swivels that are held, or widen the spacing"
)
yawed_at_rest = Template(
    "the loop hangs yawed by {yaw:.3g} rad against its ends at rest (bound {bound:.3g} rad), turned mostly by "
    "{source:.300}, or widen the spacing"
)
other_rests = Template(
    "the rope has more than one way to hang: turned in slowly it snapped over at {angle:.3g} rad of twist; use less "
    "twist (installed_twist, yaw of the ends), or free swivels that are held"
)
forces_missing = Template(
    "{force:.3g} N are missing between the end forces, the weight and the change of the rope's momentum "
    "(audit.momentum, bound {bound:.3g} N): time steps are too long for this motion, or the state was altered from "
    "outside; lower step_max, or restore an earlier state, and report an error that stays"
)
moments_missing = Template(
    "{moment:.3g} N m are missing between the moments on the rope and the change of its angular momentum "
    "(audit.moment, bound {bound:.3g} N m): time steps are too long for this motion, or the state was altered from "
    "outside; lower step_max, or restore an earlier state"
)
waves_unresolved = Template(
    "an end force changes by {change:.3g} N in one time step, and an axial period of the rope's longer leg has "
    "{steps:.3g} steps (bound {bound:.3g}): its waves are not resolved; lower step_max to {step:.2g} s"
)
shaking_unresolved = Template(
    "an end shakes sideways, or a stop did: its waves of {frequency:.2g} Hz are {wave:.2g} m long {height:.3g} m "
    "above the loop, on elements of {length:.2g} m, and not resolved: end forces are {force:.2g} of the largest off "
    "and the loop up to {place:.2g} m; set mesh.lateral_frequency = {cure:.2g} (mesh.kind = auto), or shorten the "
    "elements"
)
shaking_lags = Template(
    "an end shakes sideways: its waves of {frequency:.2g} Hz lag in steps of {h:.2g} s: end forces are {force:.2g} of "
    "the largest off and the loop up to {place:.2g} m; lower step_max to {step:.1g} s"
)
bend_unresolved = Template(
    "the rope's sharpest bend has {elements:.3g} elements in half a turn (bound {bound:.3g}); set mesh.kind = auto, or "
    "lower coarse_length; where auto is set, a leg has gone slack: keep it taut, or take mesh.kind = eem with more "
    "elements"
)
loop_unresolved = Template(
    "elements of {fine:.3g} m are too long for the bend: they put the loop up to {error:.2g} m from its place "
    "(accuracy.loop = {bound:g} m) and turn it by up to {yaw:.2g} rad; set mesh.kind = auto, or take elements of at "
    "most {length:.2g} m there"
)
no_torque_to_guard = Template(
    "guard.torque = {threshold:g} N m sees nothing: the {fidelity:s} model computes no moment of the swivels; set "
    "model.fidelity = auto (or torsional)"
)
no_turns_to_guard = Template(
    "guard.turns = {threshold:g} sees nothing: the {fidelity:s} model keeps the loop in its plane; set model.fidelity "
    "= auto (or torsional)"
)
no_swing_to_guard = Template(
    "guard.window = {threshold:g} m sees nothing: the {fidelity:s} model's loop hangs midway between the ends at any "
    "time; set model.fidelity = auto (or torsional)"
)
no_rise_to_guard = Template(
    "guard.rise = {threshold:g} m sees nothing: the {fidelity:s} model's loop is at its quasi-static place at any "
    "time; set model.fidelity = auto (or torsional), or count the rise from a height, guard.rise_y"
)
no_air = Template(
    "air.density = 0, so that air that moves at ({vx:g}, {vy:g}, {vz:g}) m/s does nothing: give the density, 1.2 kg/m3 "
    "at the surface"
)
no_air_to_push = Template(
    "air.density = 0, so that air.buffet = {buffet:g} does nothing: give the density, 1.2 kg/m3 at the surface"
)
extrapolated_too_far = Template(
    "a communication step of {h:g} s is too long for inputs that are extrapolated: beyond {bound:g} s forces err by "
    "some percent; communicate more often, or set inputs_at_step_end = true and give the motion at the end of each step"
)
of_end = Template("inputs of the {side:s} end: {told:.470}")
positions_rounded = Template(
    "positions look rounded to {grid:g} m; the end follows speed and acceleration and draws them in slowly; give more "
    "digits, or leave the position out (inputs.given = speed, 3)"
)
samples_repeated = Template(
    "the sample of an earlier step came again in {steps:g} steps of {step:g} s, lately every {every:g} s, while the "
    "end moved: a slower part sends them, or samples are lost; the motion was extrapolated; communicate as often as "
    "they are sent"
)
table_too_coarse = Template(
    "positions look interpolated linearly between times {every:g} s apart, with steps of {step:g} s; the end follows "
    "the acceleration; give a table as fine as the steps, or steps as long as the table's"
)
motion_misfits = Template(
    "position, speed and acceleration are not of one motion: the end lags behind by up to {place:.3g} m and "
    "{speed:.3g} m/s, and has up to {acceleration:.3g} m/s^2 more than given (inputs.misfit); check time stamps, units "
    "and signs, or name the trusted ones in inputs.given"
)
estimates_lag = Template(
    "the end is followed with a misfit of up to {place:.3g} m in position and {speed:.3g} m/s in speed, because its "
    "acceleration is estimated (inputs.misfit); give the acceleration (inputs.given = all, 0), or raise "
    "inputs.estimate_bandwidth, here {bandwidth:.3g} rad/s"
)
accuracy_given_up = Template(
    "accuracy was given up in {steps:d} steps since t = {since:.6g} s: they needed more Newton iterations than "
    "work_max = {bound:d} allows a communication step; raise it, or communicate more often"
)
torque_of_coupling = Template(
    "the coupling Qb = {Qb:g}, Qc = {Qc:g} N m: measure it on this rope, free swivels that are held"
)
torque_of_twist = Template("installed_twist = {angle:g} rad: lower it, free swivels that are held")
torque_of_curvature = Template(
    "the permanent curvature of up to {curvature:g} 1/m: lower it, or let it lie as the loop bends "
    "(initial_curvature_angle and curvature_*_across = 0)"
)
torque_of_ends = Template("the ends, which twist the rope by {angle:g} rad: turn them back")
