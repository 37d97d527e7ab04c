"""Messages of refusals and failures.

codegen.messages makes the C of them.  Warnings are in warning_messages, reasons for a fidelity in
fidelity_messages.
"""

from rope_model.messages.text import Template

# the rope's start
start_time_out_of_range = Template(
    "the start time t = {t} s is out of range: it must be within {bound:g} s of 0, or steps are lost in rounding; "
    "count from another instant"
)
moves_at_start = Template(
    "the {side:s} end moves at the start; a run starts from rest: give zero speeds"
)
ends_above_each_other = Template(
    "the ends hang exactly above each other, {apart:g} m apart, so that the loop has no plane; move one sideways"
)
rope_too_short = Template(
    "the rope of {length:g} m cannot hang between ends {width:g} m apart with a height difference of {height:g} m; "
    "give a longer rope or bring the ends together"
)
no_equilibrium = Template(
    "no equilibrium within {iterations:d} iterations: {force:.3g} N are left unbalanced; check twist, units and the "
    "room between bodies, or take elements that are shorter for EI"
)
winds_about_itself = Template(
    "no equilibrium: the rope goes on winding about itself, with {force:.3g} N left unbalanced "
    "after {most:d} solutions for its contact; lower the coupling, the installed twist or the length, or hang it "
    "without this contact: contact.rope_stiffness = 0"
)
not_laid_down = Template(
    "no equilibrium: {corrections:d} corrections laid the rope down by {laid:.3g} of the {below:.3g} m "
    "by which the sump's floor is higher than the loop of a rope that hangs freely; lower sump.level = "
    "{level:g} m, or start with the ends higher"
)
end_in_lining = Template(
    "no equilibrium: an end of the rope lies {inside:.3g} m in the shaft's lining, which is {width:g} m wide and "
    "{depth:g} m deep about x = {x:g} m, z = {z:g} m; both ends must hang within it: change lining.*, or lower "
    "layout.spacing"
)
end_below_floor = Template(
    "no equilibrium: an end of the rope hangs {below:.3g} m below the sump's floor, sump.level = {level:g} m; give its "
    "height from the origin of left.y and right.y"
)

fails_at_twist = Template(
    "at {reached:.4g} of {twist:.4g} rad of twist (last increment {step:.2g} rad, {iterations:d} iterations in all): "
    "{why:.340}"
)
takes_too_long = Template("more than the rest of a rope takes; use less twist, or a shorter rope")
fails_at_curvature = Template(
    "at {reached:.4g} of a permanent curvature of {curvature:.4g} 1/m (lower it, or let it lie as the loop bends): "
    "{why:.380}"
)
# its mesh
fit_fails = Template(
    "{why:.400} (mesh.kind = auto takes them from EI, mass_per_length, spacing and accuracy.loop)"
)
too_many_lengths = Template(
    "coarse_length = {coarse:g} m divides a rope of {length:g} m into {outer:.0f} lengths, more than {most:d}; use "
    "longer elements"
)
too_few_lengths = Template(
    "the mesh's segments II to VI need {inner:g} m of a rope of {length:g} m and leave nothing for I and VII; lower "
    "coarse_length or the counts"
)
too_many_elements = Template(
    "coarse_length and counts make {elements:.0f} elements, more than {most:d}; use fewer"
)

# motions of its ends
input_not_finite = Template(
    "input {side:s}.{name:s} = {value} is not finite; check the signal connected to it"
)
input_out_of_range = Template(
    "input {side:s}.{name:s} = {value:g} is beyond +-{bound:g} (SI units); check its unit and connection"
)
no_clamp = Template(
    "{side:s}.{name:s} = {value:g} rad needs a clamp; set {side:s}.swivel.attachment = clamped or give 0"
)
inputs_do_not_fit = Template(
    "inputs {side:s}.{name:s} and its derivatives do not fit together: reaching them within the step would take "
    "{acceleration:.3g} {unit:s} (inputs.acceleration_max = {bound:g}); give one smooth motion, with its speed and "
    "acceleration where these are inputs"
)
input_misfit = Template(
    "input {side:s}.{name:s} is {misfit:.3g} {unit:s} away from the motion of its derivatives (inputs.misfit_max = "
    "{bound:g}); give position, speed and acceleration of one motion, or name the trusted ones in inputs.given"
)
input_jump = Template(
    "input {side:s}.{name:s} jumps by {misfit:.3g} {unit:s} more than the samples before let expect "
    "(inputs.misfit_max = {bound:g}; estimates may lag by {lag:.2g} s, 3 / inputs.estimate_bandwidth, here "
    "{bandwidth:.3g} rad/s); give one smooth motion, check its unit, or raise inputs.estimate_bandwidth"
)
motions_of_another_time = Template(
    "the ends' motions are of t = {given_at:.9g} s: they must be of {earliest:.9g} s (inputs.hold_max before the step) "
    "to {t:.9g} s, where it ends; give the instant at which they were read"
)
inputs_frozen = Template(
    "the inputs of the {side:s} end have not changed for {held:.3g} s although it moves (inputs.hold_max = {bound:g} "
    "s); check whether their sender still runs"
)
nonzero_input = Template("{side:s}.{name:s} = {value:g}")

# steps
time_goes_back = Template("cannot advance from t = {start:g} s to {t} s; time must go forward")
too_far_at_once = Template(
    "cannot advance from t = {start:g} s to {t} s at once: that takes more than {most:d} steps of step_max = "
    "{step_max:g} s; communicate every {longest:g} s or more often"
)
too_many_steps = Template(
    "t = {now:.6g} s: {most:d} steps did not lead from t = {start:g} s to {t} s; communicate more often, or allow "
    "longer steps by step_max, step_min and tolerance"
)
too_much_work = Template(
    "t = {now:.6g} s: {iterations:d} Newton iterations did not lead from t = {start:g} s to {t} s; communicate more "
    "often, allow larger errors, or bound the work by work_max"
)
fails_at = Template("t = {t:.6g} s: {why:.480}")
error_too_large = Template("its local error is {error:.3g} times what the accuracy allows")
step_fails = Template(
    "a step of {h:.3g} s, step_min = {step_min:g} s, fails too: {why:s}. Use shorter elements (coarse_length), a "
    "smaller step_min, or a gentler motion"
)
step_to_event_fails = Template("the step to a swivel event fails: {why:s}")
transformation_fails = Template(
    "the transformation of the mesh fails, within step_min = {step_min:g} s too: {why:s}. Use equal elements "
    "(mesh.kind = eem), a smaller step_min, or a gentler motion"
)
swivel_chatters = Template(
    "a swivel chatters between stick and slip; check its friction, and whether the end is slack"
)
rope_goes_slack = Template(
    "the rope goes slack: tension {tension:.4g} N at t = {t:g} s, which the rigid model cannot follow; use a flexible "
    "one (model.fidelity = auto, planar or torsional) or a gentler motion"
)

# use
no_state = Template("the rope has no state yet; call initialize first")
no_finite_derivative = Template(
    "the equations of this state have no finite derivative; take a smaller step_max"
)
no_derivative = Template(
    "the derivatives of the last communication step cannot be computed: {why:.400}"
)
too_many_to_differentiate = Template(
    "it took {steps:d} internal steps, and derivatives are those of at most {most:d}; take shorter communication steps"
)

# use of one form of the rope alone
rigid_under_forces = Template(
    "forces do not move the places of a rope with the rigid model; set model.fidelity = torsional (or spatial, planar)"
)
no_memory = Template("no memory for {elements:d} elements ({megabytes:.3g} MB); use fewer")
wrong_number_of_bytes = Template(
    "the saved state has {found:d} bytes, one of this rope {own:d}; restore it into a rope with the same parameters"
)
no_state_in_bytes = Template(
    "these bytes are not a state of this rope; save one anew, or restore it into its own rope"
)
engine_alone = Template(
    "{refused:s}; take the engine, balance_rope(scene), or an FMU of the native flavour"
)
no_such_input = Template("an input's number is 0 to {last:d}")
