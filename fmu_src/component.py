"""The rope behind the FMI variables: initialisation, steps, states.

No exception leaves a method that a host calls: a failure is logged, kept in ``status.message`` and makes ``do_step``
return False, because hosts differ in what they do with an error raised inside a callback.
"""

from __future__ import annotations

import base64
import json
import math
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

from rope_model.parameters import Preset
from rope_model.simulation.balance_rope import Status
from rope_model.simulation.ends import SHORTEST_AIM, SIDES
from rope_model.simulation.simulator import RopeSimulator
from rope_model.simulation.state import RopeState

from .interface import Kind, Value, Variable, motion_of, scene_of, variables

Severity = Literal["note", "warning", "error"]
Log = Callable[[str, Severity], None]
#: host and rope may differ by this much about the time, s
TIME_SLACK = 1e-9
#: s: steps beyond it are too long for extrapolated inputs
LONGEST_EXTRAPOLATION = 0.02
#: what a variable reads that has no value
_NOTHING: dict[Kind, Value] = {"Real": 0.0, "Integer": 0, "Boolean": False, "String": ""}


class RopeComponent:
    """Values by value reference, and the rope that computes the outputs."""

    def __init__(self, preset: Preset, bundle: Path | None, log: Log) -> None:
        self.table: tuple[Variable, ...] = variables(preset)
        self.values: dict[str, Value] = {v.name: v.start for v in self.table if v.start is not None}
        self.status = Status(True)
        self._rope: RopeSimulator | None = None
        self._start_time = 0.0
        self._bundle, self._log = bundle, log
        self._retune = False
        self._initializing, self._changed = False, True
        self._warned: set[str] = set()  # subjects of the warnings that have been in the log
        self._pending = ""  # an error of a call that cannot report one itself

    # life cycle

    def setup(self, start_time: float) -> None:
        """Remember when the run starts."""
        self._start_time = start_time

    def enter_initialization(self) -> None:
        """From now on until the first step, outputs are computed from what has been set."""
        self._initializing, self._changed = True, True
        self._warned.clear()

    def exit_initialization(self) -> None:
        """Hang the rope with the parameters and inputs set so far, unless it hangs so already."""
        self._hang_if_changed()
        self._initializing = False

    def do_step(self, t: float, h: float) -> bool:
        """Advance from ``t`` by ``h``; False, with status and log telling why, when that fails."""
        return self._guarded(f"doStep({t!r}, {h!r})", lambda: self._step(t, h))

    # values

    def get(self, references: Sequence[int], kind: Kind) -> list[Any]:
        """Values of variables of one FMI type; what cannot be had is zero or empty, and the status says why."""
        out: list[Any] = [_NOTHING[kind]] * len(references)

        def read() -> Status:
            for i, reference in enumerate(references):
                variable = self._variable(reference, kind)
                if variable is not None:
                    out[i] = type(out[i])(self._value(variable))
            return self.status

        self._hang_if_changed()
        self._guarded("get", read)
        return out

    def set(self, references: Sequence[int], values: Sequence[Value], kind: Kind) -> None:
        """Set parameters and inputs; a value that may not be set now fails the next step."""
        if len(references) != len(values):
            self._fail_later(f"set got {len(references)} value references and {len(values)} values")
            return
        for reference, value in zip(references, values, strict=True):
            variable = self._variable(reference, kind)
            if variable is None:
                continue
            started = self._rope is not None and not self._initializing
            if variable.causality == "output":
                self._fail_later(f"{variable.name} is an output and cannot be set")
            elif started and variable.variability == "fixed":
                if value != self.values[variable.name]:
                    self._fail_later(
                        f"{variable.name} is fixed after initialisation; it stays {self.values[variable.name]!r}; "
                        "reset the FMU to change it. This step was not done, the next will be"
                    )
            else:
                self._retune |= variable.variability == "tunable" and started
                self._changed = True
                self.values[variable.name] = value

    # states

    def get_state(self) -> dict[str, Any]:
        """Everything that influences the future."""
        return {
            "values": dict(self.values),
            "status": [self.status.valid, self.status.message],
            "start_time": self._start_time,
            "pending": self._pending,
            "rope": self._rope.state if self._rope is not None else None,
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Go on from a state of ``get_state``, also another instance's; one that does not fit changes nothing."""
        saved: list[Status] = []

        def restore() -> Status:
            saved.append(self._restore(state))
            return Status(True)

        if self._guarded("setFMUstate", restore):
            self.status = saved[0]

    @staticmethod
    def state_to_bytes(state: dict[str, Any]) -> bytes:
        """A state as bytes."""
        rope: RopeState | None = state.get("rope")
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
            return {"error": f"these {len(data)} bytes are not a state of this FMU ({error!r})"}

    # behind the calls

    def _hang_if_changed(self) -> None:
        if self._initializing and self._changed:
            self._changed = False
            self._guarded("initialisation", self._initialize)

    def _initialize(self) -> Status:
        self._rope = None
        rope = RopeSimulator(scene_of(self.values), self._bundle)
        status = rope.initialize(self._start_time, *(motion_of(side, self.values) for side in SIDES))
        if status.valid:
            self._rope, state = rope, rope.state
            self._log(f"model: {state.rung}, {state.rung_reason}", "note")
            self._log(f"kernels: {rope.form}, {rope.model.kernels.elements} elements", "note")
            self._warn()
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
        left, right = (motion_of(side, self.values) for side in SIDES)
        state, within = self._rope.state, SHORTEST_AIM
        if not self.values["inputs_at_step_end"]:
            left, right = left.extrapolated(h), right.extrapolated(h)
            within = max(within, state.last_interval if state.counts.steps else 0.0)
        status = self._rope.advance_to(t + h, left, right, within)
        if status.valid:
            self._warn()
        return status

    def _warnings(self) -> dict[str, str]:
        """What is to be minded now, by subject."""
        if (rope := self._rope) is None:
            return {}
        long_step = self._long_step(rope)
        return rope.warnings() | ({"long_step": long_step} if long_step else {})

    def _long_step(self, rope: RopeSimulator) -> str:
        h, moved = rope.state.last_interval, rope.state.counts.steps > 0
        if self.values["inputs_at_step_end"] or not moved or h <= LONGEST_EXTRAPOLATION * (1 + 1e-9):
            return ""
        return (
            f"a communication step of {h:.6g} s is too long for inputs that are extrapolated: forces err by percents "
            f"beyond {LONGEST_EXTRAPOLATION:.6g} s; communicate more often, or set inputs_at_step_end = true and give "
            "the motion at the end of each step"
        )

    def _warn(self) -> None:
        """Into the log what is to be minded, each thing once."""
        for subject, text in self._warnings().items():
            if subject not in self._warned:
                self._warned.add(subject)
                self._log(text, "warning")

    def _restore(self, state: dict[str, Any]) -> Status:
        """The status that was saved; ValueError, and nothing changed, when the state is none of this FMU's."""
        if "error" in state:
            raise ValueError(state["error"])
        values = state.get("values", {})
        kinds = {name: type(value) for name, value in self.values.items()}
        if {name: type(value) for name, value in values.items()} != kinds:
            raise ValueError("the state is none of this FMU's: its variables are others")
        rope, saved, pending = None, Status(*state["status"]), str(state["pending"])
        start_time = float(state["start_time"])
        if state["rope"] is not None:
            scene = scene_of(values)
            fixed = [v.name for v in self.table if v.variability == "fixed"]
            same = self._rope is not None and all(values[name] == self.values[name] for name in fixed)
            rope = self._rope if same and self._rope is not None else RopeSimulator(scene, self._bundle)
            rope.restore(state["rope"])
            rope.retune(scene)
        self.values, self._rope, self._start_time, self._pending = dict(values), rope, start_time, pending
        self._retune = self._initializing = False
        return saved

    def _guarded(self, what: str, call: Callable[[], Status]) -> bool:
        before = self.status
        try:
            self.status = call()
        except (ValueError, RuntimeError) as error:
            self.status = Status(False, f"{what}: {error}")
        except Exception as error:
            self.status = Status(False, f"{what}: internal error, please report it: {error!r}")
            self._log(traceback.format_exc(), "error")
        if not self.status.valid and self.status is not before:
            self._log(self.status.message, "error")
        return self.status.valid

    def _fail_later(self, message: str) -> None:
        self._log(message, "error")
        self._pending = self._pending or message

    def _variable(self, reference: int, kind: Kind) -> Variable | None:
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
        if name == "status.warning":
            return "\n".join(self._warnings().values())
        if self._rope is None:  # before initialisation zero; after one that failed nothing that looks like a force
            return _NOTHING[variable.kind] if self.status.valid or variable.kind != "Real" else math.nan
        if name in ("status.rung", "status.rung_reason"):
            return str(getattr(self._rope, name.removeprefix("status.")))
        return self._rope.signals((name,))[name]
