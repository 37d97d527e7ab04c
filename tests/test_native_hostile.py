"""The native FMU with the rope in it refuses absurd parameters, steps, times and states, or takes them without harm."""

import ctypes
import math
import struct

import pytest
from native_libraries import VERSIONS, hostile
from native_raw import ERROR, OK, SMALL, Instance, Library, reseal

from fmu_src.native.build import available_platforms

if not available_platforms():
    pytest.skip("no compiler builds the native FMU here", allow_module_level=True)


# values and times


@pytest.mark.parametrize(
    ("version", "every"), [(3, 3), *(pytest.param(version, 1, marks=pytest.mark.slow) for version in (2, 3))]
)
def test_absurd_parameters_are_refused_with_name_value_and_cure(
    libraries: dict[int, Library], version: int, every: int
) -> None:
    """``every`` so many of a parameter's absurd values, others for each."""
    library = libraries[version]
    rope = Instance(library)
    refused = 0
    for number, (name, variable) in enumerate(library.variables.items()):
        if variable.causality != "parameter" or variable.type == "Boolean" or variable.dimensions:
            continue
        for value in hostile(name, variable.type)[number % every :: every]:
            whole = variable.type not in ("Real", "Float64")
            least, most = (None if b is None else float(b) for b in (variable.min, variable.max))
            out = (
                not math.isfinite(value) or (least is not None and value < least) or (most is not None and value > most)
            )
            status = rope.hang(SMALL | {name: int(value) if whole else value})
            if status == OK and out:
                pytest.fail(f"{name} = {value} was accepted")
            if status == OK:
                assert all(map(math.isfinite, rope.forces())), (name, value)
                continue
            refused += 1
            message = rope.said[-1]
            if out:
                assert name.split(".")[-1] in message or "element count" in message, (name, value, message)
                assert (str(int(value)) if whole else f"{value:.0e}".split("e")[0]) in message, (name, value, message)
            assert ";" in message or ": " in message, (name, value, message)
    assert rope.hang() == OK
    rope.free()
    assert refused > 100


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("h", "words"),
    [
        (0.0, "not positive"), (-0.01, "-0.01"), (math.nan, "nan"), (math.inf, "inf"), (1e300, "1e+300"),
        (1e6, "communicate every 400 s"),
    ],
)  # fmt: skip
def test_absurd_steps_are_refused_with_the_bound_and_a_reset_helps(
    libraries: dict[int, Library], version: int, h: float, words: str
) -> None:
    rope = Instance(libraries[version])
    assert rope.hang() == OK
    before = rope.forces()
    assert rope.step(0.0, h) == ERROR
    assert words in rope.said[-1]
    assert rope.hang() == OK
    assert rope.forces() == before
    rope.free()


@pytest.mark.parametrize("start", [1e300, -1e11, math.nan])
def test_start_times_that_leave_no_room_for_steps_are_refused(library: Library, start: float) -> None:
    rope = Instance(library)
    assert rope.hang(SMALL, start) == ERROR
    assert "start time" in rope.said[-1]
    rope.free()


def test_a_run_that_starts_late_goes_on_though_time_is_coarse(library: Library) -> None:
    """At 2e9 s neighbouring numbers are further apart than the width to which instants are sought."""
    rope, late = Instance(library), 2e9
    assert rope.hang({"right.y": 0.0, "inputs_at_step_end": 1}, late) == OK
    for k in range(40):
        assert rope.move(0.02 * k, 0.02, 3.0, since=late) == OK
    assert rope.real("energy.transformations") != 0
    rope.free()


# states


@pytest.mark.parametrize(("kind", "stride"), [(1, 8), (0, 34), pytest.param(0, 1, marks=pytest.mark.slow)])
def test_hostile_states_are_refused_or_step_without_harm(library: Library, kind: int, stride: int) -> None:
    """Each word of a state in turn becomes a hostile number, and the checksum fits."""
    rope, state = Instance(library), ctypes.c_void_p()
    assert rope.hang(SMALL | {"mesh.kind": kind, "left.swivel.mode": 2, "rope.installed_twist": 1.0}) == OK
    lived_before = [rope.move(0.02 * k, 0.02) for k in range(5)]
    assert lived_before == [OK] * 5
    assert rope.save(state) == OK
    data, good = rope.write(state), ctypes.c_void_p(state.value)
    words = [struct.pack("<d", x) for x in (math.nan, math.inf, -1e300, 1e-300, 1e300)]
    words += [struct.pack("<ii", 2**31 - 1, -1), struct.pack("<ii", -(2**31), 7), struct.pack("<q", 2**62)]
    accepted = 0
    for number, place in enumerate(range(24, len(data) - 8, 8 * stride)):  # behind the checksum
        word = words[number % len(words)]
        bad = ctypes.c_void_p()
        if rope.read(reseal(data[:place] + word + data[place + 8 :]), bad) == ERROR:
            continue
        if rope.restore(bad) == OK:
            accepted += 1
            if rope.move(0.1, 0.02) == OK:
                assert all(map(math.isfinite, rope.forces())), place
        assert rope.forget(bad) == OK
        assert rope.restore(good) == OK
    assert accepted > 0  # an acceleration may have any size
    expected = rope.move(0.1, 0.02), rope.forces()
    assert rope.restore(good) == OK
    assert (rope.move(0.1, 0.02), rope.forces()) == expected
    assert rope.forget(good) == OK
    rope.free()


def test_a_state_on_other_elements_is_refused(library: Library) -> None:
    """Element lengths and arc lengths, at the state's end, are those of the mesh."""
    rope, state, bad = Instance(library), ctypes.c_void_p(), ctypes.c_void_p()
    assert rope.hang() == OK
    assert rope.save(state) == OK
    data = rope.write(state)
    for word in range(1, 9 + 10 + 1):
        at = len(data) - 8 * word
        (value,) = struct.unpack_from("<d", data, at)
        for other in (value + 1e-6, -value - 1.0, math.nan):
            assert rope.read(reseal(data[:at] + struct.pack("<d", other) + data[at + 8 :]), bad) == OK
            assert rope.restore(bad) == ERROR
            assert "not a state of this rope; save one anew" in rope.said[-1]
            assert rope.forget(bad) == OK
    assert rope.restore(state) == OK
    assert rope.forget(state) == OK
    rope.free()
