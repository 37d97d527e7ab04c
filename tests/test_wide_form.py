"""The rope with four elements at a time, where the processor can, has the bits of the form for any processor."""

import ctypes
import platform
import subprocess
from pathlib import Path

import pytest

from rope_model.codegen.build import sources
from rope_model.engine import NativeRope, declare
from rope_model.numerics.kernels import FLAGS, cache_folder, compile_objects, find_compiler, object_files
from rope_model.parameters import Mesh, Model, Rope, Scene, Swivel
from rope_model.shaft_parameters import Air, Contact, Lining, Shaft
from rope_model.simulation.ends.paths import EndMotion

#: thirteen elements: neither form's lanes are full at the end
BASE = Scene(rope=Rope(length=30.0), mesh=Mesh(kind="eem", elements=13), left=Swivel(mode="coulomb"))
SHAFT = Shaft(lining=Lining(width=3.4, depth=3.0), contact=Contact(rope_stiffness=1e7), air=Air(density=1.2, vx=4.0))
SCENES = {
    "torsional": BASE,
    "spatial": BASE.with_(model=Model(fidelity="spatial")),
    "planar": BASE.with_(model=Model(fidelity="planar"), left=Swivel(mode="locked")),
    "curved wires": BASE.with_(rope=Rope(length=30.0, EI_stick=2000.0, initial_curvature=0.05)),
    "shaft": BASE.with_(shaft=SHAFT),
}


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> type[NativeRope]:
    """The rope whose processor says that it has no wide vectors."""
    flags, compiler = Path("/proc/cpuinfo"), find_compiler()
    if platform.machine() != "x86_64" or not flags.is_file() or "avx2" not in flags.read_text(encoding="utf-8"):
        pytest.skip("asks Linux on x86_64 for a processor with AVX2")
    if compiler is None:
        pytest.skip("needs a C compiler")
    folder, command = tmp_path_factory.mktemp("plain"), [*compiler, *FLAGS]
    objects = object_files(sources(), compiler, FLAGS, cache_folder())
    compile_objects(sources(), command, objects)
    (folder / "processor.c").write_text("int processor_has_avx2(void) { return 0; }\n", encoding="utf-8")
    files = [str(folder / "processor.c"), *(str(path) for file, path in objects.items() if file != "processor.c")]
    subprocess.run([*command, *files, "-o", str(folder / "rope.so"), "-lm"], check=True)
    library = declare(ctypes.CDLL(str(folder / "rope.so")))

    class Plain(NativeRope):
        _library = staticmethod(lambda: library)

    return Plain


@pytest.mark.parametrize("name", SCENES)
def test_both_forms_have_the_same_bits(plain: type[NativeRope], name: str) -> None:
    told = []
    for form in (NativeRope, plain):
        rope = form(SCENES[name])
        assert rope.initialize(0.0, EndMotion(), EndMotion()).valid
        told.append([rope.signals()])
        for k in range(1, 21):
            t = 0.01 * k
            moved = EndMotion(y=0.5 * t * t, vy=t, ay=1.0), EndMotion(y=-0.5 * t * t, vy=-t, ay=-1.0)
            assert rope.advance_to(t, *moved).valid
            told[-1].append(rope.signals())
    assert told[0] == told[1]
