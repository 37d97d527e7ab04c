"""Speed of a rope that rests for long.

Values that die away end in denormal numbers, with which some processors compute many times more slowly.

Two ropes with the same motion take turns step by step: one as shipped, the other with denormals set to zero by the
processor (flags FTZ and DAZ of x86's MXCSR, set by the C library's fesetenv; the first one's flag DE tells whether
an operand of a step was denormal).  Elsewhere than on Linux on x86-64 only the times as shipped are measured.
"""

from __future__ import annotations

import argparse
import ctypes
import platform
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter_ns

import numpy as np

from rope_model import EndMotion, Model, RopeState, Scene, balance_rope, rope_120

H, RESTS, WINDOW = 0.01, 10_000, 1_000  # s; steps at rest, and those over which the median time is taken
PUSH, PUSHED = 0.1, 2.0  # m, s: the left end goes aside and comes back
TRAVEL = 90.0  # m

#: of both ends at a time (s)
Motion = Callable[[float], tuple[EndMotion, EndMotion]]


class Denormals:
    """What this thread's processor does with them, where it can be told; ``known`` says whether."""

    _FLAGS, _MET, _FLUSH = 0x3F, 0x02, 0x8040

    def __init__(self) -> None:
        self.known = platform.system() == "Linux" and platform.machine() == "x86_64"
        self._c = ctypes.CDLL("libm.so.6") if self.known else None
        self._environment = (ctypes.c_uint32 * 8)()  # fenv_t; its last word is MXCSR
        self._kept = self._read() & ~(self._FLAGS | self._FLUSH)

    def keep(self) -> None:
        """Computed with, and no operand met yet."""
        self._write(self._kept)

    def flush(self) -> None:
        """Taken as zero."""
        self._write(self._kept | self._FLUSH)

    def met(self) -> bool:
        """Whether an operand was one since ``keep``."""
        return bool(self._read() & self._MET)

    def _read(self) -> int:
        if self._c is not None:
            self._c.fegetenv(self._environment)
        return int(self._environment[7])

    def _write(self, word: int) -> None:
        self._read()
        self._environment[7] = word
        if self._c is not None:
            self._c.fesetenv(self._environment)


@dataclass(frozen=True)
class Rested:
    """Medians of steps (s) when the rest begins, after RESTS steps of it, and then without denormals."""

    what: str
    first: float
    last: float
    flushed: float  # NaN where the processor cannot be told
    met: float  # share of the last steps with a denormal operand; NaN likewise
    at_ends: int  # denormal values of the state, at its two end nodes and at all others
    inside: int


def hanging(t: float) -> tuple[EndMotion, EndMotion]:
    """Nothing moves."""
    return EndMotion(y=0.0), EndMotion(y=TRAVEL)


def pushed(t: float) -> tuple[EndMotion, EndMotion]:
    """The left end goes out of plane and comes back for good."""
    s = t / PUSHED
    if s >= 1.0:
        return hanging(t)
    size = 16.0 * PUSH
    z = size * (s * (1.0 - s)) ** 2
    vz = size * 2.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / PUSHED
    az = size * (2.0 - 12.0 * s + 12.0 * s * s) / PUSHED**2
    return EndMotion(y=0.0, z=z, vz=vz, az=az), EndMotion(y=TRAVEL)


def scenes() -> dict[str, tuple[Scene, Motion, float]]:
    """Scene, motion, and when (s) the ends come to rest."""
    coupled = rope_120().scene
    uncoupled = coupled.with_(rope=replace(coupled.rope, Qb=0.0, Qc=0.0), model=Model("torsional"))
    return {
        "hangs from the start": (coupled, hanging, 0.0),
        "pushed aside": (coupled, pushed, PUSHED),
        "pushed aside, rope without coupling": (uncoupled, pushed, PUSHED),
    }


def rested(what: str, scene: Scene, motion: Motion, moving: float) -> Rested:
    """Both ropes through the motion and the rest."""
    denormals, ropes = Denormals(), [balance_rope(scene, "native") for _ in range(2)]
    for rope in ropes:
        assert rope.initialize(0.0, *motion(0.0)).valid
    before = round(moving / H)
    times, met = np.zeros((2, before + RESTS)), np.zeros(before + RESTS, dtype=bool)
    set_up = (denormals.keep, denormals.flush)
    try:
        for k in range(before + RESTS):
            t, ends = (k + 1) * H, motion((k + 1) * H)
            for i in (0, 1) if k % 2 else (1, 0):
                advance = ropes[i].advance_to
                set_up[i]()
                start = perf_counter_ns()
                valid = advance(t, *ends).valid
                times[i, k] = 1e-9 * (perf_counter_ns() - start)
                met[k] |= i == 0 and denormals.met()
                assert valid
    finally:
        denormals.keep()
    first = float(np.median(times[0, before : before + WINDOW]))
    last, flushed = np.median(times[:, -WINDOW:], axis=1).tolist()
    known = 1.0 if denormals.known else np.nan
    share = known * float(np.mean(met[-WINDOW:]))
    return Rested(what, first, last, known * flushed, share, *denormal_values(ropes[0].state))


def denormal_values(state: RopeState) -> tuple[int, int]:
    """How many numbers of the motion are denormal at the ends, and inside."""
    m = state.motion
    found = [(x != 0.0) & (np.abs(x) < np.finfo(float).tiny) for x in (m.q, m.v, m.a, m.b, m.a_rate, m.reaction)]
    return sum(int(np.sum(x[[0, -1]])) for x in found), sum(int(np.sum(x[1:-1])) for x in found)


def measure() -> list[Rested]:
    """All scenes."""
    return [rested(what, *given) for what, given in scenes().items()]


if __name__ == "__main__":
    argparse.ArgumentParser("python -m benchmarks.rest", description=__doc__).parse_args()
    for found in measure():
        print(found)
