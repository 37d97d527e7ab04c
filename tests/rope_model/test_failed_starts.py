"""Starts that fail on the way: while a rope is hung up, the engine changes its floor and its permanent curvature."""

import ctypes as ct
import os

import pytest
from scenes import hung

from rope_model import Contact, EndMotion, Mesh, Rope, Scene, Shaft, Sump, Swivel
from rope_model.codegen.build import sources
from rope_model.compiler import cache_folder, compile_library, find_compiler
from rope_model.engine import NativeRope, declare

#: a rope that is laid down on a floor, takes its permanent curvature, then its twist, and is hung up
#: again while its left swivel slides
ROPE = Rope(length=12.0, initial_curvature=0.05, installed_twist=2.5, diameter=0.04)
FLOOR = Shaft(sump=Sump(level=-5.0), contact=Contact(stiffness=1e5))
SCENE = Scene(
    ROPE,
    shaft=FLOOR,
    left=Swivel(mode="coulomb", mu_static=1e-5, mu_kinetic=1e-5),
    mesh=Mesh(kind="eem", elements=12),  # enough for a claim that is none of accuracy
)
#: hang.c with a search that fails once the allowed number of equilibria is found
COUNTED = """
int equilibria_allowed = -1;

static RopeStatus counted(Simulator *sim, State *state, double max_turn, char *message) {
    if (equilibria_allowed == 0) return say_no_equilibrium(message, 0, 0);
    if (equilibria_allowed > 0) equilibria_allowed--;
    return find_equilibrium(sim, state, max_turn, message);
}

"""
#: the comment of the function that calls it
CALLER = "/* Bring the state to an equilibrium at rest"


@pytest.fixture(scope="module")
def library() -> ct.CDLL:
    compiler = find_compiler()
    if os.name != "posix" or compiler is None:
        pytest.skip("needs a C compiler, and a library that shows its variables")
    text = sources()["hang.c"]
    assert text.count("find_equilibrium(") == text.count(CALLER) == 1
    text = text.replace("find_equilibrium(", "counted(").replace(CALLER, COUNTED + CALLER)
    made = compile_library(sources() | {"hang.c": text}, compiler, cache_folder(), "counted")
    return declare(ct.CDLL(str(made)))


@pytest.fixture
def allowed(library: ct.CDLL) -> ct.c_int:
    """Equilibria that a start may still find; -1: any number."""
    number = ct.c_int.in_dll(library, "equilibria_allowed")
    number.value = -1
    return number


def rope_of(library: ct.CDLL, scene: Scene) -> NativeRope:
    class Counted(NativeRope):
        _library = staticmethod(lambda: library)

    return Counted(scene)


@pytest.fixture(scope="module")
def unfailed(library: ct.CDLL) -> tuple[bytes, bytes]:
    """States of a rope at rest and a little later, none of whose starts has failed."""
    rope = hung(rope_of(library, SCENE))
    return rope.native_state(), later(rope)


def later(rope: NativeRope) -> bytes:
    assert rope.advance_to(0.01, EndMotion(), EndMotion()).valid
    return rope.native_state()


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (1, "no equilibrium"),  # beside the floor on its way
        (6, "at 0.025 of a permanent curvature of 0.05 1/m"),
        (12, "at 1 of 2.5 rad of twist"),
        (15, "no equilibrium"),  # beside the floor, while the swivel slides
        (20, "at 0.025 of a permanent curvature of 0.05 1/m"),
    ],
)
def test_a_start_that_fails_on_the_way_leaves_scene_and_rope_as_they_were(
    found: int, words: str, library: ct.CDLL, allowed: ct.c_int, unfailed: tuple[bytes, bytes]
) -> None:
    rope = hung(rope_of(library, SCENE))
    allowed.value = found
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    assert not status.valid
    assert status.message.startswith(words)
    allowed.value = -1
    assert (rope.native_state(), later(rope)) == unfailed
    assert (hung(rope).native_state(), later(rope)) == unfailed
