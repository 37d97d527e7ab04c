"""What equal elements of a bend's length and more do to a loop at rest: ``python -m evidence.mesh_rule.coarse``.

On elements longer than some .7 w, w = (EI / rho g)^(1/3), the loop slips aside and turns by which node hangs lowest.
Prints the largest error of its place over the law of the loop, and of its yaw over x = element / w, of all places of
the nodes: on ropes of the seed that the constants of method.mesh_error come from, and of the judge's.
"""

from dataclasses import replace
from itertools import islice
from typing import NamedTuple

import numpy as np

from evidence.mesh_rule.scenes import FIT, JUDGE, Sample, draw
from evidence.ropes import at_rest
from evidence.tables import Array
from rope_model import EndMotion, Mesh, Model, Scene
from rope_model.method.mesh_error import bend_error
from rope_model.physics.estimates import bending_length

#: x tried, places of the nodes within an element, ropes, the longest of them (m) and the shortest
LENGTHS = (0.5, 0.65, 0.8, 1.0, 1.2, 1.5, 2.0, 3.0)
PLACES = 5
ROPES = 5
LONGEST = 300.0
SHORTEST = 36.0  # in w
#: coupling over its bound
COUPLED = 0.3
FINE = 3e-4  # m, loop_error of the mesh to compare with
HEIGHT = 20.0  # m, of the left end
_SIGNALS = ("loop.x", "loop.y", "loop.z", "loop.yaw")


class Off(NamedTuple):
    """Of a rope's loop on elements of x w: largest errors, m and rad, and what the law of the loop expects, m."""

    x: float
    law: float
    place: float
    yaw: float


def hang(scene: Scene, height: float) -> Array:
    """Place and yaw of the loop at rest."""
    return np.array(list(at_rest(scene, EndMotion(y=height)).signals(_SIGNALS).values()))


def coupled(sample: Sample) -> Scene:
    """The rope with a torque that yaws its loop."""
    Qb = COUPLED * (sample.rope.Qa * sample.rope.Qd) ** 0.5
    return Scene(replace(sample.rope, Qb=Qb, Qc=Qb), sample.layout, model=Model("torsional"))


def measure(scene: Scene, x: float) -> Off:
    """Largest errors over PLACES of the nodes."""
    rope = scene.rope
    w = float(bending_length(scene))
    elements = round(rope.length / (x * w))
    fine = rope.length / elements
    off = []
    for k in range(PLACES):
        height = HEIGHT + 2 * fine * k / PLACES
        equal, exact = (
            hang(scene.with_(mesh=m), height)
            for m in (Mesh("eem", elements), Mesh("auto", loop_error=FINE))
        )
        off.append(equal - exact)
    found = np.array(off)
    place = np.linalg.norm(found[:, :3], axis=1).max()
    yaw = np.abs(found[:, 3]).max()
    return Off(fine / w, float(bend_error(scene, fine)), float(place), float(yaw))


def rows(seed: int) -> list[list[Off]]:
    """By the length of the elements, of ropes that are long enough for them, in their plane and out of it."""
    ropes = list(
        islice(
            (s for s in draw(seed, 20 * ROPES) if SHORTEST * s.w < s.rope.length < LONGEST), ROPES
        )
    )
    scenes = [
        scene
        for s in ropes
        for scene in (Scene(s.rope, s.layout, model=Model("planar")), coupled(s))
    ]
    return [[measure(scene, x) for scene in scenes] for x in LENGTHS]


def main() -> None:
    """Print both tables."""
    for seed in (FIT, JUDGE):
        print(f"seed {seed}: x, place / law (smallest, median, largest), yaw / x (the same)")
        for of_length in rows(seed):
            places = [e.place / e.law for e in of_length]
            yaws = [e.yaw / e.x for e in of_length[1::2]]
            shown = (
                " ".join(f"{x:.3g}" for x in np.quantile(v, (0, 0.5, 1))) for v in (places, yaws)
            )
            print(f"  {of_length[0].x:.2f}   {'   '.join(shown)}")


if __name__ == "__main__":
    main()
