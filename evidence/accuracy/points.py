"""What is wound: points of the chart in families, each a mesh, a solver and a model for one coupling."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product

from benchmarks.kinematic import fixed_steps
from evidence.reproduction.windings import COUPLINGS, scene_of
from hoist_demo.parameters import Winding as Trip
from rope_model.cases import LEVELS
from rope_model.parameters import Scene
from rope_model.solver_parameters import Accuracy, FidelityChoice, Mesh, Model, Solver

#: s, every run is sampled at multiples of it; every communication step divides it
SAMPLE = 0.04
#: s, shortest communication step
SHORTEST = 0.01
STEPS = (5e-3, 10e-3, 20e-3, 40e-3)  # s
EEM_ELEMENTS = (60, 100, 150, 200, 300, 600)
EEM_LARGEST = 200  # elements; finer meshes gain nothing from the longest step, which halving makes short again
TMN_ERRORS = (0.05, 0.01, 5e-3, 2e-3, 1e-3, 3e-4, 1e-4)  # m, loop_error
#: the last of each is the reference solution
REFERENCE_ELEMENTS = (200, 400, 800)
REFERENCE_STEPS = (10e-3, 5e-3, 2.5e-3)  # s
#: the trip, and rest after it (s)
TRIP = Trip()
SETTLE = 3.0


@dataclass(frozen=True)
class Point:
    """One run: ``name`` is its label within its family."""

    family: str
    name: str
    coupling: str
    mesh: Mesh = field(default_factory=lambda: Mesh("auto"))
    solver: Solver = field(default_factory=Solver)
    model: Model = Model()  # noqa: RUF009 - immutable
    accuracy: Accuracy = Accuracy()  # noqa: RUF009 - immutable
    interval: float = 0.0  # s, communication step; 0: the largest step, or SHORTEST

    @property
    def communication(self) -> float:
        """s, communication step."""
        return self.interval or max(SHORTEST, self.solver.step_max)

    @property
    def scene(self) -> Scene:
        """The 120 m scene of this point."""
        return scene_of(self.coupling, self.mesh).with_(
            solver=self.solver, model=self.model, accuracy=self.accuracy
        )


def eem_name(elements: int, step: float) -> str:
    """Name of a point of equal elements."""
    return f"{elements}, {1e3 * step:g} ms"


#: the reference solution's
FINEST = eem_name(REFERENCE_ELEMENTS[-1], REFERENCE_STEPS[-1])


def points() -> list[Point]:
    """Return everything, in the order of its measurement."""
    return [p for c in COUPLINGS for p in _all(c)]


def _all(coupling: str) -> Iterator[Point]:
    for n, h in product(REFERENCE_ELEMENTS, REFERENCE_STEPS):
        yield Point("reference", eem_name(n, h), coupling, Mesh("eem", elements=n), fixed_steps(h))
    yield from _levels(coupling)
    for n, h in product(EEM_ELEMENTS, STEPS):
        if n > EEM_LARGEST and h == max(STEPS):
            continue
        yield Point("eem", eem_name(n, h), coupling, Mesh("eem", elements=n), fixed_steps(h))
    chosen = {f"{e:g} m": Mesh("auto", loop_error=e) for e in TMN_ERRORS} | {
        "published": Mesh(end_levels=0)
    }
    for (name, mesh), h in product(chosen.items(), STEPS):
        yield Point("tmn", f"{name}, {1e3 * h:g} ms", coupling, mesh, fixed_steps(h))
    yield from _fidelities(coupling)


def _levels(coupling: str) -> Iterator[Point]:
    """The levels, and the standard one in a host that communicates every 10 ms."""
    for level, settings in LEVELS.items():
        yield Point("levels", level, coupling, **settings)
        if level == "standard":
            yield Point("levels", "standard, 10 ms", coupling, **settings, interval=SHORTEST)


def _fidelities(coupling: str) -> Iterator[Point]:
    """Exact ones where the rope is uncoupled; in the coupled rope the lower ones leave something out."""
    exact: tuple[FidelityChoice, ...] = ("torsional", "spatial", "planar", "rigid")
    approximate: tuple[FidelityChoice, ...] = ("torsional", "planar", "rigid")
    for fidelity in exact if coupling == "uncoupled" else approximate:
        yield Point("fidelities", fidelity, coupling, model=Model(fidelity))
