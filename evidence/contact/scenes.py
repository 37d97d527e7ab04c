"""Ropes that lie on a floor, fall on it, and are pulled around a divider: with what is exact about each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rope_model import BalanceRope, EndMotion, balance_rope
from rope_model.parameters import Layout, Mesh, Model, Rope, Scene, Solver
from rope_model.shaft_parameters import Contact, Conveyance, Divider, HeadRopes, Lining, Shaft, Sump

Array = NDArray[np.float64]
#: a height and its rates
Rates = tuple[float, float, float]
GRAVITY = Layout().gravity
WEIGHT = Rope().mass_per_length * GRAVITY  # N/m


def made(scene: Scene, left: EndMotion, right: EndMotion) -> BalanceRope:
    """The native rope of ``scene`` at rest."""
    rope = balance_rope(scene, "native")
    status = rope.initialize(0.0, left, right)
    if not status.valid:
        raise RuntimeError(status.message)
    return rope


@dataclass(frozen=True)
class TouchDown:
    """A rope at rest on a floor: heights ``y`` (m) at ``x`` (m) from where it lifts off, and the layer's theory.

    ``leg`` and ``force`` are relative errors.
    """

    layer: float
    x: Array
    y: Array
    exact: Array
    leg: float  # of the height of a place half way up the leg
    force: float  # of the floor's force


def touch_down(EI: float, element: float, stiffness: float) -> TouchDown:
    """A rope between two wide ends, its middle on the floor.

    Where a beam under tension T0 lifts off, y = w/T0 (x^2/2 - b x + b^2 (1 - exp(-x/b))), b = sqrt(EI/T0); along all
    of the leg, N + EI k^2/2 - w y = T0, N and k those of a catenary but for higher powers of b.
    """
    length, spacing, level = 32.0, 20.0, -10.0
    rope = Rope(length=length, EI=EI, Qb=0.0, Qc=0.0)
    sunk = math.sqrt(2.0 * 0.05 * rope.diameter * WEIGHT / stiffness)
    scene = Scene(
        rope=rope,
        layout=Layout(spacing=spacing),
        mesh=Mesh("eem", elements=round(length / element)),
        model=Model(fidelity="planar"),
        shaft=Shaft(sump=Sump(level=level), contact=Contact(stiffness=stiffness)),
    )
    found = made(scene, EndMotion(), EndMotion())
    signals = found.signals(["left.fx", "left.fy", "contact.floor"])
    T0, V = signals["left.fx"], -signals["left.fy"]
    b = math.sqrt(EI / T0)
    m, s = found.state.motion, found.state.partition.nodes_s
    up = m.q[:, 1] - (level + 0.5 * rope.diameter - sunk)
    # the end force carries what hangs, and a layer's weight less than that: that presses on where it lifts off
    lifts = V / WEIGHT + b
    near = (s < lifts) & (s > lifts - 3.0 * b)
    x = lifts - s[near]
    exact = WEIGHT / T0 * (0.5 * x**2 - b * x + b * b * (1.0 - np.exp(-x / b)))
    half = int(np.argmin(np.abs(s - 0.5 * lifts)))
    slope = (V - WEIGHT * s[half]) / T0
    N, k = T0 * math.sqrt(1.0 + slope**2), WEIGHT / T0 / (1.0 + slope**2)
    leg = (N - T0 + 0.5 * EI * k * k) / WEIGHT
    force = WEIGHT * length - 2.0 * V
    return TouchDown(b, x, up[near], exact, float(up[half]) / leg - 1.0, signals["contact.floor"] / force - 1.0)


@dataclass(frozen=True)
class Fallen:
    """A rope whose ends fall as freely as it does: time (s), impulse of the floor on it (N s), and the theory's."""

    t: Array
    impulse: Array
    exact: Array


def fallen(EI: float, element: float, stop: float) -> Fallen:
    """A rope that is let go as it just touches the floor.

    A flexible rope presses with three times the weight of what lies: 3 w l, l = g t^2 of both legs; impulse w g t^3.
    """
    length, spacing, H = 30.0, 0.5, 2e-3
    scene = Scene(
        rope=Rope(length=length, EI=EI, Qa=1e6, Qb=0.0, Qc=0.0),
        layout=Layout(spacing=spacing),
        mesh=Mesh("eem", elements=round(length / element)),
        model=Model(fidelity="planar"),
        solver=Solver(step_max=H, tolerance=100.0),
    )
    bottom = made(scene, EndMotion(), EndMotion()).signals(["loop.y"])["loop.y"]
    floor = Sump(level=bottom - 0.5 * scene.rope.diameter)
    found = made(scene.with_(shaft=Shaft(sump=floor)), EndMotion(), EndMotion())
    rows, impulse, before = [(0.0, 0.0)], 0.0, 0.0
    for k in range(1, round(stop / H) + 1):
        t = k * H
        end = EndMotion(y=-0.5 * GRAVITY * t * t, vy=-GRAVITY * t, ay=-GRAVITY)
        status = found.advance_to(t, end, end)
        if not status.valid:
            raise RuntimeError(status.message)
        force = found.signals(["contact.floor"])["contact.floor"]
        impulse += 0.5 * H * (before + force)
        before = force
        rows.append((t, impulse))
    t, total = np.array(rows).T
    return Fallen(t, total, WEIGHT * GRAVITY * t**3)


@dataclass(frozen=True)
class Pulled:
    """Tensions (N) on both sides of a divider that a rope slides half around, and the theory of the larger one.

    Means over the time in which it slides evenly: waves along the rope make each instant differ by 1e-3.
    Capstan with weight: T' = mu T - w R (mu sin phi + cos phi) along the underside, phi from 0 to pi.
    """

    slack: float
    tight: float
    exact: float


def pulled(friction: float, element: float, speed: float = 0.2) -> Pulled:
    """A rope in a U under a round divider, drawn tight and pulled around it."""
    length, size, stiffness, pull = 16.0, 2.0, 1e8, 2e4
    rope = Rope(length=length, EI=10.0, Qb=0.0, Qc=0.0)
    sunk = pull / (0.5 * size) / stiffness
    spacing = size + rope.diameter - 2.0 * sunk
    free = 0.5 * (length - 0.5 * math.pi * spacing)
    scene = Scene(
        rope=rope,
        layout=Layout(spacing=spacing),
        mesh=Mesh("eem", elements=round(length / element)),
        model=Model(fidelity="planar"),
        solver=Solver(step_max=5e-3, tolerance=100.0),
        shaft=Shaft(
            divider_1=Divider(size=size, y=-free),
            contact=Contact(stiffness=stiffness, friction=friction, slip_speed=1e-4),
        ),
    )
    tight, ramp, H = 0.5 * pull * length / rope.Qa + sunk, 0.5, 5e-3
    found, tensions = made(scene, EndMotion(), EndMotion()), []
    for k in range(1, round(3.0 * ramp / H) + 1):
        # draw it tight, and pull it around from then on: rates of a step that takes the time ramp
        t = k * H
        up, side = smooth_step(t / ramp), smooth_step(t / ramp - 1.0)
        rise = tight * up[1], tight * up[2] / ramp, tight * up[3] / ramp**2
        slide = speed * ramp * side[0], speed * side[1], speed * side[2] / ramp
        left, right = (_end(rise, slide, sign) for sign in (-1.0, 1.0))
        status = found.advance_to(t, left, right)
        if not status.valid:
            raise RuntimeError(status.message)
        if t > 2.0 * ramp:
            forces = found.signals(["left.fy", "right.fy"])
            left_leg, right_leg = WEIGHT * (free - slide[0]), WEIGHT * (free + slide[0])
            tensions.append((-forces["left.fy"] - left_leg, -forces["right.fy"] - right_leg))
    slack, tight = np.mean(tensions, axis=0).tolist()
    held = 2.0 * friction / (1.0 + friction**2) * WEIGHT * 0.5 * spacing
    exact = (slack - held) * math.exp(friction * math.pi) - held
    return Pulled(slack, tight, exact)


def _end(rise: Rates, slide: Rates, sign: float) -> EndMotion:
    y, vy, ay = (a + sign * b for a, b in zip(rise, slide, strict=True))
    return EndMotion(y=y, vy=vy, ay=ay)


def smooth_step(s: float) -> tuple[float, float, float, float]:
    """Integral, value and two rates of a smooth step from 0 to 1 while ``s`` does so."""
    if s >= 1.0:
        return s - 0.5, 1.0, 0.0, 0.0
    s = max(s, 0.0)
    value, rate = s**3 * (10 - 15 * s + 6 * s * s), 30 * (s * (1 - s)) ** 2
    return s**4 * (2.5 - 3 * s + s * s), value, rate, 60 * s * (1 - s) * (1 - 2 * s)


@dataclass(frozen=True)
class Struck:
    """A rope among bodies of every kind: work of the conveyances, dissipated by contact, and unexplained, J."""

    work: float
    dissipated: float
    unexplained: float


def struck(stiffness: float) -> Struck:
    """A short loop that is let down, askew, on a floor, a divider and the lining."""
    length, down, T, H = 10.0, 1.5, 2.0, 1e-2
    scene = Scene(
        rope=Rope(length=length),
        mesh=Mesh("eem", elements=20),
        shaft=Shaft(
            sump=Sump(level=-4.2),
            divider_1=Divider(size=0.2, y=-3.5, offset=0.3),
            lining=Lining(width=2.8, depth=2.0),
            conveyance=Conveyance(width=1.0, depth=1.0, height=3.0, above=0.3),
            head_ropes=HeadRopes(diameter=0.04, row=0.5),
            contact=Contact(stiffness=stiffness),
        ),
    )
    found = made(scene, EndMotion(), EndMotion())
    for k in range(1, round(1.5 * T / H) + 1):
        _, value, rate, second = smooth_step(k * H / T)
        left, right = (EndMotion(y=-y * value, vy=-y * rate / T, ay=-y * second / T**2) for y in (down, 0.2 * down))
        status = found.advance_to(k * H, left, right)
        if not status.valid:
            raise RuntimeError(status.message)
    energies = found.state.energy_balance
    return Struck(energies.work_ends, energies.dissipated_contact, energies.residual)
