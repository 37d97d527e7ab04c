"""What every form of the rope can do: hang, follow its ends, be read, and go back to a saved state."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..parameters import Scene
from .contact.point_forces import PointForces
from .ends.paths import EndMotion
from .fidelity import Fidelity
from .outputs.signal_table import checked_names
from .state import RopeState


@dataclass(frozen=True)
class Status:
    """Whether the rope's state is valid; if not, the message names cause and cure."""

    valid: bool
    message: str = ""


@dataclass(frozen=True)
class Snapshot:
    """A state in memory, as the rope that made it keeps it."""

    kept: Any
    unpack: Callable[[Any], RopeState]

    @property
    def state(self) -> RopeState:
        """For analysis, and for other ropes."""
        return self.unpack(self.kept)


class BalanceRope(ABC):
    """A balance rope between two conveyances: ``initialize``, then ``advance_to`` as often as needed.

    SI units.  Both forms, native and Python, take the same steps to the same numbers.  A start or a step that fails is
    a ``Status`` that says why, and leaves the state as it was; whatever needs a state raises RuntimeError before
    ``initialize``.  One rope may be used by one thread at a time.
    """

    @property
    @abstractmethod
    def scene(self) -> Scene:
        """The data of the run."""

    @property
    @abstractmethod
    def form(self) -> str:
        """How it computes: native, or the Python form with kernels that are compiled or portable (interpreted)."""

    @property
    @abstractmethod
    def elements(self) -> int:
        """Number of elements."""

    @property
    @abstractmethod
    def time(self) -> float:
        """The present state's instant, s."""

    @property
    @abstractmethod
    def fidelity(self) -> Fidelity:
        """How much of the rope is computed now: torsional is all, then spatial, planar and rigid."""

    @property
    @abstractmethod
    def fidelity_reason(self) -> str:
        """Why it is this fidelity."""

    @property
    @abstractmethod
    def state(self) -> RopeState:
        """The present state for analysis: nodes, mesh, swivels, energies, events; it never changes."""

    @abstractmethod
    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        """Hang the rope at rest at ``t`` (s) between the ends' positions, untwisted but for the installed twist.

        Speeds must be zero.  Accelerations play no part: the ends' paths begin at rest.
        """

    @abstractmethod
    def advance_to(self, t: float, left: EndMotion, right: EndMotion, given_at: float | None = None) -> Status:
        """Follow the conveyances to ``t`` (s) by their motions at ``given_at``, or else at ``t``.

        Motions of an earlier instant, at most inputs.hold_max before the step, are extrapolated with constant
        acceleration; simulation.ends.following has what happens to motions that do not fit.  On failure the state stays
        what it was.  Less than 1e-9 s ahead nothing moves; the time is not lost, the next step begins where this one
        did.
        """

    @abstractmethod
    def signals(self, names: Iterable[str] | None = None) -> dict[str, float]:
        """Values by name, in the units of SIGNALS; ValueError for a name that is not among them.

        Without ``names`` all but the added masses, which cost as much as a step: ask for those by name.
        """

    def reader(self, names: Sequence[str]) -> Callable[[], NDArray[np.float64]]:
        """A function that reads these values again and again, in this order; faster than ``signals``."""
        wanted = checked_names(names)
        return lambda: np.array([*self.signals(wanted).values()])

    @abstractmethod
    def apply(self, forces: PointForces) -> None:
        """From now on these forces act on the rope, and no others of the kind; they are no part of its state.

        A planar rope feels what is in its plane; a rigid one feels nothing and goes no step with them: set
        ``model.fidelity`` to torsional.
        """

    @abstractmethod
    def rows(self) -> NDArray[np.float64]:
        """(nodes, 13): arc length, r and r' of the nodes, and their rates; faster than ``state``."""

    @abstractmethod
    def displacement(self, forces: PointForces) -> NDArray[np.float64]:
        """(n, 3): by how much its forces at ``start`` move their places, m, at the end of a step as long as the last.

        As far as the equations are linear in it.
        """

    def added_mass(self) -> tuple[float, float]:
        """kg, left and right: how much an end's downward force grows with an upward acceleration of that end.

        The acceleration is held over an interval as long as the last, from the present state on.
        """
        left, right = self.signals(("left.added_mass", "right.added_mass")).values()
        return left, right

    @abstractmethod
    def warnings(self) -> dict[str, str]:
        """Warnings about a valid state, sentences by subject."""

    def save(self) -> bytes:
        """The complete state, for ``restore`` of any form of the same scene, also in another process."""
        return self.state.to_bytes()

    def snapshot(self) -> Snapshot:
        """The complete state, for ``restore``; faster than ``state`` and ``save``."""
        return Snapshot(self.state, lambda state: state)

    @abstractmethod
    def restore(self, data: bytes | RopeState | Snapshot) -> None:
        """Go on from what ``save``, ``state`` or ``snapshot`` gave.

        ValueError, and no change, when it does not fit this scene.
        """

    @abstractmethod
    def retune(self, scene: Scene) -> None:
        """Go on with other solver tolerances, swivel friction or wind; nothing else of the scene may differ."""


def state_in(data: bytes | RopeState | Snapshot) -> RopeState:
    """The state that ``save``, ``state`` or ``snapshot`` gave."""
    if isinstance(data, Snapshot):
        return data.state
    return RopeState.from_bytes(data) if isinstance(data, bytes) else data
