"""The rope behind the FMI variables: initialisation, steps, states.

No exception leaves a public method: a failure is logged, kept in ``status.message`` and makes ``do_step`` return
False, because hosts differ in what they do with an error raised inside a callback.
"""

from __future__ import annotations

import base64
import json
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rope_model.parameters import Preset
from rope_model.simulation.signals import SIDES, group_of
from rope_model.simulation.simulator import RopeSimulator, Status
from rope_model.simulation.state import RopeState

from .interface import Value, Variable, motion_of, scene_of, variables

#: log(message, is_error)
Log = Callable[[str, bool], None]
#: host and rope may differ by this much about the time, s
TIME_SLACK = 1e-9


class RopeComponent:
    """Values by value reference, and the rope that computes the outputs."""

    def __init__(self, preset: Preset, bundle: Path | None, log: Log) -> None:
        self.table: tuple[Variable, ...] = variables(preset)
        self.values: dict[str, Value] = {v.name: v.start for v in self.table if v.start is not None}
        self.status = Status(True)
        self._rope: RopeSimulator | None = None
        self._start_time = 0.0
        self._bundle, self._log = bundle, log
        self._outputs: dict[str, float] = {}
        self._retune = False
        self._pending = ""  # an error of a call that cannot report one itself

    # life cycle

    def setup(self, start_time: float) -> None:
        """Remember when the run starts."""
        self._start_time = start_time

    def initialize(self) -> None:
        """Hang the rope with the parameters and inputs set so far."""
        self._guarded("initialisation", self._initialize)

    def do_step(self, t: float, h: float) -> bool:
        """Advance from ``t`` by ``h``; False, with status and log telling why, when that fails."""
        return self._guarded(f"doStep({t!r}, {h!r})", lambda: self._step(t, h))

    # values

    def get(self, references: Sequence[int], kind: str) -> list[Any]:
        """Values of variables of one FMI type."""
        out: list[Any] = []
        for reference in references:
            variable = self._variable(reference, kind)
            out.append({"Real": 0.0, "Integer": 0, "Boolean": False, "String": ""}[kind])
            if variable is not None:
                out[-1] = type(out[-1])(self._value(variable))
        return out

    def set(self, references: Sequence[int], values: Sequence[Value], kind: str) -> None:
        """Set parameters and inputs; a value that may not be set now fails the next step."""
        for reference, value in zip(references, values, strict=True):
            variable = self._variable(reference, kind)
            if variable is None:
                continue
            if variable.causality == "output":
                self._fail_later(f"{variable.name} is an output and cannot be set")
            elif self._rope is not None and variable.variability == "fixed":
                if value != self.values[variable.name]:
                    self._fail_later(
                        f"{variable.name} is fixed after initialisation; it stays {self.values[variable.name]!r}. "
                        "Reset the FMU to change it"
                    )
            else:
                self._retune |= variable.variability == "tunable" and self._rope is not None
                self.values[variable.name] = value

    # states

    def get_state(self) -> dict[str, Any]:
        """Everything that influences the future."""
        return {
            "values": dict(self.values),
            "status": tuple(vars(self.status).values()),
            "start_time": self._start_time,
            "pending": self._pending,
            "rope": self._rope.state if self._rope is not None else None,
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Go on from a state of ``get_state``, also one of another instance of the same FMU."""
        self._guarded("setFMUstate", lambda: self._set_state(state))

    @staticmethod
    def state_to_bytes(state: dict[str, Any]) -> bytes:
        """A state as bytes."""
        rope: RopeState | None = state["rope"]
        packed = None if rope is None else base64.b64encode(rope.to_bytes()).decode()
        return json.dumps({**state, "rope": packed}, sort_keys=True).encode()

    @staticmethod
    def state_from_bytes(data: bytes) -> dict[str, Any]:
        """The state that ``state_to_bytes`` wrote; of anything else, one that ``set_state`` refuses."""
        try:
            state: dict[str, Any] = json.loads(data)
            if state["rope"] is not None:
                state["rope"] = RopeState.from_bytes(base64.b64decode(state["rope"]))
            return state
        except Exception as error:
            return {"error": f"these {len(data)} bytes are not a state of this FMU ({error})"}

    # behind the calls

    def _initialize(self) -> Status:
        rope = RopeSimulator(scene_of(self.values), self._bundle)
        self._log(f"kernels: {rope.model.kernels.form}, {rope.model.kernels.elements} elements", False)
        status = rope.initialize(self._start_time, *(motion_of(side, self.values) for side in SIDES))
        if status.valid:
            self._rope = rope
        return status

    def _step(self, t: float, h: float) -> Status:
        if self._pending:
            message, self._pending = self._pending, ""
            return Status(False, message)
        if self._rope is None:
            why = f" ({self.status.message})" if self.status.message else ""
            return Status(False, f"doStep before a successful initialisation{why}")
        now = self._rope.state.motion.t
        if not abs(t - now) <= TIME_SLACK * max(1.0, abs(now)):
            return Status(
                False, f"the host steps from t = {t!r} s, the rope is at {now!r} s; restore a state to go back"
            )
        if not 0 < h < float("inf"):
            return Status(False, f"communication step {h!r} s is not positive and finite")
        if self._retune:
            self._rope.retune(scene_of(self.values))
            self._retune = False
        motions = [motion_of(side, self.values) for side in SIDES]
        if not self.values["inputs_at_step_end"]:
            motions = [motion.extrapolated(h) for motion in motions]
        return self._rope.advance_to(t + h, *motions)

    def _set_state(self, state: dict[str, Any]) -> Status:
        if "error" in state:
            return Status(False, state["error"])
        self.values = dict(state["values"])
        if state["rope"] is None:
            self._rope = None
        else:
            if self._rope is None:
                self._rope = RopeSimulator(scene_of(self.values), self._bundle)
            self._rope.retune(scene_of(self.values))
            self._rope.restore(state["rope"])
        self._start_time, self._pending = state["start_time"], state["pending"]
        return Status(*state["status"])

    def _guarded(self, what: str, call: Callable[[], Status]) -> bool:
        self._outputs = {}
        try:
            self.status = call()
        except (ValueError, RuntimeError) as error:
            self.status = Status(False, f"{what}: {error}")
        except Exception as error:
            self.status = Status(False, f"{what}: internal error, please report it: {error!r}")
            self._log(traceback.format_exc(), True)
        if not self.status.valid:
            self._log(self.status.message, True)
        return self.status.valid

    def _fail_later(self, message: str) -> None:
        self._log(message, True)
        self._pending = self._pending or message

    def _variable(self, reference: int, kind: str) -> Variable | None:
        if not 0 <= reference < len(self.table) or self.table[reference].kind != kind:
            self._fail_later(f"there is no {kind} variable with value reference {reference}")
            return None
        return self.table[reference]

    def _value(self, variable: Variable) -> Value:
        name = variable.name
        if variable.causality != "output":
            return self.values[name]
        if name == "status.valid":
            return self.status.valid
        if name == "status.message":
            return self.status.message
        if self._rope is None:
            return 0.0
        if name not in self._outputs:
            self._outputs |= group_of(name)(self._rope)
        return self._outputs[name]
