"""The 120 m winding with EEM and TMN-ETM, uncoupled and coupled: what is seen at the samples, and processor times."""

from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import Winding, wind
from evidence.tables import Table, Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import BalanceRope, Mesh, Model, Scene, rope_120
from rope_model.physics.node import arc_lengths
from rope_model.physics.stress import material_values
from rope_model.reference.equations import Equations
from rope_model.reference.mesh import fitted
from rope_model.reference.outputs import lowest_point

COUPLINGS = ("uncoupled", "coupled")
SCENE = rope_120().scene
#: the default mesh in numbers, and the source's
MESHES = {"TMN-ETM": fitted(SCENE), "EEM": Mesh(kind="eem", elements=600)}
TRAVEL = 90.0  # m
SETTLE = 3.0  # s after the conveyances have stopped
ROUNDS = 11  # a winding of some tenths of a second is told to a few per cent by their median
SAMPLE = 5  # communication steps of 10 ms
STRESSES = ("bending", "torsion")
#: of a sample: where the loop is; of each norm its largest value, where that is, the rope's share above half of it
OF_A_NORM = ("largest [MPa]", "largest at s [m]", "above half [%]")
PLACES = ("loop s [m]", *(f"{kind} {x}" for kind in STRESSES for x in OF_A_NORM))
SIDES = ("left", "right")


def scene_of(coupling: str, mesh: Mesh) -> Scene:
    """The 120 m scene; uncoupled without Qb and Qc, but the complete model as in the source."""
    scene = SCENE.with_(mesh=mesh, model=Model("torsional"))
    return scene if coupling == "coupled" else scene.with_(rope=replace(scene.rope, Qb=0.0, Qc=0.0))


@dataclass
class Stresses:
    """Place of the loop and largest stresses of the elements at every sample: PLACES."""

    rows: list[list[float]] = field(default_factory=list)

    def watch(self, rope: BalanceRope) -> None:
        """Look at the rope."""
        state = rope.state
        scene = rope.scene
        lengths = state.partition.lengths
        q = state.motion.q
        nodes = arc_lengths(lengths)
        row = [lowest_point(q, nodes).s]
        held = np.zeros(q.shape, dtype=bool)  # the strains depend on no boundary
        equations = Equations.of(scene.rope, scene.layout.gravity, lengths, q, held)
        strains = equations.strains(q, state.motion.v)
        torsional = float(state.fidelity == "torsional")
        for norm in material_values(scene.rope, torsional, strains)[:2]:
            largest = int(np.argmax(norm))
            above = np.diff(nodes)[norm > 0.5 * norm[largest]].sum()
            row += (
                1e-6 * norm[largest],
                nodes[largest : largest + 2].mean(),
                100 * above / nodes[-1],
            )
        self.rows.append(row)


def follow(scene: Scene, name: str, stresses: Stresses | None = None) -> Winding:
    """One winding of 90 m; RuntimeError when it fails."""
    watch = None if stresses is None else stresses.watch
    return wind(scene, s_curve(Trip()), TRAVEL, SETTLE, SAMPLE, watch).completed(name)


def measure() -> Tables:
    """All runs, ROUNDS times and interleaved for the times; the first round's records become tables."""
    runs: dict[tuple[str, str], Winding] = {}
    stresses = {name: Stresses() for name in MESHES}
    times: list[tuple[object, ...]] = []
    for k, coupling, name in tqdm(
        [*product(range(ROUNDS), COUPLINGS, MESHES)], "windings", leave=False
    ):
        watched = stresses[name] if k == 0 and coupling == "coupled" else None
        run = follow(
            scene_of(coupling, MESHES[name]), f"winding, {coupling}, {name}, round {k + 1}", watched
        )
        runs.setdefault((coupling, name), run)
        counts = run.rope.state.counts
        elements = run.rope.state.partition.lengths.size
        times.append(
            (
                coupling,
                name,
                elements,
                k + 1,
                run.cpu,
                counts.steps,
                counts.newton,
                counts.rejections,
            )
        )
    names = (
        "coupling",
        "mesh",
        "elements",
        "round",
        "processor time [s]",
        "steps",
        "Newton iterations",
        "rejections",
    )
    tables = {
        f"winding-{c}": _observations({name: runs[c, name] for name in MESHES}) for c in COUPLINGS
    }
    events = [(c, event) for c in COUPLINGS for event in runs[c, "TMN-ETM"].events]
    changes = [(c, e.t, e.kinetic) for c, e in events if e.what == "transformation"]
    places = {
        f"{name} {x}": of for name in MESHES for x, of in table(PLACES, stresses[name].rows).items()
    }
    return {
        "times": table(names, times),
        **tables,
        "transformations": table(("coupling", "t [s]", "kinetic [J]"), changes),
        "stress-places": {"t [s]": np.array(runs["coupled", "EEM"].t), **places},
    }


def _observations(runs: dict[str, Winding]) -> Table:
    """Observation points and kinetic energy of both meshes at the samples."""
    columns = {"t [s]": np.array(next(iter(runs.values())).t)}
    for name, run in runs.items():
        observed = np.array(run.observed)
        half = 0.5 * run.rope.scene.layout.spacing
        for i, side in enumerate(SIDES):
            # counted from the plumb line below the end
            columns[f"{name} {side} in plane [mm]"] = 1e3 * (observed[:, i, 0] + (half, -half)[i])
            columns[f"{name} {side} out of plane [mm]"] = 1e3 * observed[:, i, 2]
            columns[f"{name} {side} theta [mrad]"] = 1e3 * observed[:, i, 6]
        columns[f"{name} kinetic [J]"] = np.array(run.kinetic)
    first, second = runs
    for name in [n for n in columns if n.startswith(first)]:
        # six digits of a large number are too few for a small difference
        columns[name.replace(first, "difference", 1)] = (
            columns[name] - columns[name.replace(first, second, 1)]
        )
    return columns
