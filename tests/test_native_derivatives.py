"""The native rope's derivatives and added mass are those of its steps and of the Python rope."""

from ctypes import c_double
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import Ends, wound

from rope_model import EndMotion, Rope, RopeSimulator, Scene, Swivel
from rope_model.engine import NativeRope
from rope_model.parameters import Attachment
from rope_model.simulation.outputs.sensitivity import LOADS, load_derivative
from rope_model.solver_parameters import FidelityChoice, Inputs, Model, Solver, Trusted


def native_derivative(rope: NativeRope, side: int, name: str, at_step_end: bool = True) -> list[float]:
    """Derivatives of LOADS to an input of one side, as an FMU gives them."""
    lib, handle, *_ = rope.library
    found, fields = (c_double * len(LOADS))(), list(EndMotion.__dataclass_fields__)
    assert lib.rope_load_derivative(handle, len(fields) * side + fields.index(name), at_step_end, found)
    return list(found)


@pytest.mark.parametrize("at_step_end", [True, False])
@pytest.mark.parametrize("trusted", ["all", "position_speed", "position", "speed"])
def test_derivatives_are_those_of_the_inputs_that_are_trusted(trusted: Trusted, at_step_end: bool) -> None:
    """Of an ideal step that ends with the input changed, by differences in both forms; others have none."""
    exact = Solver(tolerance=1e6, newton_tolerance=3e-10)
    scene = Scene(rope=Rope(length=60.0, installed_twist=1.0), inputs=Inputs(trusted), solver=exact)
    h, ends, loads = 0.01, (EndMotion(), EndMotion()), ("left.fx", "left.fy", "left.my", "right.fy")
    places = [LOADS.index(load) for load in loads]
    native, python = (wound(form(scene), lambda _: ends, 1, h) for form in (NativeRope, RopeSimulator))
    state = native.save()
    for name in ("x", "y", "vy", "ay", "yaw", "yaw_rate"):
        found = np.array(native_derivative(native, 0, name, at_step_end))
        # both take differences, of the sizes there
        of_python = load_derivative(python, 0, name, at_step_end)
        assert_allclose(found, of_python, rtol=1e-3, atol=1e-3 * np.abs(found).max(), err_msg=name)
        size = {"x": 5e-9, "y": 5e-9, "vy": 1e-6, "ay": 1e-2, "yaw": 1e-5, "yaw_rate": 1e-3}[name]
        forces = []
        for sign in (1, -1):
            native.restore(state)
            moved = replace(EndMotion(), **{name: sign * size})
            assert native.advance_to(2 * h, moved, ends[1], 2 * h if at_step_end else h).valid
            forces.append([*native.signals(loads).values()])
        native.restore(state)
        differences = (np.array(forces[0]) - np.array(forces[1])) / (2 * size)
        allowed = 2e-3 * np.abs(differences).max() + 1e-7 / size
        assert_allclose(found[places], differences, rtol=2e-3, atol=allowed, err_msg=name)
        kind = "a" if name == "ay" else "v" if name in ("vy", "yaw_rate") else "x"
        assert found.any() == (kind in {"all": "xva", "position_speed": "xv", "position": "x", "speed": "v"}[trusted])


@pytest.mark.parametrize(("fidelity", "held"), [("torsional", "plumb"), ("planar", "plumb"), ("rigid", "clamped")])
@pytest.mark.parametrize("side", [0, 1])
def test_derivatives_are_those_of_the_python_rope(side: int, fidelity: FidelityChoice, held: Attachment) -> None:
    twist = 1.0 if fidelity == "torsional" else 0.0
    # derivatives are those of a whole step, and what Newton's method leaves would show in the differences
    exact = Solver(tolerance=1e6, newton_tolerance=1e-9)
    scene = Scene(rope=Rope(length=60.0, installed_twist=twist), model=Model(fidelity), solver=exact)
    scene = scene.with_(left=Swivel(attachment=held), right=Swivel(attachment=held))

    def lowered(t: float) -> Ends:
        return EndMotion(), EndMotion(y=10.0 - 0.5 * t**3, vy=-1.5 * t**2, ay=-3.0 * t)

    ropes = [wound(form(scene), lowered, 3) for form in (RopeSimulator, NativeRope)]
    for name in EndMotion.__dataclass_fields__:
        found, expected = load_derivative(ropes[0], side, name), np.array(native_derivative(ropes[1], side, name))
        # forces are rounded to some EA / l times the rounding of places, 1e-6 N; a difference over 1e-7 m, 1e-5 m/s ...
        rounding = 1e-6 / (1e-3 if name[0] == "a" else 1e-5 if name[0] == "v" or name == "yaw_rate" else 1e-7)
        assert_allclose(found, expected, rtol=1e-3, atol=1e-3 * np.abs(expected).max() + rounding, err_msg=name)
    assert_allclose(ropes[1].added_mass(), ropes[0].added_mass(), rtol=1e-9 if fidelity == "rigid" else 1e-3)
    # the longer leg, and half of the bend with the height, of the rope below the end with its acceleration
    assert fidelity != "rigid" or native_derivative(ropes[1], side, "ay")[6 * side + 1] < -100.0


def test_added_mass_is_the_derivative_along_an_acceleration_held_over_the_last_step() -> None:
    # of y, vy and ay together, as docs/reference/variables.md says
    h = 0.01
    rope = wound(NativeRope(Scene(rope=Rope(length=60.0))), lambda _: (EndMotion(), EndMotion()), 1, h)
    for side, mass in enumerate(rope.added_mass()):
        by_y, by_vy, by_ay = (native_derivative(rope, side, name)[6 * side + 1] for name in ("y", "vy", "ay"))
        assert_allclose(-(by_ay + h * by_vy + 0.5 * h**2 * by_y), mass, rtol=1e-4)
        assert abs(by_ay) < 0.1 * mass
