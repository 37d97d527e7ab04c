"""Scenes and prescribed motions that several tests wind."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from hoist_demo.cases.table import find_case
from hoist_demo.control.trajectory import Trajectory, emergency_stop, s_curve
from hoist_demo.parameters import Winding
from rope_model import (
    BalanceRope,
    EndMotion,
    Level,
    Model,
    Scene,
    Solver,
    Swivel,
    balance_rope,
    rope_120,
    rope_240,
)
from rope_model.fidelity.choice import Fidelity

Ends = tuple[EndMotion, EndMotion]
Motion = Callable[[float], Ends]
AnyRope = TypeVar("AnyRope", bound=BalanceRope)
REST = EndMotion()


def fixed_steps(h: float) -> Solver:
    """Steps of ``h`` (s), which no local error shortens."""
    return Solver(step_max=h, tolerance=1e6)


def smooth_step(t: float, start: float = 1.0, duration: float = 3.0) -> tuple[float, float, float]:
    """From 0 to 1, with its two derivatives in 1/s and 1/s^2."""
    s = min(max((t - start) / duration, 0.0), 1.0)
    rate = 30 * s**2 * (1 - s) ** 2
    bend = 60 * s - 180 * s**2 + 120 * s**3
    return 10 * s**3 - 15 * s**4 + 6 * s**5, rate / duration, bend / duration**2


def smooth_trip(t: float, travel: float, duration: float, height: float) -> Ends:
    """The left end rises by ``travel`` (m) from 0, the right one falls as far from ``height``."""
    y, v, a = (travel * x for x in smooth_step(t, 0.0, duration))
    return EndMotion(y=y, vy=v, ay=a), EndMotion(y=height - y, vy=-v, ay=-a)


def past_each_other(t: float) -> Ends:
    """Both ends pass each other in 1 s, the left one also moves aside."""
    y, v, a = smooth_step(t, 0.0, 1.0)
    up = {"y": 0.5 * y, "vy": 0.5 * v, "ay": 0.5 * a}
    aside = {"z": 0.2 * y, "vz": 0.2 * v, "az": 0.2 * a}
    return EndMotion(**up, **aside), EndMotion(**{name: -x for name, x in up.items()})


def ends_at(reference: Trajectory, travel: float, t: float) -> Ends:
    """The left end follows the reference from height 0, the right one falls from ``travel`` (m)."""
    p = reference.at(t)
    left = EndMotion(y=p.position, vy=p.speed, ay=p.acceleration)
    return left, EndMotion(y=travel - p.position, vy=-p.speed, ay=-p.acceleration)


def turn(angle: float, duration: float, t: float) -> Ends:
    """Both conveyances turn together about Y, 1 m from the axis."""
    a, w, e = (angle * x for x in smooth_step(t, 0.0, duration))
    c = math.cos(a)
    s = math.sin(a)
    left, right = (
        EndMotion(
            x=r * c - r,
            z=-r * s,
            vx=-r * s * w,
            vz=-r * c * w,
            yaw=a,
            yaw_rate=w,
            ax=-r * (c * w * w + s * e),
            az=-r * (c * e - s * w * w),
        )
        for r in (-1.0, 1.0)
    )
    return left, right


def hung(rope: AnyRope, left: EndMotion = REST, right: EndMotion = REST, t: float = 0.0) -> AnyRope:
    """The rope at rest between these ends."""
    status = rope.initialize(t, left, right)
    assert status.valid, status.message
    return rope


def followed(
    rope: BalanceRope, motion: Motion, steps: int, step: float = 0.01, first: int = 0
) -> Iterator[int]:
    """Numbers of the steps to which the rope has followed ``motion(t)``; at 0, where that begins, it is hung up."""
    if first == 0:
        hung(rope, *motion(0.0))
        yield 0
    for k in range(first + 1, first + steps + 1):
        status = rope.advance_to(k * step, *motion(k * step))
        assert status.valid, status.message
        yield k


def wound(rope: AnyRope, motion: Motion, steps: int, step: float = 0.01, first: int = 0) -> AnyRope:
    """The rope behind the last step of ``followed``."""
    for _ in followed(rope, motion, steps, step, first):
        pass
    return rope


def recorded(
    rope: BalanceRope,
    motion: Motion,
    steps: int,
    names: Sequence[str],
    step: float = 0.01,
    late: int = 0,
) -> np.ndarray:
    """(steps, names): signals after each step from rest; motions are those of ``late`` steps before its end."""
    hung(rope, *motion(0.0))
    read = rope.reader(names)
    rows = []
    for k in range(1, steps + 1):
        status = rope.advance_to(k * step, *motion((k - late) * step), (k - late) * step)
        assert status.valid, status.message
        rows.append(read())
    return np.array(rows)


def passed(scene: Scene, steps: int, step: float = 0.01) -> BalanceRope:
    """The native rope whose ends have passed each other."""
    return wound(balance_rope(scene, "native"), past_each_other, steps, step)


def going_aside(t: float) -> Ends:
    """The left end rises and goes sideways, the right one falls from 6 m."""
    left = EndMotion(y=t**3, vy=3 * t**2, ay=6 * t, z=t**3, vz=3 * t**2, az=6 * t)
    return left, EndMotion(y=6.0 - t**3, vy=-3 * t**2, ay=-6 * t)


@dataclass(frozen=True)
class Trip:
    """A case's trip in steps of ``H`` (s): a winding, or one with an emergency stop at three fifths of it."""

    scene: str
    trip: str
    level: Level
    H: float

    @cached_property
    def reference(self) -> Trajectory:
        plain = replace(find_case(self.scene).winding, start_delay=0.0)
        whole = s_curve(plain)
        if self.trip == "emergency stop":
            return s_curve(replace(plain, emergency_at=0.6 * whole.duration))
        return whole

    @property
    def steps(self) -> int:
        """Of the trip and 5 s more."""
        return round((self.reference.duration + 5.0) / self.H) - 1

    def ends(self, t: float) -> Ends:
        return ends_at(self.reference, find_case(self.scene).winding.travel, t)


P120 = rope_120()
P240 = rope_240()
TRIP = s_curve(Winding())
LONG_TRIP = s_curve(Winding(travel=P240.travel, speed=P240.speed))
STOP = emergency_stop(TRIP, 12.0, 5.0, 50.0)
COUPLED = P120.scene
FREE = Swivel(mode="free")
UNCOUPLED = COUPLED.with_(rope=replace(COUPLED.rope, Qb=0.0, Qc=0.0))
LOOSE = UNCOUPLED.with_(left=FREE, right=FREE)


def tolerant(scene: Scene, force_tolerance: float) -> Scene:
    return scene.with_(model=Model(force_tolerance=force_tolerance))


@dataclass(frozen=True)
class Choice:
    """A winding, the fidelity that 'auto' must start it at, and the one that it must end at."""

    title: str
    scene: Scene
    fidelity: Fidelity
    last: Fidelity | None = None  # where it is another
    trip: Trajectory = TRIP
    travel: float = P120.travel  # m
    until: float = TRIP.duration + 3.0  # s
    z: float = 0.0  # m, by which the left conveyance moves out of plane between 1 s and 4 s
    yaw: float = 0.0  # rad, by which it turns

    def ends(self, t: float) -> Ends:
        left, right = ends_at(self.trip, self.travel, t)
        x, v, a = smooth_step(t)
        return replace(
            left,
            z=self.z * x,
            vz=self.z * v,
            az=self.z * a,
            yaw=self.yaw * x,
            yaw_rate=self.yaw * v,
        ), right


CHOICES = (
    Choice("coupled", COUPLED, "torsional"),
    Choice("uncoupled", UNCOUPLED, "planar"),
    Choice("free, out of plane", LOOSE, "planar", "spatial", until=12.0, z=0.2),
    Choice("out of plane", UNCOUPLED, "planar", "torsional", z=0.2),
    Choice("turned", UNCOUPLED, "planar", "torsional", yaw=0.1),
    Choice("free, turned", LOOSE, "planar", yaw=0.1),
    Choice("tolerance 0.1 %", tolerant(COUPLED, 1e-3), "planar"),
    Choice("tolerance 0.5 %", tolerant(COUPLED, 5e-3), "rigid"),
    Choice(
        "emergency stop",
        tolerant(COUPLED, 5e-3),
        "rigid",
        "planar",
        trip=STOP,
        until=STOP.duration + 5.0,
    ),
    Choice(
        "released",
        tolerant(P240.scene, 1e-2),
        "planar",
        "torsional",
        LONG_TRIP,
        P240.travel,
        until=25.0,
    ),
)
