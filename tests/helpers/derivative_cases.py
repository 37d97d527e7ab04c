"""Scenes in which derivatives are compared with differences of communication steps, at the default settings.

The oracle is the step itself: from a saved state it is repeated with one input larger and smaller.  A change of one
input alone is a misfit of the motion.  The input filter follows misfits up to a bound, and larger ones slowly:
differences must stay below the bound.  So the step that is differentiated changes all accelerations, by BEND, and the
differences are small shares of the motion that such a change makes.  Estimated accelerations do not change so soon:
where the host does not give them, the motion is not bent, and the differences are shares of ALLOWED_JERK.

A larger difference may change the numbers of internal steps, Newton's corrections and events, a smaller one is lost in
rounding: of several sizes the largest one counts with which both runs have the numbers of the run between them.

    python tests/helpers/derivative_cases.py [CASE ...]

prints the largest error of a derivative over the largest entry, by cases and steps, the input that has it, and the
number of inputs whose differences can be seen.
"""

import ctypes as ct
import math
import struct
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scenes import Ends, Motion, ends_at

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model import EndMotion, Scene, rope_120
from rope_model.boundary.input_filter import MIN_AIM_TIME, MIN_MEAN_TIME
from rope_model.boundary.input_path import ALLOWED_JERK, ALLOWED_YAW_JERK
from rope_model.engine import NativeRope
from rope_model.shaft_parameters import Air, Divider, Shaft
from rope_model.signals.signal_table import LOADS, SIGNALS
from rope_model.solver_parameters import Inputs, Model

INPUTS = tuple(EndMotion.__dataclass_fields__)
#: m/s^2 and rad/s^2, change of the accelerations in the step that is differentiated
BEND = {"x": 0.2, "y": 0.2, "z": 0.2, "yaw": 20.0}
#: inputs of the speeds along the coordinates that are bent
SPEEDS = {"x": "vx", "y": "vy", "z": "vz", "yaw": "yaw_rate"}
#: shares of the motion by BEND in the largest difference: a short step is not divided, and takes a
#: larger one
LARGEST_SHARE = 3e-2
LARGEST_SHARE_SHORT = 0.3
LARGEST_SHARE_UNBENT = 0.5
#: differences over the largest
SHARES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)
#: N and N m, change of a load by a difference of which rounding and the last corrections of
#: Newton's method are 1 %
VISIBLE = 1e-5
#: s, by how much an event may move with an input: its step is then the same
SAME_TIME = 1e-12
COUNTS = tuple(name for name in SIGNALS if name.startswith("count."))
#: rad, change of a lean by which differences are shares
LEANED = 1e-3
TRAVEL = 90.0
#: s, instant of a transformation of the winding
TRANSFORMED = 3.43
#: s, when swivels are released: an instant that no input moves
RELEASED = 3.52
REFERENCE = s_curve(Winding(travel=TRAVEL))
#: ms, steps that are differentiated
STEPS = (0.001, 0.01, 0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0)


def winding(t: float) -> Ends:
    return ends_at(REFERENCE, TRAVEL, t)


def turning(t: float) -> Ends:
    """The winding with conveyances that yaw, faster and faster."""
    left, right = winding(t)
    return replace(left, yaw=0.05 * t**3, yaw_rate=0.15 * t**2), replace(
        right, yaw=-0.04 * t**3, yaw_rate=-0.12 * t**2
    )


def leaning(t: float) -> Ends:
    left, right = winding(t)
    return replace(left, lean=0.01 * t, lean_z=-0.005 * t), replace(right, lean=-0.01 * t)


@dataclass(frozen=True)
class Case:
    """Scene, motion of its ends, and the inputs that are bent and differentiated."""

    scene: Scene
    motion: Motion = winding
    begin: float = 3.5  # s
    late: bool = False
    to_event: bool = False
    shortest: float = 0.0  # s, of its steps
    longest: float = math.inf  # s
    bent: tuple[str, ...] = ("x", "y", "z", "yaw")
    apart: tuple[str, ...] = ()  # inputs that are left out
    # of the differences; wires begin to slide, or stick again, after a small bend
    scale: float = 1.0


def with_swivels(**values: Any) -> Scene:
    """rope_120 with these values of both swivels."""
    scene = rope_120().scene
    return scene.with_(left=replace(scene.left, **values), right=replace(scene.right, **values))


def cases() -> dict[str, Case]:
    """Return the cases by name."""
    scene = rope_120().scene
    leans = ("lean", "lean_z")
    turns = ("yaw", "yaw_rate", *leans)
    out_of_plane = ("z", "vz", "az", *turns)
    rigid = tuple(name for name in INPUTS if name not in ("y", "vy", "ay"))
    rubbing = replace(scene.rope, EI_stick=5.0 * scene.rope.EI, slip_moment=2.0, slip_factor=0.01)
    published = replace(scene.rope, Qb=1.5 * scene.rope.Qc)
    # a beam pushes the right leg 5 mm aside
    beam = Shaft(divider_1=Divider(size=0.2, y=40.0, offset=1.117))
    wind = Shaft(air=Air(density=1.2, vx=5.0, vy=-3.0, cross_height=200.0))
    gentle = {"mean_diameter": 0.2, "mu_static": 0.2, "mu_kinetic": 0.1}
    return {
        "torsional, locked swivels": Case(scene),
        "planar": Case(scene.with_(model=Model("planar")), bent=("x", "y"), apart=out_of_plane),
        "spatial": Case(scene.with_(model=Model("spatial")), bent=("x", "y", "z"), apart=turns),
        "rigid": Case(scene.with_(model=Model("rigid")), bent=("y",), apart=rigid),
        "free swivels": Case(with_swivels(mode="free")),
        "swivels that stick": Case(with_swivels(mode="coulomb", **gentle), turning),
        "swivels that slip": Case(with_swivels(mode="coulomb"), turning),
        "extrapolated": Case(scene, late=True, bent=("x", "y", "z")),
        "extrapolated positions": Case(scene.with_(inputs=Inputs("position")), late=True, bent=()),
        "position and speed given": Case(scene.with_(inputs=Inputs("position_speed")), bent=()),
        "position given": Case(scene.with_(inputs=Inputs("position")), bent=()),
        "speed given": Case(scene.with_(inputs=Inputs("speed")), bent=()),
        "contact with a beam": Case(scene.with_(shaft=beam)),
        "air": Case(scene.with_(shaft=wind)),
        "the first step": Case(scene, begin=0.0),
        "a step that raises the fidelity": Case(
            scene.with_(rope=replace(scene.rope, Qb=0.0, Qc=0.0))
        ),
        "at an event": Case(
            with_swivels(mode="coulomb", release_time=RELEASED),
            turning,
            to_event=True,
            shortest=0.05,
        ),
        "a transformation": Case(scene, begin=TRANSFORMED - 0.0005),
        "Qb not Qc": Case(scene.with_(rope=published), turning),
        "hinged": Case(with_swivels(attachment="hinged")),
        "clamps that lean": Case(with_swivels(attachment="clamped"), leaning, apart=()),
        "wires that rub": Case(
            with_swivels(attachment="clamped").with_(rope=rubbing),
            leaning,
            scale=1e-3,
            longest=0.01,
        ),
    }


@dataclass(frozen=True)
class Ending:
    """LOADS at the end of a step, COUNTS there, and its time."""

    loads: NDArray[np.float64]
    counts: tuple[float, ...]
    t: float

    def took_the_steps_of(self, other: "Ending") -> bool:
        return self.counts == other.counts and abs(self.t - other.t) < SAME_TIME


@dataclass
class Differentiated:
    """Rope at the end of the step, with what repeats it."""

    rope: NativeRope
    case: Case
    start: Any  # snapshot
    stop: float
    given_at: float
    ends: Ends

    def end_with(self, ends: Ends) -> Ending:
        """Repeat the step with these motions."""
        self.rope.restore(self.start)
        if self.case.to_event:
            advance_to_event(self.rope, self.stop, ends)
        else:
            status = self.rope.advance_to(self.stop, *ends, self.given_at)
            assert status.valid, status.message
        values = self.rope.reader((*LOADS, *COUNTS))()
        return Ending(values[: len(LOADS)], tuple(values[len(LOADS) :]), self.rope.time)

    def moved(self, changes: Sequence[dict[str, float]], times: float) -> Ending:
        """Repeat the step with motions that change by ``times`` these changes."""
        left, right = (
            with_change(end, change, times) for end, change in zip(self.ends, changes, strict=True)
        )
        return self.end_with((left, right))

    def difference(self, changes: Sequence[dict[str, float]]) -> NDArray[np.float64] | None:
        """Return half the difference of LOADS when motions change up and down; None if COUNTS change too."""
        base, above, below = (self.moved(changes, times) for times in (0.0, 1.0, -1.0))
        if not (above.took_the_steps_of(base) and below.took_the_steps_of(base)):
            return None
        return np.asarray(0.5 * (above.loads - below.loads))


def with_change(end: EndMotion, change: dict[str, float], times: float) -> EndMotion:
    """Return the motion that differs by ``times`` this change."""
    return replace(end, **{name: getattr(end, name) + times * x for name, x in change.items()})


def advance_to_event(rope: NativeRope, stop: float, ends: Ends) -> None:
    """Advance as an FMI master with early return does; an event must come."""
    lib, handle, *_ = rope.library
    event = ct.c_int(0)
    step = lib.rope_advance_to_event
    step.restype = ct.c_int
    step.argtypes = (ct.c_void_p, ct.c_double, ct.c_char_p, ct.c_double, ct.POINTER(ct.c_int))
    values = [*chain.from_iterable(vars(end).values() for end in ends)]
    status = rope.status_of(
        step(handle, stop, struct.pack(f"{len(values)}d", *values), stop, ct.byref(event))
    )
    assert status.valid, status.message
    assert event.value
    assert rope.time < stop


def bent(end: EndMotion, names: Sequence[str], h: float, late: bool) -> EndMotion:
    """Return the motion with accelerations that grow by BEND over the step ``h``, or are larger from its start on."""
    if late:
        return replace(end, **{f"a{name}": getattr(end, f"a{name}") + BEND[name] for name in names})
    if h < MIN_MEAN_TIME:  # the input filter does not believe such an acceleration of a yaw
        names = [name for name in names if name != "yaw"]
    speeds = {name: SPEEDS[name] for name in names}
    values = {name: getattr(end, name) + BEND[name] * h * h / 6.0 for name in names}
    values |= {speed: getattr(end, speed) + BEND[name] * h / 2.0 for name, speed in speeds.items()}
    values |= {f"a{name}": getattr(end, f"a{name}") + BEND[name] for name in names if name != "yaw"}
    return replace(end, **values)


def differentiated(case: Case, h: float, warm: float = 0.01) -> Differentiated:
    """Follow the case's motion to its begin, and take the step ``h``."""
    rope = NativeRope(case.scene)
    status = rope.initialize(0.0, *case.motion(0.0))
    assert status.valid, status.message
    steps = round(case.begin / warm)
    for k in range(1, steps + 1):
        begin, stop = (j * case.begin / steps for j in (k - 1, k))
        at = begin if case.late else stop
        status = rope.advance_to(stop, *case.motion(at), at)
        assert status.valid, status.message
    stop = rope.time + h
    given_at = rope.time if case.late else stop
    left, right = (bent(end, case.bent, h, case.late) for end in case.motion(given_at))
    found = Differentiated(rope, case, rope.snapshot(), stop, given_at, (left, right))
    found.end_with(found.ends)
    return found


def derivative(
    rope: NativeRope, side: int, name: str, at_step_end: bool = True
) -> NDArray[np.float64]:
    """Return the derivatives of LOADS to an input, as an FMU gives them."""
    lib, handle, *_ = rope.library
    found = (ct.c_double * len(LOADS))()
    assert lib.rope_load_derivative(
        handle, len(INPUTS) * side + INPUTS.index(name), at_step_end, found
    ), lib.rope_message(handle).decode()
    return np.array(found)


def derivative_order(name: str) -> int:
    """Return 0 for an input that is a position or an angle, 1 for a speed, 2 for an acceleration."""
    if name.startswith("a"):
        return 2
    return int(name.startswith("v") or name == "yaw_rate")


def largest_difference(case: Case, name: str, h: float) -> float:
    """Return the largest change of an input of which differences are shares."""
    if name.startswith("lean"):
        return 0.1 * LARGEST_SHARE * LEANED
    axis = name[-1]
    jerk = ALLOWED_JERK
    if name.startswith("yaw"):
        axis = "yaw"
        jerk = ALLOWED_YAW_JERK
    order = derivative_order(name)
    share = LARGEST_SHARE
    aim = h
    if h < MIN_MEAN_TIME:
        share = LARGEST_SHARE_SHORT
        aim = max(h, MIN_AIM_TIME)
    if axis in case.bent and not (axis == "yaw" and h < MIN_MEAN_TIME):
        return share * BEND[axis] * aim ** (2 - order)
    return LARGEST_SHARE_UNBENT * jerk * aim ** (3 - order)


def expected_derivative(step: Differentiated, name: str, h: float) -> NDArray[np.float64] | None:
    """Return the difference quotients of LOADS to an input of the left end; None where no difference shows them."""
    largest = step.case.scale * largest_difference(step.case, name, h)
    for share in SHARES:
        size = share * largest
        difference = step.difference(({name: size}, {}))
        if difference is None:
            continue
        if np.abs(difference).max() > VISIBLE:
            return difference / size
        return None
    return None


def errors(case: Case, h: float) -> dict[str, float]:
    """Return the largest error of a derivative over the largest entry, for each input of the left end that shows it."""
    step = differentiated(case, h)
    found = {}
    derivatives = {name: derivative(step.rope, 0, name, not case.late) for name in INPUTS}
    for name in INPUTS:
        if name in case.apart or (
            name.startswith("lean") and case.scene.left.attachment != "clamped"
        ):
            assert not derivatives[name].any(), name
            continue
        expected = expected_derivative(step, name, h)
        if expected is None:
            continue
        largest = np.abs(expected).max()
        error = np.abs(derivatives[name] - expected).max()
        found[name] = float(error / largest)
    return found


def main() -> None:
    print(f"{'largest error over the largest entry, %':<36}", *(f"{h:>10g} ms   " for h in STEPS))
    for name, case in cases().items():
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        print(f"{name:<36}", end=" ")
        for h in STEPS:
            of_inputs = {}
            worst = f"{'-':>6}     "
            if case.shortest <= 1e-3 * h <= case.longest:
                of_inputs = errors(case, 1e-3 * h)
            if of_inputs:
                which = max(of_inputs, key=lambda x: of_inputs[x])
                worst = f"{100.0 * of_inputs[which]:>6.3f} {which[:4]:<4}"
            print(f"{worst} {len(of_inputs):>2}", end="  ", flush=True)
        print(flush=True)


if __name__ == "__main__":
    main()
