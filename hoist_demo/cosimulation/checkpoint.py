"""The last good state of a run in a file, to be looked at or to go on from.

A NumPy archive: the drive's state, the controller's, what the coupling remembers, the rope's own bytes (of an FMU its
serialized state), the recording, and the data of the run as text, which must be the same to go on.
"""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from hoist_demo.cosimulation.plain_data import decode, encode
from hoist_demo.cosimulation.schemes.interface import Memory, Sample, Vector
from hoist_demo.drive.plant import PlantState
from hoist_demo.drive.sliding import Slide
from hoist_demo.recording.time_series import Recording

_FIELDS = ("force", "mean", "acceleration")

_FIELD = re.compile(r"(\w+)=([^(),]+)[,)]")
"""A single value in the text of a dataclass."""

CONTROLLER = "the controller's state"
"""What messages call it."""


@dataclass(frozen=True)
class Checkpoint:
    """Everything at one sample of the controller."""

    sample: int  # number of the controller's sample, 0 at the start
    t: float  # s
    plant: PlantState
    controller: Any  # plain data
    input: Vector  # that acts on the drive, in the order of INPUT_NAMES
    memory: Memory
    rope: bytes  # b"" when the rope cannot save its state
    recording: Recording  # of the run until it stopped, as its recorder keeps it; it goes on behind this sample's row
    data: str  # of the run, that must be the same to go on: see Host.data
    cause: str  # for which the run stopped

    def write(self, path: Path) -> None:
        """Write the file; ValueError, and no file, when the controller's state is no plain data."""
        memory, plant = self.memory, self.plant
        arrays = {f"sample.{name}": np.array([getattr(s, name) for s in memory.samples]) for name in _FIELDS}
        arrays |= {f"plant.{n}": getattr(plant, n) for n, v in plant._asdict().items() if isinstance(v, np.ndarray)}
        arrays |= {"rope": np.frombuffer(self.rope, dtype=np.uint8)}
        names = list(self.recording.signals)
        if names:
            arrays["recording"] = np.array([self.recording[name] for name in names])
        text = {
            "version": version("balance-rope"),
            "sample": self.sample,
            "t": self.t,
            "controller": encode(self.controller, CONTROLLER),
            "input": self.input.tolist(),
            "free_lengths": plant.free_lengths,
            "step_next": plant.step_next,
            "slide": plant.slide,
            "times": [s.t for s in memory.samples],
            "memory": [memory.step_next, memory.exchanges, memory.taken_back, memory.residual],
            "names": names,
            "units": dict(self.recording.units),
            "data": self.data,
            "cause": self.cause,
        }
        arrays["text"] = np.frombuffer(json.dumps(text).encode(), dtype=np.uint8)
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]

    def require_fits(self, data: str) -> None:
        """ValueError unless a run of this data can go on from here."""
        if self.data != data:
            raise ValueError(
                f"the checkpoint at t = {self.t:g} s must be of the same hoist, winding, controller, gains and "
                f"sample time, but {differences(self.data, data)}: give the case and the options of that run"
            )
        if not self.rope:
            raise ValueError(
                f"the checkpoint at t = {self.t:g} s must hold the rope's state, which its rope could not save: "
                "start anew, or take an FMU with canGetAndSetFMUstate"
            )

    @staticmethod
    def read(path: Path) -> Checkpoint:
        """Read a file that `write` made in this version; raise ValueError for any other."""
        here = version("balance-rope")
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            text = json.loads(arrays["text"].tobytes())
            there = text.get("version", "an earlier one")
            kept = _checkpoint(arrays, text) if there == here else None
        except OSError as error:
            raise ValueError(
                f"'{path}': {(error.strerror or str(error)).lower()}: give a run's last_good.npz"
            ) from error
        except (KeyError, ValueError, TypeError, zipfile.BadZipFile) as error:
            raise ValueError(f"'{path}' must be a checkpoint of a run, but: {error}: give another file") from error
        if kept is None:
            raise ValueError(
                f"'{path}' must be of version {here}, it was written by {there}: go on with that version, or start "
                "anew in another folder"
            )
        return replace(kept, controller=decode(kept.controller))


def _checkpoint(arrays: Mapping[str, Any], x: Mapping[str, Any]) -> Checkpoint:
    """The checkpoint of an archive's arrays and text, its controller's state as it was written."""
    rows = zip(x["times"], *(arrays[f"sample.{name}"] for name in _FIELDS), strict=True)
    samples = tuple(Sample(t, *values) for t, *values in rows)
    plant = {n.removeprefix("plant."): v for n, v in arrays.items() if n.startswith("plant.")}
    table = arrays.get("recording", np.zeros((0, 0)))
    return Checkpoint(
        sample=x["sample"],
        t=x["t"],
        plant=PlantState(
            free_lengths=(x["free_lengths"][0], x["free_lengths"][1]),
            step_next=x["step_next"],
            slide=Slide(*x["slide"]),
            **plant,
        ),
        controller=x["controller"],
        input=np.array(x["input"]),
        memory=Memory(samples, *x["memory"]),
        rope=arrays["rope"].tobytes(),
        recording=Recording(dict(zip(x["names"], table, strict=True)), x["units"]),
        data=x["data"],
        cause=x["cause"],
    )


def differences(there: str, here: str, most: int = 6) -> str:
    """List the numbers and words that differ between a checkpoint's data and this run's."""
    old, new = (_FIELD.findall(data) for data in (there, here))
    changed = sorted(
        {f"{name} is {value} there" for name, value in old if (name, value) not in new}
        | {f"{name} is {value} here" for name, value in new if (name, value) not in old}
    )
    more = f" and {len(changed) - most} more" if len(changed) > most else ""
    return (", ".join(changed[:most]) or "they differ") + more
