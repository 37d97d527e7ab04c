"""Ropes that lie on a floor, fall on it, are pulled around a divider, or are let down on all: what is exact of each."""

import math
from typing import NamedTuple

import numpy as np

from evidence.ropes import at_rest, follow, moving, smooth_step
from rope_model import BalanceRope, EndMotion
from rope_model.parameters import Layout, Rope, Scene
from rope_model.shaft_parameters import Contact, Conveyance, Divider, HeadRopes, Lining, Shaft, Sump
from rope_model.solver_parameters import Mesh, Model, Solver

GRAVITY = Layout().gravity
WEIGHT = Rope().mass_per_length * GRAVITY  # N/m
PLANAR = Model(fidelity="planar")


class TouchDown(NamedTuple):
    """Relative errors of a rope at rest on a floor."""

    layer: float  # of heights in the bending layer, over the largest
    leg: float  # of the height of a place half way up the leg
    force: float  # of the floor's force


def touch_down(EI: float, element: float, stiffness: float) -> TouchDown:
    """A rope between two wide ends, its middle on the floor.

    Where a beam under tension T0 lifts off, y = w/T0 (x^2/2 - b x + b^2 (1 - exp(-x/b))), b = sqrt(EI/T0); along all
    of the leg, N + EI k^2/2 - w y = T0, N and k those of a catenary but for higher powers of b.
    """
    length = 32.0
    level = -10.0
    rope = Rope(length=length, EI=EI, Qb=0.0, Qc=0.0)
    sunk = math.sqrt(2.0 * 0.05 * rope.diameter * WEIGHT / stiffness)
    shaft = Shaft(sump=Sump(level=level), contact=Contact(stiffness=stiffness))
    mesh = round(length / element)
    found = at_rest(
        Scene(
            rope, Layout(spacing=20.0), mesh=Mesh("eem", elements=mesh), model=PLANAR, shaft=shaft
        )
    )
    T0, V, floor = found.signals(["left.fx", "left.fy", "contact.floor"]).values()
    b = math.sqrt(EI / T0)
    s = found.state.partition.nodes_s
    up = found.state.motion.q[:, 1] - (level + 0.5 * rope.diameter - sunk)
    # the end force carries what hangs, and a layer's weight less than that: that presses on where it lifts off
    lifts = -V / WEIGHT + b
    near = (s < lifts) & (s > lifts - 3.0 * b)
    x = lifts - s[near]
    exact = WEIGHT / T0 * (0.5 * x**2 - b * x + b * b * (1.0 - np.exp(-x / b)))
    half = int(np.argmin(np.abs(s - 0.5 * lifts)))
    slope = (-V - WEIGHT * s[half]) / T0
    N = T0 * math.sqrt(1.0 + slope**2)
    k = WEIGHT / T0 / (1.0 + slope**2)
    leg = (N - T0 + 0.5 * EI * k * k) / WEIGHT
    force = WEIGHT * length + 2.0 * V
    return TouchDown(
        float(np.abs(up[near] - exact).max() / exact.max()),
        up[half] / leg - 1.0,
        floor / force - 1.0,
    )


def fallen(EI: float, element: float, stop: float) -> float:
    """Relative error of the floor's impulse on a rope that is let go as it just touches it: its ends fall as freely.

    A flexible rope presses with three times the weight of what lies: 3 w l, l = g t^2 of both legs; impulse w g t^3.
    """
    length = 30.0
    H = 2e-3
    scene = Scene(
        Rope(length=length, EI=EI, Qa=1e6, Qb=0.0, Qc=0.0),
        Layout(spacing=0.5),
        mesh=Mesh("eem", elements=round(length / element)),
        model=PLANAR,
        solver=Solver(step_max=H, tolerance=100.0),
    )
    bottom = at_rest(scene).signals(["loop.y"])["loop.y"]
    found = at_rest(scene.with_(shaft=Shaft(sump=Sump(level=bottom - 0.5 * scene.rope.diameter))))
    read = found.reader(("contact.floor",))
    follow(
        found,
        H,
        stop,
        lambda t: 2 * (EndMotion(y=-0.5 * GRAVITY * t * t, vy=-GRAVITY * t, ay=-GRAVITY),),
        read,
    )
    impulse = found.signals(["contact.floor.impulse"])["contact.floor.impulse"]
    return impulse / (WEIGHT * GRAVITY * stop**3) - 1.0


def pulled(friction: float, element: float, speed: float = 0.2) -> float:
    """Relative error of the larger tension at a divider that a rope, drawn tight in a U, is pulled half around.

    Means over the time in which it slides evenly: waves along the rope make each instant differ by 1e-3.
    Capstan with weight: T' = mu T - w R (mu sin phi + cos phi) along the underside, phi from 0 to pi.
    """
    length = 16.0
    size = 2.0
    stiffness = 1e8
    pull = 2e4
    ramp = 0.5
    rope = Rope(length=length, EI=10.0, Qb=0.0, Qc=0.0)
    sunk = pull / (0.5 * size) / stiffness
    spacing = size + rope.diameter - 2.0 * sunk
    free = 0.5 * (length - 0.5 * math.pi * spacing)
    contact = Contact(stiffness=stiffness, friction=friction, slip_speed=1e-4)
    scene = Scene(
        rope,
        Layout(spacing=spacing),
        mesh=Mesh("eem", elements=round(length / element)),
        model=PLANAR,
        solver=Solver(step_max=5e-3, tolerance=100.0),
        shaft=Shaft(divider_1=Divider(size=size, y=-free), contact=contact),
    )
    tight = 0.5 * pull * length / rope.Qa + sunk

    def ends(t: float) -> tuple[EndMotion, EndMotion]:
        # draw it tight, and pull it around from then on: rates of a step that takes the time ramp
        up = smooth_step(t / ramp)
        side = smooth_step(t / ramp - 1.0)
        rise = tight * up[1], tight * up[2] / ramp, tight * up[3] / ramp**2
        slide = speed * ramp * side[0], speed * side[1], speed * side[2] / ramp
        left, right = (
            [a + sign * b for a, b in zip(rise, slide, strict=True)] for sign in (-1.0, 1.0)
        )
        return EndMotion(y=left[0], vy=left[1], ay=left[2]), EndMotion(
            y=right[0], vy=right[1], ay=right[2]
        )

    found = at_rest(scene)
    forces = follow(found, 5e-3, 3.0 * ramp, ends, found.reader(("left.fy", "right.fy")))
    t = 5e-3 * np.arange(1, len(forces) + 1)
    slides = np.array([speed * ramp * smooth_step(x / ramp - 1.0)[0] for x in t])
    tensions = -forces - WEIGHT * np.stack([free - slides, free + slides], axis=1)
    slack, most = tensions[t > 2.0 * ramp].mean(axis=0)
    held = 2.0 * friction / (1.0 + friction**2) * WEIGHT * 0.5 * spacing
    return float(most / ((slack - held) * math.exp(friction * math.pi) - held)) - 1.0


def let_down(stiffness: float) -> float:
    """Energy unexplained of a short loop that is let down, askew, on bodies of every kind, of the work done."""
    scene = Scene(
        rope=Rope(length=10.0),
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
    found = at_rest(scene)
    follow(found, 1e-2, 3.0, lambda t: (moving(-1.5, t, 2.0, y=1.0), moving(-0.3, t, 2.0, y=1.0)))
    return unexplained(found)


def unexplained(rope: BalanceRope) -> float:
    """Energy that is missing in the balance, of the ends' work."""
    energies = rope.state.energy_balance
    return float(energies.residual / energies.work_ends)
