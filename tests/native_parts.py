"""The native rope's mesh, frame and shape, one C function at a time.

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

from rope_model import compiler as kernels
from rope_model.codegen.build import sources
from rope_model.codegen.structures import GROUPS
from rope_model.simulation.outputs.diagnostics import LoopBottom
from rope_model.solver_parameters import Mesh

Array = NDArray[np.float64]

WARNINGS = ("-Wall", "-Wextra", "-Werror")
MESSAGE, ROUNDING = 512, 1e-12


class CLoopBottom(ct.Structure):
    _fields_ = (("s", ct.c_double), ("position", ct.c_double * 3), ("yaw", ct.c_double))

    @staticmethod
    def of(bottom: LoopBottom) -> CLoopBottom:
        return CLoopBottom(bottom.s, tuple(bottom.position), bottom.yaw)


#: functions that have no name in a library, and arrays of a state
MORE = """
#include "rules.h"
#include "simulator.h"

double mesh_centre(const Pattern *p) { return pattern_centre(p); }
double mesh_distance_past_limit(const Pattern *p, double bottom) { return distance_past_limit(p, bottom); }
double mesh_transformation_due(const Pattern *p, double bottom, double slack) {
    return transformation_due(p, bottom, slack);
}
void arrays_of(double *q, double *v, double *a, double *reaction, double *lengths, double *s, int nodes,
               NodalArrays *arrays) {
    NodalArrays of = {q, v, a, NULL, NULL, reaction, lengths, s, NULL, nodes - 1, nodes};
    *arrays = of;
}
"""


def compiled(folder: Path, texts: dict[str, str]) -> ct.CDLL:
    """The rope's library with further C texts; skips the test without a compiler."""
    if (compiler := kernels.find_compiler()) is None:
        pytest.skip("no C compiler")
    for name, text in (sources() | texts).items():
        (folder / name).write_text(text, encoding="utf-8")
    command, objects = (
        [*compiler, *kernels.FLAGS],
        kernels.object_files(sources(), compiler, kernels.FLAGS, kernels.cache_folder()),
    )
    kernels.compile_objects(sources(), command, objects)
    files = [str(path) for path in (*objects.values(), *(folder / name for name in texts))]
    made = folder / f"compiled{kernels.LIBRARY_SUFFIX}"
    command += [*WARNINGS, f"-I{folder}", *files, "-o", str(made), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return ct.CDLL(str(made))


@pytest.fixture(scope="session")
def parts(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    library = compiled(tmp_path_factory.mktemp("native"), {"more.c": MORE})
    n, x, p = ct.c_int, ct.c_double, ct.c_void_p
    signatures: dict[str, tuple[Any, ...]] = {
        "fit_mesh": (GROUPS[Mesh], p),
        "partition_elements": (n, p, x, p, p),
        "partition": (None, p, x, x, p, n, p, p),
        "partition_transform": (None, p, n, p, n, p),
        "window_due": (n, p, p),
        "mesh_centre": (x, p),
        "mesh_distance_past_limit": (x, p, x),
        "mesh_transformation_due": (x, p, x, x),
        "arc_lengths": (None, n, p, p),
        "transfer_interpolate": (None, n, p, p, n, p, p),
        "transfer_fields": (None, n, p, p, n, p, p),
        "loop_bottom": (CLoopBottom, n, p, p),
        "leg_clearance": (x, n, p, p, p, x, x, x, p),
        "legs_apart": (n, p, p, x, x),
        "shape_places": (None, x, x, x, n, p),
        "diagnostics_shape": (None, n, p, p, n, p, p),
        "hanging_guess": (None, n, p, p, p, p, p),
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
