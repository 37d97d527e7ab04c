"""The last good state of a run in a file, to be looked at or to go on from.

A NumPy archive: the fields of Checkpoint as text, and their arrays by name, as
``recording.signals['time']``.
"""

from __future__ import annotations

import json
import zipfile
from dataclasses import dataclass, fields, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from hoist_demo.cosimulation.participants.identity import Identity, differences
from hoist_demo.cosimulation.participants.plain_data import decode, encode
from hoist_demo.cosimulation.schemes.interface import SchemeState, Vector
from hoist_demo.drive.plant import PlantState
from hoist_demo.recording.time_series import Array, Recording
from rope_model.files import whole_file

#: Errors that a damaged or foreign file raises.
_UNREADABLE = (KeyError, ValueError, TypeError, AttributeError, EOFError, zipfile.BadZipFile)
#: Types of some fields that a file must have.
_TYPES = {
    "plant": PlantState,
    "scheme_state": SchemeState,
    "recording": Recording,
    "rope": bytes,
    "input": np.ndarray,
    "identity": dict,
}
CONTROLLER = "the controller's state"  #: Its name in messages.


@dataclass(frozen=True)
class Checkpoint:
    """All states at one sample of the controller."""

    sample: int  # number of the controller's sample, 0 at the start
    t: float  # s
    plant: PlantState
    controller: Any  # plain data
    input: Vector  # that acts on the drive, in the order of INPUT_NAMES
    scheme_state: SchemeState
    rope: bytes  # b"" when the rope cannot save its state
    recording: Recording  # of the run until it stopped; a resumed run replaces rows behind `sample`
    identity: Identity  # that a resumed run must share: see Host.identity
    cause: str  # reason why the run stopped
    hoist: str = ""  # name or file of the hoist, if known
    # s after the start: emergency stop, by plan or safety circuit
    emergency_at: float | None = None

    def write(self, path: Path) -> None:
        """Write the file; ValueError, and no file, when the controller's state is no plain data."""
        arrays: dict[str, Array] = {}
        text: dict[str, Any] = {"version": version("balance-rope")}
        for field in fields(self):
            name = field.name
            if name == "controller":
                name = CONTROLLER
            text[field.name] = encode(getattr(self, field.name), name, arrays)
        arrays["text"] = np.frombuffer(json.dumps(text).encode(), dtype=np.uint8)
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as draft, draft.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]

    def require_fits(self, identity: Identity) -> None:
        """Raise a ValueError unless a run of this identity can go on from here."""
        changes = differences(self.identity, identity)
        if changes:
            raise ValueError(
                f"the checkpoint at t = {self.t:g} s must be of the same hoist, winding, "
                f"controller, gains and sample time, but {changes}: "
                "give the case and the options of that run"
            )
        if not self.rope:
            raise ValueError(
                f"the checkpoint at t = {self.t:g} s must hold the rope's state, which its rope "
                "could not save: start anew, or take an FMU with canGetAndSetFMUstate"
            )

    @staticmethod
    def read(path: Path) -> Checkpoint:
        """Read a file that ``write`` made in this version; raise ValueError for any other."""
        here = version("balance-rope")
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            text = json.loads(arrays["text"].tobytes())
            there = text.pop("version", "an earlier one")
            controller = text.pop("controller", None)
            checkpoint = None
            if there == here:
                checkpoint = _checkpoint(text, arrays)
                checkpoint = replace(checkpoint, controller=decode(controller, arrays))
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise ValueError(f"'{path}': {reason}: give a run's last_good.npz") from error
        except _UNREADABLE as error:
            raise ValueError(
                f"'{path}' must be a checkpoint of a run, but: {error}: give another file"
            ) from error
        if checkpoint is None:
            raise ValueError(
                f"'{path}' must be of version {here}, it was written by {there}: "
                "go on with that version, or start anew in another folder"
            )
        return checkpoint


def _checkpoint(text: dict[str, Any], arrays: dict[str, Array]) -> Checkpoint:
    """Decode a checkpoint from an archive's text and arrays, without the controller's state."""
    values = {name: decode(value, arrays) for name, value in text.items()}
    checkpoint = Checkpoint(controller=None, **values)
    wrong = [name for name, kind in _TYPES.items() if not isinstance(values[name], kind)]
    if wrong:
        raise TypeError(f"{', '.join(wrong)} of other kinds")
    return checkpoint
