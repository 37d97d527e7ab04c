"""Scenes in which derivatives are compared with differences of communication steps, at the default settings.

The oracle is the step itself: from a saved state it is repeated with one input larger and smaller.  A change of one
input alone is a misfit of the motion.  The input filter follows misfits up to a bound, and larger ones slowly:
differences must stay below the bound.  So the step that is differentiated changes all accelerations, by BEND, and the
differences are small shares of the motion that such a change makes.  A larger one may change the number of internal
steps, a smaller one is lost in rounding: of several sizes those two neighbours count that agree best.
"""

import ctypes as ct
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scenes import Ends, Motion, ends_at

from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding
from rope_model import EndMotion, Scene, rope_120
from rope_model.engine import NativeRope
from rope_model.shaft_parameters import Air, Lining, Shaft
from rope_model.simulation.ends.input_filter import ALLOWED_YAW_JERK, MIN_MEAN_TIME
from rope_model.simulation.outputs.signal_table import LOADS
from rope_model.solver_parameters import Inputs, Model

INPUTS = tuple(EndMotion.__dataclass_fields__)
#: m/s^2 and rad/s^2, change of the accelerations in the step that is differentiated
BEND = {"x": 0.2, "y": 0.2, "z": 0.2, "yaw": 20.0}
#: shares of the motion by BEND in the largest difference: a short step is not divided, and takes a larger one
LARGEST_SHARE = 3e-3
LARGEST_SHARE_SHORT = 0.3
#: differences over the largest: smaller ones agree with each other, by rounding, on something else
SHARES = (0.03, 0.1, 0.3, 1.0)
#: rad, change of a lean by which differences are shares
LEANED = 1e-3
TRAVEL = 90.0
#: s, instant of a transformation of the winding
TRANSFORMED = 3.43
REFERENCE = s_curve(Winding(travel=TRAVEL))
#: ms, steps that are differentiated
STEPS = (0.1, 1.0, 5.0, 10.0, 20.0, 50.0, 100.0)


def winding(t: float) -> Ends:
    return ends_at(REFERENCE, TRAVEL, t)


def turning(t: float) -> Ends:
    """The winding with conveyances that yaw, faster and faster."""
    left, right = winding(t)
    return replace(left, yaw=0.05 * t**3, yaw_rate=0.15 * t**2), replace(right, yaw=-0.04 * t**3, yaw_rate=-0.12 * t**2)


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
    bent: tuple[str, ...] = ("x", "y", "z", "yaw")
    apart: tuple[str, ...] = ()  # inputs that are left out


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
    published = replace(scene.rope, Qb=1.5 * scene.rope.Qc)
    lining = Shaft(lining=Lining(width=2.042, depth=2.0))
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
        "position and speed given": Case(scene.with_(inputs=Inputs("position_speed"))),
        "position given": Case(scene.with_(inputs=Inputs("position"))),
        "speed given": Case(scene.with_(inputs=Inputs("speed"))),
        "contact with a wall": Case(scene.with_(shaft=lining)),
        "air": Case(scene.with_(shaft=wind)),
        "a transformation": Case(scene, begin=TRANSFORMED - 0.0005),
        "Qb not Qc": Case(scene.with_(rope=published), turning),
        "hinged": Case(with_swivels(attachment="hinged")),
        "clamps that lean": Case(with_swivels(attachment="clamped"), leaning, apart=()),
    }


@dataclass
class Differentiated:
    """Rope at the end of the step, with what repeats it."""

    rope: NativeRope
    case: Case
    start: Any  # snapshot
    stop: float
    given_at: float
    ends: Ends

    def loads_with(self, ends: Ends) -> NDArray[np.float64]:
        """Repeat the step with these motions, and return LOADS."""
        self.rope.restore(self.start)
        status = self.rope.advance_to(self.stop, *ends, self.given_at)
        assert status.valid, status.message
        return self.rope.reader(LOADS)()

    def difference(self, changes: Sequence[dict[str, float]]) -> NDArray[np.float64]:
        """Return half the difference of LOADS when the ends' motions change up and down by ``changes``."""
        loads = []
        for sign in (1.0, -1.0):
            moved = [
                replace(end, **{name: getattr(end, name) + sign * x for name, x in change.items()})
                for end, change in zip(self.ends, changes, strict=True)
            ]
            loads.append(self.loads_with((moved[0], moved[1])))
        return np.asarray(0.5 * (loads[0] - loads[1]))


def bent(end: EndMotion, names: Sequence[str], h: float, late: bool) -> EndMotion:
    """Return the motion with accelerations that grow by BEND over the step ``h``, or are larger from its start on."""
    if late:
        return replace(end, **{f"a{name}": getattr(end, f"a{name}") + BEND[name] for name in names})
    if h < MIN_MEAN_TIME:  # the input filter does not believe such an acceleration of a yaw
        names = [name for name in names if name != "yaw"]
    speeds = {name: "yaw_rate" if name == "yaw" else f"v{name}" for name in names}
    values = {name: getattr(end, name) + BEND[name] * h * h / 6.0 for name in names}
    values |= {speed: getattr(end, speed) + BEND[name] * h / 2.0 for name, speed in speeds.items()}
    values |= {f"a{name}": getattr(end, f"a{name}") + BEND[name] for name in names if name != "yaw"}
    return replace(end, **values)


def differentiated(case: Case, h: float, warm: float = 0.01) -> Differentiated:
    """Follow the case's motion to its begin, and take the step ``h``."""
    rope = NativeRope(case.scene)
    status = rope.initialize(0.0, *case.motion(0.0))
    assert status.valid, status.message
    steps = max(round(case.begin / warm), 1)
    for k in range(1, steps + 1):
        begin, stop = (j * case.begin / steps for j in (k - 1, k))
        at = begin if case.late else stop
        status = rope.advance_to(stop, *case.motion(at), at)
        assert status.valid, status.message
    stop = rope.time + h
    given_at = rope.time if case.late else stop
    left, right = (bent(end, case.bent, h, case.late) for end in case.motion(given_at))
    found = Differentiated(rope, case, rope.snapshot(), stop, given_at, (left, right))
    found.loads_with(found.ends)
    return found


def derivative(rope: NativeRope, side: int, name: str, at_step_end: bool = True) -> NDArray[np.float64]:
    """Return the derivatives of LOADS to an input, as an FMU gives them."""
    lib, handle, *_ = rope.library
    found = (ct.c_double * len(LOADS))()
    assert lib.rope_load_derivative(handle, len(INPUTS) * side + INPUTS.index(name), at_step_end, found), (
        lib.rope_message(handle).decode()
    )
    return np.array(found)


def bend_of(case: Case, name: str, h: float) -> float:
    """Return the change of an input of which differences are shares."""
    if name.startswith("lean"):
        return LEANED
    axis = "yaw" if name.startswith("yaw") else name[-1]
    order = 2 if name.startswith("a") else 1 if name.startswith("v") or name == "yaw_rate" else 0
    if axis == "yaw" and (h < MIN_MEAN_TIME or "yaw" not in case.bent):
        return ALLOWED_YAW_JERK * h ** (3 - order)
    return BEND[axis] * h ** (2 - order)


def best_difference(step: Differentiated, name: str, h: float) -> NDArray[np.float64]:
    """Return the difference quotients of LOADS to an input of the left end."""
    most = LARGEST_SHARE_SHORT if h < MIN_MEAN_TIME else LARGEST_SHARE
    sizes = [most * share * bend_of(step.case, name, h) for share in SHARES]
    quotients = [step.difference(({name: size}, {})) / size for size in sizes]
    apart = [float(np.abs(a - b).max()) for a, b in pairwise(quotients)]
    return quotients[apart.index(min(apart)) + 1]


def errors(case: Case, h: float) -> dict[str, float]:
    """Return the largest error of a derivative over the largest entry, for each input of the left end."""
    step, found = differentiated(case, h), {}
    derivatives = {name: derivative(step.rope, 0, name, not case.late) for name in INPUTS}
    for name in INPUTS:
        if name in case.apart or (name.startswith("lean") and case.scene.left.attachment != "clamped"):
            assert not derivatives[name].any(), name
            continue
        expected = best_difference(step, name, h)
        largest = np.abs(expected).max()
        error = np.abs(derivatives[name] - expected).max()
        found[name] = error / largest if largest else error
    return found


if __name__ == "__main__":
    print(f"{'largest error over the largest entry, %':<36}", *(f"{h:>8g}" for h in STEPS), "ms")
    for name, case in cases().items():
        worst = []
        for h in STEPS:
            of_inputs = errors(case, 1e-3 * h)
            which = max(of_inputs, key=lambda x: of_inputs[x])
            worst.append(f"{100.0 * of_inputs[which]:>8.3f} {which[:4]:<4}")
        print(f"{name:<36}", *worst, flush=True)
