"""The engine, its FMUs, the drive's FMUs and the trip in C run without a complaint of clang's sanitizers.

The checks are those of memory, of undefined behaviour, and of the type of each function that is called through a
pointer.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from checkout import HELPERS, QUICK, ROOT, TESTS

CHECKS = (
    "-g",
    "-fsanitize=address,undefined,function,float-cast-overflow",
    "-fno-sanitize-recover=all",
    "-shared-libasan",
    "-DHAS_WIDE_FORMS=0",
    "-DROPE_CHECKS",
)
FIRST_THAT_CHECKS_FUNCTIONS_IN_C = 17
#: CasADi opens its plugins with RTLD_DEEPBIND, which the address sanitizer refuses.
SHALLOW = """\
#define _GNU_SOURCE
#include <dlfcn.h>
typedef void *Open(const char *, int);
void *dlopen(const char *path, int flags) {
    return ((Open *)dlsym(RTLD_NEXT, "dlopen"))(path, flags & ~RTLD_DEEPBIND);
}
"""
#: What the checks must find: a read behind an array, and a call through another type.
WRONG = {
    "address": "int main(int n, char **x) { int a[2] = {n, n}; return a[n + 1]; }",
    "function": "static int called(int *x) { return *x; }\n"
    "int main(void) { int x = 0; int (*volatile f)(void *) = (int (*)(void *))called; return f(&x); }",
}
#: Winds the rope in process and FMUs of both versions by the trip in C, and runs the drive's FMUs.  Prints the samples
#: that the trip in C has done.
PROGRAM = """\
import json
from pathlib import Path
from fmu_src.shell import build
from rope_model import compiler
build._compiler = compiler.find_compiler
build._compilable = lambda: {build.host_platform()}
for module in (build, compiler):
    module.FLAGS = tuple({"-O3": "-O1", "-s": "-fPIC"}.get(flag, flag) for flag in module.FLAGS)
build._flags = lambda name: build.FLAGS
import fmpy
from exports import FULL, export_drive
from fmu_src.native.export import export_native
from hoist_demo.cosimulation.compiled_trip import CompiledTrip
from test_compiled_trip import Wound
samples, done = CompiledTrip.wind_samples, []
def counted(self, first, last):
    reached = samples(self, first, last)
    done[-1] += reached.sample - first
    return reached
CompiledTrip.wind_samples = counted
here = (build.host_platform(),)
for fmi in (2, 3):
    export_native(Path(f"{fmi}.fmu"), level="draft", fmi=fmi, platforms=here, profile=FULL)
    export_drive(Path(f"drive{fmi}.fmu"), here, fmi)
    fmpy.simulate_fmu(f"drive{fmi}.fmu", stop_time=1.0, output_interval=0.02)
trips = (Wound(), Wound(level="standard"), Wound("caught-rope"), *(Wound(fmu=Path(f"{fmi}.fmu")) for fmi in (2, 3)))
for trip in trips:
    done.append(0)
    assert trip.run().completed
print(json.dumps(done))
"""


def find_clang() -> str | None:
    """Return a clang that checks the types of functions in C; None without one."""
    for name in ("clang", *(f"clang-{version}" for version in range(30, 16, -1))):
        if (path := shutil.which(name)) is None:
            continue
        told = subprocess.run(
            [path, "--version"], capture_output=True, text=True, check=True
        ).stdout
        version = re.search(r"clang version (\d+)", told)
        if version and int(version[1]) >= FIRST_THAT_CHECKS_FUNCTIONS_IN_C:
            return path
    return None


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="preloads the sanitizers' library")
def test_engine_fmus_drive_and_trip_are_clean_under_sanitizers(tmp_path: Path) -> None:
    clang = find_clang()
    if clang is None:
        pytest.skip("needs clang 17 or later")
    for kind, text in WRONG.items():
        (tmp_path / "wrong.c").write_text(text)
        command = [clang, *CHECKS[:3], "wrong.c", "-o", "wrong"]
        if subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode:
            pytest.skip(f"needs the sanitizers of {clang}: apt-get install libclang-rt-dev")
        wrong = subprocess.run([tmp_path / "wrong"], capture_output=True, check=False)
        assert wrong.returncode != 0, kind
    (tmp_path / "shallow.c").write_text(SHALLOW)
    command = [clang, "-shared", "-fPIC", "shallow.c", "-o", "shallow.so"]
    subprocess.run(command, cwd=tmp_path, check=True)
    resources = subprocess.run(
        [clang, "-print-resource-dir"], capture_output=True, text=True, check=True
    ).stdout.strip()
    runtime = next(
        path
        for path in Path(resources).rglob("libclang_rt.asan*.so")
        if os.uname().machine in str(path)
    )
    # not the copies that the quick tests compile with less optimisation
    path = [part for part in os.environ["PYTHONPATH"].split(os.pathsep) if part != str(QUICK)]
    environment = os.environ | {
        "CC": " ".join((clang, *CHECKS)),
        "BALANCE_ROPE_CACHE": str(tmp_path / "cache"),
        "PYTHONPATH": os.pathsep.join([*path, str(ROOT), str(HELPERS), str(TESTS / "hoist_demo")]),
        "LD_PRELOAD": f"{tmp_path / 'shallow.so'} {runtime}",
        "ASAN_OPTIONS": "detect_leaks=0:verify_asan_link_order=0",  # Python keeps its memory
        "UBSAN_OPTIONS": "print_stacktrace=1",
    }
    wound = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert wound.returncode == 0, wound.stderr[-3000:]
    assert all(samples > 10 for samples in json.loads(wound.stdout.splitlines()[-1])), wound.stdout
