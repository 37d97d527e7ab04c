"""Formulas of numbers as programs of CasADi's virtual machine.

A program does Python's operations in the same order and gives the same bits, some ten times as fast.  It serves
formulas of hundreds of operations in every step.
"""

import struct
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import casadi as ca

from rope_model.physics.expressions import no_simplification


@cache
def trace(formula: Callable[[Sequence[Any]], Sequence[Any]], numbers: int) -> ca.Function:
    """Build the CasADi function of ``formula`` of a vector with ``numbers`` entries."""
    with no_simplification():
        symbols = [ca.SX.sym(f"x{k}") for k in range(numbers)]
        return ca.Function("formula", [ca.vertcat(*symbols)], [ca.vertcat(*formula(symbols))])


class Program:
    """Callable form of a ``formula`` of ``numbers`` numbers.  Not to be shared between threads."""

    def __init__(self, formula: Callable[[Sequence[Any]], Sequence[Any]], numbers: int) -> None:
        traced = trace(formula, numbers)
        self._inputs, self._outputs = (
            struct.Struct(f"{n}d") for n in (traced.numel_in(0), traced.numel_out(0))
        )
        self._input, self._output = bytearray(self._inputs.size), bytearray(self._outputs.size)
        buffer: Any
        buffer, self._evaluate = (
            traced.buffer()
        )  # the stubs of casadi do not know the buffer's methods
        buffer.set_arg(0, memoryview(self._input))
        buffer.set_res(0, memoryview(self._output))
        self._buffer = buffer

    def __call__(self, *numbers: float) -> tuple[float, ...]:
        self._inputs.pack_into(self._input, 0, *numbers)
        self._evaluate()
        return self._outputs.unpack(self._output)
