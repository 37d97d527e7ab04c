"""The planar winding and natural frequencies in Exudyn and in ours: ten minutes on a free machine."""

from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.kinematic import fixed_steps
from evidence.errors import force_error
from evidence.exudyn.exudyn_rope import ELEMENTS, Method, PeerRope
from evidence.exudyn.runs import UNCOUPLED, Run, exudyn, hanging_shape, measure_times, ours
from evidence.ropes import require
from evidence.tables import Measures, Tables, table
from rope_model.analysis.modes import natural_modes
from rope_model.boundary.end_paths import EndMotion
from rope_model.engine import NativeRope
from rope_model.solver_parameters import Mesh, Model

ROUNDS = 3  # s
SHORT = 3.0  # s
#: label of a mesh to the mesh and its steps (s)
TMN = {
    "mesh to 50 mm": (Mesh("auto", loop_error=0.05), (0.01, 0.02, 0.04)),
    "mesh to 5 mm": (Mesh("auto"), (0.005, 0.01, 0.02, 0.04)),
    "mesh to 1 mm": (Mesh("auto", loop_error=1e-3), (0.005, 0.01, 0.02)),
    "mesh to .2 mm": (Mesh("auto", loop_error=2e-4), (0.005,)),
}
EEM = {60: (0.01,), 120: (0.01, 0.02), 240: (0.01, 0.02), 600: (0.01,)}
#: the finest of each code, which judge
FINEST = (600, 0.005)
FINEST_PEER = ("beam-quadratic", 480, Method(0.0025, spectral_radius=0.6))
PLANAR = ("ancf", "ancf-lobatto", "beam", "beam-quadratic")
COUNTS = (30, 60, 120, 240)
#: of the frequencies: m between the ends, elements and their number, modes
HEIGHTS = (0.0, 80.0)
PEER_MODES = (("beam-quadratic", 240), ("ancf-lobatto", 240), ("beam", 480))
MODES = 4
#: the faster form of Newton's method at each step
METHODS = (Method(0.005, "modified"), Method(0.01, "full"), Method(0.02, "full"))


def our_case(group: str, label: str, mesh: Mesh, h: float) -> tuple[str, Callable[[], Run]]:
    """Return one winding of ours by its name."""
    label = f"{label}, {1e3 * h:g} ms"
    return f"{group}, {label}", partial(
        ours, group, label, UNCOUPLED.with_(mesh=mesh, solver=fixed_steps(h))
    )


def planar_cases() -> dict[str, Callable[[], Run]]:
    """Return ours and theirs, taking turns."""
    mine = [
        our_case("TMN-ETM", name, mesh, h) for name, (mesh, steps) in TMN.items() for h in steps
    ]
    mine += [
        our_case("EEM", str(n), Mesh("eem", elements=n), h)
        for n, steps in EEM.items()
        for h in steps
    ]
    theirs: list[tuple[str, Callable[[], Run]]] = [
        (f"{e}, {n}, {m.step}", partial(exudyn, e, n, m))
        for e in PLANAR
        for n in COUNTS
        for m in METHODS
    ]
    at = [(k + 0.5) / len(part) for part in (theirs, mine) for k in range(len(part))]
    return dict(
        case for _, case in sorted(zip(at, [*theirs, *mine], strict=True), key=lambda pair: pair[0])
    )


def winding() -> Tables:
    """Measure errors of every planar winding against our finest mesh and against Exudyn's, and its processor time."""
    finest = our_case("EEM", str(FINEST[0]), Mesh("eem", elements=FINEST[0]), FINEST[1])[1]()
    judges = (finest, exudyn(*FINEST_PEER))
    rows = []
    for r in [finest, *measure_times(planar_cases(), ROUNDS, SHORT)]:
        errors = [force_error(r.force, x.force) for x in judges]
        errors += [float(np.abs(r.bottom - x.bottom).max()) for x in judges]
        rows.append((r.code, r.group, r.label, r.elements, r.step, r.cost, *errors, r.failure))
    names = (
        *("code", "group", "variant", "elements", "step_s", "cpu_s_per_s"),
        *(
            "force_error_vs_ours",
            "force_error_vs_exudyn",
            "loop_error_vs_ours_m",
            "loop_error_vs_exudyn_m",
            "failure",
        ),
    )
    return {"winding": table(names, rows)}


def frequencies() -> Tables:
    """Compute the lowest in-plane frequencies of the hanging rope in both codes, ends at two height differences."""
    rows = []
    for height in HEIGHTS:
        rows += [(height, "ours, 600 elements", *our_modes(height))]
        for key, count in PEER_MODES:
            rope = PeerRope(
                UNCOUPLED, key, count, hanging_shape(UNCOUPLED, (height, 0.0)), (height, 0.0)
            )
            rope.rest()
            rows.append(
                (height, f"Exudyn {ELEMENTS[key].label}, {count}", *rope.frequencies(MODES)[:MODES])
            )
    return {
        "frequencies": table(("height_m", "code", *(f"f{k + 1}_Hz" for k in range(MODES))), rows)
    }


def our_modes(height: float) -> list[float]:
    """Return ours, Hz."""
    rope = NativeRope(UNCOUPLED.with_(mesh=Mesh(kind="eem", elements=600), model=Model("planar")))
    require(rope.initialize(0.0, EndMotion(y=height), EndMotion()))
    modes = natural_modes(rope, 3 * MODES)
    return [float(f) for f in modes.frequencies[modes.out_of_plane < 0.5][:MODES]]


MEASURES: Measures = {"frequencies": frequencies, "winding": winding}
