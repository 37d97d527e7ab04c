"""Parameters of the computation: mesh, accuracy, time integration, fidelity, trust in the inputs, stations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from rope_model.parameter_table import (
    LEAST_POSITIVE,
    Bounds,
    CrossCheck,
    ParameterGroup,
    at_least,
    choice,
    parameter,
    require,
    require_number,
)

MeshKind = Literal["tmn", "eem", "auto"]
FidelityChoice = Literal["auto", "torsional", "spatial", "planar", "rigid"]
Trusted = Literal["all", "position_speed", "position", "speed"]

#: more elements would be a mistake in the unit of their length
MAX_ELEMENTS = 20000
#: segments with given element counts, and their least counts
INNER_SEGMENTS = {"II": 0, "III": 0, "IV": 2, "V": 0, "VI": 0}


def _multiple(segment: int, mesh: Mesh) -> tuple[Any, ...]:
    count = mesh.counts[segment]
    fine = 2 * (1 + (mesh.counts[0] > 0)) * (1 + (mesh.counts[1] > 0))
    multiple = (2, 4, fine, 4, 2)[segment]
    min_count = fine if segment == 2 else 0
    return (count >= min_count, count % multiple == 0), count, multiple


def _pattern(mesh: Mesh) -> tuple[Any, ...]:
    ii, iii, _, v, vi = (1 * (count > 0) for count in mesh.counts)
    return (ii == vi, iii == v, ii >= iii), mesh.counts


@dataclass(frozen=True)
class Mesh(ParameterGroup):
    """Partition of the rope into elements.

    EEM: ``elements`` of equal length.  TMN-ETM: seven segments with lengths l, l/2, l/4, l/8, l/4,
    l/2, l.  Without elements in III and V those of the loop, in IV, are l/4 long, without II and VI
    too l/2.  auto: the TMN-ETM that suits the rope's own lengths and the accuracy, EEM on a short
    or stiff rope.  ``end_levels`` = 0 is the source's mesh.
    """

    kind: MeshKind = choice(
        "tmn",
        MeshKind,
        (
            "TMN-ETM: segments that follow the loop",
            "EEM: elements of equal length",
            "fitted to the rope: TMN-ETM, or EEM on a short or stiff rope",
        ),
        "0 TMN-ETM, segments that follow the loop; 1 EEM, equal lengths; 2 auto, fitted to the rope",
        "choose one",
    )
    elements: int = parameter(
        600, "", "number of elements, kind 1", Bounds(2, MAX_ELEMENTS, "use fewer or more")
    )
    coarse_length: float = parameter(
        2.0,
        "m",
        "element length of segments I and VII, kind 0; in the loop 1/8 of it, without III and V 1/4",
        at_least(LEAST_POSITIVE, "2 m suits a 120 m rope"),
    )
    counts: tuple[int, int, int, int, int] = parameter(
        (2, 4, 40, 4, 2), "", "number of elements of segment {segment}, kind 0"
    )
    end_levels: int = parameter(
        2,
        "",
        "how often the outermost elements are halved, kind 0",
        Bounds(0, 8, "2 resolves the clamped ends"),
    )
    grading_length: float = parameter(
        0.0,
        "m",
        "largest (element length)^2 in I and VII over distance from the loop, kind 0; 0: all l",
        Bounds(0.0, 1e4, "1 m suits a 1000 m rope"),
    )
    loop_error: float = parameter(
        0.0,
        "m",
        "error of the loop's place by the mesh, kind 2; 0: half of accuracy.loop",
        Bounds(0.0, 1.0, "0 suits most studies"),
    )
    lateral_frequency: float = parameter(
        0.0,
        "Hz",
        "highest frequency of ends that shake sideways, resolved by legs' elements and steps, kind 2; 0: none",
        Bounds(0.0, 50.0, "guide joints and rollers shake a conveyance at 1 to 5 Hz"),
    )

    cross_checks = (
        *(
            CrossCheck(
                f"element count of segment {name}",
                f"a {'positive ' if name == 'IV' else ''}multiple of {{!r}}",
                "a transformation moves whole coarse elements through the segment",
                partial(_multiple, segment),
            )
            for segment, name in enumerate(INNER_SEGMENTS)
        ),
        CrossCheck(
            "counts",
            "all five segments, or none in III and V, or none in II and VI too",
            "the pattern is the same on both sides and leaves out no length",
            _pattern,
        ),
        CrossCheck(
            "loop_error",
            "0 m unless mesh.kind = auto",
            "other kinds have the lengths that they are given: set kind = auto, or leave loop_error out",
            lambda mesh: (((mesh.kind == "auto") + (mesh.loop_error == 0) > 0,), mesh.loop_error),
        ),
        CrossCheck(
            "lateral_frequency",
            "0 Hz unless mesh.kind = auto",
            "other kinds have the lengths that they are given: set kind = auto, or leave lateral_frequency out",
            lambda mesh: (
                ((mesh.kind == "auto") + (mesh.lateral_frequency == 0) > 0,),
                mesh.lateral_frequency,
            ),
        ),
    )

    def __post_init__(self) -> None:
        require(
            isinstance(self.counts, Sequence) and len(self.counts) == len(INNER_SEGMENTS),
            "counts",
            self.counts,
            "five numbers",
            "give those of segments II to VI",
        )
        for segment, count in zip(INNER_SEGMENTS, self.counts, strict=True):
            require_number(f"element count of segment {segment}", count, whole=True)
        self.require_in_bounds()


@dataclass(frozen=True)
class Accuracy(ParameterGroup):
    """Allowed error of a run, from which mesh and steps follow."""

    end_force: float = parameter(
        1e-3,
        "1",
        "RMS error of the end forces over a run, relative to the largest",
        Bounds(1e-6, 1.0, "1e-3 suits most studies"),
    )
    loop: float = parameter(
        0.01,
        "m",
        "largest error of the loop's place",
        Bounds(1e-5, 1.0, "0.01 m suits most studies"),
    )


@dataclass(frozen=True)
class Solver(ParameterGroup):
    """Time integration: generalized-alpha with step-size control.

    Newton's tolerance is in m for positions and rad for twist angles; of r' it is the change over
    the shortest element.
    """

    step_max: float = parameter(
        0.02,
        "s",
        "largest time step",
        Bounds(LEAST_POSITIVE, 1.0, "10 ms suits most ropes"),
        tunable=True,
    )
    step_min: float = parameter(
        1.0e-5,
        "s",
        "smallest time step; below it a step fails",
        Bounds(LEAST_POSITIVE, "step_max", "use 1e-5 s"),
        tunable=True,
    )
    tolerance: float = parameter(
        1.0,
        "1",
        "largest local error of a step over that allowed; 1e6: no step is shortened for it",
        Bounds(LEAST_POSITIVE, 1e6, "use 1"),
        tunable=True,
    )
    newton_tolerance: float = parameter(
        3e-6,
        "1",
        "error that Newton's method may leave, in m and rad, on a rope of any size",
        Bounds(LEAST_POSITIVE, 1e-3, "use 3e-6"),
        tunable=True,
    )
    rho_inf: float = parameter(
        0.6,
        "1",
        "spectral radius of generalized-alpha at infinite frequency",
        Bounds(0.0, 1.0, "0.6 damps waves that the mesh cannot resolve"),
    )
    work_max: int = parameter(
        0,
        "",
        "Newton iterations of a communication step beyond which it gives up accuracy; 0: any number",
        Bounds(0, 100_000, "60 serves steps of 10 ms"),
        tunable=True,
    )


@dataclass(frozen=True)
class Model(ParameterGroup):
    """Fidelity of the model."""

    fidelity: FidelityChoice = choice(
        "auto",
        FidelityChoice,
        (
            "the lowest fidelity that the case needs",
            "all: tension, torsion and lateral motion, coupled",
            "lateral motion in space, without torsion",
            "motion in the plane of the loop",
            "end forces of an inextensible rope in closed form, without bending and waves",
        ),
        "how much of the rope is computed: 0 auto, 1 torsional (all), 2 spatial, 3 planar, 4 rigid",
        "'auto' takes the lowest that serves",
    )
    force_tolerance: float = parameter(
        0.0,
        "1",
        "relative error of the end forces that auto may trade for speed",
        Bounds(0.0, 1.0, "use 0 to leave nothing out"),
    )


@dataclass(frozen=True)
class Inputs(ParameterGroup):
    """Trust in the given motions, and how the rope's ends follow them."""

    given: Trusted = choice(
        "all",
        Trusted,
        (
            "position, speed and acceleration",
            "position and speed; the acceleration is estimated",
            "position alone; speed and acceleration are estimated",
            "speed alone; it is integrated, and the acceleration estimated",
        ),
        "trusted inputs: 0 all, 1 position and speed, 2 position alone, 3 speed alone",
        "'all' is exact where it can be had",
    )
    bandwidth: float = parameter(
        0.0,
        "rad/s",
        "rate at which a misfit is drawn in; 0: sqrt(accuracy.end_force gravity / accuracy.loop), some 1 rad/s",
        Bounds(0.0, 100.0, "0 suits most hosts"),
    )
    estimate_bandwidth: float = parameter(
        0.0,
        "rad/s",
        "bandwidth of estimated inputs; 0: a third of the rope's slowest axial wave",
        Bounds(0.0, 1e3, "0 suits most ropes"),
    )
    misfit_max: float = parameter(
        0.5,
        "m",
        "largest misfit of a position (m, rad) and of a speed (m/s, rad/s); of estimated inputs, largest jump",
        Bounds(LEAST_POSITIVE, 1e4, "0.5 admits motions that a rope can follow"),
    )
    acceleration_max: float = parameter(
        100.0,
        "m/s2",
        "largest acceleration of an end, m/s2 or rad/s2; absolute, as mine hoists brake with 5 m/s2 at most",
        Bounds(LEAST_POSITIVE, 1e6, "100 is beyond any hoist"),
    )
    hold_max: float = parameter(
        1.0,
        "s",
        "how long the sample of a moving end may be repeated",
        Bounds(LEAST_POSITIVE, 1e4, "1 s is beyond any slower part's step"),
    )


_PLACE_MEANING = "0 is the rope's left end, 1 its right end"


@dataclass(frozen=True)
class Stations(ParameterGroup):
    """Points of the rope with the outputs station.*; they stay in the rope while it flows through the loop."""

    first: float = parameter(
        0.0,
        "1",
        "place of the first station over the rope's length, from its left end",
        Bounds(0.0, "last", _PLACE_MEANING),
    )
    last: float = parameter(
        1.0, "1", "place of the last station, likewise", Bounds(0.0, 1.0, _PLACE_MEANING)
    )
