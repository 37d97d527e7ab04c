"""The same U in motion: frequencies without torque, and a winding of a twisted rope, one end held, in both codes.

CableDyn's modal analysis holds the places of the ends and lets them turn, about the shape at rest with clamped ends (a
taut rod with clamped ends gives the frequencies of a hinged one): so do ours here, and no torque is in the rope.

CableDyn moves one end of a rope that bends.  Both take the same steps of generalized-alpha with the same spectral
radius.  Its pull of a moving end leaves out what accelerates half of the first element, which is put in.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.kinematic import fixed_steps
from evidence.tables import Table, table
from rope_model import EndMotion, balance_rope
from rope_model.parameters import Layout, Mesh, Model, Scene, Swivel
from rope_model.simulation.modal import natural_modes
from rope_model.simulation.rope_system import ANGLE, POSITION, SLOPE
from rope_model.simulation.statics import find_equilibrium

from .cabledyn import AT_REST, ELEMENTS, GRAVITY, PLAIN, ROPE, SPACING, TWISTED, Deck, hung, system_of
from .statics import Array, clamped

HEIGHTS, MODES = (0.0, 40.0), 8  # m
#: CableDyn's sections have no inertia about the rope's axis; ours next to none where frequencies are compared
SPINLESS = replace(ROPE, rhoJ=1e-8)
#: deg, m, s
TWIST, WAY, TIME, DURATION, STEP = 90.0, 60.0, 10.0, 14.0, 0.01
#: s between the rows of the table
EVERY = 0.25


@dataclass(frozen=True)
class Course:
    """The winding at the end of every step: pulls of the moving and the held end (steps, 2), torque, nodes' places."""

    pull: Array  # N
    torque: Array  # N m, at the moving end
    nodes: Array  # (steps, nodes, 3), m, the second axis up


def frequencies() -> Table:
    """The lowest of either code, Hz; angles are free to follow, so that there is no torque."""
    found = []
    for height in HEIGHTS:
        for k, (ours, theirs) in enumerate(zip(_our_modes(height), _their_modes(height), strict=True), 1):
            found.append((height, k, ours, theirs))
    return table(("height", "mode", "ours", "cabledyn"), found)


def _our_modes(height: float) -> list[float]:
    guess = hung(height)
    boundary = clamped(guess)
    q = find_equilibrium(system_of(SPINLESS, guess, boundary), guess).q
    boundary.held[-1, ANGLE] = False
    boundary.held[[0, -1], SLOPE] = False
    values = natural_modes(system_of(SPINLESS, q, boundary), q, MODES + 1).frequencies
    # an end that spins freely is a mode without frequency
    return [float(f) for f in values[values > 1e-3][:MODES]]


def _their_modes(height: float) -> list[float]:
    with TemporaryDirectory() as folder:
        Deck(PLAIN, (*AT_REST, f"{MODES} nModes"), height=height).run_in(Path(folder))
        text = Path(folder, "u.modes.out").read_text(encoding="utf-8")
    rows = re.findall(r"^1\t(\d+)\t\s*(\S+)\t\s*\S+\t\s*\S+$", text, re.MULTILINE)
    return [float(frequency) for _, frequency in rows]


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
    """By CableDyn."""
    ends = [moving_end(k * STEP) for k in range(round(DURATION / STEP) + 1)]
    lines = [f"{k * STEP:.6f} 1 0 0 {e.y:.16g} 0 0 {e.vy:.16g} 0 0 {e.ay:.16g}" for k, e in enumerate(ends)]
    options = f"{STEP} dtM", f"{DURATION} TMax", f"{fixed_steps(STEP).rho_inf} rhoInf", "motion.txt motionFile"
    outputs = "FairTen1", "AnchTen1", "Torq1N1"
    with TemporaryDirectory() as folder:
        deck = Deck(TWISTED.format(twist=TWIST), options, outputs, files="p", motion="\n".join(lines))
        run = deck.run_in(Path(folder))
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
