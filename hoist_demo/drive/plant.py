"""The drive: motor, sheave, head ropes and two conveyances, integrated over one communication step.

The equations are in ``equations.py``. Without further parts of the hoist the state has seven
numbers: motor torque, sheave angle and suspension heights with their rates. Shaft, head rope modes,
play and brake append theirs. It is integrated by ``integrator.py``.

The head ropes of a hoist with a lining may slide on the sheave. Ropes of the mass mu_r per length
and the speed w hold while (Euler and Eytelwein)

    T_1 - mu_r w^2 <= exp(mu alpha) max(T_2 - mu_r w^2, 0) ,     T_1 >= T_2 .

Then they slide towards T_1, by the equations with the lining's friction, until their speed on the
sheave has come to 0. Both instants are located. What has slid goes over into the free lengths when
they hold again, so that ropes that hold have the same equations before and after, and the same as
in a hoist without a lining.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from hoist_demo.drive.coordinates import INPUT_NAMES, STATE_NAMES, TORQUE
from hoist_demo.drive.integrator import (
    MIN_STEP,
    WORK_COUNT,
    EventFunction,
    Integrator,
    Span,
    Vector,
)
from hoist_demo.drive.kernels import KernelForm
from hoist_demo.drive.outputs import OUTPUT_INDEX
from hoist_demo.parameters import GRAVITY, SIDES, Hoist
from rope_model.physics.elementary import sqrt

#: The rope's signals that act on conveyances with play.
SIDE_FORCES = tuple(f"{side}.{name}" for side, name in product(SIDES, ("fx", "fz", "my")))
MIN_ROPE = 0.1  #: Head rope at the sheave [m] below which a conveyance is in the headgear.
MAX_SWITCHES = 200  #: Changes between holding and sliding head ropes within one step of the drive.
_TENSION_LEFT = OUTPUT_INDEX["tension_left"]
_TENSION_RIGHT = OUTPUT_INDEX["tension_right"]
_PHI = STATE_NAMES.index("phi")
_RATE = STATE_NAMES.index("phi_rate")


class SlipState(NamedTuple):
    """Slip of the head ropes, positive as the sheave's rotation."""

    sense: float = 0.0  # 1 or -1 while they slide, 0 while they hold
    speed: float = 0.0  # m/s, of the ropes on the sheave
    slid_distance: float = 0.0  # m, since the start
    slip: float = 0.0  # m, since they slide: the part of slid_distance not in the free lengths


class PlantState(NamedTuple):
    """State of the drive: x = (M, phi, y_L, y_R, phi', v_L, v_R, ...), work and free lengths.

    Units are N m, rad, m, rad/s and m/s.
    """

    x: Vector  # in the order of HoistPlant.state_names, which begin with STATE_NAMES
    #: J, (10,), in the order of WORK_NAMES, then of LOSS_NAMES, which are parts of the losses.
    work_totals: Vector
    free_lengths: tuple[float, float]  # m, head ropes at phi = 0
    step_next: float = 0.0  # s, of the integrator; 0: not known yet
    slip_state: SlipState = SlipState()  # state of the head ropes on the sheave


class PlantStep(NamedTuple):
    """New state, or the old one and the cause when the step failed."""

    valid: bool
    message: str
    state: PlantState
    applied_input: Vector = np.zeros(0)  # input at the step's end, in the order of INPUT_NAMES
    outputs: Vector = np.zeros(0)  # OUTPUTS under it


class HoistPlant:
    """Drive of one hoist.

    States are explicit and never changed in place. Not to be shared between threads.
    """

    def __init__(self, hoist: Hoist, form: KernelForm = "auto") -> None:
        self.hoist = hoist
        self._form = form
        #: Integrator of head ropes that hold on the sheave.
        self.stick_integrator = Integrator(_without_lining(hoist), form)
        #: Integrator of head ropes that slide; None before its first use, which may never come.
        self._slip_integrator: Integrator | None = None
        self.state_names = self.stick_integrator.names

    def _integrator_of_slip(self) -> Integrator:
        """Return the integrator of head ropes that slide."""
        if self._slip_integrator is None:
            self._slip_integrator = Integrator(self.hoist, self._form)
        return self._slip_integrator

    def reload(self, hoist: Hoist) -> None:
        """Take over the numbers of a hoist of the same parts: another payload."""
        self.hoist = hoist
        self.stick_integrator.set_arguments(p=_without_lining(hoist).numbers)
        if self._slip_integrator is not None:
            self._slip_integrator.set_arguments(p=hoist.numbers)

    @property
    def evaluations(self) -> int:
        """Evaluations by the integrators so far."""
        evaluations = self.stick_integrator.evaluations
        if self._slip_integrator is not None:
            evaluations += self._slip_integrator.evaluations
        return evaluations

    def equilibrium(
        self, y_left: float, y_right: float, force_left: float, force_right: float
    ) -> PlantState:
        """Return the state at rest at these heights [m], under forces of one balance rope [N].

        Raises ValueError if the motor cannot hold it.
        """
        state = self.hanging_state(y_left, y_right, force_left, force_right)
        if not abs(state.x[TORQUE]) <= self.hoist.torque_limit:
            raise ValueError(
                f"holding torque = {state.x[TORQUE]:.6g} N m must be within torque_limit = "
                f"{self.hoist.torque_limit:g} N m: lighten the payload, balance the ropes "
                "or take a stronger motor"
            )
        return state

    def hanging_state(
        self, y_left: float, y_right: float, force_left: float, force_right: float
    ) -> PlantState:
        """Return the equilibrium, with whatever torque it takes."""
        heights = (y_left, y_right)
        forces = (force_left, force_right)
        for side, y, force in zip(SIDES, heights, forces, strict=True):
            self._require_taut(f"y_{side}", y, force)
        lengths = free_lengths(self.hoist, heights, forces)
        x = np.zeros(len(self.state_names))
        for name, value in hanging_places(self.hoist, heights, lengths).items():
            x[self.state_names.index(name)] = value
        x[TORQUE] = self.stick_integrator.holding_torque(x, lengths)
        if self.hoist.drive_shaft is not None:
            x[self.state_names.index("twist")] = x[TORQUE] / self.hoist.drive_shaft.stiffness
        return PlantState(x, np.zeros(WORK_COUNT), lengths)

    def advance(
        self,
        state: PlantState,
        h: float,
        path: Vector,
        added_mass: Vector,
        begin: float = 0.0,
        end: float = 1.0,
    ) -> PlantStep:
        """Advance from s = begin to end of a step h [s].

        ``path`` has u_0, u_1, u_2 of inputs u_0 + u_1 s + u_2 s^2.
        """
        old = state
        size = (state.step_next or h) / h
        for _ in range(MAX_SWITCHES):
            phase = self._phase(state)
            integrator = phase.integrator
            integrator.set_arguments(
                x=phase.x,
                work_totals=state.work_totals,
                l0=state.free_lengths,
                H=h,
                path=path,
                added_mass=added_mass,
            )
            reached = integrator.integrate(h, size, Span(begin, end), phase.event)
            if reached is None:
                return PlantStep(False, f"drive: {_not_finite(path, h, added_mass)}", old)
            begin = reached.s
            # the rest of a step behind a switch may be very short, and longer ones fit all the same
            if state is old:
                size = reached.next_size
            else:
                size = max(size, reached.next_size)
            x = reached.y[integrator.result["x"]]
            work_totals = reached.y[integrator.result["work_totals"]]
            applied_input = reached.y[integrator.result["applied_input"]]
            outputs = reached.y[integrator.result["outputs"]]
            state = self._state_of(state, x, work_totals, size * h)
            free = self._free_length(state)
            if free <= MIN_ROPE:
                return PlantStep(
                    False, f"drive: head rope of {free:.3g} m left at the sheave: overwind", old
                )
            if begin >= end:
                return PlantStep(True, "", state, applied_input, outputs)
            state = _switched(state, outputs)
        often = f"more than {MAX_SWITCHES} times in {h:g} s"
        return PlantStep(
            False, f"drive: the head ropes slip and hold {often}: shorten the step", old
        )

    def _free_length(self, state: PlantState) -> float:
        """Return the shorter head rope between sheave and conveyance, unloaded [m]."""
        wound = self.hoist.sheave_radius * state.x.item(_PHI) + state.slip_state.slip
        left, right = state.free_lengths
        return min(left - wound, right + wound)

    def _phase(self, state: PlantState) -> _Phase:
        """Return the phase of a state: head ropes that hold, or that slide."""
        slip_state = state.slip_state
        if slip_state.sense == 0.0:
            event = None if self.hoist.lining is None else self._excess
            return _Phase(self.stick_integrator, state.x, event)
        integrator = self._integrator_of_slip()
        values = dict(zip(self.state_names, state.x.tolist(), strict=True))
        values["slip"] = slip_state.slip
        values["slip_rate"] = slip_state.speed
        values["sense"] = slip_state.sense
        rate = integrator.names.index("slip_rate")
        # they hold again once they slide the other way
        return _Phase(
            integrator,
            x=np.array([values[name] for name in integrator.names]),
            event=lambda y: -slip_state.sense * y.item(rate),
        )

    def _excess(self, y: Vector) -> float:
        """Return the tension beyond what friction holds [N], of ropes that hold."""
        hoist = self.hoist
        centrifugal = hoist.rope_mass * (hoist.sheave_radius * y.item(_RATE)) ** 2
        outputs = self.stick_integrator.result["outputs"].start
        low, high = sorted(y.item(outputs + k) for k in (_TENSION_LEFT, _TENSION_RIGHT))
        held = hoist.tension_ratio_limit * max(low - centrifugal, 0.0)
        return high - centrifugal - held

    def _state_of(
        self, before: PlantState, x: Vector, work_totals: Vector, step_next: float
    ) -> PlantState:
        """Return the state in which the integrator of a phase has ended, from its coordinates x."""
        slip_state = before.slip_state
        if slip_state.sense != 0.0:
            names = self._integrator_of_slip().names
            values = dict(zip(names, x.tolist(), strict=True))
            x = np.array([values[name] for name in self.state_names])
            slip_state = SlipState(
                sense=slip_state.sense,
                speed=values["slip_rate"],
                slid_distance=slip_state.slid_distance + (values["slip"] - slip_state.slip),
                slip=values["slip"],
            )
        return PlantState(x, work_totals, before.free_lengths, step_next, slip_state)

    def accelerance(self, state: PlantState) -> Vector:
        """Return the change of (a_left, a_right) per force on either conveyance, (2, 2) [1/kg]."""
        phase = self._phase(state)
        no_input = np.zeros(len(INPUT_NAMES))
        return phase.integrator.accelerance(phase.x, no_input, state.free_lengths)

    def loads_and_outputs(
        self, state: PlantState, path: Vector, added_mass: Vector, s: float
    ) -> tuple[Vector, Vector]:
        """Return the input that acts at s, and OUTPUTS."""
        phase = self._phase(state)
        integrator = phase.integrator
        integrator.set_arguments(
            x=phase.x,
            work_totals=state.work_totals,
            l0=state.free_lengths,
            H=0.0,
            path=path,
            added_mass=added_mass,
        )
        y = integrator.evaluate(s)
        return y[integrator.result["applied_input"]], y[integrator.result["outputs"]]

    def _require_taut(self, name: str, y: float, force: float) -> None:
        """Refuse a height [m] not below the sheave, or a force [N] that slacks the head ropes."""
        hoist = self.hoist
        if not hoist.sheave_height - y > 0.0:
            raise ValueError(
                f"{name} = {y!r} m must be below the sheave at {hoist.sheave_height:g} m: lower it"
            )
        mass = hoist.mass_left if name == "y_left" else hoist.mass_right
        pull = mass * GRAVITY - hoist.tail_rope_number * force
        if not (math.isfinite(force) and pull > 0.0):
            raise ValueError(
                f"rope force {force!r} N at {name} must leave the head ropes taut: check its sign"
            )


class _Phase(NamedTuple):
    """Equations that hold for a state: those of head ropes that hold, or that slide."""

    integrator: Integrator
    x: Vector  # the state in the integrator's coordinates
    event: EventFunction | None  # that ends the phase


def free_lengths(hoist: Hoist, heights: Sequence[Any], forces: Sequence[Any]) -> tuple[Any, Any]:
    """Return the lengths of the unloaded head ropes [m] at rest, also of symbols.

    Each is the positive root of s = l (1 + (m g - n F + mu g l / 2) / EA).
    """
    c = hoist.rope_mass * GRAVITY / (2.0 * hoist.rope_stiffness)
    lengths = []
    for y, mass, force in zip(heights, (hoist.mass_left, hoist.mass_right), forces, strict=True):
        s = hoist.sheave_height - y
        b = 1.0 + (mass * GRAVITY - hoist.tail_rope_number * force) / hoist.rope_stiffness
        lengths.append(2.0 * s / (b + sqrt(b * b + 4.0 * c * s)))
    return lengths[0], lengths[1]


def hanging_places(hoist: Hoist, heights: Sequence[Any], lengths: Sequence[Any]) -> dict[str, Any]:
    """Return the coordinates of a hoist at rest that are not 0, by name; also of symbols.

    The twist of the shaft is left out.
    """
    places = {f"y_{side}": y for side, y in zip(SIDES, heights, strict=True)}
    # own weight moves the inner points of the head ropes off the straight line: dV/d eta = 0
    for j in range(1, hoist.head_rope_modes + 1):
        k = j * math.pi
        sag = 2.0 * hoist.rope_mass * GRAVITY * (1.0 - (-1.0) ** j) / (hoist.rope_stiffness * k**3)
        for side, length in zip(SIDES, lengths, strict=True):
            places[f"eta{j}_{side}"] = -sag * length**2
    return places


def _not_finite(path: Vector, h: float, added_mass: Vector) -> str:
    """Name the inputs of a step that are not finite; else the likely cause of its failure."""
    numbers = path.reshape(3, -1).T.tolist()
    bad = [
        name
        for name, moving in zip(INPUT_NAMES, numbers, strict=True)
        if not all(map(math.isfinite, moving))
    ]
    if not (math.isfinite(h) and np.isfinite(added_mass).all()):
        bad.append("step or added mass")
    if bad:
        return f"input is not finite: {', '.join(bad)}"
    steps = f"no steps of {MIN_STEP:g} s or longer keep to the tolerance"
    return f"state is not finite, or {steps}: check rope forces and torque command"


def _without_lining(hoist: Hoist) -> Hoist:
    if hoist.lining is None:
        return hoist
    return replace(hoist, lining=None)


def _switched(state: PlantState, outputs: Vector) -> PlantState:
    """Return the state in the other phase: ropes that held slide towards the larger tension."""
    slip_state = state.slip_state
    if slip_state.sense == 0.0:
        sense = -1.0
        if outputs[_TENSION_RIGHT] > outputs[_TENSION_LEFT]:
            sense = 1.0
        return state._replace(slip_state=SlipState(sense, slid_distance=slip_state.slid_distance))
    left, right = state.free_lengths
    return state._replace(
        slip_state=SlipState(slid_distance=slip_state.slid_distance),
        free_lengths=(left - slip_state.slip, right + slip_state.slip),
    )
