"""A rope with coupling of tension and torsion, at rest and wound: CableDyn 0.3.0, which has none, against ours.

With N = Qa e + Qb tau and M = Qc e + Qd tau, a torque M that is the same all along the rope leaves

    N = EA (l / L - 1),   EA = Qa - Qb Qc / Qd,   L = L0 (1 - Qb M / (Qd EA)),

the tension of a rope without coupling, of another stiffness and length.  Its torque is M where the end is turned by
what the tension twists ours, Qc / Qd times the integral of the strain e = N / EA - Qb M / (Qd EA).  Length and turn
follow from CableDyn's own tension and torque, so they are iterated.  EA, GJ, EI and mass count per length L0; L is
shorter by 2e-6 of it.

The torque is uniform at rest, and nearly so in motion: CableDyn leaves out the inertia of the spin, which changes ours
by 0.002 N m (RMS) in this winding.  L stays that at rest.
"""

import math

import numpy as np

from evidence.discrete_rod.cases import PUBLISHED, SPACING, Winding, present, rope_of
from evidence.discrete_rod.solve import lowest_of
from evidence.tables import Array, Table, table
from evidence.validation import cabledyn
from evidence.validation.cabledyn import GRAVITY, Cable, Found
from rope_model import EndMotion, Mesh, Scene

HEIGHTS = (0.0, 40.0, 80.0)  # m
#: at rest, coarse and fine; in motion
MESHES = (480, 960)
ELEMENTS = 240
QUANTITIES = (("torque", "N m"), ("yaw of the loop", "deg"), ("lowest point, y", "m"))
#: each leaves less than a tenth of the change of the one before, at rest
RUNS = 5

_EA = PUBLISHED.Qa - PUBLISHED.Qb * PUBLISHED.Qc / PUBLISHED.Qd
_STRAIN = PUBLISHED.Qb / (PUBLISHED.Qd * _EA)  # 1/(N m), of the torque
_TURN = PUBLISHED.Qc / PUBLISHED.Qd * PUBLISHED.length  # rad, of the mean strain


def followed(spacing: float, drop: float, elements: int, ends: list[EndMotion]) -> Found:
    """Iterate CableDyn's runs, from the strain of hanging legs; their tension and torque are ours."""
    apart = np.array([drop + end.y for end in ends])
    strain = (
        PUBLISHED.mass_per_length
        * GRAVITY
        * (PUBLISHED.length + apart**2 / PUBLISHED.length)
        / (4.0 * _EA)
    )
    torque = np.zeros(len(ends))
    for _ in range(RUNS):
        turn = np.degrees(_TURN * (strain - _STRAIN * torque))
        cable = Cable(
            _EA, PUBLISHED.length * (1.0 - _STRAIN * torque[0]), elements, spacing, turn[0], drop
        )
        found = cable.follow(ends, turn[0] - turn)
        torque = found.torque
        strain = found.tension.mean(axis=1) / _EA
    return found


def _ours(height: float, elements: int) -> Array:
    scene = Scene(rope=PUBLISHED, mesh=Mesh("eem", elements=elements))
    _, moment, bottom, yaw, _ = present(rope_of(scene, Winding(height, np.inf)))
    return np.array([moment[1], math.degrees(yaw), bottom[1] - height])


def _theirs(height: float, elements: int) -> Array:
    found = followed(SPACING, height, elements, [EndMotion()] * 2)
    bottom, yaw = lowest_of(np.arange(elements + 1.0), found.nodes[0])
    return np.array([found.torque[0], math.degrees(yaw), bottom[1]])


def rest() -> Table:
    """Both codes on two meshes; accepted are two thirds of the changes from the coarse one to the fine."""
    found = list[tuple[float | str, ...]]()
    for height in HEIGHTS:
        ours, theirs = (np.array([code(height, n) for n in MESHES]) for code in (_ours, _theirs))
        accepted = (np.abs(np.diff(ours, axis=0)) + np.abs(np.diff(theirs, axis=0))) * 2.0 / 3.0
        columns = (*ours, *theirs, np.abs(ours[1] - theirs[1]), *accepted)
        found += [
            (height, *row) for row in zip(*zip(*QUANTITIES, strict=True), *columns, strict=True)
        ]
    codes = [f"{code}, {mesh}" for code in ("ours", "CableDyn") for mesh in ("coarse", "fine")]
    return table(("height", "quantity", "unit", *codes, "difference", "accepted"), found)


def winding() -> Table:
    """Both codes every quarter second; an end is wound so smoothly that it excites no waves along the rope."""
    ends = cabledyn.sampled(lambda t: Winding(cabledyn.WAY, cabledyn.TIME).ours(t)[0])
    ours = cabledyn.our_winding(PUBLISHED, ELEMENTS, ends)
    return cabledyn.compared(ours, followed(cabledyn.SPACING, 0.0, ELEMENTS, ends))
