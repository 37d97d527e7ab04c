"""The native FMU with the rope in it, mistreated: many at once, in threads, without memory, any calls."""

import ctypes
import math
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule, run_state_machine_as_test
from native_libraries import HOSTILE, hostile
from native_raw import ERROR, OK, SMALL, Instance, Library, reseal

from fmu_src.native.build import available_platforms
from fmu_src.native.export import native_table, rope_sources, shell_sources
from fmu_src.native.start import Start, c_start
from fmu_src.native.table import start_values
from rope_model.parameters import rope_120

if not available_platforms():
    pytest.skip("no compiler builds the native FMU here", allow_module_level=True)

ROOT = Path(__file__).resolve().parent.parent
LINUX = sys.platform == "linux"


def live(rope: Instance, steps: int) -> list[tuple[float, ...]]:
    """The forces of steps of 20 ms, over a transformation when there are some fifty of them."""
    record = []
    for k in range(steps):
        assert rope.move(0.02 * k, 0.02, 3.0) == OK, rope.said[-1]
        record.append(rope.forces())
    return record


# many of them


def test_eight_threads_step_eight_instances_as_one_alone(libraries: dict[int, Library]) -> None:
    start = {"right.y": 0.0, "inputs_at_step_end": 1}
    ropes = [Instance(libraries[3]) for _ in range(9)]
    assert [rope.hang(start) for rope in ropes] == [OK] * 9
    alone = live(ropes[8], 50)
    assert ropes[8].real("energy.transformations") != 0
    with ThreadPoolExecutor(8) as threads:
        records = list(threads.map(lambda rope: live(rope, 50), ropes[:8]))
    for rope in ropes:
        rope.free()
    assert all(record == alone for record in records)


# memory and data


def test_nothing_is_taken_from_the_host_after_initialisation(libraries: dict[int, Library]) -> None:
    c = ctypes.CDLL(None)
    c.calloc.restype, c.free.argtypes = ctypes.c_void_p, (ctypes.c_void_p,)
    held: list[int] = []
    taken: list[int] = []

    def take(number: int, size: int) -> int:
        taken.append(number * size)
        held.append(c.calloc(ctypes.c_size_t(number), ctypes.c_size_t(size)))
        return held[-1]

    def give_back(address: int) -> None:
        held.remove(address)
        c.free(address)

    rope, state = Instance(libraries[2], (take, give_back)), ctypes.c_void_p()
    assert rope.hang({"right.y": 0.0, "inputs_at_step_end": 1}) == OK
    before = len(taken)
    assert before <= 5  # instance, component, model, simulator, and its arrays in one piece
    live(rope, 60)
    assert rope.real("energy.transformations") != 0
    assert rope.real("left.added_mass") > 0
    known, unknown = (ctypes.c_uint(rope.library.variables[n].valueReference) for n in ("left.y", "left.fy"))
    seed, value, one = ctypes.c_double(1.0), ctypes.c_double(), ctypes.c_size_t(1)
    arguments = (ctypes.byref(unknown), one, ctypes.byref(known), one, ctypes.byref(seed), ctypes.byref(value))
    assert rope.call("GetDirectionalDerivative", *arguments) == OK
    assert rope.step(math.nan, 0.02) == ERROR
    assert len(taken) == before
    assert rope.save(state) == OK
    assert len(taken) == before + 1  # the state, that is the host's
    assert rope.restore(state) == OK
    assert rope.save(state) == OK  # over the same
    assert len(taken) == before + 1
    assert rope.forget(state) == OK
    rope.free()
    assert held == []


def test_the_library_asks_for_memory_only_where_the_standard_leaves_it_to_the_fmu(library: Library) -> None:
    if not LINUX or (nm := shutil.which("nm")) is None:
        pytest.skip("needs nm, on Linux")
    command = [nm, "-D", "--undefined-only", str(library.path)]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    asked = {line.split()[-1].partition("@")[0] for line in listed.splitlines()}
    memory = {name for name in asked if any(word in name for word in ("alloc", "free", "mmap", "brk"))}
    assert memory == (set() if library.fmi == 2 else {"calloc", "free"})
    assert not asked & {"open", "fopen", "write", "printf", "time", "exit", "abort", "setlocale", "rand", "pthread_create"}  # fmt: skip  # noqa: E501


def own_sources(fmi: int) -> dict[str, str]:
    """The FMU's sources but the rope's."""
    table = native_table(rope_120())
    return shell_sources(table, fmi) | {"start.c": c_start(Start("token", start_values(table, fmi)))}


def compile_sources(folder: Path, files: dict[str, str], *flags: str) -> None:
    """The files, in ``folder``, compiled by cc with ``flags``."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = sorted(name for name in files if name.endswith(".c"))
    subprocess.run(["cc", "-std=gnu99", "-DHAS_WIDE_FORM=0", *flags, *sources, "-lm"], cwd=folder, check=True)


#: what is freed is filled, and what is written beside a block aborts when that is freed
CHECKED_HEAP = {"MALLOC_PERTURB_": "165", "MALLOC_CHECK_": "3", "LD_PRELOAD": "libc_malloc_debug.so.0"}


@pytest.mark.parametrize(
    "checker", ["malloc", *(pytest.param(name, marks=pytest.mark.slow) for name in ("valgrind", "sanitizers"))]
)
def test_a_whole_life_with_failed_calls_is_clean(checker: str, tmp_path: Path) -> None:
    """tests/native/life_cycle.c: two instances, states, refused calls, a failed initialisation, reset, all again."""
    needed = ("cc", "valgrind") if checker == "valgrind" else ("cc",)
    if not LINUX or (missing := [x for x in needed if not shutil.which(x)]):
        pytest.skip(f"needs Linux and {', '.join(needed if not LINUX else missing)}")
    flags = ["-O0"] if checker == "malloc" else ["-g", "-O1"]
    flags += ["-fsanitize=address,undefined", "-fno-sanitize-recover"] if checker == "sanitizers" else []
    compile_sources(
        tmp_path, rope_sources() | own_sources(2), *flags, "-fPIC", "-shared", "-fvisibility=hidden", "-o", "rope.so"
    )
    program = ROOT / "tests" / "native" / "life_cycle.c"
    command = ["cc", "-std=gnu99", *flags, "-I.", str(program), "-o", "life", "-ldl", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    run = ["valgrind", "--quiet", "--leak-check=full", "--error-exitcode=99"] if checker == "valgrind" else []
    done = subprocess.run(
        [*run, "./life", "./rope.so", "token"],
        cwd=tmp_path,
        env=os.environ | (CHECKED_HEAP if checker == "malloc" else {}),
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout.split() == ["0", "0"]


# any calls in any order


class Calls(RuleBasedStateMachine):
    """Two instances and three states; ``library`` and ``expected``, a new rope's forces, are set by the tests."""

    library: Library
    expected: tuple[float, ...]
    which = st.integers(0, 1)
    slot = st.integers(0, 2)
    number = st.one_of(st.sampled_from(HOSTILE), st.floats(-100.0, 100.0), st.floats())

    def __init__(self) -> None:
        super().__init__()
        self.ropes = [Instance(self.library) for _ in range(2)]
        self.times = [0.0, 0.0]
        self.states = [ctypes.c_void_p() for _ in range(3)]
        self.names = sorted(n for n, v in self.library.variables.items() if v.causality in ("parameter", "input"))

    @rule(i=which, kind=st.sampled_from([0, 1]), mode=st.sampled_from([0, 1, 2]), twist=st.sampled_from([0.0, 3.0]))
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
        if self.ropes[i].step(self.times[i] if at_now else t, h) == OK:
            self.times[i] = (self.times[i] if at_now else t) + h

    @rule(i=which, start=number, stop=st.one_of(st.none(), number))
    def enter(self, i: int, start: float, stop: float | None) -> None:
        if self.ropes[i].enter(start, stop) == OK:
            self.times[i] = start

    @rule(i=which, name=st.sampled_from(["ExitInitializationMode", "Terminate", "Reset", "EnterInitializationMode"]))
    def change_mode(self, i: int, name: str) -> None:
        if name == "EnterInitializationMode" and self.library.fmi == 3:
            return
        self.ropes[i].call(name)

    @rule(i=which, data=st.data())
    def set_entry(self, i: int, data: Any) -> None:
        name = data.draw(st.sampled_from(self.names))
        variable = self.library.variables[name]
        if not variable.dimensions:
            kind = {"Enumeration": "Int64"}.get(variable.type, variable.type)
            self.ropes[i].set(name, data.draw(st.sampled_from(hostile(name, kind))))

    @rule(i=which, reference=st.integers(0, 2**32 - 1), value=st.sampled_from([0.0, 1.0]))
    def set_by_wrong_reference(self, i: int, reference: int, value: float) -> None:
        kinds = ("Real", "Integer", "Boolean", "String") if self.library.fmi == 2 else ("Float64", "Int64", "Boolean")
        for kind in kinds:
            self.ropes[i].set("left.y", value, reference % 500 if reference % 3 else reference, kind)

    @rule(
        i=which, name=st.sampled_from(["left.fy", "loop.yaw", "stress.bending_max", "left.added_mass", "energy.total"])
    )
    def get(self, i: int, name: str) -> None:
        self.ropes[i].real(name)

    @rule(i=which, unknown=st.integers(0, 400), known=st.integers(40, 80), seed=number)
    def derivative(self, i: int, unknown: int, known: int, seed: float) -> None:
        u, k, s, value, one = (
            ctypes.c_uint(unknown), ctypes.c_uint(known), ctypes.c_double(seed), ctypes.c_double(), ctypes.c_size_t(1),
        )  # fmt: skip
        sizes = (one,) if self.library.fmi == 3 else ()
        arguments = [ctypes.byref(u), one, ctypes.byref(k), one, ctypes.byref(s), *sizes, ctypes.byref(value), *sizes]
        self.ropes[i].call("GetDirectionalDerivative", *arguments)

    @rule(i=which, slot=slot)
    def save(self, i: int, slot: int) -> None:
        self.ropes[i].save(self.states[slot])

    @rule(i=which, slot=slot)
    def restore(self, i: int, slot: int) -> None:
        self.ropes[i].restore(self.states[slot])

    @rule(i=which, slot=slot)
    def forget(self, i: int, slot: int) -> None:
        assert self.ropes[i].forget(self.states[slot]) == OK
        assert not self.states[slot].value

    @rule(
        i=which,
        slot=slot,
        end=st.one_of(st.none(), st.integers(0, 20000)),
        places=st.lists(st.tuples(st.integers(0, 20000), st.binary(min_size=1, max_size=8)), max_size=4),
        sealed=st.booleans(),
    )
    def damage(self, i: int, slot: int, end: int | None, places: list[tuple[int, bytes]], sealed: bool) -> None:
        if not self.states[slot].value:
            return
        data = bytearray(self.ropes[i].write(self.states[slot]))
        for place, new in places:
            at = place % len(data)
            data[at : at + len(new)] = new[: len(data) - at]
        bad, state = bytes(data[:end]), ctypes.c_void_p()
        if self.ropes[i].read(reseal(bad) if sealed else bad, state) == OK:
            self.ropes[i].restore(state)
            self.ropes[i].forget(state)

    @rule(i=which, name=st.sampled_from(["Get", "Set", "Serialize"]))
    def null_states(self, i: int, name: str) -> None:
        rope = self.ropes[i]
        full = f"{name}FMUstate" if self.library.fmi == 2 else f"{name}FMUState"
        assert rope.call(full, None, None, ctypes.c_size_t(8)) == ERROR

    @rule(i=which, name=st.sampled_from(["Set", "Get"]))
    def null_values(self, i: int, name: str) -> None:
        kind = "Real" if self.library.fmi == 2 else "Float64"
        vr, one = ctypes.c_uint(0), ctypes.c_size_t(1)
        assert self.ropes[i].call(f"{name}{kind}", ctypes.byref(vr), one, None, one) == ERROR
        assert self.ropes[i].call(f"{name}{kind}", None, one, None, one) == ERROR

    def teardown(self) -> None:
        """Whatever happened: after a reset both are as new."""
        for state in self.states:
            assert self.ropes[0].forget(state) == OK
        for rope in self.ropes:
            assert as_new(rope) == self.expected
            rope.free()


def as_new(rope: Instance) -> tuple[float, ...]:
    assert rope.hang(SMALL | {"left.swivel.mode": 2}) == OK, rope.said[-1]
    assert rope.move(0.0, 0.02) == OK
    return rope.forces()


def fuzz(library: Library, examples: int, calls: int) -> None:
    rope = Instance(library)
    expected = as_new(rope)
    rope.free()
    machine = type(f"Calls{library.fmi}", (Calls,), {"library": library, "expected": expected})
    run_state_machine_as_test(
        machine,
        settings=settings(
            max_examples=examples, stateful_step_count=calls, derandomize=True, deadline=None, database=None,
            suppress_health_check=list(HealthCheck),
        ),
    )  # fmt: skip


def test_any_calls_in_any_order_neither_crash_nor_hang_and_a_reset_helps(library: Library) -> None:
    fuzz(library, 20, 40)
