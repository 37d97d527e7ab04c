"""The balance rope in this process: the same RopePlant as the FMU, without the FMU.

It stands in for the FMU in comparisons and for debugging, and does what an FMU cannot: duties, and
several ropes.
"""

import logging
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from ctypes import c_int, create_string_buffer
from dataclasses import fields, replace
from functools import partial
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rope_model
from hoist_demo.cosimulation.participants.library_calls import (
    TEXT,
    OutputTable,
    RopeLibrary,
    codes_of,
    make_access,
)
from hoist_demo.cosimulation.participants.rope_data import RopeData, stamp, unstamp
from hoist_demo.cosimulation.schemes.interface import ADDED_MASSES, Reader
from hoist_demo.parameters.quantity import Value
from hoist_demo.parameters.suspension import SuspensionOffset
from hoist_demo.recording.fidelity import FIDELITY, code_of
from rope_model.scene_names import named_parameters, scene_with_values

_log = logging.getLogger(__name__)
_TAG = b"rope in process\n"


class InProcessRope:
    """A RopePlant around rope_model's BalanceRope."""

    def __init__(
        self, scene: rope_model.Scene, read: Collection[str] | None = None, name: str = ""
    ) -> None:
        """``read`` are recorded outputs; None: all but the added masses, which take long.

        Warnings begin with ``name``.
        """
        self._rope = rope_model.balance_rope(scene)
        if read is None:
            read = rope_model.SIGNALS.keys() - {*ADDED_MASSES}
        self._recorded = read
        self._warned: set[str] = set()  # subjects of warnings that were logged
        self._prefix = f"{name}: " if name else ""

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
        if not status.valid:
            return status
        for subject, text in self._rope.warnings().items():
            if subject not in self._warned:
                self._warned.add(subject)
                _log.warning("%s%s", self._prefix, text)
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
        lib = handle.lib
        rope = handle.rope
        no_numbers = (c_int * 0)()
        ends = np.zeros((1, 2 * len(fields(rope_model.EndMotion))))
        advance = make_access(
            "rope_advance_to", lib.rope_advance_to, rope, numbers=no_numbers, values=ends
        )
        return RopeLibrary(
            step=advance,
            motions=advance,
            table=partial(_output_table, lib, rope),
            status=lambda call, _: native.status_of(call != "STEP"),
            warning=lib.rope_warning,
            warned=create_string_buffer(handle.warnings),
            text=handle.text,
            log_warnings=lambda: self._log_warnings(native.status_of(True)),
        )

    def save(self) -> rope_model.Snapshot:
        return self._rope.snapshot()

    def restore(self, snapshot: rope_model.Snapshot | bytes) -> None:
        self._rope.restore(snapshot)

    def to_bytes(self, snapshot: rope_model.Snapshot) -> bytes:
        return _TAG + stamp(snapshot.to_bytes(), self._tunable())

    def from_bytes(self, data: bytes) -> bytes:
        """Return the state for ``restore``; ValueError for an FMU's or other tunable parameters.

        ``restore`` refuses one of other fixed parameters.
        """
        if not data.startswith(_TAG):
            raise ValueError(
                "the state must be that of a rope in process, it is of an FMU: "
                "give that with --fmu FILE"
            )
        return unstamp(data.removeprefix(_TAG), self._tunable())

    def _tunable(self) -> dict[str, Value]:
        """Return the parameters that a run may change; a snapshot has the others itself."""
        return {p.name: p.value for p in named_parameters(self._rope.scene) if p.facts.tunable}

    def units(self) -> dict[str, str]:
        """Unit of each output of the record, and of the fidelity's code."""
        signals = rope_model.SIGNALS.items()
        units = {name: str(signal.unit) for name, signal in signals if name in self._recorded}
        return units | {FIDELITY: "1"}

    def close(self) -> None:
        """Do nothing: no resources are held."""


def _output_table(lib: Any, rope: int, names: Sequence[str], rows: int) -> OutputTable:
    """Return a table of outputs that C reads from a native rope, of its library and its pointer."""
    indices = [k for k, name in enumerate(names) if name in rope_model.SIGNALS]
    fidelities = [k for k, name in enumerate(names) if name == FIDELITY]
    places = {name: k for k, name in enumerate(rope_model.SIGNALS)}
    numbers = (c_int * len(indices))(*(places[names[k]] for k in indices))
    values = np.zeros((rows, len(indices)))
    texts = np.zeros((rows, len(fidelities)), TEXT)
    accesses = []
    if indices:
        accesses.append(make_access("rope_signals", lib.rope_signals, rope, numbers, values))
    if fidelities:
        accesses.append(make_access("rope_fidelity", lib.rope_fidelity, rope, numbers, texts))

    def read(count: int) -> NDArray[np.float64]:
        outputs = np.full((count, len(names)), np.nan)
        outputs[:, indices] = values[:count]
        outputs[:, fidelities] = codes_of(texts[:count])
        return outputs

    return OutputTable(accesses, read)


def rope_data_of(scene: rope_model.Scene) -> RopeData:
    """Return the parameters of a scene by FMI name, with their units."""
    parameters = [*named_parameters(scene)]
    return RopeData(
        model={},
        parameters={p.name: p.value for p in parameters},
        units={p.name: p.facts.unit or "1" for p in parameters},
    )


def values_by_name(scene: rope_model.Scene) -> dict[str, Value]:
    """Return all parameters of a scene by FMI name, choices by code."""
    return {p.name: p.value for p in named_parameters(scene)}


def rope_scene(
    parameters: Mapping[str, Value],
    level: rope_model.Level = "standard",
    suspension: SuspensionOffset | None = None,
) -> rope_model.Scene:
    """Return the scene of a level with parameters by FMI name, choices by code.

    ``suspension`` adds to the spacing of the rope's ends.
    """
    scene = scene_with_values(rope_model.at_level(rope_model.Scene(), level), parameters)
    if suspension is None:
        return scene
    return scene.with_(
        layout=replace(scene.layout, spacing=suspension.end_distance(scene.layout.spacing))
    )
