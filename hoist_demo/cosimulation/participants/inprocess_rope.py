"""The balance rope in this process: the same RopePlant as the FMU, without the FMU.

It stands in for the FMU in comparisons and for debugging, and winds what one FMU cannot: duties, and several ropes.
"""

import logging
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from ctypes import c_int, create_string_buffer
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rope_model
from hoist_demo.cosimulation.participants.library_calls import (
    TEXT,
    OutputTable,
    RopeLibrary,
    access,
    codes_of,
)
from hoist_demo.cosimulation.participants.rope_data import RopeData, stamp, unstamp
from hoist_demo.cosimulation.schemes.interface import ADDED_MASSES, Reader
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.suspension import SuspensionOffset
from hoist_demo.recording.fidelity import FIDELITY, code_of
from rope_model.scene_names import named_parameters, with_values

_log = logging.getLogger(__name__)
_TAG = b"rope in process\n"


class InProcessRope:
    """A RopePlant around rope_model's BalanceRope."""

    def __init__(
        self, scene: rope_model.Scene, read: Collection[str] | None = None, name: str = ""
    ) -> None:
        """`read` are recorded outputs, None: all but the expensive added masses; warnings begin with `name`."""
        self._rope = rope_model.balance_rope(scene)
        self._recorded = rope_model.SIGNALS.keys() - {*ADDED_MASSES} if read is None else read
        self._warned: set[str] = set()  # subjects of what was logged
        self._whose = f"{name}: " if name else ""

    @property
    def whole(self) -> rope_model.BalanceRope:
        """Rope of rope_model that this one wraps."""
        return self._rope

    def initialize(
        self, t0: float, left: rope_model.EndMotion, right: rope_model.EndMotion
    ) -> rope_model.Status:
        self._warned.clear()
        return self._log_warnings(self._rope.initialize(t0, left, right))

    def step(
        self, t: float, h: float, left: rope_model.EndMotion, right: rope_model.EndMotion
    ) -> rope_model.Status:
        return self._log_warnings(self._rope.advance_to(t + h, left, right))

    def _log_warnings(self, status: rope_model.Status) -> rope_model.Status:
        """Log warnings about a valid state, each once, and return the status."""
        for subject, text in self._rope.warnings().items() if status.valid else ():
            if subject not in self._warned:
                self._warned.add(subject)
                _log.warning("%s%s", self._whose, text)
        return status

    def data(self) -> RopeData:
        """Identity of the rope: its engine, and all parameters by FMI name."""
        model = {
            "rope": f"in process, {type(self._rope).__name__}",
            "version": version("balance-rope"),
        }
        reason = ""
        with suppress(RuntimeError):  # a rope that could not be initialised has no state
            reason = self._rope.fidelity_reason
        return replace(rope_data_of(self._rope.scene), model=model, fidelity_reason=reason)

    def reader(self, names: Sequence[str]) -> Reader:
        indices = [k for k, name in enumerate(names) if name in rope_model.SIGNALS]
        fidelities = [k for k, name in enumerate(names) if name == FIDELITY]
        read = self._rope.reader([names[k] for k in indices])

        def values() -> NDArray[np.float64]:
            row = np.full(len(names), np.nan)
            row[indices] = read()
            if fidelities:
                row[fidelities] = code_of(self._rope.fidelity)
            return row

        return values

    def library(self) -> RopeLibrary | None:
        """Return the native rope's functions for trip.c; None for the rope in Python."""
        native: Any = self._rope
        if native.form != "native":
            return None
        handle = native.library
        lib, rope = handle.lib, handle.rope
        ends = np.zeros((1, 2 * len(rope_model.EndMotion.__dataclass_fields__)))

        def table(names: Sequence[str], rows: int) -> OutputTable:
            indices = [k for k, name in enumerate(names) if name in rope_model.SIGNALS]
            fidelities = [k for k, name in enumerate(names) if name == FIDELITY]
            numbers = (c_int * len(indices))(
                *([*rope_model.SIGNALS].index(names[k]) for k in indices)
            )
            values, texts = np.zeros((rows, len(indices))), np.zeros((rows, len(fidelities)), TEXT)
            accesses = (
                [access("rope_signals", lib.rope_signals, rope, numbers, values)] if indices else []
            )
            accesses += (
                [access("rope_fidelity", lib.rope_fidelity, rope, numbers, texts)]
                if fidelities
                else []
            )

            def read(count: int) -> NDArray[np.float64]:
                outputs = np.full((count, len(names)), np.nan)
                outputs[:, indices], outputs[:, fidelities] = (
                    values[:count],
                    codes_of(texts[:count]),
                )
                return outputs

            return OutputTable(accesses, read)

        none = (c_int * 0)()
        return RopeLibrary(
            access("rope_advance_to", lib.rope_advance_to, rope, none, ends),
            access("rope_advance_to", lib.rope_advance_to, rope, none, ends),
            table,
            lambda call, _: native.status_of(call != "STEP"),
            warning=lib.rope_warning,
            warned=create_string_buffer(handle.warnings),
            text=handle.text,
            heard=lambda: self._log_warnings(native.status_of(True)),
        )

    def save(self) -> rope_model.Snapshot:
        return self._rope.snapshot()

    def restore(self, snapshot: rope_model.Snapshot | rope_model.RopeState) -> None:
        self._rope.restore(snapshot)

    def to_bytes(self, snapshot: rope_model.Snapshot) -> bytes:
        return _TAG + stamp(snapshot.state.to_bytes(), self.data().parameters)

    def from_bytes(self, data: bytes) -> rope_model.RopeState:
        if not data.startswith(_TAG):
            raise ValueError(
                "the state must be that of a rope in process, it is of an FMU: give that with --fmu FILE"
            )
        return rope_model.RopeState.from_bytes(
            unstamp(data.removeprefix(_TAG), self.data().parameters)
        )

    def units(self) -> dict[str, str]:
        """Unit of each output of the record, and of the fidelity's code."""
        return {
            name: str(s.unit) for name, s in rope_model.SIGNALS.items() if name in self._recorded
        } | {FIDELITY: "1"}

    def close(self) -> None:
        """Do nothing: no resources are held."""


def rope_data_of(scene: rope_model.Scene) -> RopeData:
    """Return the parameters of a scene by FMI name, with their units."""
    named = [*named_parameters(scene)]
    return RopeData(
        {}, {p.name: p.value for p in named}, {p.name: p.facts.unit or "1" for p in named}
    )


def values_by_name(scene: rope_model.Scene) -> dict[str, Value]:
    """Return all parameters of a scene by FMI name, choices by code."""
    return {p.name: p.value for p in named_parameters(scene)}


def rope_scene(
    parameters: Mapping[str, Value],
    level: rope_model.Level = "standard",
    suspension: SuspensionOffset | None = None,
) -> rope_model.Scene:
    """Return the scene of a level with parameters by FMI name, choices by code; `suspension` adds to the spacing."""
    scene = with_values(rope_model.at_level(rope_model.Scene(), level), parameters)
    if suspension is None:
        return scene
    return scene.with_(
        layout=replace(scene.layout, spacing=suspension.end_distance(scene.layout.spacing))
    )
