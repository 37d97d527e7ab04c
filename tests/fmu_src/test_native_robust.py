"""The native FMU with the rope in it, mistreated: many at once, without memory, any calls, absurd values and states."""

import ctypes
import ctypes.util
import math
import os
import re
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import fmpy
import pytest
from checkout import NATIVE
from fmpy.fmi2 import fmi2CallbackAllocateMemoryTYPE, fmi2CallbackFreeMemoryTYPE
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule, run_state_machine_as_test
from native_host import ERROR, OK, SMALL, Host, reseal

from fmu_src.shell.build import available_platforms
from fmu_src.shell.sources import HEADERS

if not available_platforms():
    pytest.skip("no compiler builds the native FMU here", allow_module_level=True)

LINUX = sys.platform == "linux"
Fmu = tuple[Path, str]

HOSTILE = [
    math.nan,
    math.inf,
    -math.inf,
    0.0,
    -0.0,
    -1.0,
    5e-324,
    2.2e-308,
    1e-300,
    1e-9,
    1e-3,
    1.0,
    1e3,
    1e9,
    1e300,
]
#: of entries that make large ropes, which are slow, only what is refused or small
TAME: dict[str, list[float]] = {
    "rope.length": [math.nan, math.inf, 0.0, -1.0, 1e-300, 1e-9, 5.0, 60.0, 1e5, 1e300],
    "mesh.coarse_length": [math.nan, 0.0, -1.0, 1e-300, 1e-9, 0.5, 3.0, 1e300],
    "mesh.loop_error": [math.nan, 0.0, -1.0, 1.0, 1e300],
    "mesh.elements": [-1, 0, 1, 2, 3, 50, 20001, 2**31 - 1, -(2**31)],
    "mesh.kind": [-1, 0, 1, 3, 2**31 - 1],
    **{f"mesh.counts[{k}]": [-4, 0, 1, 4, 8, 40, 2**31 - 8] for k in range(1, 6)},
}
WHOLE = [-(2**31), -1, 0, 1, 2, 3, 4, 5, 2**31 - 1]
REALS = ("Real", "Float64")
#: types of variables by FMI version
KINDS = {2: ("Real", "Integer", "Boolean", "String"), 3: ("Float64", "Int64", "Boolean")}
#: C library's functions that ask for memory or give it back, by FMI version
OF_MEMORY: dict[int, set[str]] = {2: set(), 3: {"calloc", "free"}}


def hostile(name: str, kind: str) -> list[float]:
    if name in TAME:
        return TAME[name]
    if kind in REALS:
        return HOSTILE
    return list(map(float, WHOLE))


@pytest.fixture
def fmu(fmi: int, unpacked: Callable[[str], Fmu]) -> Fmu:
    return unpacked(f"native-{fmi}")


def live(rope: Host, steps: int) -> list[tuple[float, ...]]:
    record = []
    for k in range(steps):
        assert rope.move(0.02 * k, 0.02, 3.0) == OK, rope.said[-1]
        record.append(rope.forces())
    return record


def test_eight_threads_step_eight_instances_as_one_alone(unpacked: Callable[[str], Fmu]) -> None:
    start = {"right.y": 0.0, "inputs_at_step_end": 1}
    ropes = [Host(*unpacked("native-3")) for _ in range(9)]
    assert [rope.hang(start) for rope in ropes] == [OK] * 9
    alone = live(ropes[8], 50)
    assert ropes[8].real("energy.transformations") != 0
    with ThreadPoolExecutor(8) as pool:
        records = list(pool.map(lambda rope: live(rope, 50), ropes[:8]))
    for rope in ropes:
        rope.free()
    assert all(record == alone for record in records)


THREADS = 16
STEPS = 10
OUTPUTS = ("left.fy", "right.mx", "loop.y", "energy.kinetic")


def why_no_threads() -> str:
    if sys.platform != "linux" or shutil.which("cc") is None:
        return "needs Linux and a C compiler"
    if _python() is None:
        return "needs this Python's shared library"
    return ""


def _python() -> str | None:
    return ctypes.util.find_library(f"python{sys.version_info.major}.{sys.version_info.minor}")


def run_threads(
    program: Path, fmu: Path, unzipped: Path, threads: int = THREADS
) -> subprocess.CompletedProcess[str]:
    """One run, in a process of its own; a Python FMU finds the packages that this one has."""
    description = fmpy.read_model_description(str(fmu))
    variables = {v.name: v for v in description.modelVariables}
    given = [(variables[name], value) for name, value in SMALL.items()]
    entries = [f"{v.type[0].lower()}:{v.valueReference}:{value}" for v, value in given]
    motion = [variables[f"left.{name}"].valueReference for name in ("y", "vy", "ay")]
    outputs = [variables[name].valueReference for name in OUTPUTS]
    binary = next((unzipped / "binaries").rglob("BalanceRope.so"))
    resources = (unzipped / "resources").resolve().as_uri()
    command = [
        program,
        binary,
        description.guid,
        resources,
        threads,
        STEPS,
        *motion,
        *entries,
        "--",
        *outputs,
    ]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONHOME"}
    environment |= {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "LD_PRELOAD": _python() or "",
    }
    environment |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = list(map(str, command))
    return subprocess.run(
        command, capture_output=True, text=True, timeout=600, check=False, env=environment
    )


@pytest.mark.skipif(why_no_threads() != "", reason=why_no_threads())
@pytest.mark.parametrize(
    ("flavour", "count", "runs"),
    [pytest.param("python", 4, 1, marks=pytest.mark.slow), ("native-2", 16, 2)],
)
def test_many_threads_have_the_bits_of_one(
    flavour: str, count: int, runs: int, fmu_of: Any, tmp_path: Path
) -> None:
    program = tmp_path / "threads"
    fmu = fmu_of(flavour)
    text = NATIVE / "threads.c"
    command = [
        "cc",
        "-std=gnu99",
        "-O1",
        f"-I{HEADERS}",
        text,
        "-o",
        program,
        "-ldl",
        "-lm",
        "-lpthread",
    ]
    subprocess.run(command, check=True)
    unzipped = Path(fmpy.extract(str(fmu), str(tmp_path / "unzipped")))
    for _ in range(runs):
        done = run_threads(program, fmu, unzipped, count)
        assert done.returncode == 0, done.stdout + done.stderr[-3000:]
        assert done.stdout.startswith(f"{count} threads, 40 numbers each, 0 differ")


def test_nothing_is_taken_from_the_host_after_initialisation(
    unpacked: Callable[[str], Fmu],
) -> None:
    c = ctypes.CDLL(None)
    c.calloc.restype = ctypes.c_void_p
    c.free.argtypes = (ctypes.c_void_p,)
    held: list[int] = []
    taken: list[int] = []

    def take(number: int, size: int) -> int:
        taken.append(number * size)
        held.append(c.calloc(ctypes.c_size_t(number), ctypes.c_size_t(size)))
        return held[-1]

    def give_back(address: int) -> None:
        held.remove(address)
        c.free(address)

    memory = fmi2CallbackAllocateMemoryTYPE(take), fmi2CallbackFreeMemoryTYPE(give_back)
    rope = Host(*unpacked("native-2"), memory=memory)
    state = ctypes.c_void_p()
    assert rope.hang({"right.y": 0.0, "inputs_at_step_end": 1}) == OK
    before = len(taken)
    assert before <= 5  # instance, component, model, simulator, and its arrays in one piece
    live(rope, 60)
    assert rope.real("energy.transformations") != 0
    assert rope.real("left.added_mass") > 0
    assert rope.derivative("left.fy", "left.y") != 0
    assert rope.do_step(math.nan, 0.02) == ERROR
    assert len(taken) == before
    assert rope.save(state) == OK
    assert len(taken) == before + 1  # the state, that is the host's
    assert rope.restore(state) == OK
    assert rope.save(state) == OK  # over the same
    assert len(taken) == before + 1
    assert rope.forget(state) == OK
    rope.free()
    assert held == []


def test_the_library_asks_for_memory_only_where_the_standard_leaves_it_to_the_fmu(
    fmu: Fmu, fmi: int
) -> None:
    if not LINUX or (nm := shutil.which("nm")) is None:
        pytest.skip("needs nm, on Linux")
    command = [
        nm,
        "-D",
        "--undefined-only",
        str(next((Path(fmu[1]) / "binaries").rglob("BalanceRope.so"))),
    ]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    asked = {line.split()[-1].partition("@")[0] for line in listed.splitlines()}
    memory = {name for name in asked if re.search("alloc|free|mmap|brk", name)}
    assert memory == OF_MEMORY[fmi]
    assert not asked & {
        "open",
        "fopen",
        "write",
        "printf",
        "time",
        "exit",
        "abort",
        "setlocale",
        "rand",
        "pthread_create",
    }


class Calls(RuleBasedStateMachine):
    """Two instances and three states; ``fmu`` and ``expected``, a new rope's forces, are set by the tests."""

    fmu: Fmu
    expected: tuple[float, ...]
    which = st.integers(0, 1)
    slot = st.integers(0, 2)
    place = st.integers(0, 20000)
    changes = st.lists(st.tuples(place, st.binary(min_size=1, max_size=8)), max_size=4)
    number = st.one_of(st.sampled_from(HOSTILE), st.floats(-100.0, 100.0), st.floats())

    def __init__(self) -> None:
        super().__init__()
        self.ropes = [Host(*self.fmu) for _ in range(2)]
        self.times = [0.0, 0.0]
        self.states = [ctypes.c_void_p() for _ in range(3)]
        self.names = sorted(
            n for n, v in self.ropes[0].variables.items() if v.causality in ("parameter", "input")
        )

    @rule(
        i=which,
        kind=st.sampled_from([0, 1]),
        mode=st.sampled_from([0, 1, 2]),
        twist=st.sampled_from([0.0, 3.0]),
    )
    def hang(self, i: int, kind: int, mode: int, twist: float) -> None:
        more = {"mesh.kind": kind, "left.swivel.mode": mode, "rope.installed_twist": twist}
        assert self.ropes[i].hang(SMALL | more) == OK, self.ropes[i].said[-1]
        self.times[i] = 0.0

    @rule(i=which, steps=st.integers(1, 4), h=st.sampled_from([0.01, 0.02, 0.1]))
    def move(self, i: int, steps: int, h: float) -> None:
        for _ in range(steps):
            if self.ropes[i].move(self.times[i], h) == OK:
                assert all(map(math.isfinite, self.ropes[i].forces()))
                self.times[i] += h

    @rule(i=which, t=number, h=number, at_now=st.booleans())
    def step(self, i: int, t: float, h: float, at_now: bool) -> None:
        if at_now:
            t = self.times[i]
        if self.ropes[i].do_step(t, h) == OK:
            self.times[i] = t + h

    @rule(i=which, start=number, stop=st.one_of(st.none(), number))
    def enter(self, i: int, start: float, stop: float | None) -> None:
        if self.ropes[i].enter(start, stop) == OK:
            self.times[i] = start

    @rule(
        i=which,
        name=st.sampled_from(
            ["ExitInitializationMode", "Terminate", "Reset", "EnterInitializationMode"]
        ),
    )
    def change_mode(self, i: int, name: str) -> None:
        if name == "EnterInitializationMode" and self.ropes[0].fmi == 3:
            return
        self.ropes[i].call(name)

    @rule(i=which, data=st.data())
    def set_entry(self, i: int, data: Any) -> None:
        name = data.draw(st.sampled_from(self.names))
        variable = self.ropes[i].variables[name]
        if not variable.dimensions:
            kind = {"Enumeration": "Int64"}.get(variable.type, variable.type)
            self.ropes[i].put(name, data.draw(st.sampled_from(hostile(name, kind))))

    @rule(i=which, reference=st.integers(0, 2**32 - 1), value=st.sampled_from([0.0, 1.0]))
    def set_by_wrong_reference(self, i: int, reference: int, value: float) -> None:
        if reference % 3:
            reference %= 500  # most are those of variables
        for kind in KINDS[self.ropes[0].fmi]:
            self.ropes[i].put("left.y", value, reference, kind)

    @rule(
        i=which,
        name=st.sampled_from(["left.fy", "loop.yaw", "stress.bending_max", "left.added_mass"]),
    )
    def get(self, i: int, name: str) -> None:
        self.ropes[i].real(name)

    @rule(i=which, unknown=st.integers(0, 400), known=st.integers(40, 80), seed=number)
    def derivative(self, i: int, unknown: int, known: int, seed: float) -> None:
        self.ropes[i].derive(unknown, known, seed)

    @rule(i=which, slot=slot, name=st.sampled_from(["save", "restore"]))
    def keep(self, i: int, slot: int, name: str) -> None:
        getattr(self.ropes[i], name)(self.states[slot])

    @rule(i=which, slot=slot)
    def forget(self, i: int, slot: int) -> None:
        assert self.ropes[i].forget(self.states[slot]) == OK
        assert not self.states[slot].value

    @rule(i=which, slot=slot, end=st.none() | place, places=changes, sealed=st.booleans())
    def damage(
        self, i: int, slot: int, end: int | None, places: list[tuple[int, bytes]], sealed: bool
    ) -> None:
        if not self.states[slot].value:
            return
        data = bytearray(self.ropes[i].write(self.states[slot]))
        for place, new in places:
            at = place % len(data)
            data[at : at + len(new)] = new[: len(data) - at]
        bad = bytes(data[:end])
        state = ctypes.c_void_p()
        if sealed:
            bad = reseal(bad)
        if self.ropes[i].read(bad, state) == OK:
            self.ropes[i].restore(state)
            self.ropes[i].forget(state)

    def teardown(self) -> None:
        """Whatever happened: after a reset both are as new."""
        for state in self.states:
            assert self.ropes[0].forget(state) == OK
        for rope in self.ropes:
            assert as_new(rope) == self.expected
            rope.free()


def as_new(rope: Host) -> tuple[float, ...]:
    assert rope.hang(SMALL | {"left.swivel.mode": 2}) == OK, rope.said[-1]
    assert rope.move(0.0, 0.02) == OK
    return rope.forces()


@pytest.mark.parametrize("fmi", [pytest.param(2, marks=pytest.mark.slow), 3])
def test_any_calls_in_any_order_neither_crash_nor_hang_and_a_reset_helps(fmu: Fmu) -> None:
    rope = Host(*fmu)
    expected = as_new(rope)
    rope.free()
    machine = type("Calls", (Calls,), {"fmu": fmu, "expected": expected})
    bounds = settings(
        max_examples=20,
        stateful_step_count=40,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    run_state_machine_as_test(machine, settings=bounds)


@pytest.mark.parametrize(
    ("version", "every"), [(3, 14), *(pytest.param(v, 1, marks=pytest.mark.slow) for v in (2, 3))]
)
def test_absurd_parameters_are_refused_with_the_cure(
    unpacked: Callable[[str], Fmu], version: int, every: int
) -> None:
    rope = Host(*unpacked(f"native-{version}"))
    refused = 0
    for number, (name, variable) in enumerate(rope.variables.items()):
        if variable.causality != "parameter" or variable.type == "Boolean" or variable.dimensions:
            continue
        for value in hostile(name, variable.type)[number % every :: every]:
            least = -math.inf
            most = math.inf
            if variable.min is not None:
                least = float(variable.min)
            if variable.max is not None:
                most = float(variable.max)
            out = not math.isfinite(value) or value < least or value > most
            if variable.type in REALS:
                digits = f"{value:.0e}".split("e")[0]
            else:
                value = int(value)
                digits = str(value)
            status = rope.hang(SMALL | {name: value})
            if status == OK and out:
                pytest.fail(f"{name} = {value} was accepted")
            if status == OK:
                assert all(map(math.isfinite, rope.forces())), (name, value)
                continue
            refused += 1
            message = rope.said[-1]
            if out:
                assert name.split(".")[-1] in message or "element count" in message, (
                    name,
                    value,
                    message,
                )
                assert digits in message, (name, value, message)
            assert ";" in message or ": " in message, (name, value, message)
    assert rope.hang() == OK
    rope.free()
    assert refused > 50


@pytest.mark.parametrize("start", [1e300, -1e11, math.nan])
def test_start_times_that_leave_no_room_for_steps_are_refused(fmu: Fmu, start: float) -> None:
    rope = Host(*fmu)
    assert rope.hang(SMALL, start) == ERROR
    assert "start time" in rope.said[-1]
    rope.free()


def test_a_run_that_starts_late_goes_on_though_time_is_coarse(fmu: Fmu) -> None:
    """At 2e9 s neighbouring numbers are further apart than the width to which instants are sought."""
    rope = Host(*fmu)
    late = 2e9
    assert rope.hang({"right.y": 0.0, "inputs_at_step_end": 1}, late) == OK
    for k in range(40):
        assert rope.move(0.02 * k, 0.02, 3.0, since=late) == OK
    assert rope.real("energy.transformations") != 0
    rope.free()


@pytest.mark.parametrize("fmi", [pytest.param(2, marks=pytest.mark.slow), 3])
@pytest.mark.parametrize(
    ("kind", "stride"), [(1, 16), (0, 34), pytest.param(0, 1, marks=pytest.mark.slow)]
)
def test_hostile_states_are_refused_or_step_without_harm(fmu: Fmu, kind: int, stride: int) -> None:
    """Each word of a state in turn becomes a hostile number, and the checksum fits."""
    rope = Host(*fmu)
    state = ctypes.c_void_p()
    assert (
        rope.hang(SMALL | {"mesh.kind": kind, "left.swivel.mode": 2, "rope.installed_twist": 1.0})
        == OK
    )
    assert [rope.move(0.02 * k, 0.02) for k in range(5)] == [OK] * 5
    assert rope.save(state) == OK
    data = rope.write(state)
    good = ctypes.c_void_p(state.value)
    words = [struct.pack("<d", x) for x in (math.nan, math.inf, -1e300, 1e-300, 1e300)]
    words += [
        struct.pack("<ii", 2**31 - 1, -1),
        struct.pack("<ii", -(2**31), 7),
        struct.pack("<q", 2**62),
    ]
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
