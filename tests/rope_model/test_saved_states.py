"""The rope under all that may act on it goes on from a saved state bit by bit."""

import ctypes
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import air_scenes
import contact_scenes
import curved_scenes
import fidelity_scenes
import guard_scenes
import pytest
import self_contact_scenes
import wire_scenes
from scenes import Ends, going_aside, hung, past_each_other, wound
from unfit_motions import unfit

from rope_model import (
    EndMotion,
    Guard,
    Mesh,
    Model,
    Rope,
    RopeState,
    Scene,
    balance_rope,
)
from rope_model.codegen.state_structures import EventStructure, StateStructure
from rope_model.solver_parameters import FidelityChoice


@dataclass(frozen=True)
class Case:
    """A scene, the motion of its ends, steps (of ``h``, s) until it is saved and in all, and what has acted by then."""

    scene: Scene
    motion: Callable[[float], Ends]
    saved: int
    steps: int
    acted: Callable[[RopeState], Any]
    h: float = 0.01


def twisting(t: float) -> Ends:
    return (self_contact_scenes.end(t, 1.5, 2.0),) * 2


CROSS_WIND = {
    "density": 1.2,
    "vx": 10.0,
    "vy": -3.0,
    "vz": 12.0,
    "cross_y": -2.0,
    "cross_height": 2.0,
}
BLOWN = air_scenes.scene(**CROSS_WIND, buffet=1.0, buffet_length=2.0)
CURVED = curved_scenes.scene
WIRES = wire_scenes.scene()
#: its errors halve steps
STRICT = WIRES.with_(solver=replace(WIRES.solver, tolerance=1e-3, newton_tolerance=1e-8))
CASES = {
    # it drives the rope
    "wind and a floor": Case(
        BLOWN, air_scenes.ends, 15, 30, lambda x: x.energy_balance.given_to_air < -0.1
    ),
    "bodies": Case(
        contact_scenes.narrow(),
        contact_scenes.ends,
        15,
        21,
        lambda x: x.energy_balance.dissipated_contact > 0.01,
    ),
    "legs that press each other": Case(
        self_contact_scenes.twisted(),
        twisting,
        81,
        84,
        lambda x: x.energy_balance.dissipated_contact > 1.0,
    ),
    "curved and twisted": Case(
        CURVED(installed_twist=1.0), past_each_other, 12, 16, lambda x: abs(x.loop_yaw) > 0.1
    ),
    "curved, with wires that slide": Case(
        CURVED(EI_stick=3000.0, slip_moment=2.0),
        past_each_other,
        12,
        16,
        lambda x: x.hysteresis.any(),
    ),
    "wires that slide": Case(STRICT, past_each_other, 2, 3, lambda x: x.counts.steps > 8, 0.02),
}


def misfit(fidelity: FidelityChoice) -> Case:
    rope = Rope(length=60.0)
    if fidelity != "torsional":
        rope = replace(rope, Qb=0.0, Qc=0.0)
    # sixteen elements: other tests compile them, too
    scene = Scene(rope=rope, mesh=Mesh("eem", elements=16), model=Model(fidelity))

    def motion(t: float) -> Ends:
        if t > 0:
            return unfit(t, fidelity), EndMotion()
        return EndMotion(), EndMotion()

    def repeats_and_errs(state: RopeState) -> bool:
        end_filter = state.filters[0]
        return end_filter.repetitions.number * end_filter.misfits.position > 1e-4

    return Case(scene, motion, 12, 18, repeats_and_errs)


FIDELITIES: tuple[FidelityChoice, ...] = ("torsional", "spatial", "planar", "rigid")
CASES |= {f"a misfit, {fidelity}": misfit(fidelity) for fidelity in FIDELITIES}
WAITING = guard_scenes.guarded(Guard(window=0.01, window_delay=0.05))
CASES["a guard that waits"] = Case(WAITING, going_aside, 3, 7, lambda x: 0.04 < x.guard.time < 0.06)
CASES["another model since 1 s"] = Case(
    fidelity_scenes.EVEN,
    partial(fidelity_scenes.ends_at, z=0.2),
    120,
    121,
    lambda x: x.fidelity == "torsional" and "planar model cannot" in x.fidelity_reason,
)


@pytest.mark.parametrize("name", CASES)
def test_a_rope_goes_on_from_a_saved_state_bit_by_bit(name: str) -> None:
    case = CASES[name]
    rope = wound(balance_rope(case.scene), case.motion, case.saved, case.h)
    saved = rope.save()
    kept = rope.snapshot()
    assert kept.to_bytes() == saved
    added_mass = rope.added_mass()
    rest = case.motion, case.steps - case.saved, case.h, case.saved
    end = wound(rope, *rest).save()
    assert case.acted(rope.state)
    for again, state in ((rope, kept), (rope, saved), (balance_rope(case.scene), saved)):
        again.restore(state)
        assert again.save() == saved
        assert again.added_mass() == added_mass
        assert wound(again, *rest).save() == end


def test_saved_states_belong_to_their_fixed_parameters_alone() -> None:
    scene = Scene(rope=Rope(length=60.0), model=Model("rigid"))
    stiffer = scene.with_(rope=replace(scene.rope, Qa=2 * scene.rope.Qa))
    tuned = scene.with_(solver=replace(scene.solver, step_max=0.5 * scene.solver.step_max))
    rope = hung(balance_rope(scene))
    other = balance_rope(stiffer)
    for state in (rope.save(), rope.snapshot()):
        with pytest.raises(ValueError, match=r"another rope: rope\.Qa = .* must be .* same param"):
            other.restore(state)
        fitting = balance_rope(tuned)
        fitting.restore(state)
        assert fitting.snapshot().kept == rope.snapshot().kept


def test_each_form_refuses_the_states_of_the_other_in_a_sentence() -> None:
    scene = Scene(rope=Rope(length=20.0), mesh=Mesh("eem", elements=16))
    native = hung(balance_rope(scene))
    reference = hung(balance_rope(scene, "reference"))
    for rope, other in ((native, reference), (reference, native)):
        before = rope.save()
        sentence = f"a state of the {other.form} rope and must be one of the {rope.form} rope"
        for state in (other.save(), other.snapshot()):
            with pytest.raises(ValueError, match=sentence):
                rope.restore(state)
        with pytest.raises(ValueError, match=f"must be a .* one of the {rope.form} rope"):
            rope.restore(other.state)
        assert rope.save() == before


def test_bytes_that_are_no_saved_state_of_this_version_are_refused() -> None:
    scene = Scene(rope=Rope(length=60.0), model=Model("rigid"))
    rope = hung(balance_rope(scene))
    saved = rope.save()
    for wrong in (b"", b"x", b"balance rope state []\n", saved[9:]):
        with pytest.raises(ValueError, match=r"must be a saved state of a rope: give .* save\(\)"):
            rope.restore(wrong)
    label, _, state = saved.partition(b"\n")
    with pytest.raises(ValueError, match="the layout of another version"):
        rope.restore(label + b"\n" + bytes([state[0] ^ 1]) + state[1:])
    with pytest.raises(ValueError, match="the parameters of another version"):
        rope.restore(label.replace(b'"rope.Qa"', b'"rope.QA"') + b"\n" + state)
    with pytest.raises(ValueError, match="bytes"):
        rope.restore(saved[:-8])
    assert rope.save() == saved


@pytest.mark.parametrize("name", ["wind and a floor", "bodies"])
def test_the_momentum_is_that_of_end_forces_weight_bodies_and_air(name: str) -> None:
    """To Newton's tolerance over the step's square."""
    case = CASES[name]
    audit = wound(balance_rope(case.scene), case.motion, case.steps, case.h).state.audit
    assert audit.missing_force < 1e-3 * audit.force


def _real_offsets(kind: Any, start: int = 0) -> Iterator[int]:
    """Return the offsets of all real numbers in a structure of ctypes, those of events apart."""
    if kind is ctypes.c_double:
        yield start
    elif issubclass(kind, ctypes.Array):
        for k in range(kind._length_):
            yield from _real_offsets(kind._type_, start + k * ctypes.sizeof(kind._type_))
    elif issubclass(kind, ctypes.Structure) and kind is not EventStructure:
        for name, of in kind._fields_:
            yield from _real_offsets(of, start + getattr(kind, name).offset)


def test_a_state_is_refused_whichever_of_its_numbers_is_none() -> None:
    case = CASES["a guard that waits"]
    rope = wound(balance_rope(case.scene), case.motion, 2, case.h)
    saved = rope.native_state()
    assert rope.restore_native(saved).valid
    not_a_number = bytes(ctypes.c_double(float("nan")))
    offsets = list(_real_offsets(StateStructure))
    assert len(offsets) > 300
    for offset in offsets:
        damaged = saved[:offset] + not_a_number + saved[offset + len(not_a_number) :]
        assert not rope.restore_native(damaged).valid, offset
