"""Speed controller of the hoist, sampled at the communication step H.

    e   = v_ref + k_s (s_ref - s) - v ,
    M_c = R [ m a_ref + F_hold + f s_ref + F_loss(v_ref) + k_v e + I ] ,     I <- I + H k_v e / T_i

with v the rim speed of the sheave and s the measured travel of the left conveyance. F_hold holds
the imbalance at the start, f = 2 g (tail - head rope mass per length) is its change per metre of
travel, F_loss the known friction at the reference speed. The three terms that follow the reference
are the feed-forward; a share of them between 0 (plain PI) and 1 is used. The command is cut at the
limits of torque and power, and the integral then stands still as long as it would push further
(conditional integration; K. J. Astrom and T. Hagglund, Advanced PID Control, 2006, section 3.5). In
an emergency stop with the safety brake the motor is off, and ``emergency_brake`` gives the brake's
command.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from hoist_demo.control.trajectory import Braking, TrajectoryPoint
from hoist_demo.parameters import Hoist
from hoist_demo.parameters.quantity import NumberRange, ValidatedData, parameter
from rope_model.physics.elementary import Scalar, logical_and, maximum, minimum, tanh, where


@dataclass(frozen=True)
class BrakeState:
    """Memory of a regulated stop."""

    bite_speed: float  # m/s, at the rim when the brake began to bite, with its sign
    integral: float = 0.0  # N


@dataclass(frozen=True)
class Gains(ValidatedData, of="gain "):
    """Tuning; the defaults are ours [assumed] for the default hoist."""

    speed: float = parameter(1.5e5, "N s/m", "gain k_v of the speed loop")
    integral_time: float = parameter(1.0, "s", "integral time T_i of the speed loop")
    position: float = parameter(1.0, "1/s", "gain k_s of the position loop")
    feed_forward: float = parameter(
        1.0, "1", "share of the feed-forward that is used", NumberRange(0.0, 1.0)
    )


class RimMotion(NamedTuple):
    """Motion of the sheave's rim with the motor off."""

    speed: float  # m/s
    resistance: float  # N, force that slows the hoist without its brake


class BrakeCommand(NamedTuple):
    """Command to the brake until the next sample, and its state to go on with."""

    fraction: float  # -, of the full torque
    state: BrakeState | None = None


_FULL_TORQUE = 1.0  #: Fraction of the brake's torque.


def emergency_brake(
    hoist: Hoist,
    gains: Gains,
    braking: Braking,
    rim: RimMotion,
    state: BrakeState | None,
    h: float,
) -> BrakeCommand:
    """Return the command for the step of h [s] that begins now; the motor is off.

        torque:        the full torque once the dead time is over
        two-stage:     a part of it, and the full torque from a given time after the trip
        deceleration:  regulated: the speed shall fall as v_target = |v_b| - a (t - t_b) from v_b, at
                       which the brake bites,

            T = R [ m a - F_r + k_v e + I ] ,   e = |v| - v_target ,   I <- I + H k_v e / T_i ,

    with the resistance F_r: friction, and the imbalance when the heavier side rises. A brake can
    only brake: T is cut to 0 and the full torque, and I then stands still. Once v_target is 0 the
    full torque holds.
    """
    brake = hoist.brake
    if brake is None:
        raise ValueError(
            f"emergency_law = {braking.law!r} must be 'drive' for a hoist without a brake: fit one"
        )
    if braking.elapsed < brake.delay:
        return BrakeCommand(0.0)
    if braking.law == "torque":
        return BrakeCommand(_FULL_TORQUE)
    if braking.law == "two-stage":
        if braking.elapsed < brake.first_stage_time:
            return BrakeCommand(brake.first_stage)
        return BrakeCommand(_FULL_TORQUE)

    # regulated: the ramp begins where the brake bites
    state = state or BrakeState(rim.speed)
    target_speed = abs(state.bite_speed) - braking.deceleration * (braking.elapsed - brake.delay)
    if target_speed <= 0.0:
        return BrakeCommand(_FULL_TORQUE, state)
    error = math.copysign(1.0, state.bite_speed) * rim.speed - target_speed
    inertia = hoist.moving_mass * braking.deceleration
    force = inertia - rim.resistance + gains.speed * error + state.integral
    fraction = force * hoist.sheave_radius / brake.torque
    if not 0.0 <= fraction <= _FULL_TORQUE:
        return BrakeCommand(min(max(fraction, 0.0), _FULL_TORQUE), state)
    integral = state.integral + h * gains.speed * error / gains.integral_time
    return BrakeCommand(fraction, BrakeState(state.bite_speed, integral))


class Measurement(NamedTuple):
    """Measurements of the controller at its sample."""

    travel: float  # m, of the left conveyance since the start
    speed: float  # m/s, at the sheave's rim


class ControllerState(NamedTuple):
    """Integral part I [N], and the state of a regulated emergency stop."""

    integral: float = 0.0
    brake: BrakeState | None = None


class Command(NamedTuple):
    """Torque to hold until the next sample, and the state to go on with."""

    torque: float  # N m
    limited: bool
    state: Any  # see Controller
    brake: float = 0.0  # -, fraction of the brake's full torque


class LawResult(NamedTuple):
    """Result of the control law of SpeedController, of numbers or symbols."""

    torque: Scalar  # N m
    limited: Any  # bool, or a symbol
    integral: Scalar  # N, after the step


class Controller(Protocol):
    """A control law that the host can sample.

    Its memory from sample to sample is in the state of its command, and nowhere else: the host
    takes samples back, and saves and restores them. The state is any plain data, see
    ``hoist_demo.cosimulation.participants.plain_data``, and the host hands over a copy, which may
    be changed.
    """

    def command(
        self, reference: TrajectoryPoint, measured: Measurement, state: Any, h: float
    ) -> Command:
        """Command for the step of length h [s] that begins now.

        ``state`` is that of the last command, None at first.
        """


#: Makes a controller of the hoist and the motor's torque at rest [N m].
ControllerFactory = Callable[[Hoist, float], Controller]


class SpeedController:
    """The control law; its state is explicit.

    The host evaluates it, and the C of exported drives is generated from it.
    """

    def __init__(self, hoist: Hoist, holding_torque: Scalar, gains: Any = None) -> None:
        """``holding_torque`` [N m] is the motor's torque at rest at the start.

        It and the ``gains`` may be symbols; default: ``Gains``.
        """
        self._gains = Gains() if gains is None else gains
        self._radius = hoist.sheave_radius
        self._mass = hoist.moving_mass
        self._imbalance_rate = hoist.imbalance_rate
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
        if state is None:
            state = ControllerState()
        if reference.braking is not None:
            return self._brake(reference.braking, measured, state, h)
        motion = (reference.position, reference.speed, reference.acceleration)
        torque, limited, integral = self.law(motion, *measured, state.integral, h)
        return Command(torque, limited, ControllerState(integral))

    def law(
        self,
        motion: Sequence[Scalar],
        travel: Scalar,
        speed: Scalar,
        integral: Scalar,
        h: Scalar,
    ) -> LawResult:
        """Return the command, also of symbols; ``motion`` is s, v, a of the reference."""
        force, error = self.force(motion, travel, speed, integral)
        unlimited = self._holding_torque + self._radius * force
        limit = self._hoist.torque_available(speed / self._radius)
        torque = minimum(maximum(unlimited, -limit), limit)
        # anti-windup: integrate unless that would push further into the limit
        stands = logical_and(torque != unlimited, error * unlimited > 0.0)
        integrated = integral + h * self._gains.speed * error / self._gains.integral_time
        return LawResult(torque, torque != unlimited, where(stands, integral, integrated))

    def force(
        self, motion: Sequence[Scalar], travel: Scalar, speed: Scalar, integral: Scalar
    ) -> tuple[Scalar, Scalar]:
        """Return the force at the rim beyond F_hold [N], and the error of the speed [m/s]."""
        position_ref, speed_ref, _ = motion
        error = speed_ref + self._gains.position * (position_ref - travel) - speed
        feed_forward = self._gains.feed_forward * self.feed_forward(motion)
        return feed_forward + self._gains.speed * error + integral, error

    def feed_forward(self, motion: Sequence[Scalar]) -> Scalar:
        """Return the force at the rim of a full feed-forward, beyond F_hold [N]."""
        position, speed, acceleration = motion
        return self._mass * acceleration + self._imbalance_rate * position + self._loss(speed)

    def _brake(
        self, braking: Braking, measured: Measurement, state: ControllerState, h: float
    ) -> Command:
        """Return the command of a stop by the brake: no motor torque, and the brake by its law."""
        holding_force = self._holding_torque / self._radius + self._imbalance_rate * measured.travel
        imbalance = math.copysign(1.0, measured.speed) * holding_force
        rim = RimMotion(measured.speed, resistance=imbalance + abs(self._loss(measured.speed)))
        brake = emergency_brake(self._hoist, self._gains, braking, rim, state.brake, h)
        return Command(
            torque=0.0,
            limited=False,
            state=ControllerState(integral=0.0, brake=brake.state),
            brake=brake.fraction,
        )

    def _loss(self, speed: Scalar) -> Scalar:
        """Friction at the rim and along the guides of both conveyances [N] at a rim speed [m/s]."""
        return self._coulomb * tanh(speed / self._hoist.loss_speed) + self._viscous * speed
