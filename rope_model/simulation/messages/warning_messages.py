"""Warnings of results that are valid: texts of both forms, as in messages."""

from __future__ import annotations


def passed_into(body: str, touched: float, depth: float, t: float, s: float, y: float) -> str:
    return (
        f"{body} from t = {touched:.6g} s on (deepest by {depth:.3g} m at {t:.6g} s, {s:.4g} m along it, at y = "
        f"{y:.4g} m)"
    )


def and_another(before: str, passed: str) -> str:
    return f"{before:.380} and {passed:.120}"


def rope_struck(what: str) -> str:
    return f"the rope has struck {what:.430}; the outputs contact.* are the forces"


def rope_pressed_into(what: str, stiffness: float) -> str:
    return (
        f"the rope was pressed into {what:.330}, by more than its diameter: contact.stiffness = {stiffness:g} is too "
        "soft"
    )


def rope_passed_into(what: str) -> str:
    return f"the rope has passed into {what:.400}; contact is not computed: later results describe no real rope"


def sides_passed(number: float, since: float, y: float) -> str:
    return (
        "the rope's legs have passed through each other, or one of them through the conveyance and head ropes above "
        f"the other: {number:g} times (loop.crossings), first at t = {since:.6g} s around y = {y:.4g} m; contact is "
        "not computed: later results describe no real rope; set contact.rope_stiffness = 1e7, lower Qb, Qc or "
        "installed_twist, free the swivels, or widen the spacing"
    )


def sides_passed_in_spite(number: float, since: float, y: float, stiffness: float) -> str:
    return (
        f"one side of the rope has passed through the other {number:g} times (loop.crossings), first at t = "
        f"{since:.6g} s around y = {y:.4g} m: contact.rope_stiffness = {stiffness:g} is too soft, or the scene lacks "
        "conveyance and head_ropes; later results describe no real rope; raise or give these, lower Qb, Qc or "
        "installed_twist, or free the swivels"
    )


def turned_around(turns: float) -> str:
    return (
        f"the rope is turned around itself: one leg has swung {turns:.3g} turns about the other and the conveyance and "
        "head ropes above it (loop.turns; at half a turn the loop is turned over); lower Qb, Qc or installed_twist, "
        "free the swivels, or widen the spacing"
    )


def legs_touch(overlap: float, since: float, y: float) -> str:
    return (
        f"the rope's legs have touched each other, first at t = {since:.6g} s, and overlapped by up to {overlap:.3g} m "
        f"(loop.overlap) around y = {y:.4g} m; contact is not computed: set contact.rope_stiffness = 1e7, keep the "
        "legs taut, lower Qb, Qc or installed_twist, free the swivels, or widen the spacing"
    )


def legs_press(overlap: float, since: float, y: float) -> str:
    return (
        f"the rope's legs have pressed each other, first at t = {since:.6g} s, by up to {overlap:.3g} m (loop.overlap) "
        f"around y = {y:.4g} m; contact.rope is the force; keep the legs taut, lower Qb, Qc or installed_twist, free "
        "the swivels, or widen the spacing"
    )


def yawed_at_rest(yaw: float, bound: float, source: str) -> str:
    return (
        f"the loop hangs yawed by {yaw:.3g} rad against its ends at rest (bound {bound:.3g} rad), turned mostly by "
        f"{source:.300}, or widen the spacing"
    )


def other_rests(angle: float) -> str:
    return (
        f"the rope has more than one way to hang: turned in slowly it snapped over at {angle:.3g} rad of twist; use "
        "less twist (installed_twist, yaw of the ends), or free the swivels"
    )


def forces_missing(force: float, bound: float) -> str:
    return (
        f"{force:.3g} N are missing between the end forces, the weight and the change of the rope's momentum "
        f"(audit.momentum, bound {bound:.3g} N): time steps are too long for this motion, or the state was altered "
        "from outside; lower step_max, or restore an earlier state, and report an error that stays"
    )


def moments_missing(moment: float, bound: float) -> str:
    return (
        f"{moment:.3g} N m are missing between the moments on the rope and the change of its angular momentum "
        f"(audit.moment, bound {bound:.3g} N m): time steps are too long for this motion, or the state was altered "
        "from outside; lower step_max, or restore an earlier state"
    )


def waves_unresolved(change: float, steps: float, bound: float, step: float) -> str:
    return (
        f"an end force changes by {change:.3g} N in one time step, and an axial period of the rope's longer leg has "
        f"{steps:.3g} steps (bound {bound:.3g}): its waves are not resolved; lower step_max to {step:.2g} s"
    )


def bend_unresolved(elements: float, bound: float) -> str:
    return (
        f"the rope's sharpest bend has {elements:.3g} elements in half a turn (bound {bound:.3g}); set mesh.kind = "
        "auto, or lower coarse_length; where auto is set, a leg has gone slack: keep it taut, or take mesh.kind = eem "
        "with more elements"
    )


def loop_unresolved(fine: float, error: float, bound: float, yaw: float, length: float) -> str:
    return (
        f"elements of {fine:.3g} m are too long for the bend: they put the loop up to {error:.2g} m from its place "
        f"(accuracy.loop = {bound:g} m) and turn it by up to {yaw:.2g} rad; set mesh.kind = auto, or take elements of "
        f"at most {length:.2g} m there"
    )


def no_torque_to_guard(threshold: float, fidelity: str) -> str:
    return (
        f"guard.torque = {threshold:g} N m sees nothing: the {fidelity} model computes no moment of the swivels; set "
        "model.fidelity = auto (or torsional)"
    )


def no_turns_to_guard(threshold: float, fidelity: str) -> str:
    return (
        f"guard.turns = {threshold:g} sees nothing: the {fidelity} model keeps the loop in its plane; set "
        "model.fidelity = auto (or torsional)"
    )


def no_swing_to_guard(threshold: float, fidelity: str) -> str:
    return (
        f"guard.window = {threshold:g} m sees nothing: the {fidelity} model's loop hangs midway between the ends at "
        "any time; set model.fidelity = auto (or torsional)"
    )


def no_rise_to_guard(threshold: float, fidelity: str) -> str:
    return (
        f"guard.rise = {threshold:g} m sees nothing: the {fidelity} model's loop is at its quasi-static place at any "
        "time; set model.fidelity = auto (or torsional), or count the rise from a height, guard.rise_y"
    )


def no_air(vx: float, vy: float, vz: float) -> str:
    return (
        f"air.density = 0, so that air that moves at ({vx:g}, {vy:g}, {vz:g}) m/s does nothing: give the density, 1.2 "
        "kg/m3 at the surface"
    )


def no_air_to_push(buffet: float) -> str:
    return f"air.density = 0, so that air.buffet = {buffet:g} does nothing: give the density, 1.2 kg/m3 at the surface"


def extrapolated_too_far(h: float, bound: float) -> str:
    return (
        f"a communication step of {h:g} s is too long for inputs that are extrapolated: beyond {bound:g} s forces err "
        "by some percent; communicate more often, or set inputs_at_step_end = true and give the motion at the end of "
        "each step"
    )


def of_end(side: str, told: str) -> str:
    return f"inputs of the {side} end: {told:.470}"


def positions_rounded(grid: float) -> str:
    return (
        f"positions look rounded to {grid:g} m; the end follows speed and acceleration and draws them in slowly; give "
        "more digits, or leave the position out (inputs.given = speed, 3)"
    )


def samples_repeated(steps: float, every: float, step: float) -> str:
    return (
        f"the sample of an earlier step came again in {steps:g} steps of {step:g} s, lately every {every:g} s, while "
        "the end moved: a slower part sends them, or samples are lost; the motion was extrapolated; communicate as "
        "often as they are sent"
    )


def table_too_coarse(every: float, step: float) -> str:
    return (
        f"positions look interpolated linearly between times {every:g} s apart, with steps of {step:g} s; the end "
        "follows the acceleration; give a table as fine as the steps, or steps as long as the table's"
    )


def motion_misfits(place: float, speed: float, acceleration: float) -> str:
    return (
        f"position, speed and acceleration are not of one motion: the end lags behind by up to {place:.3g} m and "
        f"{speed:.3g} m/s, and has up to {acceleration:.3g} m/s^2 more than given (inputs.misfit); check time stamps, "
        "units and signs, or name the trusted ones in inputs.given"
    )


def accuracy_given_up(steps: int, since: float, bound: int) -> str:
    return (
        f"accuracy was given up in {steps} steps since t = {since:.6g} s: they needed more Newton iterations than "
        f"work_max = {bound} allows a communication step; raise it, or communicate more often"
    )


def torque_of_coupling(Qb: float, Qc: float) -> str:
    return f"the coupling Qb = {Qb:g}, Qc = {Qc:g} N m: measure it on this rope, free the swivels"


def torque_of_twist(angle: float) -> str:
    return f"installed_twist = {angle:g} rad: lower it, free the swivels"


def torque_of_curvature(curvature: float, angle: float) -> str:
    return (
        f"initial_curvature = {curvature:g} 1/m, which lies at {angle:g} rad: lower it, or turn it to 0 rad, as the "
        "loop bends"
    )


def torque_of_ends(angle: float) -> str:
    return f"the ends, which twist the rope by {angle:g} rad: turn them back"
