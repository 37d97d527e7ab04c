"""The native rope with another method of time integration."""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path

import numpy as np

from rope_model.native import engine
from rope_model.native.build import sources
from rope_model.numerics.kernels import cache_folder, compile_library, find_compiler
from rope_model.parameters import Scene

from .methods import Method

#: as in study.c
_KINDS, _MOST_STAGES = ("generalized-alpha", "stages", "backward"), 8
_ROOM = Path(__file__).parent


def rope_by(method: Method, scene: Scene) -> engine.NativeRope:
    """A rope stepped by ``method``; one rope at a time."""
    rows = np.zeros((_MOST_STAGES, _MOST_STAGES))
    for k, row in enumerate(method.rows):
        rows[k, : len(row)] = row
    weights = rows.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
    _library().study_select(_KINDS.index(method.kind), len(method.rows), weights)
    return _StudyRope(scene)


@cache
def _library() -> ctypes.CDLL:
    """The library; RuntimeError without a compiler."""
    if (compiler := find_compiler()) is None:
        raise RuntimeError("the study of integrators needs a C compiler: install one, or ziglang")
    texts = dict(sources())
    texts["step.inc"] = texts.pop("step.c")  # what study.c includes
    texts |= {name: (_ROOM / name).read_text(encoding="utf-8") for name in ("study.c", "study.h")}
    return engine.declare(ctypes.CDLL(str(compile_library(texts, compiler, cache_folder(), "integrators"))))


class _StudyRope(engine.NativeRope):
    """A native rope on the study's library."""

    _library = staticmethod(_library)
