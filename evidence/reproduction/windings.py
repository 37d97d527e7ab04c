"""The 120 m winding with EEM and TMN-ETM, uncoupled and coupled: what is seen at the samples, and processor times."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from tqdm import tqdm

from benchmarks.kinematic import Winding, wind
from evidence.tables import Array, Table, Tables, table
from hoist_demo.control.trajectory import s_curve
from hoist_demo.parameters import Winding as Trip
from rope_model import BalanceRope, Mesh, Model, RopeSimulator, Scene, rope_120
from rope_model.physics.stress import material_values
from rope_model.simulation.mesh.partition import fit_mesh
from rope_model.simulation.rope_system import arc_lengths

COUPLINGS = ("uncoupled", "coupled")
SCENE = rope_120().scene
#: the default mesh in numbers
DEFAULT_MESH = fit_mesh(SCENE)
MESHES = {"TMN-ETM": DEFAULT_MESH, "EEM": Mesh(kind="eem", elements=600)}
TRAVEL, SETTLE = 90.0, 3.0  # m, s after the conveyances have stopped
ROUNDS = 11  # a winding of some tenths of a second is told to a few per cent by their median
SAMPLE = 5  # communication steps of 10 ms
STRESSES = ("bending", "torsion")
SIDES = ("left", "right")


def scene_of(coupling: str, mesh: Mesh) -> Scene:
    """The 120 m scene; uncoupled without Qb and Qc, but the complete model as in the source."""
    scene = SCENE.with_(mesh=mesh, model=Model("torsional"))
    return scene if coupling == "coupled" else scene.with_(rope=replace(scene.rope, Qb=0.0, Qc=0.0))


@dataclass
class Stresses:
    """Stress norms (Pa) of the elements at every sample, and where the loop is.

    ``python`` looks at the states that the rope comes to.
    """

    python: RopeSimulator
    bottom: list[float] = field(default_factory=list)  # m, arc length
    nodes: list[Array] = field(default_factory=list)  # m, arc lengths
    values: list[tuple[Array, ...]] = field(default_factory=list)

    def watch(self, rope: BalanceRope) -> None:
        """Look at the rope."""
        state, python = rope.state, self.python
        python.restore(state)
        self.bottom.append(python.loop.s)
        self.nodes.append(arc_lengths(state.partition.lengths))
        strains, torsional = python.system.strains(state.motion.q), float(state.fidelity == "torsional")
        self.values.append(material_values(rope.scene.rope, torsional, strains.T)[:2])


def follow(scene: Scene, name: str, stresses: Stresses | None = None) -> Winding:
    """One winding of 90 m; RuntimeError when it fails."""
    watch = None if stresses is None else stresses.watch
    return wind(scene, s_curve(Trip()), TRAVEL, SETTLE, SAMPLE, watch).completed(name)


def measure() -> Tables:
    """All runs, ROUNDS times and interleaved for the times; the first round's records become tables."""
    runs: dict[tuple[str, str], Winding] = {}
    stresses = {name: Stresses(RopeSimulator(scene_of("coupled", mesh))) for name, mesh in MESHES.items()}
    times: list[tuple[object, ...]] = []
    for k, coupling, name in tqdm([*product(range(ROUNDS), COUPLINGS, MESHES)], "windings", leave=False):
        watched = stresses[name] if k == 0 and coupling == "coupled" else None
        run = follow(scene_of(coupling, MESHES[name]), f"winding, {coupling}, {name}, round {k + 1}", watched)
        runs.setdefault((coupling, name), run)
        counts = run.rope.state.counts
        elements = run.rope.state.partition.lengths.size
        times.append((coupling, name, elements, k + 1, run.cpu, counts.steps, counts.newton, counts.rejections))
    names = ("coupling", "mesh", "elements", "round", "processor time [s]", "steps", "Newton iterations", "rejections")
    tables = {f"winding-{c}": _observations({name: runs[c, name] for name in MESHES}) for c in COUPLINGS}
    events = [(c, event) for c in COUPLINGS for event in runs[c, "TMN-ETM"].events]
    changes = [(c, e.t, e.kinetic) for c, e in events if e.what == "transformation"]
    t = np.array(runs["coupled", "EEM"].t)
    return {
        "times": table(names, times),
        **tables,
        "transformations": table(("coupling", "t [s]", "kinetic [J]"), changes),
        "stress-places": {"t [s]": t, **{k: v for name in MESHES for k, v in _places(name, stresses[name])}},
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
        columns[name.replace(first, "difference", 1)] = columns[name] - columns[name.replace(first, second, 1)]
    return columns


def _places(name: str, stresses: Stresses) -> Iterator[tuple[str, Array]]:
    """Where the loop is, the largest values, where they are, and the share of the rope above half of them."""
    yield f"{name} loop s [m]", np.array(stresses.bottom)
    for i, kind in enumerate(STRESSES):
        rows = []
        for nodes, values in zip(stresses.nodes, stresses.values, strict=True):
            norm, largest = values[i], int(np.argmax(values[i]))
            above = np.diff(nodes)[norm > 0.5 * norm[largest]].sum()
            rows.append((1e-6 * norm[largest], nodes[largest : largest + 2].mean(), 100 * above / nodes[-1]))
        columns = np.array(rows).T
        yield f"{name} {kind} largest [MPa]", columns[0]
        yield f"{name} {kind} largest at s [m]", columns[1]
        yield f"{name} {kind} above half [%]", columns[2]
