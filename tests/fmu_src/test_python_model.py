"""The library of the Python flavour with a small model in Python, of which one method fails: no failure is lost."""

import ctypes
import shutil
import sys
from collections.abc import Callable
from itertools import count
from pathlib import Path

import pytest
from exports import FLAVOURS
from native_host import ERROR, OK, WARNING, Host
from shared import Unpacked

pytestmark = [
    pytest.mark.skipif("python" not in FLAVOURS, reason="needs a C compiler"),
    # python_model.c leaves the traceback on standard error
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]
MODEL = '''
class Model:
    """A model without mechanics that does all that python_model.c calls."""

    warnings = 1

    def __init__(self, instance_name, resources):
        self.message = ""
        self.t = 0.0

    def create(self, values, outputs, known):
        return True

    def initialize(self, t):
        self.t = t
        return True

    def do_step(self, t, h):
        self.t = t + h
        return True

    def retune(self):
        return True

    def time(self):
        return self.t

    def note(self):
        return "a model without mechanics"

    def warning(self, number):
        return ""

    def state(self):
        return b"12345678"

    def state_bytes(self):
        return 8

    def restore(self, state):
        self.t = float(state[0])
        return True
'''
CAUSE = "the disk of the model is full"
_NUMBERS = count()
Made = Callable[..., Host]


@pytest.fixture
def made(tmp_path: Path, unpacked: Unpacked, monkeypatch: pytest.MonkeyPatch) -> Made:
    """Return hosts of the model; ``failing`` is a method, or an attribute, in place of the model's."""

    def make(failing: str = "") -> Host:
        path, folder = unpacked("python")
        # a library that is loaded already has its model
        shutil.copytree(Path(folder, "binaries"), tmp_path / "binaries")
        name = f"small_model_{next(_NUMBERS)}"
        resources = tmp_path / "resources"
        resources.mkdir()
        (resources / "slavemodule.txt").write_text(name, encoding="utf-8")
        (resources / f"{name}.py").write_text(f"{MODEL}\n{failing}\n", encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
        return Host(path, str(tmp_path))

    return make


def raises(method: str) -> str:
    return f"    def {method}(self, *arguments):\n        raise OSError({CAUSE!r})"


def test_the_small_model_lives_through_a_run_and_its_states(made: Made) -> None:
    host = made()
    host.start()
    assert host.step(0.0) == ""
    data = host.write(host.state())
    host.go_on_from(data)
    assert host.said == []
    assert (OK, "a model without mechanics") in host.log
    host.free()


@pytest.mark.parametrize("method", ["state", "state_bytes"])
def test_a_state_that_cannot_be_saved_is_an_error_with_its_cause(method: str, made: Made) -> None:
    host = made(raises(method))
    host.start()
    state = ctypes.c_void_p()
    assert host.save(state) == ERROR
    assert CAUSE in host.said[-1]
    assert state.value is None
    host.free()


def test_a_state_longer_than_announced_is_refused_before_it_is_copied(made: Made) -> None:
    host = made("    def state(self):\n        return bytes(9)")
    host.start()
    assert host.save(ctypes.c_void_p()) == ERROR
    assert "has 9 bytes, not the 8 that it announced" in host.said[-1]
    host.free()


def test_a_state_that_cannot_be_saved_anew_stays_as_it_was(made: Made) -> None:
    host = made(
        "    def state(self):\n        if self.t > 0.0:\n            raise OSError\n        return bytes(8)"
    )
    host.start()
    state = host.state()
    before = host.write(state)
    assert host.step(0.0) == ""
    assert host.save(state) == ERROR
    assert host.write(state) == before
    assert host.restore(state) == OK
    assert host.step(0.0) == ""
    host.free()


def test_a_time_that_the_model_cannot_give_fails_the_step_with_its_cause(made: Made) -> None:
    host = made(raises("time"))
    host.start()
    assert CAUSE in host.step(0.0)
    assert CAUSE in host.get("status.message")[0]
    host.free()


@pytest.mark.parametrize("failing", [raises("note"), '    warnings = "many"'])
def test_what_fails_when_a_model_is_set_up_fails_the_initialisation(
    failing: str, made: Made
) -> None:
    host = made(failing)
    assert host.enter() == OK
    assert host.call("ExitInitializationMode") == ERROR
    assert "internal error in Python" in host.said[-1]
    host.free()


def test_a_warning_that_fails_is_in_the_log_with_its_cause(made: Made) -> None:
    host = made(raises("warning"))
    host.start()
    assert [CAUSE in message for status, message in host.log if status == WARNING] == [True]
    host.free()


def test_parameters_that_cannot_be_restored_after_a_refused_state_fail_the_fmu(made: Made) -> None:
    host = made(
        """
    times = 0

    def retune(self):
        self.times += 1
        self.message = "the model takes parameters once"
        return self.times == 1

    def restore(self, state):
        self.message = "the model goes back to no state"
        return False
"""
    )
    host.start()
    assert host.restore(host.state()) == ERROR
    assert "goes back to no state" in host.said[-1]
    assert "takes parameters once" in host.said[-1]
    assert "not allowed after a failure" in host.step(0.0)
    host.free()
