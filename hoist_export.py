"""A hoist as FMUs and as one system of them (SSP): joins fmu_src and hoist_demo, which know nothing of each other."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from fmu_src.export import export_fmu
from fmu_src.model_description import MODEL
from fmu_src.native.export import export_model, export_native
from fmu_src.profile import Profile
from fmu_src.ssp import Component, Datum, Version, export_ssp
from hoist_demo.cases.case import Case
from hoist_demo.drive_fmu.description import drive_model, duration
from hoist_demo.drive_fmu.interface import DriveRope
from hoist_demo.drive_fmu.omissions import OMISSIONS, leave_out, not_held, obstacles
from hoist_demo.parameters import start_heights
from hoist_demo.parameters.problems import Problems
from rope_model.cases import Level
from rope_model.scene_names import Value, named_parameters

if TYPE_CHECKING:
    from hoist_demo.control.trajectory import Trajectory
    from hoist_demo.ropes.definition import OneRope

DRIVE = "drive"  #: Name of the drive in a system.
ROPE = "rope"  #: Name of the rope in a system with one.
#: What a system can leave out, by name: of hoist and trip, and of ropes.
WITHOUT = (*OMISSIONS, "break", "guard", "touching")
# Where drive and ropes step at the same time, each hears of the other a step late, and that feeds the axial waves of a
# rope in proportion to its mass over the conveyance's. Measured over whole trips: steps of 10 ms let them grow at
# installed sizes, with ropes of 0.36 and more of the conveyance, to a quarter of the end force; 6.7 ms do not.
HEAVY_ROPE_RATIO = (
    0.25  #: Mass of the balance ropes over the lighter conveyance's, above which they are heavy.
)
LIGHT_STEP = 0.01  #: Communication step with light ropes [s].
HEAVY_STEP = 0.005  #: Communication step with heavy ropes [s].
MAX_STEP = 0.02  #: Largest communication step [s].
_TOGETHER = {"inputs_at_step_end": False}
_GUARDS = tuple(f"guard.{name}" for name in ("rise", "window", "clearance", "turns", "torque"))


class HoistFiles(NamedTuple):
    """Files of an exported hoist."""

    system: Path  # the SSP
    fmus: Mapping[str, Path]  # FMUs by their names in the system


def export_rope(
    destination: Path,
    case: Case,
    parameters: Mapping[str, Value],
    flavour: str = "native",
    fmi: int = 2,
    level: Level = "standard",
    platforms: Sequence[str] | None = None,
    profile: Profile | None = None,
    identifier: str = MODEL,
) -> Path:
    """Write the FMU of a rope of the hoist of ``case``, which starts where its conveyances wait.

    ``parameters`` are the rope's by FMI name; the rest is the level's. ``flavour`` is "native" or "Python"; the latter
    has one model identifier.
    """
    left, right = start_heights(case.hoist, case.winding)
    start = {**parameters, "left.y": left, "right.y": right}
    shown = replace(profile or Profile(), stop=duration(case.winding))
    if flavour == "native":
        return export_native(
            destination,
            level=level,
            fmi=fmi,
            platforms=platforms,
            start=start,
            profile=shown,
            identifier=identifier,
        )
    return export_fmu(destination, level=level, start=start, profile=shown, platforms=platforms)


def export_hoist(
    folder: Path,
    case: Case,
    ropes: Sequence[OneRope] = (),
    flavour: str = "native",
    fmi: int = 2,
    level: Level = "standard",
    platforms: Sequence[str] | None = None,
    profile: Profile | None = None,
    *,
    name: str = "hoist",
    without: Collection[str] = (),
    trajectory: Trajectory | None = None,
    step: float | None = None,
    version: Version = "1.0",
    data: Sequence[Datum] = (),
) -> HoistFiles:
    """Write drive, ropes and their system into ``folder``: an FMU each, and ``name``.ssp, which contains these.

    Each FMU has the start values of this hoist; the SSP binds none but ``inputs_at_step_end``, for tools differ in
    what they do with bindings.

    Parameters
    ----------
    case
        Hoist, trip, gains, and the rope of a hoist with one, or with equal ones.
    ropes
        The ropes where they differ; the hoist of ``case`` has them as one (``Ropes.hoist``).
    without
        Names of WITHOUT: what to leave out.
    trajectory
        The trip asked for, without the wait before it; None: the winding's S-curve.
    step
        Communication step of the system and sample time of its controller [s], at most MAX_STEP. None: LIGHT_STEP, or
        HEAVY_STEP where the balance ropes weigh more than HEAVY_ROPE_RATIO of the lighter conveyance.
    version
        Of SSP.
    data
        The data's statuses, which go into the system.

    Raises
    ------
    ValueError
        For what a system cannot hold; the message says how to leave it out.
    """
    if unknown := sorted({*without} - {*WITHOUT}):
        raise ValueError(
            f"without = {unknown[0]!r} must be one of {', '.join(WITHOUT)}: choose one"
        )
    if step is not None and not 0.0 < step <= MAX_STEP:
        raise ValueError(
            f"step = {step:g} s must be above 0 and at most {MAX_STEP:g} s: shorten it"
        )
    case = leave_out(case, without)
    Problems([*obstacles(case), *_obstacles(case, ropes, without)]).refuse()
    drive_ropes = [
        DriveRope(r.name, r.scene.rope.mass_per_length, r.scene.rope.length, r.suspension)
        for r in ropes
    ]
    pace = step_of(case) if step is None else step
    drive = drive_model(case, drive_ropes, trajectory, period=pace)
    fmus = {DRIVE: export_model(folder / f"{DRIVE}.fmu", platforms, fmi, **vars(drive))}
    for rope, parameters in _parameters(case, ropes).items():
        path = folder / f"{rope}.fmu"
        # several ropes can be linked into one program
        identifier = re.sub(r"\W", "_", f"{MODEL}_{rope}", flags=re.ASCII) if ropes else MODEL
        fmus[rope] = export_rope(
            path, case, parameters, flavour, fmi, level, platforms, profile, identifier
        )
    # drive and ropes step at the same time: the ropes extrapolate the motion
    components = [
        Component(one, path, {} if one == DRIVE else _TOGETHER) for one, path in fmus.items()
    ]
    system = folder / f"{name}.ssp"
    export_ssp(
        system, "FrictionHoist", components, drive.duration, pace, drive.description, version, data
    )
    return HoistFiles(system, fmus)


def step_of(case: Case) -> float:
    """Return a communication step at which drive and ropes may step at the same time [s]."""
    hoist = case.hoist
    heavy = hoist.tail_mass * hoist.tail_rope_length > HEAVY_ROPE_RATIO * min(
        hoist.mass_left, hoist.mass_right
    )
    return HEAVY_STEP if heavy else LIGHT_STEP


def _obstacles(case: Case, ropes: Sequence[OneRope], without: Collection[str]) -> Iterator[str]:
    """Yield what FMUs of ropes cannot do, each with the option that leaves it out."""
    for name, parameters in _parameters(case, ropes).items():
        for guard in _GUARDS:
            if "guard" not in without and (value := parameters.get(guard, 0.0)):
                reason = "an exported drive has no safety circuit, though the rope's guard.tripped tells of it"
                yield not_held(f"{name}: {guard} = {value}", "0", reason, "guard")
    for one in ropes:
        if "break" not in without and one.breaks is not None:
            yield not_held(
                f"{one.name}: breaks_at = {one.breaks.t:g} s",
                "None",
                "the rope of an FMU holds",
                "break",
            )
    pressed = ropes[0].scene.shaft.contact.rope_stiffness if len(ropes) > 1 else 0.0
    if "touching" not in without and pressed > 0.0:
        reason = "each rope of a system presses itself alone, it knows no neighbours"
        yield not_held(f"contact.rope_stiffness = {pressed:g} N/m2", "0", reason, "touching")


def _parameters(case: Case, ropes: Sequence[OneRope]) -> dict[str, Mapping[str, Value]]:
    """Return the parameters of each rope by FMI name; of several ropes all, whatever the level."""
    several: dict[str, Mapping[str, Value]] = {
        one.name: {p.name: p.value for p in named_parameters(one.scene)} for one in ropes
    }
    return several or {ROPE: case.rope}
