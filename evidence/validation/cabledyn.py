"""A winding of a rope twisted by 90 degrees, clamped as a U at both ends, one end held: CableDyn against ours.

CableDyn 0.3.0 (SMI-Lab-Inha, Apache-2.0) has cubic elements and quasi-static torsion without coupling to tension; its
rope hangs in water of hardly any density.  It moves one end of a rope that bends.  Both take the same steps of
generalized-alpha with the same spectral radius, without damping.  CableDyn's pull of a moving end leaves out what
accelerates half of the first element, which is put in.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.kinematic import fixed_steps
from evidence.ropes import AT_ZERO, at_rest, moving, require
from evidence.tables import Array, Table, table
from rope_model import EndMotion
from rope_model.parameters import Layout, Rope, Scene
from rope_model.physics.node import ANGLE, POSITION
from rope_model.solver_parameters import Mesh, Model

ROPE = Rope(Qb=0.0, Qc=0.0)
GRAVITY = Layout().gravity
SPACING = 0.5  # m
ELEMENTS = 480  # m
#: deg, m, s
TWIST = 90.0
WAY = 60.0
TIME = 10.0
DURATION = 14.0
STEP = 0.01
#: s between the rows of the table
EVERY = 0.25

DECK = """\
--- LINE TYPES ---
Name Diam MassDenInAir EA BA EI GAs GJ Irt Irn Cd_n Cd_t Ca_n Ca_t
rope {d} {rho} {EA} 0.0 {EI} {GAs} {GJ} 1e-3 2e-3 0.0 0.0 0.0 0.0
--- POINTS ---
ID Type X Y Z
1 Coupled 0.0 0.0 0.0
2 Fixed {spacing} 0.0 {below}
--- LINES ---
ID NodeA NodeB Outputs
1 1 2 pt
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
    """At rest and at the end of every step: pulls of the moving and the held end (steps, 2), torque, nodes' places."""

    pull: Array  # N
    torque: Array  # N m, at the moving end
    nodes: Array  # (steps, nodes, 3), m, the second axis up


@dataclass(frozen=True)
class Found(Course):
    """CableDyn's, and its tension (steps, elements) in N."""

    tension: Array


def sampled(motion: Callable[[float], EndMotion]) -> list[EndMotion]:
    """Return it at rest and at the end of every step."""
    return [motion(k * STEP) for k in range(round(DURATION / STEP) + 1)]


def our_winding(rope: Rope, elements: int, ends: Sequence[EndMotion]) -> Course:
    """By the native rope, without damping."""
    scene = Scene(
        rope=replace(rope, beta_K=0.0),
        layout=Layout(spacing=SPACING, gravity=GRAVITY),
        mesh=Mesh("eem", elements=elements),
        model=Model("torsional"),
        solver=fixed_steps(STEP),
    )
    form = at_rest(scene, ends[0])
    motions = [form.state.motion]
    for k, end in enumerate(ends[1:], 1):
        require(form.advance_to(k * STEP, end, AT_ZERO))
        motions.append(form.state.motion)
    reaction = np.array([m.reaction[[0, -1]] for m in motions])
    pull = np.linalg.norm(reaction[:, :, POSITION], axis=2)
    torque = -reaction[:, 0, ANGLE]
    return Course(pull, torque, np.array([m.q[:, POSITION] for m in motions]))


@dataclass(frozen=True)
class Cable:
    """Their rope: clamped as a U at both ends, one ``drop`` (m) below the other, which may move and roll.

    ``twist`` (deg) is imposed at rest, and by it less ``roll`` (steps,) later.
    """

    EA: float  # N
    length: float  # m
    elements: int
    spacing: float  # m
    twist: float
    drop: float = 0.0

    def follow(self, ends: Sequence[EndMotion], roll: Array) -> Found:
        """Run CableDyn's driver, which the package ``cabledyn`` carries; its motions start at rest."""
        import cabledyn

        motion = [
            f"{k * STEP:.6f} 1 0 0 {e.y:.16g} 0 0 {e.vy:.16g} 0 0 {e.ay:.16g} {x:.12g}"
            for k, (e, x) in enumerate(zip(ends, roll, strict=True))
        ]
        duration = (len(ends) - 1) * STEP
        rho = fixed_steps(STEP).rho_inf
        options = f"{STEP} dtM", f"{duration} TMax", f"{rho} rhoInf", "motion.txt motionFile"
        outputs = "FairTen1", "AnchTen1", "Torq1N1"
        data = {
            "d": ROPE.diameter,
            "rho": ROPE.mass_per_length,
            "EI": ROPE.EI,
            "GAs": 0.4 * ROPE.Qa,
            "GJ": ROPE.Qd,
        }
        lines = {
            "options": "\n".join(options),
            "outputs": "\n".join(f'"{name}"' for name in outputs),
        }
        with TemporaryDirectory() as folder:
            deck = Path(folder, "u.dat")
            deck.write_text(
                DECK.format(**vars(self), **data, g=GRAVITY, below=-self.drop, **lines),
                encoding="utf-8",
            )
            Path(folder, "motion.txt").write_text("\n".join(motion), encoding="utf-8")
            run = cabledyn.CableDynDriver().run(deck, Path(folder, "u"))
            history = run.read_main()
            moving_force, held_force, torque = (np.array(history.column(name)) for name in outputs)
            places = np.array(run.read_line_positions(1).values)[:, 1:].reshape(
                len(ends), self.elements + 1, 3
            )
            tension = np.array(run.read_line_tensions(1).values)[:, 1:]
        half = 0.5 * ROPE.mass_per_length * self.length / self.elements
        moving_force = moving_force + half * np.array([e.ay for e in ends])
        x, back, up = np.moveaxis(places, 2, 0)
        nodes = np.stack((x - 0.5 * self.spacing, up, -back), axis=2)
        return Found(np.stack((moving_force, held_force), axis=1), torque, nodes, tension)


def winding() -> Table:
    """Without coupling."""
    ends = sampled(lambda t: moving(WAY, t, TIME, y=1.0))
    twisted = replace(ROPE, installed_twist=math.radians(TWIST))
    cable = Cable(ROPE.Qa, ROPE.length, ELEMENTS, SPACING, TWIST)
    return compared(our_winding(twisted, ELEMENTS, ends), cable.follow(ends, np.zeros(len(ends))))


def compared(ours: Course, theirs: Course) -> Table:
    """Both codes every quarter second; ``apart`` is how far our nodes are from CableDyn's at most."""
    found = []
    for k in range(0, len(theirs.nodes), round(EVERY / STEP)):
        for code, x in {"ours": ours, "CableDyn": theirs}.items():
            lowest = x.nodes[k, :, 1].min()
            aside = np.abs(x.nodes[k, :, 2]).max()
            apart = np.linalg.norm(x.nodes[k] - theirs.nodes[k], axis=1).max()
            found.append((k * STEP, code, *x.pull[k], x.torque[k], lowest, aside, apart))
    return table(("time", "code", "moving", "held", "torque", "lowest", "aside", "apart"), found)
