"""What is compared: our variants, Exudyn's elements and options."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from benchmarks.kinematic import fixed_steps
from rope_model.parameters import Mesh, Model, Scene

from .elements import ELEMENTS
from .exudyn_rope import Method
from .runs import SIDEWAYS, TORSION_FREE, UNCOUPLED, Run, exudyn, ours, swinging_ends


@dataclass(frozen=True)
class Variant:
    """One of ours; variants of a group are one line in the figures."""

    group: str
    label: str
    scene: Scene


def _tmn(label: str, mesh: Mesh, *steps: float) -> list[Variant]:
    return [
        Variant(
            "TMN-ETM",
            f"{label}, {1e3 * h:g} ms",
            UNCOUPLED.with_(mesh=mesh, solver=fixed_steps(h)),
        )
        for h in steps
    ]


def _eem(elements: int, *steps: float) -> list[Variant]:
    mesh = Mesh(kind="eem", elements=elements)
    return [
        Variant(
            "EEM",
            f"{elements}, {1e3 * h:g} ms",
            UNCOUPLED.with_(mesh=mesh, solver=fixed_steps(h)),
        )
        for h in steps
    ]


#: a new variant of ours is one line here
OURS = [
    *_tmn("mesh to 50 mm", Mesh("auto", loop_error=0.05), 0.01, 0.02, 0.04),
    *_tmn("mesh to 5 mm", Mesh("auto"), 0.005, 0.01, 0.02, 0.04),
    *_tmn("mesh to 1 mm", Mesh("auto", loop_error=1e-3), 0.005, 0.01, 0.02),
    *_tmn("mesh to .2 mm", Mesh("auto", loop_error=2e-4), 0.005),
    *_eem(60, 0.01),
    *_eem(120, 0.01, 0.02),
    *_eem(240, 0.01, 0.02),
    *_eem(600, 0.01),
]
REFERENCE_OURS = _eem(600, 0.005)[0]
REFERENCE_PEER = ("beam-quadratic", 480, Method(0.0025, spectral_radius=0.6))

PLANAR = ("ancf", "ancf-lobatto", "beam", "beam-quadratic")
COUNTS = (30, 60, 120, 240)
#: the faster form of Newton's method at each step, see OPTIONS
METHODS = (Method(0.005, "modified"), Method(0.01, "full"), Method(0.02, "full"))
OPTIONS = [
    Method(step, newton, radius)
    for step in (0.005, 0.01, 0.02)
    for newton in ("full", "modified")
    for radius in (0.6, 0.8)
]
OPTIONS_AT = ("beam-quadratic", 120)


@dataclass(frozen=True)
class Space:
    """A comparison in space: the torsion of the scene is what the peer's ``elements`` can do."""

    title: str
    scene: Scene
    reference: Variant
    ours: tuple[Variant, ...]
    theirs: tuple[tuple[str, int, Method], ...]


def at(scene: Scene, mesh: Mesh, step: float) -> Scene:
    """``scene`` on ``mesh`` with steps of ``step``."""
    return scene.with_(mesh=mesh, solver=fixed_steps(step))


def _space(title: str, scene: Scene, theirs: list[tuple[str, int, Method]]) -> Space:
    meshes = {error: Mesh("auto", loop_error=error) for error in (0.05, 5e-3, 1e-3)}
    variants = (
        *(
            Variant("TMN-ETM", f"mesh to {1e3 * error:g} mm, {1e3 * h:g} ms", at(scene, meshes[error], h))
            for error, h in ((0.05, 0.02), (5e-3, 0.01), (5e-3, 0.02), (1e-3, 0.01))
        ),
        Variant("EEM", "240, 10 ms", at(scene, Mesh("eem", 240), 0.01)),
    )
    reference = Variant("EEM", "600, 10 ms", at(scene, Mesh("eem", 600), 0.01))
    return Space(title, scene, reference, variants, tuple(theirs))


SPACE = (
    _space(
        "without torsion",
        TORSION_FREE.with_(model=Model("spatial")),
        [("ancf-3d", n, Method(h, "full")) for n in (120, 240, 480) for h in (0.01, 0.02)],
    ),
    _space(
        "with torsion, ends locked",
        UNCOUPLED.with_(model=Model("torsional")),
        [("beam-3d", n, Method(0.01, "full")) for n in (120, 240)],
    ),
)


def planar_cases() -> dict[str, Callable[[], Run]]:
    """Ours and theirs in turn."""
    theirs = [
        (f"{ELEMENTS[e].label}, {n}, {1e3 * m.step:g} ms", partial(exudyn, e, n, m))
        for e in PLANAR
        for n in COUNTS
        for m in METHODS
    ]
    mine = [(f"{v.group}, {v.label}", partial(ours, v.group, v.label, v.scene)) for v in OURS]
    # spread ours evenly among theirs
    at = [(k + 0.5) / len(part) for part in (theirs, mine) for k in range(len(part))]
    return dict(case for _, case in sorted(zip(at, [*theirs, *mine], strict=True), key=lambda pair: pair[0]))


def space_cases(space: Space) -> dict[str, Callable[[], Run]]:
    """The reference first."""
    mine = {
        f"{v.group}, {v.label}": partial(ours, v.group, v.label, v.scene, swinging_ends)
        for v in (space.reference, *space.ours)
    }
    theirs = {
        f"{ELEMENTS[e].label}, {n}, {1e3 * m.step:g} ms": partial(exudyn, e, n, m, space.scene, SIDEWAYS)
        for e, n, m in space.theirs
    }
    return {**mine, **theirs}
