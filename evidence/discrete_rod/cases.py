"""The same ropes in rope_model and as discrete rods: at rest, in small vibration, wound, and let go by a swivel.

Every case is computed on two meshes of rope_model and on meshes of the rod that halve its edges from one to the next.
The rod's error falls fourfold from mesh to mesh, so its limit is that of the two finest continued (Richardson).  Where
both solve the same equations, the finer mesh of rope_model is off that limit by no more than the errors that the two
codes' own convergence tells: a third of what the finest mesh of each changed, twice that for rope_model, whose order
lies between 2 and 4 and shows only once its mesh is fine.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from evidence.discrete_rod.rod import Rod
from evidence.discrete_rod.solve import (
    HELD,
    Record,
    equilibrium,
    first_guess,
    lowest_of,
    modes,
    move,
)
from evidence.ropes import at_rest, require
from evidence.tables import Array
from rope_model import (
    BalanceRope,
    EndMotion,
    Layout,
    Mesh,
    Model,
    Rope,
    Scene,
    Solver,
    Swivel,
)
from rope_model.analysis.modes import natural_modes
from rope_model.engine import NativeRope

Results = dict[str, Array]

#: published coupling, Qb and Qc not quite equal
PUBLISHED = Rope(Qb=2.371e5, Qc=2.301e5)
#: short and ten times softer along, with more torque per weight, so that both codes wind it in minutes
SHORT = Rope(length=40.0, Qa=1.2e7, Qb=1.015e5, Qc=0.985e5, EI=600.0)
SPACING = Layout().spacing
SIDES = ("left", "right")
OF_AN_END = ("fx", "fy", "fz", "swivel.torque", "swivel.angle")
#: signals of ours that are compared
READ = (
    "loop.x",
    "loop.y",
    "loop.z",
    "loop.yaw",
    *(f"{side}.{name}" for side in SIDES for name in OF_AN_END),
)
TRAVEL = 12.0  # m
DURATION = 8.0  # s
RELEASE = 0.1  # s
#: s, instants that are compared of a winding and of a release
WOUND = np.linspace(0.0, 10.0, 101)
LET_GO = np.linspace(0.0, 2.0, 101)
#: a dirty swivel: it slips, sticks, and slips again
DIRTY = Swivel(mode="coulomb", mu_static=0.02, mu_kinetic=0.015, release_time=RELEASE)


@dataclass(frozen=True)
class Winding:
    """Height, speed and acceleration (m, s) of the left end at t >= 0; the right end comes down from ``travel``."""

    travel: float
    duration: float  # infinite: at rest

    def __call__(self, t: float) -> tuple[float, float, float]:
        x = min(t / self.duration, 1.0)
        rise = x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)
        speed = 140 * (x * (1 - x)) ** 3
        change = 420 * (x * (1 - x)) ** 2 * (1 - 2 * x)
        pace = self.travel / self.duration
        return self.travel * rise, pace * speed, pace * change / self.duration

    def ours(self, t: float) -> tuple[EndMotion, EndMotion]:
        y, v, a = self(t)
        return EndMotion(y=y, vy=v, ay=a), EndMotion(y=self.travel - y, vy=-v, ay=-a)

    def rod(self, t: float) -> Array:
        y, v, a = self(t)
        ends = np.zeros((3, 2, 3))
        ends[0, :, 0] = -0.5 * SPACING, 0.5 * SPACING
        ends[:, :, 1] = (y, self.travel - y), (v, -v), (a, -a)
        return ends


def grade(length: float, bottom: float, edges: int) -> Array:
    """(edges,): edge lengths, short at the clamps and around the loop's lowest point at arc length ``bottom``."""
    s = np.linspace(0.0, length, 100 * edges + 1)
    size = np.minimum(0.2 + 0.06 * np.abs(s - bottom), 0.08 + 0.25 * np.minimum(s, length - s))
    count = np.concatenate(([0.0], np.cumsum(0.5 * (1 / size[1:] + 1 / size[:-1]))))
    return np.diff(np.interp(np.linspace(0.0, count[-1], edges + 1), count, s))


def rope_of(scene: Scene, ends: Winding, step: float = 1e-3) -> BalanceRope:
    """Ours, at rest; complete, with a ``step`` (s) short enough that only the mesh errs."""
    solver = Solver(step_max=step, tolerance=0.1)
    return at_rest(scene.with_(solver=solver, model=Model("torsional")), *ends.ours(0.0))


def present(rope: BalanceRope) -> tuple[Array, Array, Array, float, Array]:
    """What a Record holds of ours: forces (2, 3) and moments (2,) on its ends, lowest point, yaw, swivels' angles."""
    x = rope.signals(READ)
    return (
        np.array([[-x[f"{side}.f{axis}"] for axis in "xyz"] for side in SIDES]),
        np.array([x[f"{side}.swivel.torque"] for side in SIDES]),
        np.array([x[f"loop.{axis}"] for axis in "xyz"]),
        x["loop.yaw"],
        np.array([x[f"{side}.swivel.angle"] for side in SIDES]),
    )


# at rest


def _rest(reaction: Array, moment: Array, bottom: Array, yaw: float) -> Results:
    values = {
        "side force, in plane [N]": reaction[0, 0],
        "side force, out of plane [N]": reaction[0, 2],
        "torque [N m]": moment[1],
        "lowest point, y [m]": bottom[1],
        "yaw of the loop [rad]": yaw,
    }
    return {name: np.array(value) for name, value in values.items()}


def statics_ours(elements: int) -> Results:
    """120 m, both swivels locked, ends at equal height."""
    r = rope_of(Scene(rope=PUBLISHED, mesh=Mesh("eem", elements=elements)), Winding(0.0, np.inf))
    return _rest(*present(r)[:4])


def statics_rod(edges: int) -> Results:
    """The same."""
    lengths = grade(PUBLISHED.length, 0.5 * PUBLISHED.length, edges)
    rod = Rod(lengths, PUBLISHED, Winding(0.0, np.inf).rod)
    y = equilibrium(rod, first_guess(rod))
    loads = rod.evaluate(0.0, y[:, None], HELD)
    return _rest(loads.reaction[:, :, 0], loads.moment[:, 0], *lowest_of(rod.s, rod.nodes(0.0, y)))


# small vibration


def _by_plane(frequencies: Array, out_of_plane: Array) -> Results:
    out = out_of_plane > 0.5
    planes = {"out of plane": frequencies[out], "in plane": frequencies[~out]}
    return {f"{name} f{i + 1} [Hz]": f[i] for name, f in planes.items() for i in range(4)}


def _in_order(frequencies: Array, _: Array) -> Results:
    return {f"f{i + 1} [Hz]": frequencies[i] for i in range(8)}


#: name -> rope, height difference (m), how its modes are named
VIBRATIONS: dict[str, tuple[Rope, float, Callable[[Array, Array], Results]]] = {
    "uncoupled, 0 m": (Rope(Qb=0.0, Qc=0.0), 0.0, _by_plane),
    "coupled, 80 m": (Rope(), 80.0, _in_order),
}


def modes_ours(case: str, elements: int) -> Results:
    """120 m, swivels locked, in one of VIBRATIONS."""
    rope, height, named = VIBRATIONS[case]
    r = rope_of(Scene(rope=rope, mesh=Mesh("eem", elements=elements)), Winding(height, np.inf))
    engine = NativeRope(r.scene)
    engine.restore(r.state)
    found = natural_modes(engine, 10)
    return named(found.frequencies, found.out_of_plane)


def modes_rod(case: str, edges: int) -> Results:
    """The same."""
    rope, height, named = VIBRATIONS[case]
    rod = Rod(
        grade(rope.length, 0.5 * (rope.length - height), edges), rope, Winding(height, np.inf).rod
    )
    return named(*modes(rod, equilibrium(rod, first_guess(rod)), 10))


# in time


def follow(rope: BalanceRope, ends: Winding, times: Array) -> Record:
    """Our rope along ``ends``, with communication steps of 10 ms that end on ``times``."""
    rows = [present(rope)]
    switches = list[float]()
    interval = 0.01
    for k in range(1, round(times[-1] / interval) + 1):
        require(rope.advance_to(k * interval, *ends.ours(k * interval)))
        switches += [event.t for event in rope.state.events if "swivel" in event.what]
        if np.abs(times - k * interval).min() < 1e-9:
            rows.append(present(rope))
    reaction, moment, bottom, yaw, angle = (np.array(x) for x in zip(*rows, strict=True))
    return Record(reaction, moment, bottom, yaw, angle, tuple(switches))


def _histories(r: Record) -> Results:
    return {
        "left end, side force in plane [N]": r.reaction[:, 0, 0],
        "right end, side force in plane [N]": r.reaction[:, 1, 0],
        "left end, vertical force [N]": r.reaction[:, 0, 1],
        "left end, side force out of plane [N]": r.reaction[:, 0, 2],
        "left end, torque [N m]": r.moment[:, 0],
        "lowest point, x [m]": r.bottom[:, 0],
        "lowest point, y [m]": r.bottom[:, 1],
        "lowest point, z [m]": r.bottom[:, 2],
        "yaw of the loop [rad]": r.yaw,
    }


def winding_ours(multiple: int, times: Array = WOUND) -> Results:
    """40 m, swivels locked, 12 m in 8 s; TMN-ETM, the loop's elements 0.25 m over ``multiple``."""
    counts = tuple(multiple * n for n in (2, 4, 40, 4, 2))
    mesh = Mesh("tmn", coarse_length=2.0 / multiple, counts=counts)  # type: ignore[arg-type]
    ends = Winding(TRAVEL, DURATION)
    return _histories(follow(rope_of(Scene(rope=SHORT, mesh=mesh), ends), ends, times))


def winding_rod(edges: int, times: Array = WOUND) -> Results:
    """The same, on equal edges."""
    rod = Rod(np.full(edges, SHORT.length / edges), SHORT, Winding(TRAVEL, DURATION).rod)
    return _histories(move(rod, equilibrium(rod, first_guess(rod)), times))


def _release(r: Record) -> Results:
    """Histories, and when the swivel first came to rest and slipped again."""
    results = {"swivel's angle [rad]": r.angle[:, 1], "left end, torque [N m]": r.moment[:, 0]}
    results |= {
        "left end, side force out of plane [N]": r.reaction[:, 0, 2],
        "yaw of the loop [rad]": r.yaw,
    }
    names = ("sticks at [s]", "slips again at [s]")
    return results | {name: np.array(t) for name, t in zip(names, r.switches[1:3], strict=False)}


def release_ours(elements: int, times: Array = LET_GO) -> Results:
    """40 m at rest, ends 12 m apart in height; the right swivel is let go at 0.1 s, with dry friction."""
    ends = Winding(TRAVEL, np.inf)
    scene = Scene(rope=SHORT, right=DIRTY, mesh=Mesh("eem", elements=elements))
    return _release(follow(rope_of(scene, ends, 2e-4), ends, times))


def release_rod(edges: int, times: Array = LET_GO) -> Results:
    """The same."""
    rod = Rod(np.full(edges, SHORT.length / edges), SHORT, Winding(TRAVEL, np.inf).rod, DIRTY)
    return _release(move(rod, equilibrium(rod, first_guess(rod)), times, RELEASE))


# side by side


@dataclass(frozen=True)
class Comparison:
    """One quantity, a number or a history, on two meshes of ours and on the rod's, coarse to fine."""

    ours: tuple[Array, ...]
    rod: tuple[Array, ...]

    @property
    def limit(self) -> Array:
        """The rod's, for edges of no length."""
        return self.rod[-1] + (self.rod[-1] - self.rod[-2]) / 3

    @property
    def differences(self) -> tuple[float, ...]:
        """Largest differences of ours from the limit, coarse to fine."""
        return tuple(_largest(x - self.limit) for x in self.ours)

    @property
    def order(self) -> float:
        """Observed order of the rod; NaN with two meshes."""
        changes = [_largest(b - a) for a, b in zip(self.rod, self.rod[1:], strict=False)]
        return (
            float(np.log2(changes[-2] / changes[-1]))
            if len(changes) > 1 and min(changes) > 0
            else np.nan
        )

    @property
    def acceptance(self) -> float:
        """What the finer of ours may differ from the limit by, from the convergence of both."""
        ours, rod = (_largest(x[-1] - x[-2]) / 3 for x in (self.ours, self.rod))
        return 2 * ours + rod


def _largest(x: Array) -> float:
    return float(np.abs(x).max())


@dataclass(frozen=True)
class Case:
    """A case by the functions that compute it on a mesh, and the meshes."""

    name: str
    ours: Callable[[int], Results]
    rod: Callable[[int], Results]
    ours_on: tuple[int, ...]
    rod_on: tuple[int, ...]

    def compare(self) -> dict[str, Comparison]:
        """Every quantity by its name."""
        ours = [self.ours(n) for n in self.ours_on]
        rod = [self.rod(n) for n in self.rod_on]
        return {
            name: Comparison(tuple(x[name] for x in ours), tuple(x[name] for x in rod))
            for name in ours[-1]
        }


def cases() -> list[Case]:
    """What the page shows."""
    edges = (80, 160, 320)
    rest = (150, 300, 600)
    return [
        Case("rest, published coupling, 120 m", statics_ours, statics_rod, (600, 1200), rest),
        *(
            Case(
                f"frequencies, 120 m, {name}",
                partial(modes_ours, name),
                partial(modes_rod, name),
                (600, 1200),
                rest,
            )
            for name in VIBRATIONS
        ),
        Case("winding", winding_ours, winding_rod, (1, 2), edges),
        Case("release of a swivel", release_ours, release_rod, (80, 160), edges),
    ]
