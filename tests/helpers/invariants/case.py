"""A scene, its motion and its communication steps, of a seed and a number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from invariants.features import DURATION, FEATURES, Drawn, Draws, Values, catalogue_rope
from invariants.motions import Ends, draw_motion
from rope_model import EndMotion, Mesh, PointForces, Scene
from rope_model.scene_names import scene_with_values

Array = np.ndarray
#: share of cases with each feature of the steps
STEPS = {"unequal steps": 0.25, "inputs at step start": 0.25, "point force": 0.15}
#: s, communication steps
LENGTHS = (0.005, 0.01, 0.02, 0.04)


@dataclass(frozen=True)
class Case:
    """All that a run takes; a relation winds it and changed copies of it."""

    seed: int
    number: int
    features: tuple[str, ...]
    scene: Scene
    motion: Callable[[float], Ends]
    times: Array  # s, of the start and of the ends of all communication steps
    late: bool = False  # the motions given are those of each step's start
    force: tuple[float, Array] | None = None  # place (m) and a dead load (N) there

    @property
    def start(self) -> float:
        return float(self.times[0])

    def at(self, t: float) -> Ends:
        return self.motion(t)

    def with_(self, **parts: object) -> Case:
        return replace(self, **parts)  # type: ignore[arg-type]

    def scene_with_values(self, **values: object) -> Case:
        """With other parameters of the scene; ``__`` stands for the dot of a name."""
        changed = {name.replace("__", "."): value for name, value in values.items()}
        return replace(self, scene=scene_with_values(self.scene, changed))  # type: ignore[arg-type]

    def point_forces(self) -> PointForces | None:
        if self.force is None:
            return None
        place, load = self.force
        rows = np.array([load])
        return PointForces(
            np.array([place]), rows, rows, float(self.times[0]), float(self.times[-1])
        )

    def moves_in_plane(self) -> bool:
        """Whether nothing leads the rope out of the plane of the loop."""
        ends = chain.from_iterable(self.at(float(t)) for t in self.times)
        return all(end.z == end.yaw == end.lean_z == 0.0 for end in ends)


def draw(seed: int, number: int, without: frozenset[str] = frozenset()) -> Case:
    """The case of this seed and number, without these features; ValueError where the product refuses the scene."""
    return Sketch(seed, number, without).case()


@dataclass
class Sketch:
    """What is drawn of a case before the product has seen it."""

    seed: int
    number: int
    without: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        duration = self.draws("duration").evenly(*DURATION)
        drawn = Drawn(self.draws("rope"), duration)
        catalogue_rope(drawn)
        self.features = list[str]()
        for feature, share in FEATURES.items():
            name = feature.__name__
            if self.draws(f"has {name}").chance(share) and name not in self.without:
                self.features.append(name)
                drawn.draws = self.draws(name)
                feature(drawn)
        self.values: Values = drawn.values
        moves, self.motion = draw_motion(self.seed, self.number, drawn, self.without)
        self.features += moves
        self._steps(drawn)

    def draws(self, feature: str) -> Draws:
        return Draws(self.seed, self.number, feature)

    def has(self, name: str) -> bool:
        return self.draws(f"has {name}").chance(STEPS[name]) and name not in self.without

    def _steps(self, drawn: Drawn) -> None:
        draws = self.draws("steps")
        step = draws.one_of(*LENGTHS)
        number = max(round(drawn.duration / step), 5)
        self.times = step * np.arange(number + 1)
        if self.has("unequal steps"):
            self.features.append("unequal steps")
            parts = np.array([draws.one_of(0.25, 0.5, 1.0, 1.5, 2.0) for _ in range(number)])
            self.times = np.concatenate(([0.0], np.cumsum(step * parts)))
        self.late = self.has("inputs at step start")
        if self.late:
            self.features.append("inputs at step start")
        self.force = None
        if self.has("point force"):
            self.features.append("point force")
            draws = self.draws("point force")
            weight = 0.02 * drawn.length * drawn.values["rope.mass_per_length"] * 9.81
            load = (
                np.array(
                    [draws.evenly(-0.2, 0.2), draws.evenly(-1.0, 0.5), draws.evenly(-0.2, 0.2)]
                )
                * weight
            )
            self.force = (draws.evenly(0.05, 0.95) * drawn.length, load)

    def case(self) -> Case:
        scene = scene_with_values(Scene(mesh=Mesh("auto")), self.values)
        return Case(
            self.seed,
            self.number,
            tuple(self.features),
            scene,
            self.motion,
            self.times,
            self.late,
            self.force,
        )


REST = EndMotion()
