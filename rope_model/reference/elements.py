"""Functions of the element, evaluated for all elements of a mesh at once.

Arrays have their entries first: (entries, elements).
"""

from functools import lru_cache
from threading import Lock

import casadi as ca
import numpy as np

from rope_model.arrays import Array

#: functions of meshes that are kept: those of some ropes, each with seven functions
KEPT_FUNCTIONS = 64


class MappedFunction:
    """Function of one element as a function of arrays of elements.

    CasADi reads and writes arrays that are allocated once: a call converts nothing.  Results are
    copies.  Ropes in several threads may share it.
    """

    def __init__(self, function: ca.Function, elements: int) -> None:
        mapped = function.map(elements)
        # CasADi has columns one after the other
        self._arguments = [
            np.zeros((elements, function.numel_in(k))).T for k in range(mapped.n_in())
        ]
        self._results = [
            np.zeros((elements, function.numel_out(k))).T for k in range(mapped.n_out())
        ]
        self._buffer, self._evaluate = mapped.buffer()  # the buffer must outlive its function
        for k, argument in enumerate(self._arguments):
            self._buffer.set_arg(k, memoryview(argument.T))
        for k, result in enumerate(self._results):
            assert function.sparsity_out(k).is_dense()
            self._buffer.set_res(k, memoryview(result.T))
        self._lock = Lock()

    def __call__(self, *arguments: Array | float) -> tuple[Array, ...]:
        """Return the results, each (entries, elements); an argument has that shape, or is broadcast to it."""
        with self._lock:
            for place, argument in zip(self._arguments, arguments, strict=True):
                place[:] = argument
            self._evaluate()
            return tuple(result.copy(order="K") for result in self._results)


@lru_cache(KEPT_FUNCTIONS)
def mapped(function: ca.Function, elements: int) -> MappedFunction:
    """Return the ``function`` of one element for a number of ``elements``."""
    return MappedFunction(function, elements)
