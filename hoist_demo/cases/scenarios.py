"""Faults in a shaft, by name: trips of the published hoists that end in an emergency, or begin with a fault.

overwind        the trip ends so far above its landing that the loop comes within 4 m of the rope's end
slack-rope      the brake grips at once with its full torque, harder than gravity, and the head ropes hold, as if they
                were clamped: the rope under the rising conveyance goes slack, and jerks when it falls back; its legs
                hold each other where they meet. Where friction alone holds the head ropes (hoist.lining) both their
                sides keep some tension, no conveyance slows down harder than gravity, and nothing goes slack
seized-swivel   one of two swivels does not turn
jammed-conveyance
                the descending conveyance catches in its guides; its head ropes go slack, which opens the safety
                circuit, and slip on the sheave; the slack legs hold each other as above
caught-rope     an emergency stop swings the loop up under a divider within it, which holds it and lets it go
"""

from __future__ import annotations

from dataclasses import replace

from hoist_demo.cases.case import COULOMB, LOCKED, PUBLISHED_ROPE, Case, swivels
from hoist_demo.parameters import Hoist, Winding
from hoist_demo.parameters.components import Brake, Jam, Lining

_HOIST, _WINDING = Hoist(), Winding()
_ROPE = {"rope.length": _HOIST.tail_rope_length, **swivels(LOCKED)}
#: of legs that go slack, and fall about each other
_SLACK = _ROPE | {"contact.rope_stiffness": 1e7}
#: m: of the rope's length
_OVERWIND = _HOIST.tail_rope_length - 8.0
_STOPPED = replace(_WINDING, emergency_at=12.0, settle=20.0)
_DEEP = Hoist(shaft_travel=200.0, tail_rope_length=240.0)

SCENARIOS = {
    "overwind": Case(
        replace(_HOIST, shaft_travel=_OVERWIND), replace(_WINDING, travel=_OVERWIND), rope=_ROPE, stated=PUBLISHED_ROPE
    ),
    "slack-rope": Case(
        replace(_HOIST, brake=Brake(torque=8e5)),
        replace(_WINDING, emergency_at=8.0, emergency_law="torque"),
        rope=_SLACK,
        stated=PUBLISHED_ROPE,
    ),
    "seized-swivel": Case(
        _DEEP,
        Winding(travel=200.0, speed=10.0),
        rope={"rope.length": _DEEP.tail_rope_length, **swivels(COULOMB, release_time=0.0), "left.swivel.mode": LOCKED},
        stated=PUBLISHED_ROPE,
    ),
    "jammed-conveyance": Case(
        replace(_HOIST, brake=Brake(), lining=Lining(), jam_right=Jam(), slack_tension=2e4),
        replace(_WINDING, emergency_law="deceleration", settle=20.0),
        rope=_SLACK,
        stated=PUBLISHED_ROPE,
    ),
    "caught-rope": Case(
        _HOIST, _STOPPED, rope=_ROPE | {"divider_1.size": 0.2, "divider_1.y": -12.5}, stated=PUBLISHED_ROPE
    ),
}
