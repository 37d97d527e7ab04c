"""The native rope's mesh, frame, shape and signals, one C function at a time.

C and Python do the same operations in the same order.  They may differ by what libm, numpy's vectorised sine, cosine
and power, and sums in another order round differently: 1e-12 of the quantities' size, where nothing else is said.
"""

from __future__ import annotations

import ctypes as ct
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rope_model.native.build import generate
from rope_model.native.structures import GROUPS
from rope_model.numerics.kernels import LIBRARY_SUFFIX, find_compiler
from rope_model.parameters import Mesh
from rope_model.simulation.diagnostics import (
    LoopBottom,
)

Array = NDArray[np.float64]

NATIVE = Path(__file__).resolve().parent.parent / "rope_model" / "native"
FLAGS = ("-O2", "-std=c99", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared", "-ffp-contract=off")
PARTS = (
    "mesh.c",
    "transfer.c",
    "shape.c",
    "shaft.c",
    "guards.c",
    "signals.c",
    "rigid.c",
    "ends.c",
    "parameters.c",
    "text.c",
)
MESSAGE, ROUNDING = 512, 1e-12


class CLoopBottom(ct.Structure):
    _fields_ = (("s", ct.c_double), ("position", ct.c_double * 3), ("yaw", ct.c_double))

    @staticmethod
    def of(bottom: LoopBottom) -> CLoopBottom:
        return CLoopBottom(bottom.s, tuple(bottom.position), bottom.yaw)


#: the signals of a state that the caller gives by its members, so that its layout is C's own business
SIGNALS_BY_MEMBERS = """
#include <string.h>
#include "cases.h"
#include "simulator.h"

double mesh_centre(const Pattern *p) { return pattern_centre(p); }
double mesh_distance_to_due(const Pattern *p, double bottom) { return distance_to_due(p, bottom); }
double mesh_transformation_due(const Pattern *p, double bottom, double slack) {
    return transformation_due(p, bottom, slack);
}

static Simulator rope;

/* a simulator would compute these from its equations */
const LoopBottom *bottom_now(Simulator *of) { return &of->bottom; }
void compute_strains(Simulator *of) { (void)of; }
void added_mass_signals(Simulator *of, double *values) { (void)of, (void)values; }
void contact_signals(Simulator *of, double *values) { (void)of, (void)values; }
const double *end_row(const double *x, int nodes, int side) { return x + (side ? (size_t)(nodes - 1) * DOF : 0); }

Simulator *signals_rope(void) { return &rope; }

int signal_group(int signal) {
    static const signed char groups[] = SIGNAL_GROUPS;
    return groups[signal];
}

void signals_by_members(int group, const Scene *scene, int fidelity, double t, double loop_yaw, const double *offsets,
                        const double *means, const int *phases, const double *signs,
                        const Path *paths, const double *energy_balance, const double *counts, double given_up_since,
                        const Audit *audit, const double *nearest, const double *crossing, const double *guard,
                        const Arrays *arrays, double (*strains)[3], const LoopBottom *bottom, double *values) {
    static double memory[sizeof(State) / sizeof(double) + 100000];
    State *state = (State *)memory, s;
    memset(&s, 0, sizeof s);
    s.elements = arrays->elements;
    s.t = t, s.loop_yaw = loop_yaw, s.fidelity = fidelity, s.given_up_since = given_up_since, s.audit = *audit;
    for (int k = 0; k < 2; k++) {
        s.offsets[k] = offsets[k], s.force_mean[k] = means[k], s.paths[k] = paths[k];
        s.swivels[k].phase = phases[k], s.swivels[k].sign = signs[k];
    }
    const double *l = energy_balance, *n = counts;
    EnergyBalance *e = &s.energy_balance;
    e->kinetic = l[0], e->strain = l[1], e->gravity = l[2], e->contact = l[3];
    e->work_ends = l[4], e->dissipated_material = l[5], e->dissipated_swivel = l[6];
    e->dissipated_contact = l[7], e->dissipated_wires = l[8], e->given_to_air = l[9];
    e->nonconservative = l[10], e->transformations = l[11], e->start = l[12];
    s.counts.steps = (int64_t)n[0], s.counts.rejections = (int64_t)n[1], s.counts.newton = (int64_t)n[2];
    s.counts.transformations = (int64_t)n[3], s.counts.swivel_events = (int64_t)n[4];
    s.counts.given_up = (int64_t)n[5];
    memcpy(s.nearest, nearest, sizeof s.nearest);
    memcpy(&s.crossing, crossing, sizeof s.crossing);
    memcpy(&s.guard, guard, sizeof s.guard);
    *state = s;
    const Arrays to = state_arrays(state);
    const size_t size = sizeof(double) * (size_t)to.nodes * DOF;
    memcpy(to.q, arrays->q, size), memcpy(to.v, arrays->v, size), memcpy(to.a, arrays->a, size);
    memcpy(to.reaction, arrays->reaction, size);
    memcpy(to.lengths, arrays->lengths, sizeof(double) * (size_t)to.elements);
    memcpy(to.s, arrays->s, sizeof(double) * (size_t)to.nodes);
    rope.scene = *scene, rope.state = state, rope.strains = strains, rope.bottom = *bottom;
    rope.initialized = 1, rope.known = 0;
    memcpy(rope.values, values, sizeof rope.values);
    int signal = 0;
    while (signal_group(signal) != group) signal++;
    rope_signal(&rope, signal);
    memcpy(values, rope.values, sizeof rope.values);
}

void arrays_of(double *q, double *v, double *a, double *reaction, double *lengths, double *s, int nodes,
               Arrays *arrays) {
    Arrays of = {q, v, a, NULL, NULL, reaction, lengths, s, NULL, nodes - 1, nodes};
    *arrays = of;
}
"""


@pytest.fixture(scope="session")
def parts(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """The C functions by their names."""
    compiler = find_compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("native")
    path = folder / f"parts{LIBRARY_SUFFIX}"
    for name, text in generate().items():
        (folder / name).write_text(text, encoding="ascii")
    (folder / "by_members.c").write_text(SIGNALS_BY_MEMBERS, encoding="ascii")
    sources = [*(str(NATIVE / name) for name in PARTS), str(folder / "by_members.c")]
    subprocess.run([*compiler, *FLAGS, f"-I{NATIVE}", f"-I{folder}", *sources, "-o", str(path), "-lm"], check=True)
    library = ct.CDLL(str(path))
    n, x, p = ct.c_int, ct.c_double, ct.c_void_p
    signatures: dict[str, tuple[Any, ...]] = {
        "mesh_fit": (GROUPS[Mesh], p),
        "mesh_elements": (n, p, x, p),
        "mesh_partition": (None, p, x, x, n, p, p),
        "mesh_transform": (None, p, n, n, p),
        "mesh_centre": (x, p),
        "mesh_distance_to_due": (x, p, x),
        "mesh_transformation_due": (x, p, x, x),
        "mesh_arc_lengths": (None, n, p, p),
        "transfer_interpolate": (None, n, p, p, n, p, p),
        "transfer_fields": (None, n, p, p, n, p, p),
        "shape_nearest_turn": (x, x, x),
        "shape_loop_bottom": (CLoopBottom, n, p, p),
        "shape_leg_clearance": (x, n, p, p, p, x, x, x),
        "shape_legs_apart": (n, p, p, x, x),
        "shape_places": (None, x, x, x, n, p),
        "shape_points": (None, n, p, p, n, p, p),
        "shape_hanging_guess": (None, n, p, p, p, p, p),
        "signal_group": (n, n),
        "rope_signal": (x, p, n),
        "signals_rope": (p,),
        "signals_by_members": (None, n, p, n, x, x, *[p] * 7, x, *[p] * 8),
        "arrays_of": (None, p, p, p, p, p, p, n, p),
    }
    for name, (result, *arguments) in signatures.items():
        getattr(library, name).restype, getattr(library, name).argtypes = result, arguments
    return SimpleNamespace(**{name: passing_arrays(getattr(library, name)) for name in signatures})


def passing_arrays(function: Any) -> Callable[..., Any]:
    """``function`` with numpy arrays (C order, float) and ctypes structures as pointers."""

    def address(x: Any) -> Any:
        if isinstance(x, np.ndarray):
            assert x.flags.c_contiguous
            assert x.dtype == float
            return x.ctypes.data
        return ct.addressof(x) if isinstance(x, ct.Structure | ct.Array) else x

    return lambda *arguments: function(*map(address, arguments))


def message() -> Any:
    return ct.create_string_buffer(MESSAGE)
