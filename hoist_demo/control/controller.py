"""Speed controller of the hoist, sampled at the communication step H.

    e   = v_ref + k_s (s_ref - s) - v ,     v, s: rim speed of the sheave, measured travel of the left conveyance
    M_c = R [ m a_ref + F_hold + f s_ref + F_loss(v_ref) + k_v e + I ] ,     I <- I + H k_v e / T_i

F_hold holds the imbalance at the start, f = 2 g (tail - head rope mass per length) is its change per metre of travel,
F_loss the known friction at the reference speed. The three terms that follow the reference are the feed-forward; a
share of them between 0 (plain PI) and 1 is used.
The command is cut at the limits of torque and power, and the integral then stands still as long as it would push
further (conditional integration; K. J. Astrom and T. Hagglund, Advanced PID Control, 2006, section 3.5).
When the reference says that the safety brake stops the hoist, the motor is off and `emergency_brake` asks for it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from hoist_demo.control.trajectory import Braking, TrajectoryPoint
from hoist_demo.parameters import Hoist
from hoist_demo.parameters.quantity import Bounds, ValidatedData, parameter
from rope_model.physics.elementary import logical_and, maximum, minimum, tanh, where


@dataclass(frozen=True)
class BrakeState:
    """Memory of a regulated stop."""

    bite_speed: float  # m/s, at the rim when the brake began to bite, with its sign
    integral: float = 0.0  # N


@dataclass(frozen=True)
class Gains(ValidatedData, of="gain "):
    """Tuning; the defaults are ours [assumed] for the default hoist."""

    speed: float = parameter(1.5e5, "N s/m", "k_v")
    integral_time: float = parameter(1.0, "s", "T_i")
    position: float = parameter(1.0, "1/s", "k_s")
    feed_forward: float = parameter(
        1.0, "1", "share of the feed-forward that is used", Bounds(0.0, 1.0)
    )


def emergency_brake(
    hoist: Hoist,
    gains: Gains,
    braking: Braking,
    speed: float,
    resistance: float,
    state: BrakeState | None,
    h: float,
) -> tuple[float, BrakeState | None]:
    """Return the fraction of the full torque for the step of h [s] that begins now, and the state to go on with.

    The motor is off; `speed` is that of the rim [m/s], `resistance` F_r [N].

        torque:        the full torque once the dead time is over
        two-stage:     a part of it, and the full torque from a given time after the trip
        deceleration:  regulated: the speed shall fall as |v_b| - a (t - t_b) from v_b, at which the brake bites,

            T = R [ m a - F_r + k_v e + I ] ,     e = |v| - v_asked ,     I <- I + H k_v e / T_i ,

    with the force F_r that slows the hoist anyway: friction, and the imbalance when the heavier side rises. A brake can
    only brake: T is cut to 0 and the full torque, and I then stands still. Once v_asked is 0 the full torque holds.
    """
    brake = hoist.brake
    if brake is None:
        raise ValueError(
            f"emergency_law = {braking.law!r} must be 'drive' for a hoist without a brake: fit one"
        )
    if braking.elapsed < brake.delay:
        return 0.0, None
    if braking.law == "torque":
        return 1.0, None
    if braking.law == "two-stage":
        return brake.first_stage if braking.elapsed < brake.first_stage_time else 1.0, None

    # regulated: the ramp begins where the brake bites
    state = BrakeState(speed) if state is None else state
    target_speed = abs(state.bite_speed) - braking.deceleration * (braking.elapsed - brake.delay)
    if target_speed <= 0.0:
        return 1.0, state
    error = math.copysign(1.0, state.bite_speed) * speed - target_speed
    wanted = (
        hoist.moving_mass * braking.deceleration - resistance + gains.speed * error + state.integral
    )
    fraction = wanted * hoist.sheave_radius / brake.torque
    if not 0.0 <= fraction <= 1.0:
        return min(max(fraction, 0.0), 1.0), state
    return fraction, BrakeState(
        state.bite_speed, state.integral + h * gains.speed * error / gains.integral_time
    )


class Measurement(NamedTuple):
    """Measurements of the controller at its sample."""

    travel: float  # m, of the left conveyance since the start
    speed: float  # m/s, at the sheave's rim


class ControllerState(NamedTuple):
    """Integral part I [N], and what a regulated emergency stop remembers."""

    integral: float = 0.0
    brake: BrakeState | None = None


class Command(NamedTuple):
    """Torque to hold until the next sample, and the state to go on with."""

    torque: float  # N m
    limited: bool
    state: Any  # see Controller
    brake: float = 0.0  # -, fraction of the brake's full torque


class Controller(Protocol):
    """A control law that the host can sample.

    Whatever it remembers from sample to sample is in the state of its command, and nowhere else: the host takes samples
    back, and saves and restores them. The state is any plain data (`hoist_demo.cosimulation.plain_data` tells which),
    and the host hands over a copy, which may be changed.
    """

    def command(
        self, reference: TrajectoryPoint, measured: Measurement, state: Any, h: float
    ) -> Command:
        """Command for the step of length h [s] that begins now; `state` is the last command's, None at first."""


class SpeedController:
    """The control law; its state is explicit. The host evaluates its text, and exported drives have C made of it."""

    def __init__(self, hoist: Hoist, holding_torque: Any, gains: Any = None) -> None:
        """`holding_torque` [N m] is the motor's torque at rest at the start; it and the `Gains` may be symbols."""
        self._gains = Gains() if gains is None else gains
        self._radius = hoist.sheave_radius
        self._mass, self._imbalance_rate = hoist.moving_mass, hoist.imbalance_rate
        self._coulomb, self._viscous = hoist.travel_loss
        self._holding_torque = holding_torque
        self._hoist = hoist

    def command(
        self,
        reference: TrajectoryPoint,
        measured: Measurement,
        state: ControllerState | None,
        h: float,
    ) -> Command:
        """Torque command for the step of length h [s] that begins now."""
        state = ControllerState() if state is None else state
        *motion, _, braking = reference
        if braking is not None:
            return self._brake(braking, measured, state, h)
        torque, limited, integral = self.law(motion, *measured, state.integral, h)
        return Command(torque, limited, ControllerState(integral))

    def law(
        self, motion: Sequence[Any], travel: Any, speed: Any, integral: Any, h: Any
    ) -> tuple[Any, Any, Any]:
        """Return (torque [N m], limited, integral after h), also of symbols; `motion` is s, v, a of the reference."""
        force, error = self.force(motion, travel, speed, integral)
        wanted = self._holding_torque + self._radius * force
        limit = self._hoist.torque_available(speed / self._radius)
        torque = minimum(maximum(wanted, -limit), limit)
        # anti-windup: integrate unless that would push further into the limit
        stands = logical_and(torque != wanted, error * wanted > 0.0)
        grown = integral + h * self._gains.speed * error / self._gains.integral_time
        return torque, torque != wanted, where(stands, integral, grown)

    def force(
        self, motion: Sequence[Any], travel: Any, speed: Any, integral: Any
    ) -> tuple[Any, Any]:
        """Return the force at the rim beyond the one that holds [N], and the error of the speed [m/s]."""
        error = motion[1] + self._gains.position * (motion[0] - travel) - speed
        return self._gains.feed_forward * self.ahead(
            motion
        ) + self._gains.speed * error + integral, error

    def ahead(self, motion: Sequence[Any]) -> Any:
        """Return the force at the rim that a full feed-forward asks for, beyond the one that holds [N]."""
        position, speed, acceleration = motion
        return self._mass * acceleration + self._imbalance_rate * position + self._loss(speed)

    def _brake(
        self, braking: Braking, measured: Measurement, state: ControllerState, h: float
    ) -> Command:
        """Return the command of a stop by the brake: no motor torque, and the brake by its law."""
        holding_force = self._holding_torque / self._radius + self._imbalance_rate * measured.travel
        resistance = math.copysign(1.0, measured.speed) * holding_force + abs(
            self._loss(measured.speed)
        )
        fraction, brake = emergency_brake(
            self._hoist, self._gains, braking, measured.speed, resistance, state.brake, h
        )
        return Command(0.0, False, ControllerState(0.0, brake), fraction)

    def _loss(self, speed: Any) -> Any:
        """Friction at the rim and along the guides of both conveyances [N] at a rim speed [m/s]."""
        return self._coulomb * tanh(speed / self._hoist.loss_speed) + self._viscous * speed
