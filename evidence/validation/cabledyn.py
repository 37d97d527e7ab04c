"""A winding of a rope twisted by 90 degrees, clamped as a U at both ends, one end held: CableDyn against ours.

CableDyn 0.3.0 (SMI-Lab-Inha, Apache-2.0) has cubic elements and quasi-static torsion without coupling to tension; its
rope hangs in water of hardly any density.  It moves one end of a rope that bends.  Both take the same steps of
generalized-alpha with the same spectral radius, without damping.  CableDyn's pull of a moving end leaves out what
accelerates half of the first element, which is put in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.kinematic import fixed_steps
from evidence.tables import Table, table
from evidence.validation.statics import Array
from rope_model import EndMotion, balance_rope
from rope_model.parameters import Layout, Mesh, Model, Rope, Scene, Swivel
from rope_model.simulation.rope_system import ANGLE, POSITION

ROPE, GRAVITY = Rope(Qb=0.0, Qc=0.0), Layout().gravity
SPACING, ELEMENTS = 0.5, 480  # m
#: deg, m, s
TWIST, WAY, TIME, DURATION, STEP = 90.0, 60.0, 10.0, 14.0, 0.01
#: s between the rows of the table
EVERY = 0.25

DECK = """\
--- LINE TYPES ---
Name Diam MassDenInAir EA BA EI GAs GJ Irt Irn Cd_n Cd_t Ca_n Ca_t
rope {d} {rho} {EA} 0.0 {EI} {GAs} {GJ} 1e-3 2e-3 0.0 0.0 0.0 0.0
--- POINTS ---
ID Type X Y Z
1 Coupled 0.0 0.0 0.0
2 Fixed {spacing} 0.0 0.0
--- LINES ---
ID NodeA NodeB Outputs
1 1 2 p
--- SECTIONS ---
LineID LineType Length NumSegs
1 rope {length} {elements}
--- END CONNECTIONS ---
LineID End Stiffness EzX EzY EzZ TorsStiffness NxX NxY NxZ Pretwist
1 A Rigid 0.0 0.0 -1.0 Rigid 0.0 1.0 0.0 0.0
1 B Rigid 0.0 0.0 1.0 Rigid 0.0 1.0 0.0 {twist}
--- OPTIONS ---
{g} g
1e-6 rhoW
{options}
--- OUTPUTS ---
{outputs}
--- END ---
"""


@dataclass(frozen=True)
class Course:
    """The winding at the end of every step: pulls of the moving and the held end (steps, 2), torque, nodes' places."""

    pull: Array  # N
    torque: Array  # N m, at the moving end
    nodes: Array  # (steps, nodes, 3), m, the second axis up


def moving_end(t: float) -> EndMotion:
    """It rises by WAY within TIME."""
    x = min(t / TIME, 1.0)
    return EndMotion(
        y=WAY * x**3 * (10.0 - 15.0 * x + 6.0 * x * x),
        vy=30.0 * WAY / TIME * (x * (1.0 - x)) ** 2,
        ay=60.0 * WAY / TIME**2 * x * (1.0 - x) * (1.0 - 2.0 * x),
    )


def our_winding() -> Course:
    """By the native rope."""
    locked = Swivel("locked")
    scene = Scene(
        rope=replace(ROPE, beta_K=0.0, installed_twist=math.radians(TWIST)),
        layout=Layout(spacing=SPACING, gravity=GRAVITY),
        mesh=Mesh("eem", elements=ELEMENTS),
        model=Model("torsional"),
        solver=fixed_steps(STEP),
        left=locked,
        right=locked,
    )
    rope, motions = balance_rope(scene, "native"), []
    status = rope.initialize(0.0, moving_end(0.0), EndMotion())
    for k in range(round(DURATION / STEP) + 1):
        if k:
            status = rope.advance_to(k * STEP, moving_end(k * STEP), EndMotion())
        if not status.valid:
            raise RuntimeError(status.message)
        motions.append(rope.state.motion)
    reaction = np.array([m.reaction[[0, -1]] for m in motions])
    pull, torque = np.linalg.norm(reaction[:, :, POSITION], axis=2), np.abs(reaction[:, 0, ANGLE])
    return Course(pull, torque, np.array([m.q[:, POSITION] for m in motions]))


def their_winding() -> Course:
    """By CableDyn's driver, which the package ``cabledyn`` carries."""
    import cabledyn

    ends = [moving_end(k * STEP) for k in range(round(DURATION / STEP) + 1)]
    motion = [f"{k * STEP:.6f} 1 0 0 {e.y:.16g} 0 0 {e.vy:.16g} 0 0 {e.ay:.16g}" for k, e in enumerate(ends)]
    options = f"{STEP} dtM", f"{DURATION} TMax", f"{fixed_steps(STEP).rho_inf} rhoInf", "motion.txt motionFile"
    outputs = "FairTen1", "AnchTen1", "Torq1N1"
    data = {"d": ROPE.diameter, "rho": ROPE.mass_per_length, "EA": ROPE.Qa, "EI": ROPE.EI, "GAs": 0.4 * ROPE.Qa}
    data |= {
        "GJ": ROPE.Qd,
        "length": ROPE.length,
        "elements": ELEMENTS,
        "spacing": SPACING,
        "g": GRAVITY,
        "twist": TWIST,
    }
    lines = {"options": "\n".join(options), "outputs": "\n".join(f'"{name}"' for name in outputs)}
    with TemporaryDirectory() as folder:
        deck = Path(folder, "u.dat")
        deck.write_text(DECK.format(**data, **lines), encoding="utf-8")
        Path(folder, "motion.txt").write_text("\n".join(motion), encoding="utf-8")
        run = cabledyn.CableDynDriver().run(deck, Path(folder, "u"))
        history = run.read_main()
        moving, held, torque = (np.array(history.column(name)) for name in outputs)
        places = np.array(run.read_line_positions(1).values)[:, 1:].reshape(len(ends), ELEMENTS + 1, 3)
    half = 0.5 * ROPE.mass_per_length * ROPE.length / ELEMENTS
    moving = moving + half * np.array([e.ay for e in ends])
    x, back, up = np.moveaxis(places, 2, 0)
    return Course(np.stack((moving, held), axis=1), np.abs(torque), np.stack((x - 0.5 * SPACING, up, -back), axis=2))


def winding() -> Table:
    """Both codes every quarter second; ``apart`` is how far our nodes are from CableDyn's at most."""
    courses = {"ours": our_winding(), "CableDyn": their_winding()}
    theirs, found = courses["CableDyn"].nodes, []
    for k in range(0, len(theirs), round(EVERY / STEP)):
        for code, x in courses.items():
            lowest, aside = x.nodes[k, :, 1].min(), np.abs(x.nodes[k, :, 2]).max()
            apart = np.linalg.norm(x.nodes[k] - theirs[k], axis=1).max()
            found.append((k * STEP, code, *x.pull[k], x.torque[k], lowest, aside, apart))
    return table(("time", "code", "moving", "held", "torque", "lowest", "aside", "apart"), found)
