"""A hoist as FMUs and as one system of them (SSP)."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from fmu_src.model_description import MODEL
from fmu_src.native.export import export_model, export_native
from fmu_src.profile import Profile
from fmu_src.python.export import export_fmu
from fmu_src.ssp import Component, System, SystemNumber, Version, export_ssp
from hoist_demo.cases.case import Case
from hoist_demo.drive_fmu.description import drive_model, duration
from hoist_demo.drive_fmu.interface import DriveRope
from hoist_demo.drive_fmu.omissions import OMISSIONS, leave_out, obstacles, omission_text
from hoist_demo.parameters import start_heights
from hoist_demo.parameters.problems import Problems
from rope_model.cases import Level
from rope_model.scene_names import Value, named_parameters

if TYPE_CHECKING:
    from hoist_demo.control.trajectory import Trajectory
    from hoist_demo.run.ropes import OneRope

NATIVE = "native"  #: Flavour of the complete rope in C.
PYTHON = "Python"  #: Flavour of the published system in plain Python.
DRIVE = "drive"  #: Name of the drive in a system.
ROPE = "rope"  #: Name of the rope in a system with one.
#: Names of what a system can leave out: of hoist and trip, and of ropes.
OMITTABLE = (*OMISSIONS, "break", "guard", "touching")
# Where drive and ropes step at the same time, each gets the other's data a step late, and that
# feeds the axial waves of a rope in proportion to its mass over the conveyance's. Measured over
# whole trips: steps of 10 ms let them grow at installed sizes, with ropes of 0.36 and more of the
# conveyance, to a quarter of the end force; 6.7 ms do not. Mass of the balance ropes over the
# lighter conveyance's, above which they are heavy.
HEAVY_ROPE_RATIO = 0.25
LIGHT_STEP = 0.01  #: Communication step with light ropes [s].
HEAVY_STEP = 0.005  #: Communication step with heavy ropes [s].
MAX_STEP = 0.02  #: Largest communication step [s].
#: Values of a rope that steps at the same time as the drive: it extrapolates the motion.
_SIMULTANEOUS = {"inputs_at_step_end": False}
_GUARDS = tuple(f"guard.{name}" for name in ("rise", "window", "clearance", "turns", "torque"))


class HoistFiles(NamedTuple):
    """Files of an exported hoist."""

    system: Path  # the SSP
    fmus: Mapping[str, Path]  # FMUs by their names in the system


@dataclass(frozen=True)
class RopeFmu:
    """Choices of a rope's FMU; the defaults are those of ``balance-rope export``."""

    flavour: str = NATIVE  # or PYTHON, FMI 2.0 alone
    fmi: int = 2
    level: Level = "standard"
    platforms: Sequence[str] | None = None  # names of FMI 3.0; None: all that can be built here
    profile: Profile = Profile()  # noqa: RUF009  it is frozen
    identifier: str = MODEL  # of a native FMU


@dataclass(frozen=True)
class SystemOptions:
    """Choices of a system that no FMU has."""

    name: str = "hoist"  # of the file
    without: Collection[str] = ()  # parts to leave out, names of OMITTABLE
    #: Reference of the trip, without the wait before it; None: the winding's S-curve.
    trajectory: Trajectory | None = None
    #: Communication step of the system and sample time of its controller [s], at most MAX_STEP.
    #: None: LIGHT_STEP, or HEAVY_STEP where the balance ropes weigh more than HEAVY_ROPE_RATIO of
    #: the lighter conveyance.
    step: float | None = None
    version: Version = "1.0"  # of SSP
    data: Sequence[SystemNumber] = ()  # the data's statuses, which go into the system

    def __post_init__(self) -> None:
        unknown = sorted({*self.without} - {*OMITTABLE})
        if unknown:
            raise ValueError(
                f"without = {unknown[0]!r} must be one of {', '.join(OMITTABLE)}: choose one"
            )
        if self.step is not None and not 0.0 < self.step <= MAX_STEP:
            raise ValueError(
                f"step = {self.step:g} s must be above 0 and at most {MAX_STEP:g} s: shorten it"
            )


def export_rope(
    destination: Path,
    case: Case,
    parameters: Mapping[str, Value],
    fmu: RopeFmu = RopeFmu(),
) -> Path:
    """Write the FMU of a rope of the hoist of ``case``, which starts where its conveyances wait.

    ``parameters`` are the rope's by FMI name; the rest is the level's.
    """
    left, right = start_heights(case.hoist, case.winding)
    start = {**parameters, "left.y": left, "right.y": right}
    profile = replace(fmu.profile, stop=duration(case.winding))
    if fmu.flavour == NATIVE:
        return export_native(
            destination,
            level=fmu.level,
            fmi=fmu.fmi,
            platforms=fmu.platforms,
            start=start,
            profile=profile,
            identifier=fmu.identifier,
        )
    return export_fmu(
        destination, level=fmu.level, start=start, profile=profile, platforms=fmu.platforms
    )


def export_hoist(
    folder: Path,
    case: Case,
    ropes: Sequence[OneRope] = (),
    fmu: RopeFmu = RopeFmu(),
    options: SystemOptions = SystemOptions(),
) -> HoistFiles:
    """Write drive, ropes and their system into ``folder``: FMUs, and an SSP with all of them.

    Each FMU has the start values of this hoist; the SSP binds none but ``inputs_at_step_end``,
    because tools treat bindings differently.

    Parameters
    ----------
    case
        Hoist, trip, gains, and the rope of a hoist with one, or with equal ones.
    ropes
        The ropes where they differ; the hoist of ``case`` has them as one (``Ropes.hoist``).
    fmu
        Choices of the ropes' FMUs; the drive's has their platforms and version of FMI.

    Raises
    ------
    ValueError
        For parts that a system cannot hold; the message says how to leave them out.
    """
    case = leave_out(case, options.without)
    Problems([*obstacles(case), *_obstacles(case, ropes, options.without)]).refuse()
    step = options.step
    if step is None:
        step = step_of(case)
    drive_ropes = [
        DriveRope(r.name, r.scene.rope.mass_per_length, r.scene.rope.length, r.suspension)
        for r in ropes
    ]
    drive = drive_model(case, drive_ropes, options.trajectory, period=step)
    drive_fmu = export_model(folder / f"{DRIVE}.fmu", fmu.platforms, fmu.fmi, drive)
    fmus = {DRIVE: drive_fmu, **_export_ropes(folder, case, ropes, fmu)}
    components = [Component(DRIVE, drive_fmu, {})]
    components += [
        Component(name, path, _SIMULTANEOUS) for name, path in fmus.items() if name != DRIVE
    ]
    system = System(
        "FrictionHoist",
        stop=drive.duration,
        step=step,
        description=drive.description,
        version=options.version,
        data=options.data,
    )
    path = export_ssp(folder / f"{options.name}.ssp", components, system)
    return HoistFiles(path, fmus)


def _export_ropes(
    folder: Path, case: Case, ropes: Sequence[OneRope], fmu: RopeFmu
) -> dict[str, Path]:
    """Write the FMUs of the ropes into ``folder``; return them by the ropes' names in the system."""
    fmus = {}
    for name, parameters in _parameters(case, ropes).items():
        identifier = _identifier(name) if ropes else MODEL
        of_rope = replace(fmu, identifier=identifier)
        fmus[name] = export_rope(folder / f"{name}.fmu", case, parameters, of_rope)
    return fmus


def _identifier(rope: str) -> str:
    """Return the model identifier of one of several ropes, which can be linked into one program."""
    return re.sub(r"\W", "_", f"{MODEL}_{rope}", flags=re.ASCII)


def step_of(case: Case) -> float:
    """Return a communication step at which drive and ropes may step at the same time [s]."""
    hoist = case.hoist
    lighter_conveyance = min(hoist.mass_left, hoist.mass_right)
    if hoist.tail_mass * hoist.tail_rope_length > HEAVY_ROPE_RATIO * lighter_conveyance:
        return HEAVY_STEP
    return LIGHT_STEP


def _obstacles(case: Case, ropes: Sequence[OneRope], without: Collection[str]) -> Iterator[str]:
    """Yield the parts of ropes that no FMU can hold, each with the option that leaves it out."""
    if "guard" not in without:
        for name, parameters in _parameters(case, ropes).items():
            yield from _guards(name, parameters)
    if "break" not in without:
        for rope in ropes:
            if rope.breaks is not None:
                value = f"{rope.name}: breaks_at = {rope.breaks.t:g} s"
                yield omission_text(value, "None", "the rope of an FMU holds", "break")
    if "touching" not in without and len(ropes) > 1:
        stiffness = ropes[0].scene.shaft.contact.rope_stiffness
        if stiffness > 0.0:
            reason = "each rope of a system presses itself alone, it knows no neighbours"
            yield omission_text(
                f"contact.rope_stiffness = {stiffness:g} N/m2", "0", reason, "touching"
            )


def _guards(name: str, parameters: Mapping[str, Value]) -> Iterator[str]:
    """Yield a sentence for each guard that is set in the parameters of the rope ``name``."""
    reason = "an exported drive has no safety circuit, though the rope's guard.tripped tells of it"
    for guard in _GUARDS:
        value = parameters.get(guard, 0.0)
        if value:
            yield omission_text(f"{name}: {guard} = {value}", "0", reason, "guard")


def _parameters(case: Case, ropes: Sequence[OneRope]) -> dict[str, Mapping[str, Value]]:
    """Return the parameters of each rope by FMI name; of several ropes all, whatever the level."""
    if not ropes:
        return {ROPE: case.rope}
    return {rope.name: _values(rope) for rope in ropes}


def _values(rope: OneRope) -> dict[str, Value]:
    """Return all parameters of a rope by FMI name."""
    return {parameter.name: parameter.value for parameter in named_parameters(rope.scene)}
