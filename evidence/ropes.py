"""Ropes at rest and led by their ends, and smooth motions of the ends: what the rooms share."""

from collections.abc import Callable
from typing import Any

import numpy as np

from evidence.tables import Array
from rope_model import BalanceRope, EndMotion, Scene, Status, balance_rope
from rope_model.public import Form

AT_ZERO = EndMotion()


def require(status: Status) -> None:
    """Raise RuntimeError with the rope's message where a start or a step has failed."""
    if not status.valid:
        raise RuntimeError(status.message)


def at_rest(
    scene: Scene,
    left: EndMotion = AT_ZERO,
    right: EndMotion = AT_ZERO,
    form: Form = "native",
) -> BalanceRope:
    """Return the rope of ``scene`` at rest between these ends."""
    rope = balance_rope(scene, form)
    require(rope.initialize(0.0, left, right))
    return rope


def follow(
    rope: BalanceRope,
    h: float,
    stop: float,
    ends: Callable[[float], tuple[EndMotion, EndMotion]],
    read: Callable[[], Any] = tuple,
) -> Array:
    """Return what is read after every ``h`` (s) until ``stop`` (s) while the ends move so."""
    rows = []
    for k in range(1, round(stop / h) + 1):
        require(rope.advance_to(k * h, *ends(k * h)))
        rows.append(read())
    return np.array(rows)


def smooth_step(s: float) -> tuple[float, float, float, float]:
    """Return integral, value and two rates of a smooth step from 0 to 1 while ``s`` goes from 0 to 1."""
    if s >= 1.0:
        return s - 0.5, 1.0, 0.0, 0.0
    s = max(s, 0.0)
    value = s**3 * (10 - 15 * s + 6 * s * s)
    rate = 30 * (s * (1 - s)) ** 2
    return s**4 * (2.5 - 3 * s + s * s), value, rate, 60 * s * (1 - s) * (1 - 2 * s)


def moving(way: float, t: float, time: float, **axes: float) -> EndMotion:
    """Return an end that moves by ``way`` (m) within ``time`` (s), along the axes times their factors."""
    _, value, rate, second = smooth_step(t / time)
    motion = {"": way * value, "v": way * rate / time, "a": way * second / time**2}
    return EndMotion(
        **{name + axis: part * x for axis, part in axes.items() for name, x in motion.items()}
    )
