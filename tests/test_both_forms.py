"""Both forms of the rope under all that may act on it: they agree, and each goes on from a saved state bit by bit."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
import test_air
import test_contact
import test_fidelity
import test_guards
import test_initial_curvature
import test_rope_contact
import test_wire_friction
from numpy.testing import assert_allclose
from scenes import Ends, going_aside, past_each_other, wound
from test_input_filter import unfit

from rope_model import (
    BalanceRope,
    EndMotion,
    Guard,
    Mesh,
    Model,
    Rope,
    RopeState,
    Scene,
    balance_rope,
)
from rope_model.rules.audit import Audit
from rope_model.solver_parameters import FidelityChoice


@dataclass(frozen=True)
class Case:
    """A scene, the motion of its ends, steps (of ``h``, s) until it is saved and in all, and what has acted by then."""

    scene: Scene
    motion: Callable[[float], Ends]
    saved: int
    steps: int
    acted: Callable[[RopeState], Any]
    off: float = 1e-9  # m: rounding, by some ten steps of a stiff contact
    h: float = 0.01
    forms: tuple[str, ...] = ("python", "native")


def twisting(t: float) -> Ends:
    return (test_rope_contact.end(t, 1.5, 2.0),) * 2


CROSS_WIND = {
    "density": 1.2,
    "vx": 10.0,
    "vy": -3.0,
    "vz": 12.0,
    "cross_y": -2.0,
    "cross_height": 2.0,
}
BLOWN = test_air.scene(**CROSS_WIND, buffet=1.0, buffet_length=2.0)
CURVED, WIRES = test_initial_curvature.scene, test_wire_friction.scene()
#: its errors halve steps
STRICT = WIRES.with_(solver=replace(WIRES.solver, tolerance=1.0, newton_tolerance=1e-8))
CASES = {
    # it drives the rope
    "wind and a floor": Case(
        BLOWN, test_air.ends, 15, 30, lambda x: x.energy_balance.given_to_air < -0.1
    ),
    "bodies": Case(
        test_contact.narrow(),
        test_contact.ends,
        15,
        21,
        lambda x: x.energy_balance.dissipated_contact > 0.01,
    ),
    "legs that press each other": Case(
        test_rope_contact.twisted(),
        twisting,
        81,
        84,
        lambda x: x.energy_balance.dissipated_contact > 1.0,
    ),
    "curved and twisted": Case(
        CURVED(installed_twist=1.0), past_each_other, 12, 16, lambda x: abs(x.loop_yaw) > 0.1, 1e-8
    ),
    "curved, with wires that slide": Case(
        CURVED(EI_stick=3000.0, slip_moment=2.0),
        past_each_other,
        12,
        16,
        lambda x: x.hysteresis.any(),
        1e-8,
    ),
    "wires that slide": Case(
        STRICT, past_each_other, 2, 4, lambda x: x.counts.steps > 8, 1e-8, 0.02
    ),
}


def misfit(fidelity: FidelityChoice) -> Case:
    torque = {} if fidelity == "torsional" else {"Qb": 0.0, "Qc": 0.0}
    # sixteen elements: other tests compile them, too
    scene = Scene(
        rope=Rope(length=60.0, **torque), mesh=Mesh("eem", elements=16), model=Model(fidelity)
    )

    def motion(t: float) -> Ends:
        return unfit(t, fidelity) if t > 0 else EndMotion(), EndMotion()

    return Case(
        scene, motion, 12, 18, lambda x: x.filters[0].repeats * x.filters[0].position_misfit > 1e-4
    )


FIDELITIES: tuple[FidelityChoice, ...] = ("torsional", "spatial", "planar", "rigid")
SAVED = CASES | {f"a misfit, {fidelity}": misfit(fidelity) for fidelity in FIDELITIES}
WAITING = test_guards.guarded(Guard(window=0.01, window_delay=0.05))
SAVED["a guard that waits"] = Case(WAITING, going_aside, 3, 7, lambda x: 0.04 < x.guard.time < 0.06)
SAVED["another model since 1 s"] = Case(
    test_fidelity.EVEN,
    partial(test_fidelity.ends_at, z=0.2),
    120,
    121,
    lambda x: x.fidelity == "torsional" and "planar model cannot" in x.fidelity_reason,
    forms=("native",),
)


@cache
def run(name: str, form: Any) -> tuple[BalanceRope, bytes, Any, bytes]:
    """The rope after all steps, and what was saved on the way: bytes, a snapshot, bytes of the end."""
    case = SAVED[name]
    rope = wound(balance_rope(case.scene, form), case.motion, case.saved, case.h)
    saved, kept = rope.save(), rope.snapshot()
    wound(rope, case.motion, case.steps - case.saved, case.h, case.saved)
    return rope, saved, kept, rope.save()


@pytest.mark.parametrize("name", CASES)
def test_both_forms_agree(name: str) -> None:
    case, (python, native) = CASES[name], (run(name, form)[0] for form in ("python", "native"))
    one, other = python.state, native.state
    assert case.acted(other)
    assert one.counts == other.counts
    assert_allclose(one.motion.q, other.motion.q, atol=case.off)
    assert_allclose(one.energy_balance, other.energy_balance, atol=1e3 * case.off)
    assert_allclose(
        one.hysteresis,
        other.hysteresis,
        atol=1e-8 * np.abs(other.hysteresis).max(initial=0.0) + 1e-9,
    )
    assert_allclose(np.hstack(one.contact), np.hstack(other.contact), rtol=1e-6, atol=1e-6)
    for found, expected in (
        (one.errors.position, other.errors.position),
        (one.errors.squares, other.errors.squares),
    ):
        assert_allclose(found, expected, rtol=1e-6)
    # what is missing is a difference of forces
    since = Audit._fields.index("force")
    assert_allclose(one.audit[since:], other.audit[since:], rtol=1e-6, atol=5e-6)
    names = [x for x in native.signals() if x.startswith(("contact.", "clearance.", "nearest."))]
    assert_allclose(
        [*python.signals(names).values()], [*native.signals(names).values()], rtol=1e-6, atol=1e-6
    )
    # the momentum is that of end forces, weight, bodies and air: to Newton's tolerance over the step's square
    if name in ("wind and a floor", "bodies"):
        assert max(one.audit.missing_force, other.audit.missing_force) < 1e-3 * other.audit.force


#: cases with contact, and with wires that slide, of the rope in Python; others hold them
SLOW = [
    (name, "python")
    for name in ("legs that press each other", "wires that slide", "a misfit, planar")
]
PAIRS = [(name, form) for name, case in SAVED.items() for form in case.forms]


@pytest.mark.parametrize(
    ("name", "form"), [pytest.param(*x, marks=[pytest.mark.slow] * (x in SLOW)) for x in PAIRS]
)
def test_a_rope_goes_on_from_a_saved_state_bit_by_bit(name: str, form: Any) -> None:
    case, (rope, saved, kept, end) = SAVED[name], run(name, form)
    assert case.acted(rope.state)
    for again, state in ((rope, kept), (rope, saved), (balance_rope(case.scene, form), saved)):
        again.restore(state)
        assert again.save() == saved
        assert wound(again, case.motion, case.steps - case.saved, case.h, case.saved).save() == end
