"""Fit the constants of physics.contact_error on trips past a divider that no page judges; a minute.

python -m evidence.contact.estimates prints, of each trip on the fitted mesh against many equal elements, which
constants its errors ask for, and their geometric means.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rope_model.parameters import Scene
from rope_model.physics import contact_error
from rope_model.physics.contact_error import ContactSums, with_contact_of_place

from .brushed import STOP, Brushed, brushed

#: m: offset and height of the divider; the last is too far to be touched
TRIPS, FREE = ((-1.12, -30.0), (-1.05, -30.0), (-0.95, -30.0), (-0.93, -22.0)), (-0.3, -30.0)
#: equal elements and steps (s) of the fine runs
FINE = 480, 4e-3


def errors(offset: float, height: float) -> tuple[Brushed, float, float]:
    """The trip on the fitted mesh; errors of its end forces (root mean square, N) and of the loop's place (m)."""
    coarse, fine = brushed(offset=offset, height=height), brushed(*FINE, offset=offset, height=height)
    forces: NDArray[np.float64] = np.sqrt(np.square(coarse.forces - fine.forces).mean(axis=1))
    loop = np.linalg.norm(coarse.loop - fine.loop, axis=0)
    return coarse, float(forces.max()), float(loop.max())


def main() -> None:
    """The command."""
    # what the mesh misses without contact is not what these constants tell
    _, force, place = errors(*FREE)
    print(f"untouched: end forces {force:.3g} N, loop {1e3 * place:.3g} mm")
    asked = []
    for trip in TRIPS:
        x, at_ends, of_place = errors(*trip)
        more = [math.sqrt(max(a * a - b * b, 0.0)) for a, b in ((at_ends, force), (of_place, place))]
        per_one = with_contact_of_place(Scene(), 0.0, ContactSums(square=x.square)) / contact_error.OF_PLACE
        asked.append((more[0] / math.sqrt(x.square / STOP), more[1] / per_one))
        print(
            f"offset {trip[0]} m, height {trip[1]} m: AT_ENDS {asked[-1][0]:.3g}, OF_PLACE {asked[-1][1]:.3g}",
            flush=True,
        )
    for name, column in zip(("AT_ENDS", "OF_PLACE"), zip(*asked, strict=True), strict=True):
        mean = math.exp(sum(map(math.log, column)) / len(column))
        print(f"{name} = {mean:.3g}, now {getattr(contact_error, name)}")


if __name__ == "__main__":
    main()
