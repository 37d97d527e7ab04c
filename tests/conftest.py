"""Fixtures of the tests: exported FMUs, functions of the native rope, figures that are left out."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Callable, Generator, Iterator
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import fmpy
import pytest
from checkout import QUICK, ROOT
from exports import EXPORTS
from hypothesis import settings
from native_host import Host
from native_parts import parts as parts
from shared import Unpacked
from stand_in import VERSIONS

from rope_model.compiler import find_compiler, make_once

# processes that tests start run this checkout, too
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
# what Python compiles for one of them serves the others
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# what is compiled on this machine, in this process or another, serves a test and not a year of windings
if (
    os.name == "posix"
    and "OPTIMISING_CC" not in os.environ
    and len(compiler := find_compiler() or ()) == 1
):
    os.environ |= {
        "OPTIMISING_CC": compiler[0],
        "SYSTEM_CC": compiler[0],
        "CC": str(QUICK / "cc"),
    }
# examples are bounded by their number: a busy machine is no failure
settings.register_profile(
    "seeded", deadline=None, derandomize=True, max_examples=50
)  # the same every time
settings.load_profile("seeded")
# nor does it draw numbers of the modules that happen to be loaded, which it would read all for it: 5 s in each process
providers = import_module("hypothesis.internal.conjecture.providers")
if hasattr(providers, "is_local_module_file"):
    providers.is_local_module_file = lambda _: False


def pytest_collection_modifyitems(config: pytest.Config) -> None:
    """FMUs are compiled quickly in the tests of ``make test``; ``make test-slow`` compiles them as they are shipped."""
    if os.name == "posix" and find_spec("ziglang") and config.option.markexpr == "not slow":
        os.environ["PYTHONPATH"] = os.pathsep.join((str(QUICK), os.environ["PYTHONPATH"]))


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compiles the engine while several processes collect tests, all of which would wait for it."""
    config = session.config
    if getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        compiling = subprocess.Popen(
            [sys.executable, "-c", "from rope_model.codegen.build import library; library()"],
            stderr=subprocess.DEVNULL,  # tests that need it say what is wrong
        )
        config.add_cleanup(compiling.wait)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collects the tests without searching for garbage, a fifth of its time, and searches what is there no more.

    Later it is searched less often: the syntax tree of a module is none, and takes three times as long else.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
        gc.set_threshold(200_000, 20, 20)


@pytest.fixture(scope="session")
def fmu_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The FMU of a kind in ``exports.EXPORTS``, made once, however many processes share the tests."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "exports"

    def found(kind: str) -> Path:
        path = folder / f"{kind}.fmu"
        return make_once(path, lambda: EXPORTS[kind](path))

    return found


@pytest.fixture(scope="session")
def unpacked(tmp_path_factory: pytest.TempPathFactory, fmu_of: Callable[[str], Path]) -> Unpacked:
    @cache
    def found(kind: str) -> tuple[Path, str]:
        return fmu_of(kind), fmpy.extract(str(fmu_of(kind)), str(tmp_path_factory.mktemp(kind)))

    return found


@pytest.fixture
def plain_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures without ticks, and of linear models without a layout: most of their time."""
    monkeypatch.setattr(import_module("hoist_demo.report.linear_figures"), "LAYOUT", None)
    figures = import_module("hoist_demo.report.figures")
    ticker = import_module("matplotlib.ticker")

    class Canvas(figures.FigureCanvasAgg):  # type: ignore[misc, name-defined]
        def print_png(self, *arguments: object, **named: object) -> None:
            for axes in self.figure.axes:
                for axis in (axes.xaxis, axes.yaxis):
                    axis.set_major_locator(ticker.NullLocator())
                    axis.set_minor_locator(ticker.NullLocator())
            super().print_png(*arguments, **named)

    monkeypatch.setattr(figures, "FigureCanvasAgg", Canvas)


@pytest.fixture
def no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run's files without its figures, which take half of the time of a short run."""
    monkeypatch.setattr(import_module("hoist_demo.report.figures"), "write_figures", lambda *_: [])


@pytest.fixture
def no_reference_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """FMUs without the reference run, which takes most of the time of an export whose sources are compiled."""
    monkeypatch.setattr("fmu_src.attachments.reference_files", lambda *_, **__: {})


@pytest.fixture(params=VERSIONS)
def fmi(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture
def host(fmi: int, unpacked: Unpacked) -> Iterator[Host]:
    made = Host(*unpacked(f"stand-in-{fmi}"))
    yield made
    made.free()
