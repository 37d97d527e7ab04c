"""Messages have one text: C says what Python says."""

import ctypes as ct
import inspect
from collections.abc import Callable

import pytest
from native_parts import compiled

from rope_model.codegen.messages import SPOKEN

TEXTS: dict[str, Callable[..., str]] = dict(x for m in SPOKEN for x in inspect.getmembers(m, inspect.isfunction))
TYPES = {"float": ("double", ct.c_double), "int": ("int", ct.c_int), "str": ("const char *", ct.c_char_p)}
#: numbers that are written in full, rounded, with an exponent, and not at all
SAMPLES = {
    "float": (0.1, -1234567.891, 1e-9, 2.5e17, 100.0, float("inf"), float("nan")),
    "int": (0, 57, 20000),
    "str": ("left", "100 %", "x" * 600),
}


def kinds(name: str) -> list[str]:
    return [str(p.annotation) for p in inspect.signature(TEXTS[name]).parameters.values()]


@pytest.fixture(scope="module")
def spoken(tmp_path_factory: pytest.TempPathFactory) -> ct.CDLL:
    code = ['#include "messages.h"']
    for name in TEXTS:
        declared = "".join(f", {TYPES[kind][0]} x{k}" for k, kind in enumerate(kinds(name)))
        arguments = "".join(f", x{k}" for k in range(len(kinds(name))))
        code.append(f"int of_{name}(char *room{declared}) {{ return say_{name}(room{arguments}); }}")
    return compiled(tmp_path_factory.mktemp("messages"), {"all.c": "\n".join(code) + "\n"})


@pytest.mark.parametrize("name", TEXTS)
def test_c_says_what_python_says(spoken: ct.CDLL, name: str) -> None:
    say, room = getattr(spoken, f"of_{name}"), ct.create_string_buffer(512)
    say.argtypes = (ct.c_char_p, *(TYPES[kind][1] for kind in kinds(name)))
    for k in range(7):
        values = [SAMPLES[kind][k % len(SAMPLES[kind])] for kind in kinds(name)]
        given = [value.encode() if isinstance(value, str) else value for value in values]
        assert say(room, *given) == 0
        assert room.value.decode() == TEXTS[name](*values)[:511]
