"""Messages of refusals and failures: the texts of both forms.

Each function is a text and nothing else: codegen.messages makes the C of it.  Numbers are written as ``{x}``, ``{x:g}``
or with a number of digits as ``{x:.3g}``.  Warnings are in warning_messages, reasons for a fidelity in
fidelity_messages.
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
        f"the ends hang exactly above each other, {apart:g} m apart, so that the loop has no plane; move one sideways"
    )


def rope_too_short(length: float, width: float, height: float) -> str:
    return (
        f"the rope of {length:g} m cannot hang between ends {width:g} m apart with a height difference of {height:g} "
        "m; give a longer rope or bring the ends together"
    )


def no_equilibrium(iterations: int, force: float) -> str:
    return (
        f"no equilibrium within {iterations} iterations: {force:.3g} N are left unbalanced; check twist, units and the "
        "room between bodies, or take elements that are shorter for EI"
    )


def end_in_lining(inside: float, width: float, depth: float, x: float, z: float) -> str:
    return (
        f"no equilibrium: an end of the rope lies {inside:.3g} m in the shaft's lining, which is {width:g} m wide and "
        f"{depth:g} m deep about x = {x:g} m, z = {z:g} m; both ends must hang within it: change lining.*, or lower "
        "layout.spacing"
    )


def end_below_floor(below: float, level: float) -> str:
    return (
        f"no equilibrium: an end of the rope hangs {below:.3g} m below the sump's floor, sump.level = {level:g} m; "
        "give its height from the origin of left.y and right.y"
    )


# its mesh


def fails_at_twist(reached: float, twist: float, step: float, iterations: int, why: str) -> str:
    return (
        f"at {reached:.4g} of {twist:.4g} rad of twist (last increment {step:.2g} rad, {iterations} iterations in "
        f"all): {why:.340}"
    )


def takes_too_long() -> str:
    return "more than ropes need that come to rest; use less twist, or a shorter rope"


def fails_at_curvature(reached: float, curvature: float, why: str) -> str:
    return (
        f"at {reached:.4g} of initial_curvature = {curvature:.4g} 1/m (lower it, or let it lie as the loop bends): "
        f"{why:.380}"
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
        f"{acceleration:.3g} {unit} (inputs.acceleration_max = {bound:g}); give position, speed and acceleration of "
        "one smooth motion"
    )


def input_misfit(side: str, name: str, misfit: float, unit: str, bound: float) -> str:
    return (
        f"input {side}.{name} is {misfit:.3g} {unit} away from the motion of its derivatives (inputs.misfit_max = "
        f"{bound:g}); give position, speed and acceleration of one motion, or name the trusted ones in inputs.given"
    )


def motions_of_another_time(given_at: float, earliest: float, t: float) -> str:
    return (
        f"the ends' motions are of t = {given_at:.9g} s: they must be of {earliest:.9g} s (inputs.hold_max before the "
        f"step) to {t:.9g} s, where it ends; give the instant at which they were read"
    )


def inputs_frozen(side: str, held: float, bound: float) -> str:
    return (
        f"the inputs of the {side} end have not changed for {held:.3g} s although it moves (inputs.hold_max = "
        f"{bound:g} s); check whether their sender still runs"
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


def too_much_work(now: float, iterations: int, start: float, t: float) -> str:
    return (
        f"t = {now:.6g} s: {iterations} Newton iterations did not lead from t = {start:g} s to {t} s; communicate more "
        "often, allow larger errors, or bound the work by work_max"
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


def transformation_fails(step_min: float, why: str) -> str:
    return (
        f"the transformation of the mesh fails, within step_min = {step_min:g} s too: {why}. Use equal elements "
        "(mesh.kind = eem), a smaller step_min, or a gentler motion"
    )


def swivel_chatters() -> str:
    return "a swivel chatters between stick and slip; check its friction, and whether the end is slack"


def rope_goes_slack(tension: float, t: float) -> str:
    return (
        f"the rope goes slack: tension {tension:.4g} N at t = {t:g} s, which the rigid model cannot follow; use a "
        "flexible one (model.fidelity = auto, planar or torsional) or a gentler motion"
    )


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
