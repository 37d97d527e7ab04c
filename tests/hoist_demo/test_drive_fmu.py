"""The drive's FMU against the drive in process, and on other platforms in emulators."""

import importlib.util
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from checkout import NATIVE
from drives import Plant, PlantInput
from exports import FLAVOURS, export_drive
from native_host import OK, WARNING, H, Host
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from stand_in import RUNNERS

from fmu_src.native.export import export_model, export_native
from fmu_src.shell import build
from fmu_src.shell.build import PLATFORMS, host_platform, library
from fmu_src.shell.sources import HEADERS
from hoist_demo.cases.case import Case
from hoist_demo.cases.table import find_case
from hoist_demo.control.controller import ControllerState, Measurement, SpeedController
from hoist_demo.control.trajectory import s_curve
from hoist_demo.drive.plant import SIDE_FORCES
from hoist_demo.drive_fmu import interface
from hoist_demo.drive_fmu.description import LONGEST_HOLD, DriveModel, drive_model
from hoist_demo.drive_fmu.description import sources as drive_sources
from hoist_demo.drive_fmu.kernels import (
    MAX_MODES,
    complete,
    moment_function,
    point_function,
    structures,
)
from hoist_demo.drive_fmu.omissions import OMISSIONS, leave_out, obstacles
from hoist_demo.parameters import SIDES, Hoist, start_heights
from hoist_demo.parameters.components import DriveShaft, Guides, Play
from hoist_demo.parameters.suspension import MOVED, SuspensionOffset, moment_at, motion_at
from release.libraries import drive_library
from rope_model.codegen.platforms import prebuilt_file

pytestmark = pytest.mark.skipif("native-2" not in FLAVOURS, reason="needs a C compiler")
SETUP = find_case("rope-120")
MOTIONS = interface.motions(SETUP.hoist)


@pytest.fixture
def drive(unpacked: Callable[[str], tuple[Path, str]]) -> Iterator[Host]:
    made = Host(*unpacked("drive-2"))
    yield made
    made.free()


def in_process(case: Case, forces: list[tuple[float, float]]) -> list[list[float]]:
    """Motions after each step under the given forces of the balance rope; the loop of hoist_demo.cosimulation.host."""
    plant = Plant(case.hoist)
    reference = s_curve(case.winding)
    heights = start_heights(case.hoist, case.winding)
    state = plant.equilibrium(*heights, *interface.rest_forces(case))
    shown = plant.outputs(state, PlantInput(float(state.x[0]), *interface.rest_forces(case)))
    controller = SpeedController(case.hoist, shown.torque)
    memory = ControllerState()
    rows = []
    for k, (left, right) in enumerate(forces):
        measured = Measurement(shown.y_left - heights[0], case.hoist.sheave_radius * shown.rate)
        command = controller.command(reference.at(k * H), measured, memory, H)
        memory = command.state
        held = PlantInput(command.torque, left, right)
        moved = plant.step(state, H, held)
        assert moved.valid, moved.message
        state = moved.state
        shown = plant.outputs(moved.state, held)
        rows.append([getattr(shown, field) for field in MOTIONS.values()])
    return rows


def test_trip_under_swaying_forces_is_that_of_the_drive_in_process(drive: Host) -> None:
    # forces that differ from those at rest by up to a fifth, and swing at 1.5 Hz
    left, right = interface.rest_forces(SETUP)
    swing = 0.2 * np.sin(2 * np.pi * 1.5 * H * np.arange(2600))
    forces = [(left * (1 + s), right * (1 - s)) for s in swing]
    expected = in_process(SETUP, forces)
    drive.start()
    found = []
    for k, (left, right) in enumerate(forces):
        drive.set(**dict(zip(interface.FORCE_INPUTS, (left, right), strict=True)))
        assert drive.step(k * H) == ""
        found.append(drive.get(*MOTIONS))
    scale = np.abs(expected).max(axis=0)
    assert scale[0] > 89.0
    # 1e-7 of the fastest oscillation per step against an integrator that errs by 1e-8 at most
    assert_allclose(np.array(found) / scale, np.array(expected) / scale, rtol=0.0, atol=2e-6)


def test_motion_under_constant_forces_is_the_same_at_every_communication_step(drive: Host) -> None:
    """10 s of the trip."""
    found = {}
    for step in (0.001, 0.01, 0.1, 1.0, 2.0):
        drive.start()
        for k in range(round(10.0 / step)):
            assert drive.step(k * step, step) == ""
        found[step] = drive.get(*MOTIONS)
        assert drive.get("status.warning") == [""]
        drive.call("Reset")
    assert found[H][0] == pytest.approx(25.607, abs=1e-3)
    # internal steps of 1 ms at most err by 1e-7 of the fastest oscillation, which is millimetres
    for values in found.values():
        assert_allclose(values, found[H], rtol=0.0, atol=1e-9)


def test_controller_samples_at_its_own_period_within_and_across_steps(drive: Host) -> None:
    """Commands change at multiples of the period alone, whether it is longer than the steps or shorter."""
    drive.start(controller__period=0.02)
    commands = []
    for k in range(400):
        assert drive.step(k * 0.005, 0.005) == ""
        commands += drive.get("drive.torque_command")
    moving = np.array(commands)[-100:].reshape(-1, 4)
    assert np.all(moving == moving[:, :1])
    assert np.unique(moving[:, 0]).size == moving.shape[0]
    drive.call("Reset")


def test_changing_forces_held_over_a_long_step_are_warned_of_and_constant_ones_not(
    drive: Host,
) -> None:
    weights = dict(zip(interface.FORCE_INPUTS, interface.rest_forces(SETUP), strict=True))
    for step, factor, told in ((0.02, 1.01, False), (0.05, 1.0, False), (0.05, 1.01, True)):
        drive.start()
        drive.set(**{name: factor * value for name, value in weights.items()})
        before = len(drive.log)
        assert drive.step(0.0, step) == ""
        (said,) = drive.get("status.warning")
        assert (f"longer than {LONGEST_HOLD:g} s" in said) == told
        assert ([status for status, _ in drive.log[before:]] == [WARNING]) == told
        drive.call("Reset")
        drive.set(**weights)


def test_internal_steps_converge_with_order_five(drive: Host) -> None:
    ends = []
    for steps in (2, 4, 64):
        drive.start(solver__step_max=H / steps)
        # a blow that sets the conveyances swinging by decimetres, so that errors stand clear of rounding
        drive.set(**{interface.FORCE_INPUTS[1]: -2e5})
        for k in range(60):
            assert drive.step(k * H) == ""
        drive.set(**{interface.FORCE_INPUTS[1]: interface.rest_forces(SETUP)[1]})
        ends += drive.get("left.vy")
        drive.call("Reset")
    errors = np.abs(np.array(ends[:-1]) - ends[-1])
    assert np.all(np.log2(errors[:-1] / errors[1:]) > 4.7), errors


def test_forces_that_no_rope_could_follow_are_refused_and_leave_the_drive_where_it_was(
    drive: Host,
) -> None:
    """Inputs are held: what is sent again counts on, and a jump is a jump."""
    drive.start()
    assert drive.step(0.0) == ""
    state = drive.state()
    before = drive.get(*MOTIONS)
    for force, words in ((-1e9, "m/s2, not within +-100 m/s2"), (1e300, interface.FORCE_INPUTS[0])):
        drive.set(**{interface.FORCE_INPUTS[0]: force})
        assert words in drive.step(H)
        assert drive.get(*MOTIONS) == before
        assert drive.restore(state) == OK
    drive.set(**dict(zip(interface.FORCE_INPUTS, interface.rest_forces(SETUP), strict=True)))
    assert drive.step(H) == ""


def test_drive_that_is_given_no_pull_at_the_start_rests_under_the_weight_of_the_rope(
    drive: Host,
) -> None:
    """A container initialises connected inputs with 0; then the pull comes, and nothing may move."""
    weights = dict(zip(interface.FORCE_INPUTS, interface.rest_forces(SETUP), strict=True))
    for parameters, rests in (({}, True), ({"left__fy_start": 0.0, "right__fy_start": 0.0}, False)):
        drive.set(**dict.fromkeys(interface.FORCE_INPUTS, 0.0))
        drive.start(**parameters)
        drive.set(**weights)
        assert drive.step(0.0) == ""
        # the reference waits: motions are rounding of the equilibrium, of 1e-9 m of stretch; a jolt moves millimetres
        assert (abs(drive.get("left.vy")[0]) < 1e-8) == rests
        drive.call("Reset")


def test_overwind_is_refused_and_leaves_the_drive_where_it_was(drive: Host) -> None:
    drive.start(solver__step_max=0.001)
    drive.set(**{interface.FORCE_INPUTS[1]: -1e6})
    t = 0.0
    while not (said := drive.step(t)):
        before = drive.get("left.y")
        t += H
    assert "overwind" in said
    assert drive.get("left.y") == before


PLACES = {
    "a": SuspensionOffset(0.2, -0.1, -0.5),
    "b": SuspensionOffset(z=0.4),
    "c": SuspensionOffset(),
}


def exported(folder: Path, name: str, model: DriveModel) -> Host:
    """An instance of a drive that only one test needs; no more is compiled than for others of its structure."""
    fmu = export_model(folder / f"{name}.fmu", (host_platform(),), 2, model)
    return Host(fmu, fmpy.extract(str(fmu), str(folder / name)))


def test_ropes_beside_the_centres_do_the_work_that_the_drive_gets() -> None:
    """At random places: forces and moments times the speeds of the ropes' ends, and of the conveyances."""
    rng = np.random.default_rng(1)
    moment = moment_function()
    point = point_function()
    for place in PLACES.values():
        for side in SIDES:
            offset = place.at(side)
            force = rng.normal(size=3)
            centre = rng.normal(size=6)
            turn = rng.normal(size=3)
            my = float(moment(offset, turn[0], force))
            _, _, vx, vz, _, _ = point(offset, centre, turn).full().ravel()
            at_centre = force[0] * centre[2] + force[2] * centre[3] + my * turn[1]
            assert force[0] * vx + force[2] * vz == pytest.approx(at_centre, rel=1e-12)


def test_drive_of_several_ropes_moves_as_one_rope_with_their_sum_would_move_it(
    tmp_path: Path,
) -> None:
    case = leave_out(find_case("kiruna-355"), ("lining",))
    mass = case.hoist.tail_rope_mass / 3.0
    length = case.hoist.tail_rope_length
    ropes = [interface.DriveRope(name, mass, length, place) for name, place in PLACES.items()]
    several = exported(tmp_path, "several", drive_model(case, ropes))
    one = exported(tmp_path, "one", drive_model(case))
    for drive in (several, one):
        drive.start()
    rng = np.random.default_rng(1)
    pulls = np.array([interface.rest_forces(case, rope) for rope in ropes])
    for k in range(100):
        total = dict.fromkeys((*interface.FORCE_INPUTS, *SIDE_FORCES), 0.0)
        for rope, pull in zip(ropes, pulls, strict=True):
            for side, at_rest in zip(SIDES, pull, strict=True):
                fx = 300.0 * rng.normal()
                fy = at_rest * (1.0 + 0.1 * rng.normal())
                fz = 300.0 * rng.normal()
                my = moment_at(
                    rope.suspension.at(side), several.get(f"{side}.yaw")[0], (fx, fy, fz)
                )[1]
                for name, value in (("fx", fx), ("fy_mean", fy), ("fz", fz), ("my", my)):
                    total[f"{side}.{name}"] += value
                names = (f"{rope.name}.{side}.{name}" for name in ("fx", "fy_mean", "fz"))
                several.set(**dict(zip(names, (fx, fy, fz), strict=True)))
        one.set(**total)
        for drive in (several, one):
            assert drive.step(k * H) == ""
    # the same kernels: sums of three numbers, rounded in another order, over 100 steps
    motions = interface.MOTIONS
    assert_allclose(several.get(*motions), one.get(*motions), rtol=1e-9, atol=1e-12)
    for rope in ropes:
        for side in SIDES:
            if rope.suspension == SuspensionOffset():
                continue
            centre = one.get(*(f"{side}.{name}" for name in MOVED))
            # no output has the yaw's second derivative, which the places and speeds do not need
            moved = motion_at(
                rope.suspension.at(side), centre, *one.get(f"{side}.yaw", f"{side}.yaw_rate"), 0.0
            )[:4]
            shown = several.get(*(f"{rope.name}.{side}.{name}" for name in MOVED[:4]))
            assert_allclose(shown, moved, rtol=1e-9, atol=1e-12)
    for drive in (several, one):
        drive.free()


def test_what_a_system_cannot_hold_is_told_and_can_be_left_out() -> None:
    case = find_case("jammed-conveyance")
    case = replace(case, winding=replace(case.winding, emergency_at=5.0, emergency_law="torque"))
    for name in (name for name, one in OMISSIONS.items() if one.reason):
        told = [
            one for one in obstacles(case) if one.endswith(f"leave it out with --without {name}")
        ]
        assert len(told) == 1
        assert not {*told} & {*obstacles(leave_out(case, [name]))}
    assert drive_model(leave_out(case, OMISSIONS)).duration > 10.0


def test_drive_of_fmi_3_claims_no_event_mode_and_refuses_it(
    unpacked: Callable[[str], tuple[Path, str]],
) -> None:
    fmu, folder = unpacked("drive-3")
    with zipfile.ZipFile(fmu) as archive:
        interface3 = ElementTree.fromstring(archive.read("modelDescription.xml")).find(
            "CoSimulation"
        )
    assert {interface3.get(name) for name in ("hasEventMode", "mightReturnEarlyFromDoStep")} == {
        "false"
    }
    with pytest.raises(AssertionError, match="has no event mode"):
        Host(fmu, folder, events=1)


def test_hoists_with_other_numbers_share_the_sources_of_their_drive() -> None:
    """Numbers are data.  What makes other sources is the count of head rope modes, and a shaft."""
    hoists = [
        replace(Hoist(), payload_left=7e3, shaft_travel=400.0),
        replace(Hoist(), power_limit=1e6, guides=Guides(), play=Play(), conveyance_mass_right=9e3),
    ]
    assert {complete(hoist).equation_structure for hoist in hoists} == {
        complete(Hoist()).equation_structure
    }
    for hoist in (*hoists, replace(Hoist(), head_rope_modes=4, drive_shaft=DriveShaft())):
        assert complete(hoist).equation_structure in structures()
    case = replace(
        SETUP,
        hoist=replace(SETUP.hoist, payload_left=4e3),
        winding=replace(SETUP.winding, speed=9.0),
    )
    other = drive_model(case)
    model = drive_model(SETUP)
    assert other.sources == model.sources == drive_sources(complete(SETUP.hoist).equation_structure)
    assert other.data != model.data


def test_library_of_the_package_serves_hoists_of_other_numbers_without_a_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = host_platform()
    brought = drive_library(complete(SETUP.hoist).equation_structure, 2)
    compiled = library(brought.sources, brought.identifier, here).read_bytes()
    monkeypatch.setattr(build, "_PACKAGE", tmp_path)
    monkeypatch.setattr(build, "_compilable", lambda: set[str]())
    path = prebuilt_file(tmp_path, brought.sources, brought.identifier, here)
    path.parent.mkdir()
    path.write_bytes(compiled)
    hoist = replace(SETUP.hoist, payload_left=3e3, power_limit=8e5, guides=Guides(), play=Play())
    own = exported(tmp_path, "own", drive_model(replace(SETUP, hoist=hoist)))
    own.start()
    assert own.step(0.0) == ""
    assert own.get("left.y", "right.y") == [
        pytest.approx(0.0, abs=1e-6),
        pytest.approx(90.0, abs=1e-6),
    ]
    own.free()
    many = replace(SETUP, hoist=replace(SETUP.hoist, head_rope_modes=MAX_MODES + 1))
    with pytest.raises(ValueError, match="up to 4 head rope modes"):
        exported(tmp_path, "many", drive_model(many))


def test_parts_that_a_hoist_lacks_do_nothing() -> None:
    """A limit of power beyond all speeds gives the limit of torque to the bit, guides without friction nothing."""
    whole = complete(hoist := replace(Hoist(), torque_limit=2.1e5 / 3.0))
    assert [whole.torque_available(rate) for rate in (0.0, 1e-3, 7.3, 1e3)] == [
        hoist.torque_limit
    ] * 4
    assert whole.travel_loss == hoist.travel_loss
    assert (whole.mass_left, whole.mass_right) == (hoist.mass_left, hoist.mass_right)


STEPS = 1000
OUTPUTS = ("left.y", "left.vy", "left.ay", "drive.torque")


def run(
    fmu: Path, platform: str, commands: Callable[[ElementTree.Element], str]
) -> NDArray[np.float64]:
    """What the library for ``platform`` prints in a run by the ``commands``, of STEPS steps."""
    with tempfile.TemporaryDirectory() as name, zipfile.ZipFile(fmu) as archive:
        folder = Path(name)
        target = PLATFORMS[platform]
        described = ElementTree.fromstring(archive.read("modelDescription.xml"))
        path = f"binaries/{target.folder2}/{described.find('CoSimulation').get('modelIdentifier')}{target.suffix}"
        library = folder / Path(path).name
        library.write_bytes(archive.read(path))
        command = [
            *RUNNERS[platform],
            _compile(folder, platform),
            f"./{library.name}",
            described.get("guid"),
        ]
        # wine keeps its settings in the folder as well
        where = {**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"}
        options = {
            "input": commands(described),
            "capture_output": True,
            "text": True,
            "check": False,
        }
        done = subprocess.run(list(map(str, command)), cwd=folder, env=where, **options)
    assert done.returncode == 0, done.stderr[-500:]
    return np.array([float.fromhex(line) for line in done.stdout.split()]).reshape(STEPS, -1)


def script(described: ElementTree.Element) -> str:
    """Commands for foreign_host: the drive runs under the forces at the start."""
    references = {
        str(v.get("name")): v.get("valueReference") for v in described.iter("ScalarVariable")
    }
    lines = ["i"]
    for k in range(STEPS):
        lines += [f"s {k * H!r} {H!r}", *(f"g {references[name]}" for name in OUTPUTS)]
    return "\n".join(lines) + "\n"


ROPE_OUTPUTS = ("left.fy", "right.fy", "left.mz", "loop.yaw")


def rope_script(described: ElementTree.Element) -> str:
    """Commands for foreign_host: the left end of the rope rises by 10 m in 10 s, smoothly, the right one sinks."""
    references = {
        str(v.get("name")): v.get("valueReference") for v in described.iter("ScalarVariable")
    }
    lines = [f"b {references['inputs_at_step_end']} 1", "i"]
    for k in range(STEPS):
        s = (k + 1) / STEPS
        duration = STEPS * H
        way = 10.0
        motion = {
            "y": way * s**3 * (10.0 - 15.0 * s + 6.0 * s**2),
            "vy": way / duration * 30.0 * s**2 * (1.0 - s) ** 2,
            "ay": way / duration**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
        }
        for name, value in motion.items():
            lines.append(f"r {references[f'left.{name}']} {value!r}")
            lines.append(f"r {references[f'right.{name}']} {90.0 * (name == 'y') - value!r}")
        lines += [f"s {k * H!r} {H!r}", *(f"g {references[name]}" for name in ROPE_OUTPUTS)]
    return "\n".join(lines) + "\n"


def _compile(folder: Path, platform: str) -> Path:
    if platform.endswith("windows"):
        host = folder / "host.exe"
        libraries = []
    else:
        host = folder / "host"
        libraries = ["-ldl"]
    compiler = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-target",
        PLATFORMS[platform].target,
        "-std=c99",
        "-O1",
    ]
    source = NATIVE / "foreign_host.c"
    subprocess.run(
        [*compiler, f"-I{HEADERS}", str(source), "-o", str(host), *libraries], check=True
    )
    return host


#: platforms whose programs an emulator runs here
FOREIGN = ("aarch64-linux", "x86_64-windows")


def require_emulator(platform: str) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("ziglang is not installed: pip install ziglang")
    if shutil.which(RUNNERS[platform][0]) is None:
        pytest.skip(
            f"no emulator for {platform}: apt-get install qemu-user-static libc6-arm64-cross, or wine"
        )


def exported_by_dll(dll: bytes) -> set[str]:
    """Names in the export table of a 64 bit Windows library (PE32+)."""
    pe = struct.unpack_from("<I", dll, 0x3C)[0]
    sections = struct.unpack_from("<H", dll, pe + 6)[0]
    optional = struct.unpack_from("<H", dll, pe + 20)[0]

    def place(address: int) -> int:
        for k in range(sections):
            size, begin, _, at = struct.unpack_from("<4I", dll, pe + 24 + optional + 40 * k + 8)
            if begin <= address < begin + max(size, 1):
                return int(address - begin + at)
        raise AssertionError("an address outside of all sections")

    table = place(struct.unpack_from("<I", dll, pe + 24 + 112)[0])
    count, _, names = struct.unpack_from("<3I", dll, table + 24)
    addresses = struct.unpack_from(f"<{count}I", dll, place(names))
    return {dll[place(x) : dll.index(b"\0", place(x))].decode() for x in addresses}


@pytest.mark.slow
def test_dll_of_the_drive_exports_the_functions_of_fmi_alone(tmp_path: Path) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("ziglang is not installed: pip install ziglang")
    with zipfile.ZipFile(export_drive(tmp_path / "drive.fmu", ("x86_64-windows",))) as archive:
        names = exported_by_dll(archive.read("binaries/win64/HoistDrive.dll"))
    assert len(names) > 30
    assert [name for name in names if not name.startswith("fmi2")] == []


@pytest.mark.slow
@pytest.mark.parametrize("platform", FOREIGN)
def test_library_of_the_rope_in_the_emulator_gives_the_values_of_this_platform(
    platform: str, tmp_path: Path
) -> None:
    require_emulator(platform)
    rope = export_native(tmp_path / "rope.fmu", platforms=(host_platform(), platform))
    expected = run(rope, host_platform(), rope_script)
    found = run(rope, platform, rope_script)
    scale = np.abs(expected).max(axis=0)
    # another C library rounds its functions otherwise, and steps to tolerances amplify that
    assert_allclose(found / scale, expected / scale, rtol=0, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("platform", FOREIGN)
def test_library_of_the_drive_in_the_emulator_gives_the_values_of_this_platform(
    platform: str, tmp_path: Path
) -> None:
    require_emulator(platform)
    drive = export_drive(tmp_path / "drive.fmu", (host_platform(), platform))
    expected = run(drive, host_platform(), script)
    found = run(drive, platform, script)
    scale = np.maximum(np.abs(expected).max(axis=0), 1e-12)
    # only tanh may round otherwise, in another C library
    assert_allclose(found / scale, expected / scale, rtol=0, atol=1e-14)
