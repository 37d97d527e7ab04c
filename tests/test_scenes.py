"""The scenes themselves, minutes long: `make test-slow`."""

from __future__ import annotations

import numpy as np
import pytest

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model.parameters import rope_240
from rope_model.simulation.diagnostics import loop_bottom, observation_points
from rope_model.simulation.paths import EndMotion
from rope_model.simulation.simulator import RopeSimulator

H = 0.01


@pytest.mark.slow
def test_the_240_m_rope_winds_and_its_swivels_are_released() -> None:
    case = rope_240()
    trip = s_curve(Winding(travel=case.travel, speed=case.speed))
    rope = RopeSimulator(case.scene)
    assert rope.initialize(0.0, EndMotion(), EndMotion(y=case.travel)).valid
    events, dissipated, opposite = [], [0.0], []
    for k in range(1, round((trip.duration + 5.0) / H) + 1):
        p = trip.at(k * H)
        left = EndMotion(y=p.position, vy=p.speed, ay=p.acceleration)
        right = EndMotion(y=case.travel - p.position, vy=-p.speed, ay=-p.acceleration)
        status = rope.advance_to(k * H, left, right)
        assert status.valid, status.message
        events += [event for event in rope.state.events if "swivel" in event.what]
        dissipated.append(rope.state.energy_balance.dissipated_swivel)
        if k * H < 20.0 and k % 10 == 0:
            q = rope.state.motion.q
            z = observation_points(q, loop_bottom(q, rope.state.partition.lengths).position)[:, 2]
            opposite.append(z[0] > 0 > z[1] or z[0] < 0 < z[1])
    # both healthy swivels slip at once when they are released, and stick again and again
    assert [event.what for event in events[:2]] == ["left swivel slips +", "right swivel slips -"]
    assert {event.t for event in events[:2]} == {20.0}
    assert any("sticks" in event.what for event in events)
    assert np.all(np.diff(dissipated) >= -1e-12)
    assert abs(rope.state.energy_balance.residual) < 20.0  # J, of 1e5 J of kinetic energy
    # before the release the legs lean out of plane to opposite sides
    assert np.mean(opposite) > 0.95
