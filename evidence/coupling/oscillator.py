"""Two masses split in two: the smallest co-simulation with an exact solution.

    drive      m y'' + k y = f + F                              k, f: spring to the ground, constant force
    follower   m_2 x'' = k_2 (y - x) + c_2 (y' - x') ,     F = -m_e y'' - k_2 (y - x) - c_2 (y' - x')

Both partners are solved exactly within a step, by the matrix exponential, so that only the exchange errs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hoist_demo.cosimulation.schemes.interface import Load, Memory, Motion, Pair, Sample, Scheme, Vector

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Data:
    """Masses, springs and damper; periods of about 1 and 0.4 s."""

    m: float = 10.0  # kg
    k: float = 400.0  # N/m
    f: float = 40.0  # N
    m_e: float = 1.0  # kg, moves with the drive
    m_2: float = 2.0  # kg
    k_2: float = 500.0  # N/m
    c_2: float = 1.0  # N s/m

    def exact(self, t: float) -> Array:
        """(y, v, x, w) at t [s] from rest at zero."""
        M = self.m + self.m_e
        A = np.array(
            [
                [0, 1, 0, 0, 0],
                [-(self.k + self.k_2) / M, -self.c_2 / M, self.k_2 / M, self.c_2 / M, self.f / M],
                [0, 0, 0, 1, 0],
                [self.k_2 / self.m_2, self.c_2 / self.m_2, -self.k_2 / self.m_2, -self.c_2 / self.m_2, 0],
                [0, 0, 0, 0, 0],
            ]
        )
        state: Array = (expm(A * t) @ np.array([0.0, 0.0, 0.0, 0.0, 1.0]))[:4]
        return state

    def acceleration(self, state: Array) -> float:
        """y'' of the whole."""
        y, v, x, w = state
        return float((self.f - self.k * y - self.k_2 * (y - x) - self.c_2 * (v - w)) / (self.m + self.m_e))


def drive(A: Array, b: Array, x: Array, h: float, coefficients: Array) -> Array:
    """x(h) of x' = A x + b u with u = sum c_i s^i, s = t / h: exact."""
    free, forced = propagators(A.tobytes(), b.tobytes(), len(x), h, len(coefficients))
    end: Array = free @ x + forced @ coefficients
    return end


@lru_cache(maxsize=512)
def propagators(A: bytes, b: bytes, n: int, h: float, p: int) -> tuple[Array, Array]:
    """What a step makes of the state, (n, n), and of the coefficients of u, (n, p)."""
    whole = np.zeros((n + p, n + p))
    whole[:n, :n] = np.frombuffer(A).reshape(n, n)
    forced = np.zeros((n, p))
    for i in range(1, p):
        whole[n + i, n + i - 1] = i / h  # of s^i
    for i in range(p):
        whole[:n, n:] = 0.0
        whole[:n, n + i] = np.frombuffer(b)
        step = expm(whole * h)
        forced[:, i] = step[:n, n]
    return step[:n, :n], forced


class Drive:
    """The left half; state (y, v)."""

    def __init__(self, data: Data, state: Array) -> None:
        self.data, self.state = data, state

    def step(self, t: float, h: float, load: Load) -> str:
        d = self.data
        mass = d.m + float(load.added_mass[0])
        A, b = np.array([[0.0, 1.0], [-d.k / mass, 0.0]]), np.array([0.0, 1.0 / mass])
        self.state = drive(A, b, self.state, h, np.array([load.start[0] + d.f, load.rise[0], load.bend[0]]))
        return ""

    def place(self) -> Vector:
        return np.array([self.state[0]])

    def motion(self, load: Load, s: float) -> Motion:
        d, (y, v) = self.data, self.state
        a = (d.f - d.k * y + load.at(s)) / (d.m + load.added_mass)
        return Motion(np.array([y]), np.array([v]), a)

    def mobility(self) -> Vector:
        return np.array([[1.0 / self.data.m]])

    def work(self) -> float:
        """Of F: the energy less the work of f."""
        d, (y, v) = self.data, self.state
        return float(d.m * v * v / 2 + d.k * y * y / 2 - d.f * y)

    def save(self) -> Array:
        return self.state

    def restore(self, snapshot: Array) -> None:
        self.state = snapshot


class Follower:
    """The right half; state (x, w), and the end's motion (y, v, a)."""

    def __init__(self, data: Data, state: Array, end: Array) -> None:
        self.data, self.state, self.end = data, state, end
        self.mean = self._force()
        self.h = 0.0

    def step(self, t: float, h: float, motion: Motion) -> str:
        d = self.data
        new = np.array([motion.place[0], motion.speed[0], motion.acceleration[0]])
        c, before = quintic(self.end, new, h), self.state
        A = np.array([[0.0, 1.0], [-d.k_2 / d.m_2, -d.c_2 / d.m_2]])
        force = d.k_2 * c + d.c_2 * np.append(np.arange(1, 6) * c[1:], 0.0) / h
        impulse = d.m_e * (new[1] - self.end[1])
        self.state, self.end, self.h = drive(A, np.array([0.0, 1.0 / d.m_2]), self.state, h, force), new, h
        self.mean = -(impulse + d.m_2 * float(self.state[1] - before[1])) / h
        return ""

    def forces(self) -> tuple[Vector, Vector]:
        return np.array([self._force()]), np.array([self.mean])

    def added_mass(self) -> Vector:
        """Answer to an acceleration held over the last step."""
        h = self.h or 1e-3
        still = Follower(self.data, np.zeros(2), np.zeros(3))
        still.end = np.array([0.0, 0.0, 1.0])
        still.step(0.0, h, Motion(np.array([h * h / 2]), np.array([h]), np.array([1.0])))
        return -still.forces()[0]

    def save(self) -> tuple[Array, Array, float, float]:
        return self.state, self.end, self.mean, self.h

    def restore(self, snapshot: tuple[Array, Array, float, float]) -> None:
        self.state, self.end, self.mean, self.h = snapshot

    def free(self, snapshot: object) -> None:
        """Nothing is held."""

    def _force(self) -> float:
        d, (x, w), (y, v, a) = self.data, self.state, self.end
        return float(-d.m_e * a - d.k_2 * (y - x) - d.c_2 * (v - w))


def quintic(start: Array, end: Array, h: float) -> Array:
    """Coefficients (6,) in s of the polynomial with places, speeds and accelerations at both ends."""
    y0, v0, a0 = start
    dx = end[0] - y0 - h * v0 - h * h * a0 / 2
    dv, da = h * (end[1] - v0 - h * a0), h * h * (end[2] - a0)
    c3, c4, c5 = 10 * dx - 4 * dv + da / 2, -15 * dx + 7 * dv - da, 6 * dx - 3 * dv + da / 2
    return np.array([y0, h * v0, h * h * a0 / 2, c3, c4, c5])


def start(data: Data, t: float, H: float) -> tuple[Pair, Memory]:
    """Both halves on the exact solution at t [s], with exact samples of the two steps before."""
    samples = []
    for past in (t - 2 * H, t - H, t):
        y, v, x, w = state = data.exact(past)
        a = data.acceleration(state)
        force = -data.m_e * a - data.k_2 * (y - x) - data.c_2 * (v - w)
        before = data.exact(past - H)
        impulse = data.m_e * (v - before[1]) + data.m_2 * (w - before[3])
        samples.append(Sample(past, np.array([force]), np.array([-impulse / H]), np.array([a])))
    follower = Follower(data, np.array([x, w]), np.array([y, v, a]))
    follower.mean, follower.h = float(samples[-1].mean[0]), H
    return Pair(Drive(data, np.array([y, v])), follower), Memory(tuple(samples))


START, END = 0.5, 2.5  # s


def error(scheme: Scheme, H: float, data: Data | None = None) -> float:
    """RMS error of the force over its largest, from START to END, at the communication points."""
    data = Data() if data is None else data
    pair, memory = start(data, START, H)
    found, exact = [], []
    for k in range(round((END - START) / H)):
        advance = scheme.advance(pair, memory, START + k * H, H)
        if advance.cause:
            return math.inf
        memory = advance.memory
        y, v, x, w = state = data.exact(START + (k + 1) * H)
        exact.append(-data.m_e * data.acceleration(state) - data.k_2 * (y - x) - data.c_2 * (v - w))
        found.append(float(memory.last.force[0]))
    difference = np.array(found) - np.array(exact)
    return float(np.sqrt(np.mean(difference**2)) / np.max(np.abs(exact)))
