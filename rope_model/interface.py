"""BalanceRope, the interface of the engine and the reference rope, with Status and Snapshot."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rope_model.boundary.end_paths import EndMotion
from rope_model.boundary.point_forces import PointForces
from rope_model.fidelity.choice import Fidelity
from rope_model.parameters import Scene
from rope_model.saved_state import changed_fixed_parameters, labelled
from rope_model.signals.signal_table import checked_names
from rope_model.state import RopeState


@dataclass(frozen=True)
class Status:
    """Outcome of a start, step or restore; on failure the rope's state is unchanged."""

    valid: bool  #: true if the start or step succeeded
    message: str = ""  #: cause and cure, if not


@dataclass(frozen=True)
class Snapshot:
    """A complete state in memory, in the form of the rope that made it."""

    form: str  #: form of that rope
    scene: Scene  #: data of that rope
    kept: Any  #: state in that form
    unpack: Callable[[Any], RopeState]  #: function that makes a RopeState of it
    pack: Callable[[Any], bytes]  #: function that makes bytes of it

    @property
    def state(self) -> RopeState:
        """State for analysis, and for other ropes."""
        return self.unpack(self.kept)

    def to_bytes(self) -> bytes:
        """Return the bytes that ``save`` would have returned."""
        return labelled(self.pack(self.kept), self.form, self.scene)


class BalanceRope(ABC):
    """A balance rope between two conveyances: ``initialize``, then ``advance_to`` as often as needed.

    SI units.  A start or a step that fails leaves the state as it was.  Before ``initialize`` all
    that needs a state raises RuntimeError.  One thread at a time may use a rope.
    """

    @property
    @abstractmethod
    def scene(self) -> Scene:
        """Data of the run."""

    @property
    @abstractmethod
    def form(self) -> str:
        """Form of the rope: native or reference."""

    @property
    @abstractmethod
    def elements(self) -> int:
        """Number of elements."""

    @property
    def time(self) -> float:
        """Instant of the present state [s]."""
        return self.state.motion.t

    @property
    def fidelity(self) -> Fidelity:
        """Present fidelity; from complete to coarsest: torsional, spatial, planar, rigid."""
        return self.state.fidelity

    @property
    def fidelity_reason(self) -> str:
        """Reason for this fidelity."""
        return self.state.fidelity_reason

    @property
    @abstractmethod
    def state(self) -> RopeState:
        """Present state for analysis: nodes, mesh, swivels, energies, events; it never changes."""

    @abstractmethod
    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        """Hang the rope at rest, with its installed twist.

        Without that, and without coupling and curvature, it has no torque where its ends are apart
        along X and the conveyances have no yaw.  Held ends that are apart in the direction psi
        about Y twist it by 2 psi, yaws by their sum: as if it had been hung in the nominal position
        and the ends had then moved.  To hang it free of twist between such ends, yaw both by psi,
        or take 2 psi off the installed twist.

        Parameters
        ----------
        t : float
            Time of the start [s].
        left, right : EndMotion
            Positions of the ends. Speeds must be 0; accelerations play no part.

        Returns
        -------
        Status
            Valid, or cause and cure.
        """

    @abstractmethod
    def advance_to(
        self, t: float, left: EndMotion, right: EndMotion, given_at: float | None = None
    ) -> Status:
        """Follow the conveyances to ``t``.

        Parameters
        ----------
        t : float
            Time to reach [s]. If it is less than 1e-9 s ahead, the call succeeds without a step.
        left, right : EndMotion
            Motions of the ends at ``given_at``.
        given_at : float, optional
            Instant of the motions [s], ``t`` by default. Motions of an earlier instant, at most inputs.hold_max before
            the step, are extrapolated with constant acceleration.

        Returns
        -------
        Status
            Valid, or cause and cure.
        """

    @abstractmethod
    def signals(self, names: Iterable[str] | None = None) -> dict[str, float]:
        """Read signals of the present state.

        Parameters
        ----------
        names : iterable of str, optional
            Names in SIGNALS; by default all but the added masses, which cost as much as a step.

        Returns
        -------
        dict
            Values by name, in the units of SIGNALS.

        Raises
        ------
        ValueError
            If a name is not in SIGNALS.
        """

    def reader(self, names: Sequence[str]) -> Callable[[], NDArray[np.float64]]:
        """Return a function that reads these signals again and again, in this order; faster than ``signals``."""
        wanted = checked_names(names)
        return lambda: np.array([*self.signals(wanted).values()])

    @abstractmethod
    def apply(self, forces: PointForces) -> None:
        """Put these forces, and no others of the kind, on the rope from now on; they are no part of its state.

        A planar rope feels forces in its plane. A rigid one refuses steps with forces: set
        ``model.fidelity`` to torsional.

        Parameters
        ----------
        forces : PointForces
            Points on the rope, and forces there.

        Raises
        ------
        ValueError
            If a place is off the rope.
        """

    @abstractmethod
    def rows(self) -> NDArray[np.float64]:
        """Return arc length [m], r [m] and r' of the nodes, and their rates (nodes, 13); faster than ``state``."""

    @abstractmethod
    def displacement(self, forces: PointForces) -> NDArray[np.float64]:
        """Return the displacements [m] (n, 3) that the forces at ``start`` cause at their points of the rope.

        They are those of the linearised equations at the end of a step as long as the last.

        Raises
        ------
        ValueError
            If a place is off the rope, or the rope is rigid.
        """

    def added_mass(self) -> tuple[float, float]:
        """Return the added masses of the left and right end [kg]: downward force per upward acceleration of the end.

        Both are those at the end of the last interval. The acceleration grows over it from 0, in
        proportion to the time. The native rope alone computes them.
        """
        left, right = self.signals(("left.added_mass", "right.added_mass")).values()
        return left, right

    @abstractmethod
    def warnings(self) -> dict[str, str]:
        """Return warnings about a valid state: sentences by subject.

        The native rope computes all.  The reference rope computes passed_sides, yaw_at_rest,
        unresolved_bend for too coarse a mesh, and of leg_contact a loop that is turned over.  It
        says nothing of touching legs (leg_contact), other_rests, missing_loads, unresolved_waves and
        unfit_inputs.
        """

    def save(self) -> bytes:
        """Return the complete state, for ``restore`` of a rope of this form, also in another process.

        The point forces of ``apply`` and the tunable parameters of ``retune`` are no part of it.
        """
        return self.snapshot().to_bytes()

    @abstractmethod
    def snapshot(self) -> Snapshot:
        """Return the complete state, for ``restore``; faster than ``state`` and ``save``."""

    @abstractmethod
    def restore(self, data: bytes | RopeState | Snapshot) -> None:
        """Go on from the result of ``save``, ``state`` or ``snapshot``; nothing changes if it is refused.

        From ``save`` and ``snapshot`` the rope goes on to the same bits.  A ``state`` may have been
        changed, and lacks the communication step that led to it: until the next step, added masses
        are those of a step that is yet to come.

        Raises
        ------
        ValueError
            If ``save`` or ``snapshot`` is that of another form, or of a rope with other parameters
            than the tunable ones.  If a ``state`` has another mesh or numbers that no rope of this
            scene has; its parameters are not known.
        """

    def retune(self, scene: Scene) -> None:
        """Go on with other tunable parameters: solver, swivel friction, wind.

        Raises
        ------
        ValueError
            If anything else of the scene differs; nothing changes then.
        """
        for old, new in changed_fixed_parameters(self.scene, scene):
            raise ValueError(
                f"{old.name} = {new.value:g} must stay {old.value:g} during a run: make a new rope"
            )
        self._retune(scene)

    @abstractmethod
    def _retune(self, scene: Scene) -> None:
        """Take the tunable parameters of ``scene``."""
