"""Emergency stops with the brake; the motor is off.

    torque:        the full torque once the dead time is over
    two-stage:     a part of it, and the full torque from a given time after the trip
    deceleration:  regulated: the speed shall fall as |v_b| - a (t - t_b) from the speed v_b at which the brake bites,

        T = R [ m a - F_r + k_v e + I ] ,     e = |v| - v_asked ,     I <- I + H k_v e / T_i ,

with the force F_r that slows the hoist anyway: friction, and the imbalance when the heavier side rises. A brake can
only brake: T is cut to 0 and the full torque, and I then stands still. Once v_asked is 0 the full torque holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from hoist_demo.control.trajectory import Braking
from hoist_demo.parameters import Hoist


@dataclass(frozen=True)
class BrakeState:
    """Memory of a regulated stop."""

    bite_speed: float  # m/s, at the rim when the brake began to bite, with its sign
    integral: float = 0.0  # N


@dataclass(frozen=True)
class BrakeCommand:
    """Fraction of the full torque to hold until the next sample, and the state to go on with."""

    fraction: float
    state: BrakeState | None


class EmergencyBrake:
    """The laws for one hoist; the state is explicit."""

    def __init__(self, hoist: Hoist, gain: float, integral_time: float) -> None:
        """Gain k_v [N s/m] and integral time T_i [s] of a regulated stop."""
        self._hoist = hoist
        self._gain, self._integral_time = gain, integral_time

    def command(
        self, braking: Braking, speed: float, resistance: float, state: BrakeState | None, h: float
    ) -> BrakeCommand:
        """Command for the step of length h [s] that begins now, at a rim speed [m/s] against the resistance F_r [N]."""
        brake = self._hoist.brake
        if brake is None:
            raise ValueError(f"emergency_law = {braking.law!r} must be 'drive' for a hoist without a brake: fit one")
        if braking.elapsed < brake.delay:
            return BrakeCommand(0.0, None)
        if braking.law == "torque":
            return BrakeCommand(1.0, None)
        if braking.law == "two-stage":
            return BrakeCommand(brake.first_stage if braking.elapsed < brake.first_stage_time else 1.0, None)

        # regulated: the ramp begins where the brake bites
        state = BrakeState(speed) if state is None else state
        asked = abs(state.bite_speed) - braking.deceleration * (braking.elapsed - brake.delay)
        if asked <= 0.0:
            return BrakeCommand(1.0, state)
        error = math.copysign(1.0, state.bite_speed) * speed - asked
        wanted = self._hoist.moving_mass * braking.deceleration - resistance + self._gain * error + state.integral
        fraction = wanted * self._hoist.sheave_radius / brake.torque
        if not 0.0 <= fraction <= 1.0:
            return BrakeCommand(min(max(fraction, 0.0), 1.0), state)
        integral = state.integral + h * self._gain * error / self._integral_time
        return BrakeCommand(fraction, BrakeState(state.bite_speed, integral))
