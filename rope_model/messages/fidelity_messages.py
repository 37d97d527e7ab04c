"""Reasons why a fidelity of the model serves, or does not: texts as in messages."""

from rope_model.messages.text import Template

cannot_follow = Template("the {fidelity:s} model cannot follow {why:.300}")
fixed_model_cannot_follow = Template(
    "the {fidelity:s} model cannot follow {why:.300}; set model.fidelity = auto (or torsional)"
)
while_swivels_hold = Template("{why:.300} while its swivels hold")
applied_forces = Template("forces that are applied to places of the rope")
error_above_tolerance = Template(
    "the ends within the tolerance of {tolerance_percent:.3g} %: its estimated error is {error_percent:.3g} %"
)
would_go_slack = Template("a rope that goes slack (tension {tension:.4g} N)")
as_set = Template("set by model.fidelity")
held_where_initialised = Template("{why:.300} where the rope is initialised with its swivels held")
may_touch = Template("the rope may touch a body in the shaft")
may_touch_itself = Template("the rope may touch itself")
guards_watch = Template("guards watch the loop, which may turn and swing")
in_air = Template("the air may carry the rope along")
is_curved = Template("the rope has a permanent curvature of {curvature:g} 1/m")
not_plumb = Template("an end is not held plumb")
is_pushed = Template("forces are applied to places of the rope")
no_torque = Template("no torque acts and nothing acts out of plane")
coupled = Template("tension and torsion are coupled (Qb = {Qb:g}, Qc = {Qc:g} N m)")
twisted = Template("the rope is twisted by {angle:g} rad")
torque_and_unsupported = Template("{torque:.200}; the spatial model cannot follow {why:.200}")
error_within_tolerance = Template(
    "the estimated error of the {fidelity:s} model is {error_percent:.2g} %, within the tolerance of "
    "{tolerance_percent:.3g} %, for ends at up to {speed:g} m/s, {acceleration:g} m/s^2 and {jerk:g} m/s^3"
)
