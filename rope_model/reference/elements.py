"""Functions of the element, evaluated for many elements at once.

CasADi takes the operations of a function one after the other.  Most of the time is spent on finding
the next operation, so each is done for GROUP elements.  Arrays have their entries first: (entries,
elements).
"""

from functools import cache
from threading import Lock
from typing import Any

import casadi as ca
import numpy as np

from rope_model.arrays import Array

GROUP = 64  #: elements of which an operation takes little longer than of one


class ElementsFunction:
    """Function of one element as a function of arrays of elements.

    It reads and writes arrays that are allocated once.  Results are copies, and threads take turns.
    """

    def __init__(self, function: ca.Function) -> None:
        of_group = _of_group(function.expand())
        self._arguments = [np.zeros(of_group.size_in(k)[::-1]) for k in range(of_group.n_in())]
        self._results = [np.zeros(of_group.size_out(k)[::-1]) for k in range(of_group.n_out())]
        buffer: Any  # CasADi's stubs lack its methods of Python
        buffer, self._evaluate = of_group.buffer()
        for k, argument in enumerate(self._arguments):
            buffer.set_arg(k, argument.data)
        for k, result in enumerate(self._results):
            buffer.set_res(k, result.data)
        self._buffer = buffer  # CasADi reads and writes through it
        self._lock = Lock()

    def __call__(self, elements: int, *arguments: Array | float) -> tuple[Array, ...]:
        """Return the results, each (entries, elements).

        Arguments are (entries, elements), or (entries, 1) and numbers for what is the same in all.
        """
        results = tuple(np.empty((len(place), elements)) for place in self._results)
        with self._lock:
            for start in range(0, elements, GROUP):
                part = slice(start, start + GROUP)
                size = min(GROUP, elements - start)  # what is behind it is computed for nothing
                for place, argument in zip(self._arguments, arguments, strict=True):
                    if isinstance(argument, np.ndarray) and argument.shape[1] > 1:
                        argument = argument[:, part]
                    place[:, :size] = argument
                self._evaluate()
                for place, result in zip(self._results, results, strict=True):
                    result[:, part] = place[:, :size]
        return results


@cache
def over_elements(function: ca.Function) -> ElementsFunction:
    """Return the ``function`` of one element as a function of arrays of elements."""
    return ElementsFunction(function)


def _of_group(function: ca.Function) -> ca.Function:
    """Return the function of GROUP elements, whose arguments and results are (GROUP, entries).

    It has the operations of ``function``, with vectors in the place of numbers.
    """
    arguments = [ca.MX.sym(f"x{k}", GROUP, function.numel_in(k)) for k in range(function.n_in())]
    entries = [ca.horzsplit(argument) for argument in arguments]
    places = [function.sparsity_out(k).find() for k in range(function.n_out())]
    results = [[ca.MX(GROUP, 1)] * function.numel_out(k) for k in range(function.n_out())]
    work = [ca.MX()] * function.sz_w()
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        read = function.instruction_input(k)
        written = function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            result, entry = written
            results[result][places[result][entry]] = work[read[0]]
        elif operation == ca.OP_INPUT:
            argument, entry = read
            work[written[0]] = entries[argument][entry]
        elif operation == ca.OP_CONST:
            work[written[0]] = ca.MX(np.full(GROUP, function.instruction_constant(k)))
        elif len(read) == 1:
            work[written[0]] = ca.MX.unary(operation, work[read[0]])
        else:
            first, second = read
            work[written[0]] = ca.MX.binary(operation, work[first], work[second])
    return ca.Function(
        function.name(), arguments, [ca.densify(ca.horzcat(*columns)) for columns in results]
    )
