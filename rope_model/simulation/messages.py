"""What the rope says when something is refused, fails, is chosen or deserves a warning: the texts of both forms.

Each function is a text and nothing else: native.messages makes the C of it.  Numbers are written as ``{x}``, ``{x:g}``
or with a number of digits as ``{x:.3g}``.
"""

from __future__ import annotations

# the rope's start


def start_time_out_of_range(t: float, bound: float) -> str:
    return (
        f"the start time t = {t} s is out of range: it must be within {bound:g} s of 0, or steps are lost in rounding; "
        "count from another instant"
    )


def moves_at_start(side: str) -> str:
    return f"the {side} end moves at the start; a run starts from rest: give zero speeds"


def ends_above_each_other(apart: float) -> str:
    return (
        f"the ends hang exactly above each other, {apart:g} m apart, which leaves the loop no plane; move one sideways"
    )


def rope_too_short(length: float, width: float, height: float) -> str:
    return (
        f"the rope of {length:g} m cannot hang between ends {width:g} m apart with a height difference of "
        f"{height:g} m; give a longer rope or bring the ends together"
    )


def no_equilibrium(iterations: int, force: float) -> str:
    return (
        f"no equilibrium within {iterations} iterations: {force:.3g} N are left unbalanced; the rope may have none in "
        "this configuration (too much twist), the elements may be too long for EI, or a unit may be wrong"
    )


# its mesh


def fails_at_twist(reached: float, twist: float, why: str) -> str:
    return f"at {reached:.4g} of {twist:.4g} rad of twist: {why:.400}"


def fails_at_curvature(reached: float, curvature: float, why: str) -> str:
    return (
        f"at {reached:.4g} of initial_curvature = {curvature:.4g} 1/m, which should be lowered or lie as the loop "
        f"bends: {why:.380}"
    )


def fitted_mesh_fails(why: str) -> str:
    return f"{why:.400} (mesh.kind = auto takes them from EI, mass_per_length, spacing and accuracy.loop)"


def too_many_lengths(coarse: float, length: float, outer: float, most: int) -> str:
    return (
        f"coarse_length = {coarse:g} m divides a rope of {length:g} m into {outer:.0f} lengths, more than {most}; use "
        "longer elements"
    )


def too_few_lengths(inner: float, length: float) -> str:
    return (
        f"the mesh's segments II to VI need {inner:g} m of a rope of {length:g} m and leave nothing for I and VII; "
        "lower coarse_length or the counts"
    )


def too_many_elements(elements: float, most: int) -> str:
    return f"coarse_length and counts make {elements:.0f} elements, more than {most}; use fewer"


# motions of its ends


def input_not_finite(side: str, name: str, value: float) -> str:
    return f"input {side}.{name} = {value} is not finite; check the signal connected to it"


def input_out_of_range(side: str, name: str, value: float, bound: float) -> str:
    return f"input {side}.{name} = {value:g} is beyond +-{bound:g} (SI units); check its unit and connection"


def inputs_do_not_fit(side: str, name: str, acceleration: float, unit: str, bound: float) -> str:
    return (
        f"inputs {side}.{name} and its derivatives do not fit together: reaching them within the step would take "
        f"{acceleration:.3g} {unit} (bound {bound:g}); give position, speed and acceleration of one smooth motion"
    )


def nonzero_input(side: str, name: str, value: float) -> str:
    return f"{side}.{name} = {value:g}"


# steps


def time_goes_back(start: float, t: float) -> str:
    return f"cannot advance from t = {start:g} s to {t} s; time must go forward"


def too_far_at_once(start: float, t: float, most: int, step_max: float, longest: float) -> str:
    return (
        f"cannot advance from t = {start:g} s to {t} s at once: that takes more than {most} steps of step_max = "
        f"{step_max:g} s; communicate every {longest:g} s or more often"
    )


def too_many_steps(now: float, most: int, start: float, t: float) -> str:
    return (
        f"t = {now:.6g} s: {most} steps did not lead from t = {start:g} s to {t} s; communicate more often, or allow "
        "longer steps by step_max, step_min and tolerance"
    )


def fails_at(t: float, why: str) -> str:
    return f"t = {t:.6g} s: {why:.480}"


def error_too_large(error: float) -> str:
    return f"its local error is {error:.3g} times what the accuracy allows"


def step_fails(h: float, step_min: float, why: str) -> str:
    return (
        f"a step of {h:.3g} s, step_min = {step_min:g} s, fails too: {why}. Use shorter elements (coarse_length), a "
        "smaller step_min, or a gentler motion"
    )


def step_to_event_fails(why: str) -> str:
    return f"the step to a swivel event fails: {why}"


def swivel_chatters() -> str:
    return "a swivel chatters between stick and slip; check its friction, and whether the end is slack"


def rope_goes_slack(tension: float, t: float) -> str:
    return (
        f"the rope goes slack: tension {tension:.4g} N at t = {t:g} s, which the rigid model cannot follow; use a "
        "flexible one (model.fidelity = auto, planar or torsional) or a gentler motion"
    )


# the choice of the model


def cannot_follow(fidelity: str, why: str) -> str:
    return f"the {fidelity} model cannot follow {why:.300}"


def fixed_model_cannot_follow(fidelity: str, why: str) -> str:
    return f"the {fidelity} model cannot follow {why:.300}; set model.fidelity = auto (or torsional)"


def while_swivels_hold(why: str) -> str:
    return f"{why:.300} while its swivels hold"


def applied_forces() -> str:
    return "forces that are applied to places of the rope"


def errs_too_much(tolerance_percent: float, error_percent: float) -> str:
    return f"the ends within the tolerance of {tolerance_percent:.3g} %: it errs by an estimated {error_percent:.3g} %"


def would_go_slack(tension: float) -> str:
    return f"a rope that goes slack (tension {tension:.4g} N)"


def as_asked() -> str:
    return "as asked for"


def held_where_initialised(why: str) -> str:
    return f"{why:.300} where the rope is initialised with its swivels held"


def may_touch() -> str:
    return "the rope may touch a body in the shaft"


def may_touch_itself() -> str:
    return "the rope may touch itself"


def guards_watch() -> str:
    return "guards watch the loop, which may turn and swing"


def in_air() -> str:
    return "the air may carry the rope along"


def is_curved(curvature: float) -> str:
    return f"the rope has a permanent curvature of {curvature:g} 1/m"


def is_pushed() -> str:
    return "forces are applied to places of the rope"


def no_torque() -> str:
    return "no torque acts and nothing acts out of plane"


def coupled(Qb: float, Qc: float) -> str:
    return f"tension and torsion are coupled (Qb = {Qb:g}, Qc = {Qc:g} N m)"


def twisted(angle: float) -> str:
    return f"the rope is twisted by {angle:g} rad"


def torque_and_more(torque: str, why: str) -> str:
    return f"{torque:.200}; the spatial model cannot follow {why:.200}"


def errs_little(
    fidelity: str, error_percent: float, tolerance_percent: float, speed: float, acceleration: float, jerk: float
) -> str:
    return (
        f"the {fidelity} model errs by an estimated {error_percent:.2g} %, within the tolerance of "
        f"{tolerance_percent:.3g} %, for ends at up to {speed:g} m/s, {acceleration:g} m/s^2 and {jerk:g} m/s^3"
    )


# warnings


def passed_into(body: str, touched: float, depth: float, t: float, s: float, y: float) -> str:
    return (
        f"{body} from t = {touched:.6g} s on (deepest by {depth:.3g} m at {t:.6g} s, {s:.4g} m along it, at y = "
        f"{y:.4g} m)"
    )


def and_another(before: str, passed: str) -> str:
    return f"{before:.380} and {passed:.120}"


def rope_struck(what: str) -> str:
    return f"the rope has struck {what:.430}; the outputs contact.* have the forces"


def rope_pressed_into(what: str, stiffness: float) -> str:
    return (
        f"the rope was pressed into {what:.330}, by more than its diameter: contact.stiffness = {stiffness:g} is too "
        "soft for it"
    )


def rope_passed_into(what: str) -> str:
    return f"the rope has passed into {what:.400}; contact is not computed: nothing after that is what a real rope does"


def sides_passed(number: float, since: float, y: float) -> str:
    return (
        "the rope's legs have passed through each other, or one of them through the conveyance and head ropes above "
        f"the other: {number:g} times (loop.crossings), the first at t = {since:.6g} s around y = {y:.4g} m; contact "
        "is not computed: nothing after that is what a real rope does; contact.rope_stiffness = 1e7 computes that of "
        "the legs; lower Qb, Qc or installed_twist, free the swivels, or widen the spacing"
    )


def sides_passed_in_spite(number: float, since: float, y: float, stiffness: float) -> str:
    return (
        "one side of the rope has passed through the other, the conveyance and head ropes above its end where the "
        f"scene has none, or the leg where contact.rope_stiffness = {stiffness:g} is too soft for it: {number:g} times "
        f"(loop.crossings), the first at t = {since:.6g} s around y = {y:.4g} m; nothing after that is what a real "
        "rope does; give conveyance and head_ropes, raise contact.rope_stiffness, lower Qb, Qc or installed_twist, or "
        "free the swivels"
    )


def turned_around(turns: float) -> str:
    return (
        f"the rope is turned around itself: one leg has swung {turns:.3g} turns about the other and the conveyance and "
        "head ropes above it (loop.turns); half a turn is a loop turned over; lower Qb, Qc or installed_twist, free "
        "the swivels, or widen the spacing"
    )


def legs_touch(overlap: float, since: float, y: float) -> str:
    return (
        f"the rope's legs have touched each other, first at t = {since:.6g} s, and lain in each other by up to "
        f"{overlap:.3g} m (loop.overlap) around y = {y:.4g} m; contact is not computed, and a real rope would lie "
        "against itself: contact.rope_stiffness = 1e7 computes it; keep the legs taut, lower Qb, Qc or "
        "installed_twist, free the swivels, or widen the spacing"
    )


def legs_press(overlap: float, since: float, y: float) -> str:
    return (
        f"the rope's legs have pressed each other, first at t = {since:.6g} s, by up to {overlap:.3g} m (loop.overlap) "
        f"around y = {y:.4g} m; contact.rope has the force; keep the legs taut, lower Qb, Qc or installed_twist, free "
        "the swivels, or widen the spacing"
    )


def yawed_at_rest(yaw: float, bound: float, source: str) -> str:
    return (
        f"the loop hangs yawed by {yaw:.3g} rad against its ends at rest (bound {bound:.3g} rad), turned mostly by "
        f"{source:.300}, or widen the spacing"
    )


def other_rests(angle: float) -> str:
    return (
        f"the rope has more than one way to hang: turned in slowly it snapped over at {angle:.3g} rad of twist, and "
        "hangs as it came to rest after that; use less twist (installed_twist, yaw of the ends), or free the swivels"
    )


def forces_missing(force: float, bound: float) -> str:
    return (
        f"{force:.3g} N are missing between the end forces, the weight and the change of the rope's momentum "
        f"(audit.momentum, bound {bound:.3g} N): time steps are too long for this motion, the state was altered from "
        "outside, or the rope computes wrongly; lower step_max, or go back to a state that was saved before, and "
        "report what neither mends"
    )


def moments_missing(moment: float, bound: float) -> str:
    return (
        f"{moment:.3g} N m are missing between what acts on the rope and the change of its angular momentum "
        f"(audit.moment, bound {bound:.3g} N m): time steps are too long for this motion, or the state was altered "
        "from outside; lower step_max, or go back to a state that was saved before"
    )


def waves_unresolved(change: float, steps: float, bound: float, step: float) -> str:
    return (
        f"an end force changes by {change:.3g} N in one time step, of which an axial period of the rope's longer leg "
        f"has {steps:.3g} (bound {bound:.3g}): its waves are not resolved; lower step_max to {step:.2g} s"
    )


def bend_unresolved(elements: float, bound: float) -> str:
    return (
        f"the rope's sharpest bend has {elements:.3g} elements in half a turn (bound {bound:.3g}): they are too "
        "long for it; set mesh.kind = auto, or lower coarse_length; where auto's are too long, a leg has gone slack: "
        "keep it taut, or take mesh.kind = eem with more elements"
    )


def no_air(vx: float, vy: float, vz: float) -> str:
    return (
        f"air.density = 0, so that air that moves at ({vx:g}, {vy:g}, {vz:g}) m/s does nothing: give the density, "
        "1.2 kg/m3 at the surface"
    )


def no_air_to_push(buffet: float) -> str:
    return f"air.density = 0, so that air.buffet = {buffet:g} does nothing: give the density, 1.2 kg/m3 at the surface"


def accuracy_given_up(steps: int, since: float, bound: int) -> str:
    return (
        f"accuracy was given up in {steps} steps since t = {since:.6g} s: they wanted more Newton iterations than "
        f"work_max = {bound} allows a communication step; raise it, or communicate more often"
    )


def torque_of_coupling(Qb: float, Qc: float) -> str:
    return f"the coupling Qb = {Qb:g}, Qc = {Qc:g} N m: give what was measured on this very rope, free the swivels"


def torque_of_twist(angle: float) -> str:
    return f"installed_twist = {angle:g} rad: lower it, free the swivels"


def torque_of_curvature(curvature: float, angle: float) -> str:
    return (
        f"initial_curvature = {curvature:g} 1/m, which lies at {angle:g} rad: lower it, or turn it to 0 rad, as the "
        "loop bends"
    )


def torque_of_ends(angle: float) -> str:
    return f"the ends, which twist the rope by {angle:g} rad: turn them back"


# use


def no_state() -> str:
    return "the rope has no state yet; call initialize first"


def no_finite_derivative() -> str:
    return "the equations of this state have no finite derivative; take a smaller step_max"


# use of the native form alone


def no_memory(elements: int, megabytes: float) -> str:
    return f"no memory for {elements} elements ({megabytes:.3g} MB); use fewer"


def wrong_number_of_bytes(found: int, own: int) -> str:
    return f"the saved state has {found} bytes, one of this rope {own}; restore it into a rope with the same parameters"


def bytes_are_no_state() -> str:
    return "these bytes are not a state of this rope; save one anew, or restore it into its own rope"


def no_such_input() -> str:
    return "an input's number is 0 to 21"
