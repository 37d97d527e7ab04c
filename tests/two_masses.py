"""Two masses split in two: the smallest co-simulation with an exact solution, on which schemes show their order.

    drive      m y'' + k y = f + F
    follower   m_2 x'' = k_2 (y - x) + c_2 (y' - x') ,     F = -m_e y'' - k_2 (y - x) - c_2 (y' - x')

Both halves are solved exactly within a step, by the matrix exponential, so that only the exchange errs.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.linalg import expm

from hoist_demo.cosimulation.schemes.interface import InterfaceMotion, Load, Memory, Pair, Reader, Sample, Scheme
from rope_model import EndMotion, Status

NOTHING = EndMotion()


@cache
def _exponential(entries: bytes, n: int) -> np.ndarray:
    return np.asarray(expm(np.frombuffer(entries).reshape(n, n)))


def exponential(A: np.ndarray) -> np.ndarray:
    """exp(A), computed once for the steps of a length and the instants of all schemes."""
    return _exponential(A.tobytes(), len(A))


def both(left: float) -> np.ndarray:
    """Return the value of the left end, and 0 at the right one."""
    return np.array([left, 0.0])


@dataclass(frozen=True)
class Data:
    """Masses (kg), springs (N/m) and damper (N s/m); periods of about 1 and 0.4 s."""

    m: float = 10.0
    k: float = 400.0
    f: float = 40.0  # N
    m_e: float = 1.0  # moves with the drive
    m_2: float = 2.0
    k_2: float = 500.0
    c_2: float = 1.0

    def exact(self, t: float) -> np.ndarray:
        """(y, v, x, w) at t from rest at zero."""
        M, k, c = self.m + self.m_e, self.k_2, self.c_2
        A = np.zeros((5, 5))
        A[0, 1] = A[2, 3] = 1.0
        A[1] = np.array([-(self.k + k), -c, k, c, self.f]) / M
        A[3, :4] = np.array([k, c, -k, -c]) / self.m_2
        return (exponential(A * t) @ np.array([0.0, 0.0, 0.0, 0.0, 1.0]))[:4]

    def forces(self, t: float) -> tuple[float, float]:
        """F and y'' of the exact solution."""
        y, v, x, w = self.exact(t)
        inner = self.k_2 * (y - x) + self.c_2 * (v - w)
        a = (self.f - self.k * y - inner) / (self.m + self.m_e)
        return -self.m_e * a - inner, a


def driven(A: np.ndarray, b: np.ndarray, x: np.ndarray, h: float, c: np.ndarray) -> np.ndarray:
    """x(h) of x' = A x + b u with u = sum c_i (t / h)^i: exact, by a chain of integrators."""
    n, p = len(x), len(c)
    whole = np.zeros((n + p, n + p))
    whole[:n, :n], whole[:n, n] = A, b
    whole[n + np.arange(p - 1), n + 1 + np.arange(p - 1)] = 1.0
    start = [ci * math.factorial(i) / h**i for i, ci in enumerate(c)]
    return (exponential(whole * h) @ np.concatenate((x, start)))[:n]


class Drive:
    """The left half; state (y, v). The right end of the interface rests, and no force acts there."""

    def __init__(self, data: Data, state: np.ndarray) -> None:
        self.data, self.state = data, state

    def step(self, t: float, h: float, load: Load) -> str:
        d, mass = self.data, self.data.m + float(load.added_mass[0])
        c = np.array([load.start[0] + d.f, load.rise[0], load.bend[0]])
        self.state = driven(np.array([[0.0, 1.0], [-d.k / mass, 0.0]]), np.array([0.0, 1.0 / mass]), self.state, h, c)
        return ""

    def place(self) -> np.ndarray:
        return both(self.state[0])

    def motion(self, load: Load, s: float) -> InterfaceMotion:
        d, (y, v) = self.data, self.state
        force = load.start[0] + s * (load.rise[0] + s * load.bend[0])
        a = (d.f - d.k * y + force) / (d.m + load.added_mass[0])
        return InterfaceMotion(both(y), both(v), both(a))

    def ends(self, motion: InterfaceMotion) -> tuple[EndMotion, EndMotion]:
        return EndMotion(y=motion.place[0], vy=motion.speed[0], ay=motion.acceleration[0]), NOTHING

    def mobility(self) -> np.ndarray:
        return np.diag(both(1.0 / self.data.m))

    def work(self) -> float:
        """Work of F: the energy less the work of f."""
        d, (y, v) = self.data, self.state
        return float(d.m * v * v / 2 + d.k * y * y / 2 - d.f * y)

    def save(self) -> np.ndarray:
        return self.state

    def restore(self, snapshot: np.ndarray) -> None:
        self.state = snapshot


class Follower:
    """The right half; state (x, w), and the end's motion (y, v, a), which is a quintic within a step."""

    def __init__(self, data: Data, state: np.ndarray, end: np.ndarray, mean: float, h: float) -> None:
        self.data, self.state, self.end, self.mean, self.h = data, state, end, mean, h

    def step(self, t: float, h: float, left: EndMotion, right: EndMotion) -> Status:
        d, (y0, v0, a0), before = self.data, self.end, self.state
        new = np.array([left.y, left.vy, left.ay])
        dx, dv, da = new[0] - y0 - h * v0 - h * h * a0 / 2, h * (new[1] - v0 - h * a0), h * h * (new[2] - a0)
        c = np.array([10 * dx - 4 * dv + da / 2, -15 * dx + 7 * dv - da, 6 * dx - 3 * dv + da / 2])
        c = np.concatenate(([y0, h * v0, h * h * a0 / 2], c))
        A = np.array([[0.0, 1.0], [-d.k_2 / d.m_2, -d.c_2 / d.m_2]])
        force = d.k_2 * c + d.c_2 * np.append(np.arange(1, 6) * c[1:], 0.0) / h
        self.state = driven(A, np.array([0.0, 1.0 / d.m_2]), before, h, force)
        self.mean = -(d.m_e * (new[1] - v0) + d.m_2 * float(self.state[1] - before[1])) / h
        self.end, self.h = new, h
        return Status(True)

    def reader(self, names: Sequence[str]) -> Reader:
        signals = {"left.fy": self.force, "left.fy_mean": lambda: self.mean, "left.added_mass": self.added_mass}
        return lambda: np.array([signals[name]() if name in signals else 0.0 for name in names])

    def force(self) -> float:
        d, (x, w), (y, v, a) = self.data, self.state, self.end
        return -d.m_e * a - d.k_2 * (y - x) - d.c_2 * (v - w)

    def added_mass(self) -> float:
        """Answer to an acceleration held over the last step."""
        still = Follower(self.data, np.zeros(2), np.array([0.0, 0.0, 1.0]), 0.0, self.h)
        still.step(0.0, self.h, EndMotion(y=self.h**2 / 2, vy=self.h, ay=1.0), NOTHING)
        return -still.force()

    def save(self) -> tuple:
        return self.state, self.end, self.mean, self.h

    def restore(self, snapshot: tuple) -> None:
        self.state, self.end, self.mean, self.h = snapshot


def start(data: Data, t: float, H: float) -> tuple[Pair, Memory]:
    """Both halves on the exact solution at t, with exact samples of the two steps before."""
    samples = []
    for past in (t - 2 * H, t - H, t):
        (_, v, _, w), before, (force, a) = data.exact(past), data.exact(past - H), data.forces(past)
        impulse = data.m_e * (v - before[1]) + data.m_2 * (w - before[3])
        samples.append(Sample(past, both(force), both(-impulse / H), both(a)))
    y, v, x, w = data.exact(t)
    follower = Follower(data, np.array([x, w]), np.array([y, v, a]), float(samples[-1].mean[0]), H)
    return Pair(Drive(data, np.array([y, v])), follower), Memory(tuple(samples))


def error(scheme: Scheme, H: float, data: Data | None = None) -> float:
    """RMS error of the force over its largest, from 0.5 to 2.5 s, at the communication points."""
    data, begin = data or Data(), 0.5
    (pair, memory), found = start(data, begin, H), []
    times = begin + H * np.arange(round(2.0 / H))
    for t in times:
        advance = scheme.advance(pair, memory, float(t), H)
        if advance.cause:
            return math.inf
        memory = advance.memory
        found.append(float(memory.last.force[0]))
    exact = np.array([data.forces(float(t) + H)[0] for t in times])
    return float(np.sqrt(np.mean((np.array(found) - exact) ** 2)) / np.max(np.abs(exact)))
