"""NativeRope, the rope in C: a ctypes wrapper of the library with the interface of BalanceRope."""

import ctypes
import os
import struct
from collections.abc import Callable, Iterable, Sequence
from ctypes import POINTER, Structure, byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import cache, lru_cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from rope_model.boundary.end_paths import EndMotion
from rope_model.boundary.point_forces import NO_FORCES, PointForces
from rope_model.codegen import state_structures as layout
from rope_model.codegen.build import failed, library
from rope_model.codegen.interface_structures import (
    FORCE_ROW,
    LinearFactsStructure,
    MemoryStructure,
    PointForcesStructure,
    TangentCoefficientsStructure,
)
from rope_model.codegen.structures import scene_structure
from rope_model.fidelity.choice import Fidelity
from rope_model.interface import BalanceRope, Snapshot, Status
from rope_model.messages import messages
from rope_model.native_state import pack, unpack, with_layout_digest, without_layout_digest
from rope_model.parameters import Scene
from rope_model.physics.node import ANGLE, NODE_DOF
from rope_model.saved_state import require_form, require_same_rope, state_behind_label
from rope_model.signals.signal_table import SIGNALS, checked_names
from rope_model.state import RopeState
from rope_model.warnings.result_warnings import WARNINGS

#: numbers of a row: arc length, r, r' and their rates
ROW_SIZE = 1 + 2 * ANGLE
_MOTIONS = struct.Struct(f"{2 * len(EndMotion.__dataclass_fields__)}d")


class LinearFacts(NamedTuple):
    """Facts about the present state for linear models."""

    free: NDArray[np.bool_]  #: (nodes, 7), true for coordinates that are not prescribed
    near_bodies: bool  #: true if an element may touch a body of the shaft
    curved: bool  #: true if permanent curvature acts
    rubs: bool  #: true if wires rub
    lowest_s: float  #: m, arc length of the loop's lowest point


class ChainMatrix(NamedTuple):
    """Symmetric matrix of a chain whose nodes couple with their neighbours only."""

    nodes: NDArray[np.float64]  #: (nodes, 7, 7), blocks on the diagonal
    #: (elements, 7, 7), blocks of each node (rows) with the next (columns)
    next: NDArray[np.float64]


@cache
def _load() -> ctypes.CDLL:
    path = library()
    try:
        return declare(ctypes.CDLL(str(path)))
    except OSError as error:
        raise failed(error) from error


def declare(lib: ctypes.CDLL) -> ctypes.CDLL:
    """Declare the types of the library's functions and return the library."""
    rope = c_void_p
    number = c_int
    success = c_int
    text = c_char_p
    buffer = c_void_p
    functions: dict[str, tuple[Any, tuple[Any, ...]]] = {
        # name: result, arguments
        "rope_create": (rope, (c_void_p, c_void_p, text)),
        "rope_destroy": (None, (rope,)),
        "rope_initialize": (success, (rope, c_double, text)),
        "rope_advance_to": (success, (rope, c_double, text, c_double)),
        "rope_retune": (success, (rope, c_void_p)),
        "rope_apply": (None, (rope, c_void_p)),
        "rope_rows": (None, (rope, buffer)),
        "rope_displacement": (success, (rope, c_void_p, buffer)),
        "rope_is_initialized": (c_int, (rope,)),
        "rope_time": (c_double, (rope,)),
        "rope_elements": (number, (rope,)),
        "rope_message": (text, (rope,)),
        "rope_fidelity": (text, (rope,)),
        "rope_fidelity_reason": (text, (rope,)),
        "rope_warning": (None, (rope, number, text)),
        "rope_signals": (None, (rope, c_size_t, POINTER(c_int), POINTER(c_double))),
        "rope_load_derivative": (success, (rope, number, number, POINTER(c_double))),
        "rope_repeated_steps": (c_size_t, (rope,)),
        "rope_linear_facts": (None, (rope, POINTER(LinearFactsStructure))),
        "rope_frames": (None, (rope, buffer)),
        "rope_tangent": (None, (rope, POINTER(TangentCoefficientsStructure), buffer, buffer)),
        "rope_release_free_swivels": (success, (rope,)),
        "rope_state_bytes": (c_size_t, (rope,)),
        "rope_save": (None, (rope, buffer)),
        "rope_restore": (success, (rope, text, c_size_t)),
    }
    for name, (result, arguments) in functions.items():
        function = getattr(lib, name)
        function.restype = result
        function.argtypes = arguments
    return lib


class NativeHandle(NamedTuple):
    """Access for C code that steps a native rope itself; it reports success to ``NativeRope.status_of``."""

    lib: ctypes.CDLL
    rope: int  # address
    warnings: int  # number of warnings
    text: Any  # buffer for a warning


class NativeRope(BalanceRope):
    """Rope in C, complete.

    Raises ValueError if the mesh does not fit the rope, NoEngine without a C compiler or when it
    fails, and WriteError when its library cannot be kept.
    """

    _library = staticmethod(_load)

    def __init__(self, scene: Scene) -> None:
        self._lib = self._library()
        libc = ctypes.CDLL(None if os.name == "posix" else "msvcrt")
        functions = zip(MemoryStructure._fields_, (libc.calloc, libc.free), strict=True)
        memory = MemoryStructure(*(ctypes.cast(function, of) for (_, of), function in functions))
        self._text = ctypes.create_string_buffer(layout.MESSAGE)  # receives messages of the library
        self._rope = self._lib.rope_create(byref(scene_structure(scene)), byref(memory), self._text)
        if not self._rope:
            raise ValueError(self._text.value.decode())
        self._scene = scene
        self._state: RopeState | None = None  # cache of `state`
        self._applied = NO_FORCES
        self._forces = _forces(NO_FORCES)  # kept, for the library has a pointer to them

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle a rope as its scene, state and forces."""
        state = b""
        if self._lib.rope_is_initialized(self._rope):
            state = self.native_state()
        return _rebuild, (type(self), self._scene, state, self._applied)

    def __del__(self) -> None:
        if rope := self.__dict__.pop("_rope", None):
            self._lib.rope_destroy(rope)

    @property
    def scene(self) -> Scene:
        return self._scene

    @property
    def form(self) -> str:
        return "native"

    @property
    def library(self) -> NativeHandle:
        """Library and rope for C code that steps the rope itself."""
        return NativeHandle(self._lib, self._rope, len(WARNINGS), self._text)

    @property
    def elements(self) -> int:
        return int(self._lib.rope_elements(self._rope))

    @property
    def time(self) -> float:
        self._require_state()
        return float(self._lib.rope_time(self._rope))

    @property
    def fidelity(self) -> Fidelity:
        self._require_state()
        return cast(Fidelity, self._lib.rope_fidelity(self._rope).decode())

    @property
    def fidelity_reason(self) -> str:
        self._require_state()
        return str(self._lib.rope_fidelity_reason(self._rope).decode())

    @property
    def state(self) -> RopeState:
        if self._state is None:
            self._state = unpack(self.native_state())
        return self._state

    def initialize(self, t: float, left: EndMotion, right: EndMotion) -> Status:
        return self.status_of(self._lib.rope_initialize(self._rope, t, _ends(left, right)))

    def advance_to(
        self, t: float, left: EndMotion, right: EndMotion, given_at: float | None = None
    ) -> Status:
        self._require_state()
        if given_at is None:
            given_at = t
        ends = _ends(left, right)
        return self.status_of(self._lib.rope_advance_to(self._rope, t, ends, given_at))

    def signals(self, names: Iterable[str] | None = None) -> dict[str, float]:
        self._require_state()
        wanted = checked_names(names)
        values = (c_double * len(wanted))()
        self._lib.rope_signals(self._rope, len(wanted), _numbers(wanted), values)
        return dict(zip(wanted, values[:], strict=True))

    def reader(self, names: Sequence[str]) -> Callable[[], NDArray[np.float64]]:
        wanted = checked_names(names)
        values = (c_double * len(wanted))()
        view: NDArray[np.float64] = np.ctypeslib.as_array(values)
        read = self._lib.rope_signals
        arguments = (self._rope, len(wanted), _numbers(wanted), values)

        def read_now() -> NDArray[np.float64]:
            self._require_state()
            read(*arguments)
            return view.copy()

        return read_now

    def apply(self, forces: PointForces) -> None:
        forces.require_on(self._scene.rope.length)
        self._applied = forces
        self._forces = _forces(forces)
        self._lib.rope_apply(self._rope, byref(self._forces.structure))

    def rows(self) -> NDArray[np.float64]:
        self._require_state()
        rows = np.empty((self.elements + 1, ROW_SIZE))
        self._lib.rope_rows(self._rope, rows.ctypes.data)
        return rows

    def displacement(self, forces: PointForces) -> NDArray[np.float64]:
        self._require_state()
        forces.require_on(self._scene.rope.length)
        in_c = _forces(forces)
        displacement = np.empty((forces.s.size, 3))
        if not self._lib.rope_displacement(
            self._rope, byref(in_c.structure), displacement.ctypes.data
        ):
            raise ValueError(self._lib.rope_message(self._rope).decode())
        return displacement

    def linear_facts(self) -> LinearFacts:
        """Return what linear models need to know of the present state."""
        facts = self._linear_facts()
        free = np.ones((self.elements + 1, NODE_DOF), dtype=np.bool_)
        free[[0, -1]] = np.array(facts.free)
        return LinearFacts(free, facts.near_bodies, facts.curved, facts.rubs, facts.lowest_s)

    def _linear_facts(self) -> LinearFactsStructure:
        self._require_state()
        facts = LinearFactsStructure()
        self._lib.rope_linear_facts(self._rope, byref(facts))
        return facts

    def frames(self) -> NDArray[np.float64]:
        """Return F (elements, ...) of the functions of physics.rope_element, without the wires' latest tangents.

        Raises ValueError unless the fidelity is torsional: others have no frames.
        """
        if self.fidelity != "torsional":
            raise ValueError(
                f"a {self.fidelity} rope has no frames: set model.fidelity = 'torsional'"
            )
        frames = np.empty((self.elements, self._linear_facts().frame_size))
        self._lib.rope_frames(self._rope, frames.ctypes.data)
        return frames

    def tangent(self, q: float = 0.0, v: float = 0.0, a: float = 0.0) -> ChainMatrix:
        """Return q dR/dq + v dR/dv + a dR/da of the torsional model at the present state, without contact.

        It is the symmetric tangent of Newton's method: the parts of the residual R without energy
        are left out.
        """
        self._require_state()
        matrix = ChainMatrix(
            np.empty((self.elements + 1, NODE_DOF, NODE_DOF)),
            np.empty((self.elements, NODE_DOF, NODE_DOF)),
        )
        c = TangentCoefficientsStructure(q, v, a)
        self._lib.rope_tangent(
            self._rope, byref(c), matrix.nodes.ctypes.data, matrix.next.ctypes.data
        )
        return matrix

    def release_free_swivels(self) -> Status:
        """Release the free swivels of a rope that has just been hung, and bring it to rest; others hold."""
        return self.status_of(self._lib.rope_release_free_swivels(self._rope))

    def warnings(self) -> dict[str, str]:
        self._require_state()
        warnings = {}
        for number, subject in enumerate(WARNINGS):
            self._lib.rope_warning(self._rope, number, self._text)
            if warning := self._text.value:
                warnings[subject] = warning.decode()
        return warnings

    def snapshot(self) -> Snapshot:
        return Snapshot(self.form, self._scene, self.native_state(), unpack, with_layout_digest)

    def restore(self, data: bytes | RopeState | Snapshot) -> None:
        _require(self.restore_native(self._native_state_in(data)))

    def _native_state_in(self, data: bytes | RopeState | Snapshot) -> bytes:
        """Return the ``native_state`` of a result of ``save``, ``state`` or ``snapshot`` of this rope."""
        if isinstance(data, bytes):
            return without_layout_digest(state_behind_label(data, self.form, self._scene))
        if isinstance(data, Snapshot):
            require_form(data.form, self.form)
            require_same_rope(data.scene, self._scene)
            return cast(bytes, data.kept)
        if not isinstance(data, RopeState):
            raise ValueError(
                f"a {type(data).__name__} must be a RopeState of rope_model.state, bytes of save() "
                "or a Snapshot: give one of the native rope"
            )
        # a RopeState has no step that led to it, nor a hysteresis before the wires rub
        return pack(data).ljust(self._lib.rope_state_bytes(self._rope), b"\0")

    def _retune(self, scene: Scene) -> None:
        succeeded = self._lib.rope_retune(self._rope, byref(scene_structure(scene)))
        _require(self.status_of(succeeded))
        self._scene = scene

    def native_state(self) -> bytes:
        """Return the state in the memory layout of the native rope."""
        self._require_state()
        data = ctypes.create_string_buffer(self._lib.rope_state_bytes(self._rope))
        self._lib.rope_save(self._rope, data)
        return data.raw

    def restore_native(self, data: bytes) -> Status:
        """Go on from a ``native_state``."""
        return self.status_of(self._lib.rope_restore(self._rope, data, len(data)))

    def _require_state(self) -> None:
        if not self._lib.rope_is_initialized(self._rope):
            raise RuntimeError(messages.no_state())

    def status_of(self, succeeded: int) -> Status:
        """Return the status after a call of the library that returned ``succeeded``."""
        if succeeded:
            self._state = None
            return _VALID
        return Status(False, self._lib.rope_message(self._rope).decode())


class _ForcesInC(NamedTuple):
    """Point forces in the form of rope.h."""

    structure: Structure
    rows: NDArray[np.float64]  # (forces, FORCE_ROW), the memory to which the structure points


def _forces(forces: PointForces) -> _ForcesInC:
    """Return the forces in the form of rope.h."""
    rows = np.column_stack((forces.s, forces.at_start, forces.at_stop)).astype(float, copy=False)
    places = rows.ctypes.data_as(POINTER(c_double * FORCE_ROW))
    structure = PointForcesStructure(forces.s.size, forces.start, forces.stop, places)
    return _ForcesInC(structure, rows)


def _rebuild(
    kind: type[NativeRope], scene: Scene, state: bytes, applied: PointForces
) -> NativeRope:
    rope = kind(scene)
    rope.apply(applied)
    if state:
        _require(rope.restore_native(state))
    return rope


def _require(status: Status) -> None:
    """Raise ValueError with the message of a status that is not valid."""
    if not status.valid:
        raise ValueError(status.message)


_VALID = Status(True)
_NUMBER = {name: i for i, name in enumerate(SIGNALS)}


@lru_cache
def _numbers(names: tuple[str, ...]) -> ctypes.Array[c_int]:
    """Return the signals' numbers; cached, because a host reads the same signals again and again."""
    return (c_int * len(names))(*(_NUMBER[name] for name in names))


def _ends(left: EndMotion, right: EndMotion) -> bytes:
    """Return both motions as an array of EndMotion of rope.h."""
    return _MOTIONS.pack(*left.__dict__.values(), *right.__dict__.values())
