"""The engine's checks of motions, parameters and models say what is wrong; parameters and models as the tables do."""

import ctypes as ct
import dataclasses
import math
from collections.abc import Iterator
from typing import Any, get_args

import numpy as np
import pytest
from end_paths import NO_MEASURES, Follower
from fidelity_choice import choose_fidelity, lowest_sufficient, unsupported_motion
from hypothesis import example, given
from hypothesis import strategies as st
from native_parts import compiled, refusal, stale_input_error
from numpy.testing import assert_allclose
from scenes import CHOICES as WINDINGS
from scenes import Choice
from shared import Array

from fmu_src.interface import variables
from rope_model import Rope, RopeCase, Scene, Swivel, scene_names
from rope_model.boundary.end_paths import MOTION_BOUNDS, EndMotion
from rope_model.boundary.input_filter import InputFilter, Repetitions
from rope_model.codegen.structures import EndMotionStructure, SceneStructure, scene_structure
from rope_model.fidelity.choice import FIDELITIES
from rope_model.physics.node import SIDES
from rope_model.shaft_parameters import PARTS as PARTS_OF_SHAFT
from rope_model.solver_parameters import FidelityChoice, Inputs, Model

Ends = tuple[EndMotion, EndMotion]

MESSAGE = 512
ROUNDING = 1e-12
#: the codes of the fidelities
FIDELITY_NAMES = get_args(FidelityChoice)
FREE = Swivel(mode="free")
RELEASED = Swivel(mode="free", release_time=20.0)


@pytest.fixture(scope="module")
def native(tmp_path_factory: pytest.TempPathFactory) -> Any:
    library = compiled(tmp_path_factory.mktemp("native"), {})
    texts = (library.text_number, library.text_exact, library.text_short)
    for function in (*texts, library.fidelity_name):
        function.restype = ct.c_char_p
    return library


def text_of(function: Any, *arguments: Any) -> str:
    message = ct.create_string_buffer(b"?" * (MESSAGE - 1))
    function(*arguments, message)
    return message.value.decode()


def c_end(end: EndMotion) -> EndMotionStructure:
    return EndMotionStructure(*dataclasses.astuple(end))


def ends_of(ends: Ends) -> Any:
    return (EndMotionStructure * 2)(*map(c_end, ends))


def pointer(x: Array) -> Any:
    return x.ctypes.data_as(ct.POINTER(ct.c_double))


def same(ours: Array, theirs: Array, size: float = 1.0) -> None:
    assert_allclose(ours, theirs, rtol=ROUNDING, atol=ROUNDING * size)


reals = st.floats(allow_nan=True, allow_infinity=True)
coordinates = st.floats(-50.0, 50.0)


@given(reals, st.integers(1, 8))
@example(2.0**-44, 8)  # below a power of two the nearest short text belongs to another number
def test_numbers_are_written_as_python_writes_them(native: Any, x: float, digits: int) -> None:
    room = ct.create_string_buffer(40)
    assert native.text_number(room, ct.c_double(x), digits).decode() == f"{x:.{digits}g}"
    assert native.text_exact(room, ct.c_double(x)).decode() == repr(x)
    assert native.text_short(room, ct.c_double(x)).decode() == repr(x).removesuffix(".0")


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(EndMotion)])
@pytest.mark.parametrize("side", SIDES)
def test_an_end_out_of_bounds_is_refused_by_its_name_and_bound(side: str, name: str) -> None:
    bound = MOTION_BOUNDS[name]
    for value in (math.nan, math.inf, -math.inf, -100000.25, 1.234567e9):
        said = refusal(Scene(), EndMotion(**{name: value}), NO_MEASURES, side)
        assert f"{side}.{name} = " in said
        assert ("beyond" if math.isfinite(value) else "not finite") in said
    if not name.startswith("lean"):  # for clamps alone
        for value in (bound, -bound, 0.5 * bound):
            assert refusal(Scene(), EndMotion(**{name: value}), NO_MEASURES, side) == ""
        beyond = EndMotion(**{name: math.nextafter(bound, math.inf)})
        assert f"{side}.{name} = " in refusal(Scene(), beyond, NO_MEASURES, side)


@pytest.mark.parametrize("name", ["x", "y", "z", "yaw", "vx", "vy", "vz", "yaw_rate"])
def test_a_motion_that_does_not_fit_together_is_refused_with_the_bound(name: str) -> None:
    # a yaw's acceleration is not given, but follows from its rate
    bound = "misfit_max"
    if name == "yaw_rate":
        bound = "acceleration_max"
    told = []
    for value in (0.001, 0.4321, 0.6, 50.0):
        target = EndMotion(**{name: value})
        told.append(refusal(Scene(), target, Follower().step(0.02, target).measures, "right"))
    assert told[0] == ""
    assert f"inputs.{bound}" in told[-1]
    assert "right." in told[-1]


def test_an_acceleration_that_is_too_large_is_refused() -> None:
    measures = NO_MEASURES._replace(peaks=(0.0, 1.0, 5.0, 5.0, 5.0, 100.1))
    said = refusal(Scene(), EndMotion(), measures, "left")
    assert "left.lean_z and its derivatives" in said
    assert "inputs.acceleration_max = 100" in said


def test_a_signal_that_stands_still_for_longer_than_it_may_is_refused() -> None:
    inputs = Inputs()
    end_filter = InputFilter(given_at=1.0, repetitions=Repetitions(held=7.0))
    latest = 1.0 + inputs.hold_max
    assert stale_input_error(inputs, 0.5 * (1.0 + latest), end_filter, "right") == ""
    said = stale_input_error(inputs, latest + 0.5, end_filter, "right")
    assert "right" in said
    assert "inputs.hold_max" in said


def with_values(scene: Scene, values: dict[str, float]) -> SceneStructure:
    structure = scene_structure(scene)
    for name, value in values.items():
        *groups, field = name.split(".")
        if groups[-1] == "swivel":
            group = structure.swivels[SIDES.index(groups[0])]
        else:
            parent = structure.shaft if groups[0] in PARTS_OF_SHAFT else structure
            group = getattr(parent, groups[0])
        if field.startswith("counts"):
            group.counts[int(field[-2]) - 1] = value
        else:
            setattr(group, field, value)
    return structure


def message_of(values: dict[str, Any]) -> str:
    try:
        scene_names.scene_with_values(
            Scene(), {n: x for n, x in values.items() if n != "inputs_at_step_end"}
        )
    except ValueError as error:
        return str(error)
    return ""


TABLE = [
    variable
    for variable in variables(RopeCase(Scene(), 0.0, 1.0))
    if variable.causality == "parameter"
]
PARAMETERS: dict[str, Any] = {x.name: x.start for x in TABLE if not x.name.startswith("inputs")}
WHOLE = [x for x in variables(RopeCase(Scene(rope=Rope(EI=300)), 0.0, 1.0)) if x.name == "rope.EI"]
REALS = (
    *(
        math.nan,
        math.inf,
        -math.inf,
        -1.0,
        0.0,
        5e-324,
        1e-5,
        9.9e-6,
        1e-3,
        1.001e-3,
        0.0017,
        0.02,
        1.0,
        1.0000001,
    ),
    *(1e4, 10000.1, 3e5, 1.1e6),
)
INTEGERS = (-2147483648, -1, 0, 1, 2, 3, 4, 5, 6, 8, 9, 20000, 20001)


@pytest.mark.parametrize("name", sorted(PARAMETERS))
def test_parameter_out_of_range_is_refused_with_the_same_message(native: Any, name: str) -> None:
    refused = 0
    values = REALS if isinstance(PARAMETERS[name], float) else INTEGERS
    for value in values:
        message = message_of(PARAMETERS | {name: value})
        assert text_of(native.check_scene, ct.byref(with_values(Scene(), {name: value}))) == message
        refused += bool(message)
    assert refused
    assert (WHOLE[0].kind, type(WHOLE[0].start)) == ("Real", float)


def scenes() -> Iterator[Any]:
    short = Rope(length=30.0, Qb=0.0, Qc=0.0)
    ropes = {
        "uncoupled": short,
        "coupled": Rope(length=30.0),
        "long": Rope(length=240.0),
        "twisted": dataclasses.replace(short, installed_twist=1.0),
        "non-conservative": dataclasses.replace(short, Qb=1e3, Qc=-1e3),
        "twisted far": Rope(length=120.0, installed_twist=-300.0),
    }
    for rope_name, rope in ropes.items():
        for swivel_name, swivel in {"held": Swivel(), "free": FREE, "released": RELEASED}.items():
            yield pytest.param(
                Scene(rope=rope, left=swivel, right=swivel), id=f"{rope_name}, {swivel_name}"
            )
    yield pytest.param(Scene(left=Swivel(mode="coulomb"), right=FREE), id="coulomb and free")
    yield pytest.param(Scene(rope=short, left=FREE, right=RELEASED), id="free and released")
    yield pytest.param(Scene(rope=short, left=RELEASED, right=FREE), id="released and free")


ENDS: tuple[Ends, ...] = (
    (EndMotion(), EndMotion(y=12.0)),
    *(
        (EndMotion(y=2.0, **{name: 0.123456789}), EndMotion(y=9.0))
        for name in ("z", "vz", "az", "yaw", "yaw_rate")
    ),
    *(
        (EndMotion(y=2.0), EndMotion(y=9.0, **{name: -1e-9}))
        for name in ("x", "vx", "ax", "z", "yaw_rate")
    ),
    (EndMotion(vy=18.0, ay=5.0), EndMotion(y=10.0, vy=-18.0, ay=-5.0)),
    (EndMotion(ay=-15.0), EndMotion(y=10.0, ay=-15.0)),
    (EndMotion(y=29.0, vy=14.0), EndMotion(ay=0.7)),
)


def assert_same_fidelities(native: Any, scene: Scene, ends: Ends, forces: int = 0) -> None:
    structure = scene_structure(scene)
    c_ends = ends_of(ends)
    choice = choose_fidelity(scene, ends, forces)
    reason = ct.create_string_buffer(MESSAGE)
    assert (
        FIDELITY_NAMES[native.choose_fidelity(ct.byref(structure), c_ends, forces, reason)]
        == choice.fidelity
    )
    assert reason.value.decode() == choice.reason
    lowest = FIDELITY_NAMES[native.lowest_sufficient(ct.byref(structure), c_ends, forces)]
    assert lowest == lowest_sufficient(scene, ends, forces)
    for fidelity in FIDELITIES:
        number = FIDELITY_NAMES.index(fidelity)
        ours = text_of(native.unsupported_motion, ct.byref(structure), number, c_ends, forces)
        assert ours == unsupported_motion(scene, fidelity, ends, forces)


@pytest.mark.parametrize("scene", list(scenes()))
@pytest.mark.parametrize("tolerance", [0.0, 1e-5, 2e-3, 0.1, 0.9])
def test_fidelity_and_its_reason_are_the_same(native: Any, scene: Scene, tolerance: float) -> None:
    for ends in ENDS:
        assert_same_fidelities(native, scene.with_(model=Model(force_tolerance=tolerance)), ends)


@pytest.mark.parametrize("fidelity", FIDELITY_NAMES)
def test_fidelity_by_name_is_the_same(native: Any, fidelity: FidelityChoice) -> None:
    for ends in ENDS:
        assert_same_fidelities(
            native, Scene(model=Model(fidelity=fidelity, force_tolerance=0.1)), ends, 2
        )


@pytest.mark.parametrize("case", WINDINGS, ids=[case.title for case in WINDINGS])
def test_fidelities_along_the_windings_of_the_choice_are_the_same(
    native: Any, case: Choice
) -> None:
    for t in np.arange(0.0, case.until, 0.25):
        assert_same_fidelities(native, case.scene, case.ends(float(t)))
