"""Matrices, frames and facts of the engine's present state, from which linear models and modes are made."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hoist_demo.run import at_rest
from rope_model import EndMotion, Model, Rope, Scene, Swivel, rope_120
from rope_model.analysis.chain_matrices import of_blocks
from rope_model.analysis.linear import linear_rope
from rope_model.analysis.modes import natural_modes
from rope_model.engine import NativeRope

ENDS = EndMotion(y=10.0), EndMotion(y=-10.0)
FREE = Swivel(mode="free")


#: the complete model, as a rope without torque would be computed as planar
def hung(rope: Rope, fidelity: str = "torsional", **more: Swivel) -> NativeRope:
    model = Model(fidelity)  # type: ignore[arg-type]
    engine = NativeRope(Scene(rope=rope, model=model, **more))
    status = engine.initialize(0.0, *ENDS)
    assert status.valid, status.message
    return engine


@pytest.mark.parametrize("curvature", [0.0, 0.3])
def test_the_tangent_is_the_derivative_of_the_residual_by_the_element_s_functions(
    curvature: float,
) -> None:
    # equal coupling: the whole residual is the derivative of an energy
    engine = hung(Rope(Qb=2e5, Qc=2e5, initial_curvature=curvature), right=Swivel(inertia=0.3))
    model = linear_rope(engine)
    for given, expected in (("q", model.stiffness), ("v", model.damping), ("a", model.mass)):
        found = of_blocks(*engine.tangent(**{given: 1.0})).toarray()
        # rounding of sums of 1e2 terms, over the largest entry
        largest = np.abs(expected.toarray()).max()
        assert_allclose(found, expected.toarray(), rtol=0, atol=1e-11 * largest)
    assert engine.tangent(a=1.0).nodes[-1, 6, 6] > 0.3


def test_a_look_at_the_matrices_changes_no_bit_of_the_run() -> None:
    looked, alone = (NativeRope(rope_120("draft").scene) for _ in range(2))
    for rope in (looked, alone):
        assert rope.initialize(0.0, EndMotion(), EndMotion()).valid
    for k in range(1, 20):
        t = 0.02 * k
        rises = EndMotion(y=0.1 * t**3, vy=0.3 * t**2, ay=0.6 * t)
        for rope in (looked, alone):
            assert rope.advance_to(t, rises, EndMotion()).valid
        looked.tangent(q=1.0, a=1.0)
        looked.linear_facts()
        if looked.fidelity == "torsional":
            looked.frames()
    assert_array_equal(looked.state.motion.q, alone.state.motion.q)


def test_a_planar_rope_has_the_modes_of_the_complete_one() -> None:
    uncoupled = Rope(Qb=0.0, Qc=0.0)
    planar, torsional = (
        hung(uncoupled, fidelity, left=FREE, right=FREE) for fidelity in ("planar", "torsional")
    )
    # both equilibria are exact to 1e-11 of the rope's length
    expected = natural_modes(torsional, 4).frequencies
    assert_allclose(natural_modes(planar, 4).frequencies, expected, rtol=1e-6)
    with pytest.raises(ValueError, match=r"a planar rope has no frames: set model\.fidelity"):
        planar.frames()
    with pytest.raises(ValueError, match="a rigid rope has no modes: set"):
        natural_modes(hung(uncoupled, "rigid"))


def test_a_rope_whose_wires_rub_has_a_linear_model_with_a_free_swivel() -> None:
    rope = Rope(EI_stick=3000.0, installed_twist=1.0)
    engine = hung(rope, left=Swivel(mode="locked"), right=FREE)
    assert not engine.linear_facts().free[-1, 6]
    assert engine.release_free_swivels().valid
    assert engine.linear_facts().rubs
    assert engine.linear_facts().free[-1, 6]
    assert abs(engine.signals(["left.my"])["left.my"]) < 1e-6
    modes = natural_modes(engine, 4)
    assert modes.frequencies[0] > 0.01
    assert linear_rope(engine).free.sum() == modes.shapes[0].size - 11


def test_a_rope_that_may_spin_as_a_whole_flows_as_one_that_may_not() -> None:
    models = []
    for left in (Swivel(mode="locked"), FREE):
        engine = hung(Rope(Qb=0.0, Qc=0.0), left=left, right=FREE)
        assert engine.release_free_swivels().valid
        models.append(linear_rope(engine, speed=6.0))
    one, both = models
    assert both.free.sum() == one.free.sum() + 1
    assert_allclose(both.rest, one.rest, rtol=1e-7, atol=1e-6)
    scale = np.abs(one.stiffness.toarray()).max()
    assert_allclose(both.stiffness.toarray(), one.stiffness.toarray(), rtol=0, atol=1e-9 * scale)


def test_a_swivel_that_slips_without_friction_has_the_linear_model_of_a_free_one() -> None:
    models = []
    for left in (FREE, Swivel(mode="coulomb", mu_static=0.0, mu_kinetic=0.0)):
        engine = hung(Rope(), left=left)
        assert engine.advance_to(0.01, *ENDS).valid
        models.append(linear_rope(engine))
    free, frictionless = models
    assert_array_equal(frictionless.free, free.free)
    assert_array_equal(frictionless.stiffness.toarray(), free.stiffness.toarray())


def test_a_rope_without_torsion_has_no_linear_model() -> None:
    with pytest.raises(ValueError, match=r"model\.fidelity must be 'torsional'"):
        linear_rope(hung(Rope(Qb=0.0, Qc=0.0), "planar"))


# the model is the claim
def test_frequencies_of_a_hoist_s_rope_do_not_depend_on_the_model_that_is_wound() -> None:
    scene = rope_120("draft").scene
    scene = scene.with_(rope=Rope(length=120.0, Qb=0.0, Qc=0.0))
    shown = {
        at_rest._lowest_modes(scene.with_(model=Model(fidelity)), 90.0)
        for fidelity in ("auto", "planar", "torsional")
    }
    assert len(shown) == 1
    assert len(shown.pop()) == at_rest.MODES
