"""The discrete rod at rest, in small vibration, and in time; every method is scipy's or Newton's.

With places p = (b, x, m) and speeds u = (b_t, v, w) the rod's equations are p_t = G u and u_t = H(p) at rest.  Then

    rest     Newton's corrections (1 / tau^2 - H'G) u = H(p), tau growing; p moves along u, m by what a
             finite turning of the tangents adds to it exactly (area on the sphere)
    modes    H'G u = -omega^2 u
    motion   scipy's Radau (order 5, L-stable) with the sparse Jacobian; its events end a phase of a swivel

The right swivel holds or slips, without regularisation: it slips off when |moment| passes the static limit, holds when
its rate comes to zero and the static limit allows.  The left one always holds.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import eigs, splu

from evidence.discrete_rod.rod import CLAMPS, Array, Parts, Rod, join, split, swept_area

HELD = 0.0
#: m and rad by which a correction may move the rod
LARGEST_MOVE = 0.3


def first_guess(rod: Rod) -> Array:
    """First guess: two legs and a half circle, untwisted."""
    left, right = rod.ends(0.0)[0]
    radius = 0.5 * (right[0] - left[0])
    s = rod.s
    leg = 0.5 * (s[-1] + left[1] - right[1] - np.pi * radius)
    phi = np.clip((s - leg) / radius, 0.0, np.pi)
    x = np.zeros((s.size, 3))
    x[:, 0] = left[0] + radius * (1 - np.cos(phi))
    x[:, 1] = (
        left[1]
        - np.minimum(s, leg)
        - radius * np.sin(phi)
        + np.maximum(s - leg - np.pi * radius, 0.0)
    )
    inner = x[1:-1]
    edges = rod.lengths.size
    return join(
        Parts(np.zeros(2), np.zeros(2), inner, 0 * inner, np.zeros(edges + 1), np.zeros(edges))
    )


def _second_order(rod: Rod, y: Array) -> tuple[sp.csc_matrix, Array]:
    """H'G, and the indices of u, without the speeds of the swivels, which hold."""
    A = rod.jacobian(0.0, y, HELD)
    names = split(np.arange(y.size))
    speeds = np.concatenate((names.v.ravel(), names.w))
    places = np.concatenate((names.x.ravel(), names.m, names.b))
    return sp.csc_matrix(A[speeds][:, places] @ A[places][:, speeds]), speeds


def equilibrium(rod: Rod, guess: Array, tolerance: float = 1e-11) -> Array:
    """The rod at rest near ``guess``, its swivels held.  Raises RuntimeError without one."""
    y = guess
    tau = 0.1
    force = np.inf
    for _ in range(400):
        A, speeds = _second_order(rod, y)
        rates = rod.rates(0.0, y, HELD)[speeds]
        u = np.zeros(y.size)
        u[speeds] = splu(sp.csc_matrix(sp.identity(speeds.size) / tau**2 - A)).solve(rates)
        move = float(np.abs(u).max())
        y = _displace(rod, y, u * min(1.0, LARGEST_MOVE / max(move, 1e-300)))
        if tau > 1e5 and move < tolerance * rod.s[-1]:
            return y
        now = float(np.linalg.norm(rates))
        tau *= 0.5 if now > 2 * force and move > LARGEST_MOVE else 3.0
        force = now
        tau = min(tau, 1e8)
    raise RuntimeError(
        f"no equilibrium: the last correction moved by {move:.3g} m or rad; give a better guess"
    )


def _displace(rod: Rod, y: Array, u: Array) -> Array:
    """``y`` displaced by the virtual velocity ``u``: places along it, twists by their exact change."""
    p = split(y)
    du = split(u)
    x = p.x + du.v
    m = p.m + np.diff(np.concatenate((du.b_t[:1], du.w, du.b_t[1:])))
    old, new = (np.vstack((CLAMPS[:1], tangents(rod, z), CLAMPS[1:])) for z in (p.x, x))
    m += swept_area(old[:-1], old[1:], new[1:]) + swept_area(old[:-1], new[1:], new[:-1])
    return join(p._replace(b=p.b + du.b_t, x=x, m=m))


def tangents(rod: Rod, inner: Array) -> Array:
    """(N, 3): unit tangents of the edges between the ends at time 0 and the nodes ``inner``."""
    left, right = rod.ends(0.0)[0]
    edge = np.diff(np.vstack((left, inner, right)), axis=0)
    return np.asarray(edge / np.linalg.norm(edge, axis=1)[:, None])


def modes(rod: Rod, y: Array, count: int) -> tuple[Array, Array]:
    """Frequencies (Hz) of the ``count`` lowest about the equilibrium ``y``, and the share of the Z motion in each."""
    A, speeds = _second_order(rod, y)
    squares, vectors = eigs(-A, count, sigma=-1e-3, v0=np.ones(speeds.size))
    order = np.argsort(squares.real)
    v = np.abs(vectors[: 3 * (rod.lengths.size - 1), order].reshape(-1, 3, count)) ** 2
    weighted = np.einsum("i,ijk->jk", rod.cells[1:-1], v)
    hertz = np.sqrt(np.maximum(squares.real[order], 0.0)) / (2 * np.pi)
    return hertz, weighted[2] / weighted.sum(axis=0)


@dataclass(frozen=True)
class Record:
    """What a run is judged by, at n times."""

    reaction: Array  # (n, 2, 3) N, of the conveyances on the rope
    moment: Array  # (n, 2) N m, about the tangent, of the conveyances on the rope
    bottom: Array  # (n, 3) m, the loop's lowest point
    yaw: Array  # (n,) rad, of the tangent there, about Y
    angle: Array  # (n, 2) rad, of the swivels
    switches: tuple[float, ...] = ()  # s, when a swivel began to slip or to stick


def lowest_of(s: Array, x: Array) -> tuple[Array, float]:
    """Position (3,) and yaw (rad) of the lowest point of a cubic spline through nodes ``x`` at arc lengths ``s``."""
    i = int(np.clip(np.argmin(x[:, 1]), 4, s.size - 5))
    curve = CubicSpline(s[i - 4 : i + 5], x[i - 4 : i + 5])
    flat = CubicSpline(s[i - 4 : i + 5], x[i - 4 : i + 5, 1]).derivative().roots(extrapolate=False)
    at = min(flat, key=lambda r: float(curve(r)[1]))
    d = curve(at, 1)
    return np.asarray(curve(at)), float(np.arctan2(-d[2], d[0]))


def move(rod: Rod, y: Array, times: Array, release: float = np.inf, rtol: float = 1e-5) -> Record:
    """Integrate from ``y`` at ``times[0]`` and record at ``times``; the swivel holds until ``release``, one of them."""
    t = float(times[0])
    end = float(times[-1])
    slip = HELD
    rows = [(t, y, slip)]
    switches = list[float]()
    due = t == release
    while t < end:
        if due:
            before = slip
            y, slip = _switch(rod, t, y, slip)
            if slip != before:
                switches.append(t)
        stop = release if t < release < end else end
        run = solve_ivp(
            rod.rates,
            (t, stop),
            y,
            "Radau",
            times[(times > t) & (times <= stop)],
            events=_phase_end(rod, slip) if t >= release else None,
            args=(slip,),
            jac=rod.jacobian,
            rtol=rtol,
            atol=1e-2 * rtol,
        )
        if run.status < 0:
            raise RuntimeError(f"t = {t:.6g} s and later: {run.message}")
        rows += [
            (float(at), state, slip) for at, state in zip(run.t, np.transpose(run.y), strict=True)
        ]
        due = run.status == 1 or stop == release
        t, y = (
            (float(run.t_events[0][0]), run.y_events[0][0])
            if run.status == 1
            else (stop, run.y[:, -1])
        )
    return replace(_record(rod, rows), switches=tuple(switches))


def _switch(rod: Rod, t: float, y: Array, slip: float) -> tuple[Array, float]:
    """State and phase after the swivel was let go, came to rest or passed its static limit."""
    y = y.copy()
    y[-1] = 0.0
    loads = rod.evaluate(t, y[:, None], slip)
    moment = float(loads.moment[1, 0])
    limit = rod.arms[0] * float(loads.reaction[1, 1, 0])
    holds = slip != 0 and abs(moment) <= limit
    return y, HELD if holds or moment == 0 else -float(np.sign(moment))


def _phase_end(rod: Rod, slip: float) -> Any:
    """Event of ``solve_ivp`` that falls through zero when the swivel must leave its phase."""

    def reserve(t: float, y: Array, _: Any) -> float:
        if slip:
            return float(slip * split(y).b_t[1])
        loads = rod.evaluate(t, y[:, None], slip)
        return float(rod.arms[0] * loads.reaction[1, 1, 0] - abs(loads.moment[1, 0]))

    reserve.terminal = True  # type: ignore[attr-defined]
    reserve.direction = -1.0  # type: ignore[attr-defined]
    return reserve


def _record(rod: Rod, rows: list[tuple[float, Array, float]]) -> Record:
    loads = [rod.evaluate(t, y[:, None], slip) for t, y, slip in rows]
    moment = np.array([x.moment[:, 0] for x in loads])
    reaction = np.array([x.reaction[:, :, 0] for x in loads])
    _, states, slip = (np.array(x) for x in zip(*rows, strict=True))
    moment[:, 1] = np.where(slip != 0, -slip * rod.arms[1] * reaction[:, 1, 1], moment[:, 1])
    lowest = (lowest_of(rod.s, rod.nodes(t, y)) for t, y, _ in rows)
    bottom, yaw = (np.array(x) for x in zip(*lowest, strict=True))
    return Record(reaction, moment, bottom, yaw, states[:, [0, -2]])
