"""The engine's mesh, transfer and shape, one C function at a time, with arrays and records of Python."""

from __future__ import annotations

import ctypes as ct
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from functools import cache
from itertools import chain
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rope_model import compiler as kernels
from rope_model.boundary.end_paths import EndMotion
from rope_model.boundary.input_filter import InputFilter
from rope_model.boundary.input_path import PathMeasures
from rope_model.codegen.build import sources
from rope_model.codegen.state_structures import MESSAGE, PARTS, PatternStructure
from rope_model.codegen.structures import GROUP_STRUCTURES, EndMotionStructure, scene_structure
from rope_model.method.mesh_fit import NO_DIVIDERS
from rope_model.method.newton import SMOOTH, NewtonLimits
from rope_model.method.partition import Partition
from rope_model.parameters import Scene
from rope_model.physics.contact_element import CONTACT_BALANCE
from rope_model.physics.energy_balance import EnergyBalance
from rope_model.physics.node import SIDES, arc_lengths
from rope_model.physics.shaft import KINDS
from rope_model.solver_parameters import Inputs, Mesh, MeshKind
from rope_model.state import Nearest

Array = NDArray[np.float64]

#: warnings under which tests compile C, as errors
WARNINGS = ("-Wall", "-Wextra", "-Wshadow", "-Werror")


class CLoopBottom(ct.Structure):
    _fields_ = (("s", ct.c_double), ("position", ct.c_double * 3), ("yaw", ct.c_double))


class CLoopTurns(ct.Structure):
    _fields_ = (("number", ct.c_double), ("sharpest_y", ct.c_double))


#: bytes of NodalArrays: nine pointers, two integers
NODAL_ARRAYS_BYTES = 9 * ct.sizeof(ct.c_void_p) + 2 * ct.sizeof(ct.c_int)

#: functions that have no name in a library, and arrays of a state
MORE = """
#include <stdlib.h>
#include <string.h>

#include "formulas.h"
#include "self_contact.h"
#include "system.h"
#include "wires.h"

void arrays_of(double *q, double *v, double *a, double *reaction, double *lengths, double *s, int nodes,
               NodalArrays *arrays) {
    NodalArrays of = {q, v, a, NULL, NULL, reaction, lengths, s, NULL, nodes - 1, nodes};
    *arrays = of;
}

/* Carry z (elements x WIRE_Z) from nodes at old_s to those of a mesh of as many elements. */
void carry_wires(int elements, const double *old_s, const double *lengths, const double *s, double *z) {
    const size_t n = (size_t)elements, rows = FIELDS * DOF * (n + 1) + n + n + 1 + WIRE_Z * n;
    double *scratch = calloc(n * WIRE_ELEMENT_HISTORY_SIZE, sizeof(double));
    State *state = calloc(1, sizeof *state + rows * sizeof(double));
    state->elements = elements;
    state->rubs = 1;
    const NodalArrays nodal = state_arrays(state);
    memcpy(nodal.lengths, lengths, n * sizeof(double));
    memcpy(nodal.s, s, (n + 1) * sizeof(double));
    memcpy(nodal.z, z, WIRE_Z * n * sizeof(double));
    wires_carry(state, old_s, scratch);
    memcpy(z, nodal.z, WIRE_Z * n * sizeof(double));
    free(state);
    free(scratch);
}

/* Contact of a rope with itself: subtract its forces from R, add its tangent times x to y, and its sums to sums. */
int self_contact_of(const Scene *scene, int elements, const double *lengths, const double *q, const double *v,
                    double c_q, double c_v, const double *x, double *R, double *y, double *sums) {
    const size_t n = (size_t)elements, size = DOF * (n + 1);
    double length = 0;
    for (int e = 0; e < elements; e++) length += lengths[e];
    const size_t places = (size_t)rope_contact_max_points(length, elements, scene->rope.diameter);
    SelfContactState state = {.scene = scene, .presses = 1};
    double *numbers = calloc(size + n, sizeof *numbers);
    state.cache = (ClearanceCache){.q = numbers, .lengths = numbers + size};
    state.work.boxes = calloc(n, sizeof *state.work.boxes);
    state.work.neighbours = calloc(n, sizeof *state.work.neighbours);
    state.contacts = calloc(ROPE_CONTACT_MAX_STRANDS * places, sizeof *state.contacts);
    const System system = {.elements = elements, .lengths = lengths, .self_contact = &state};
    const int count = find_self_contacts(&system, q, v, c_q, c_v);
    self_contact_take_force(&state, R);
    self_contact_times(&state, x, y);
    self_contact_sums(&system, q, v, sums);
    free(state.contacts);
    free(state.work.neighbours);
    free(state.work.boxes);
    free(numbers);
    return count;
}
"""


def compiled(folder: Path, texts: dict[str, str]) -> ct.CDLL:
    """The rope's library with further C texts; skips the test without a compiler."""
    if (compiler := kernels.find_compiler()) is None:
        pytest.skip("no C compiler")
    for name, text in (sources() | texts).items():
        (folder / name).write_text(text, encoding="utf-8")
    command = [*compiler, *kernels.FLAGS]
    objects = kernels.object_files(sources(), compiler, kernels.FLAGS, kernels.cache_folder())
    kernels.compile_objects(sources(), command, objects)
    more = [folder / name for name in texts]
    files = [str(path) for path in (*objects.values(), *more)]
    made = folder / f"compiled{kernels.LIBRARY_SUFFIX}"
    command += [*WARNINGS, f"-I{folder}", *files, "-o", str(made), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ct.CDLL(str(made))


@pytest.fixture(scope="session")
def parts() -> SimpleNamespace:
    """Return the functions in C, by their names."""
    return _parts()


@cache
def _library() -> ct.CDLL:
    with tempfile.TemporaryDirectory() as folder:
        return compiled(Path(folder), {"more.c": MORE})


@cache
def _parts() -> SimpleNamespace:
    library = _library()
    n = ct.c_int
    x = ct.c_double
    p = ct.c_void_p
    signatures: dict[str, tuple[Any, ...]] = {
        "fit_mesh": (GROUP_STRUCTURES[Mesh], p),
        "partition_elements": (n, p, x, p, p),
        "partition": (None, p, x, x, p, n, p, p),
        "partition_transform": (None, p, n, p, n, p),
        "window_due": (ct.c_bool, p, p),
        "arc_lengths": (None, n, p, p),
        "transfer_interpolate": (None, n, p, p, n, p, p),
        "transfer_fields": (None, n, p, p, n, p, p),
        "loop_bottom": (CLoopBottom, n, p, p),
        "leg_clearance": (x, n, p, p, p, x, x, x, p),
        "legs_apart": (ct.c_bool, p, p, x, x),
        "shape_places": (None, x, x, x, n, p),
        "diagnostics_shape": (None, n, p, p, n, p, p),
        "end_strain": (x, p, n, p, p, n),
        "loop_turns": (CLoopTurns, p, p),
        "shaft_clearances": (None, p, p, x, p),
        "check_motion": (n, p, p, p, n, p),
        "check_input_age": (n, p, x, p, n, p),
        "self_contact_of": (n, p, n, p, p, p, x, x, p, p, p, p),
        "carry_wires": (None, n, p, p, p, p),
        "rigid_rope": (n, p, p, x, p, p, p),
        "arrays_of": (None, p, p, p, p, p, p, n, p),
    }
    for name, (result, *arguments) in signatures.items():
        getattr(library, name).restype = result
        getattr(library, name).argtypes = arguments
    return SimpleNamespace(**{name: passing_arrays(getattr(library, name)) for name in signatures})


def passing_arrays(function: Any) -> Callable[..., Any]:
    """``function`` with numpy arrays (C order, float) and ctypes structures as pointers."""

    def address(x: Any) -> Any:
        if isinstance(x, np.ndarray):
            assert x.flags.c_contiguous
            assert x.dtype == float
            return x.ctypes.data
        if isinstance(x, ct.Structure | ct.Array | ct.c_double):
            return ct.addressof(x)
        return x

    return lambda *arguments: function(*map(address, arguments))


def message() -> Any:
    return ct.create_string_buffer(MESSAGE)


def fit_mesh(scene: Scene) -> Mesh:
    """Return the mesh that the scene asks for; 'auto' is fitted to the rope."""
    found = _parts().fit_mesh(scene_structure(scene))
    kinds: tuple[MeshKind, ...] = ("tmn", "eem", "auto")
    return Mesh(
        kinds[found.kind],
        coarse_length=found.coarse_length,
        counts=tuple(found.counts),
        end_levels=found.end_levels,
        grading_length=found.grading_length,
        elements=found.elements,
        loop_error=found.loop_error,
    )


def _record(pattern: PatternStructure, lengths: Array) -> Partition:
    return Partition(
        lengths,
        tuple(pattern.counts),
        pattern.coarse,
        pattern.end_levels,
        pattern.grading_length,
        tuple(pattern.windows),
    )


def partition(
    mesh: Mesh, length: float, bottom_s: float, divider_s: Sequence[float] = NO_DIVIDERS
) -> Partition:
    """Return the partition of a rope whose lowest point is at ``bottom_s`` (m), or raise ValueError."""
    parts = _parts()
    of = scene_structure(Scene(mesh=mesh)).mesh
    text = message()
    places = np.array(divider_s)
    elements = parts.partition_elements(of, length, places, text)
    if elements == 0:
        raise ValueError(text.value.decode())
    pattern = PatternStructure()
    lengths = np.empty(elements)
    parts.partition(of, length, bottom_s, places, elements, pattern, lengths)
    return _record(pattern, lengths)


def _pattern(cells: Partition) -> PatternStructure:
    return PatternStructure(
        cells.coarse, cells.grading_length, cells.counts, cells.end_levels, cells.windows
    )


def transform(
    cells: Partition, direction: int, divider_s: Sequence[float] = NO_DIVIDERS
) -> Partition:
    """Return the partition whose pattern has moved by l, or whose windows have."""
    pattern = _pattern(cells)
    lengths = np.empty(cells.lengths.size)
    _parts().partition_transform(
        pattern, int(direction), np.array(divider_s), lengths.size, lengths
    )
    return _record(pattern, lengths)


def window_due(cells: Partition, divider_s: Sequence[float]) -> bool:
    """Return whether a divider has left its window."""
    return bool(_parts().window_due(_pattern(cells), np.array(divider_s)))


def interpolate(x: Array, s: Array, at: Array) -> Array:
    """Return rows (points, 7) at arc lengths ``at`` (m) between nodes at ``s``."""
    y = np.empty((at.size, 7))
    _parts().transfer_interpolate(
        s.size,
        np.ascontiguousarray(x),
        np.ascontiguousarray(s),
        at.size,
        np.ascontiguousarray(at, dtype=float),
        y,
    )
    return y


def shape(q: Array, lengths: Array, bottom_s: float, loop: float, points: int) -> Array:
    """Return points (points, 3) of the centre line, denser around the loop of this width (m)."""
    s = arc_lengths(lengths)
    places = np.empty(points)
    xyz = np.empty((points, 3))
    _parts().shape_places(s[-1], bottom_s, loop, points, places)
    _parts().diagnostics_shape(s.size, np.ascontiguousarray(q), s, points, places, xyz)
    return xyz


def shape_places(total: float, bottom_s: float, loop: float, points: int) -> Array:
    """Return the arc lengths (points,), m, of these points."""
    places = np.empty(points)
    _parts().shape_places(total, bottom_s, loop, points, places)
    return places


def loop_bottom(q: Array, lengths: Array) -> CLoopBottom:
    """Return the lowest point of the centre line."""
    s = arc_lengths(lengths)
    found: CLoopBottom = _parts().loop_bottom(s.size, np.ascontiguousarray(q), s)
    return found


@dataclass(frozen=True)
class RigidRope:
    """Rigid rope: positions, velocities and accelerations of its nodes (nodes, 7), end tensions (N), energies (J)."""

    q: Array
    v: Array
    a: Array
    tensions: tuple[float, float]
    kinetic: float
    gravity: float


def rigid_rope(scene: Scene, ends: tuple[EndMotion, EndMotion], t: float, s: Array) -> RigidRope:
    """Return the rigid rope with nodes at ``s`` (m); raises ValueError if it goes slack."""
    q, v, a, reaction = (np.zeros((s.size, 7)) for _ in range(4))
    balance = PARTS[EnergyBalance]()
    text = message()
    motions = (EndMotionStructure * 2)(*(EndMotionStructure(*astuple(end)) for end in ends))
    nodal = ct.create_string_buffer(NODAL_ARRAYS_BYTES)
    _parts().arrays_of(q, v, a, reaction, np.diff(s), s, s.size, nodal)
    _parts().rigid_rope(scene_structure(scene), motions, t, nodal, balance, text)
    if text.value:
        raise ValueError(text.value.decode())
    return RigidRope(q, v, a, (reaction[0, 1], reaction[-1, 1]), balance.kinetic, balance.gravity)


class CProgress(ct.Structure):
    """Progress of newton.h."""

    _fields_ = (
        ("status", ct.c_int),
        ("iterations", ct.c_int),
        ("applies", ct.c_bool),
        ("norm", ct.c_double),
        ("error", ct.c_double),
        ("contraction", ct.c_double),
        ("sum", ct.c_double),
    )


class CLimits(ct.Structure):
    """NewtonLimits of newton.h."""

    _fields_ = tuple((name, ct.c_double) for name in NewtonLimits._fields)


def newton_judge(before: CProgress, norm: float, tolerance: float, fresh: bool) -> CProgress:
    """Return the progress after a correction of this norm, with limits of smooth equations."""
    judge = _library().newton_judge
    judge.restype = CProgress
    judge.argtypes = (CProgress, ct.c_double, ct.c_double, ct.c_bool, ct.c_void_p)
    limits = CLimits(*SMOOTH)
    found: CProgress = judge(before, norm, tolerance, fresh, ct.addressof(limits))
    return found


def nodal_arrays(q: Array, lengths: Array) -> Any:
    """Return the arrays of a rope at rest as the engine's functions take them; ``q`` and ``lengths`` must live on."""
    arrays = ct.create_string_buffer(NODAL_ARRAYS_BYTES)
    s = arc_lengths(lengths)
    _parts().arrays_of(q, q, q, q, lengths, s, s.size, arrays)
    arrays.kept = (q, lengths, s)  # type: ignore[attr-defined]
    return arrays


def loop_turns(q: Array, lengths: Array, bottom: CLoopBottom) -> CLoopTurns:
    """Return the turns of one side of the rope about the other."""
    found: CLoopTurns = _parts().loop_turns(
        nodal_arrays(np.ascontiguousarray(q), np.ascontiguousarray(lengths)), bottom
    )
    return found


def clearances(scene: Scene, q: Array, lengths: Array, t: float) -> tuple[Nearest, ...]:
    """Return the nearest place of a rope to the bodies of each kind at ``t`` (s)."""
    found = (PARTS[Nearest] * len(KINDS))()
    arrays = nodal_arrays(np.ascontiguousarray(q), np.ascontiguousarray(lengths))
    _parts().shaft_clearances(scene_structure(scene), arrays, t, found)
    members = attrgetter(*Nearest._fields)
    return tuple(Nearest(*members(one)) for one in found)


def refusal(scene: Scene, target: EndMotion, measures: PathMeasures, side: str) -> str:
    """Return why an end cannot move as ``target`` by a path of these measures; '' if it can."""
    sizes = np.array([*chain.from_iterable(measures)])
    motion = EndMotionStructure(*astuple(target))
    text = message()
    _parts().check_motion(scene_structure(scene), motion, sizes, SIDES.index(side), text)
    return str(text.value.decode())


def stale_input_error(inputs: Inputs, t: float, end_filter: InputFilter, side: str) -> str:
    """Return why a motion that has not changed is refused at ``t`` (s); '' if it is not."""
    settings = scene_structure(Scene(inputs=inputs))
    structure = PARTS[InputFilter](*end_filter)
    text = message()
    _parts().check_input_age(settings.inputs, t, structure, SIDES.index(side), text)
    return str(text.value.decode())


@dataclass(frozen=True)
class SelfContacts:
    """Contact of a rope with itself: its forces and a product with its tangent (nodes, 7), and its sums."""

    forces: Array
    product: Array
    sums: dict[str, float]

    def take_force(self, R: Array) -> None:
        """Subtract the forces from ``R``."""
        R -= self.forces


def find_self_contacts(
    scene: Scene,
    q: Array,
    v: Array,
    lengths: Array,
    c: tuple[float, float] = (0.0, 0.0),
    x: Array | None = None,
) -> SelfContacts:
    """Return the contacts, with the tangent with respect to c times q and v, and its product with ``x``."""
    R = np.zeros_like(q)
    y = np.zeros_like(q)
    names = (*CONTACT_BALANCE, "rope")
    sums = np.zeros(len(names))
    if x is None:
        x = np.zeros_like(q)
    _parts().self_contact_of(scene_structure(scene), lengths.size, lengths, q, v, *c, x, R, y, sums)
    return SelfContacts(-R, y, dict(zip(names, sums.tolist(), strict=True)))


def carry(z: Array, old_lengths: Array, new_lengths: Array) -> Array:
    """Return the hysteresis ``z`` (elements, 9) of wires on as many elements of other lengths."""
    carried = z.copy()
    s = arc_lengths(new_lengths)
    _parts().carry_wires(len(z), arc_lengths(old_lengths), new_lengths, s, carried)
    return carried
