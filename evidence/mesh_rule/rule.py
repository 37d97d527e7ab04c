"""The rule's constants held against the laws, on the ropes that judge it."""

import math
from typing import NamedTuple

import numpy as np

from evidence.mesh_rule import laws
from evidence.mesh_rule.laws import Laws
from evidence.mesh_rule.scenes import JUDGE, draw
from evidence.tables import Array, Table
from rope_model.method.mesh_fit import FADE_ERROR, MAX_LENGTH, NATURAL_RADIUS, fit_lengths
from rope_model.physics.elementary import sqrt
from rope_model.solver_parameters import Mesh

#: ropes: the rule itself costs nothing
MANY = 400
#: loop elements over w on which it hangs too high by more than it trembles; how far from MAX_LENGTH one is beyond doubt
UNLOCKED = 0.15
AT_LEAST = 0.05
#: the longest elements of the rule in w, in a loop as narrow as a free one
LONGEST_USED = MAX_LENGTH * NATURAL_RADIUS


class Shares(NamedTuple):
    """By the laws, one per rope: parts of the error asked for that the rule's lengths make; error of the moment."""

    loop: Array
    cover: Array
    moment: Array


def shares(found: Laws, asked: float) -> Shares:
    """Of the rule's lengths for the error ``asked`` (m), on MANY ropes of the judging seed."""
    loop = []
    cover = []
    moment = []
    for d in draw(JUDGE, MANY):
        S = laws.stiffness(np.array(d.rope.Qa), np.array(d.rope.EI), np.array(d.w))
        of = fit_lengths(d.scene(Mesh()), asked, math.log10(FADE_ERROR / asked))
        fine = np.array(of.fine_length)
        half = np.array(0.5 * math.pi * of.radius + of.fade)
        layer = sqrt(d.rope.EI / (0.5 * d.rope.mass_per_length * d.layout.gravity * d.rope.length))
        loop.append(float(laws.loop_error(found.loop.values, fine, np.array(d.w), S)) / asked)
        cover.append(float(laws.cover_error(found.cover.values, fine, half, np.array(d.w))) / asked)
        moment.append(
            float(laws.moment_error(found.ends.values, np.array(of.end), np.array(layer)))
        )
    return Shares(np.array(loop), np.array(cover), np.array(moment))


def slip(t: Table) -> tuple[float, float]:
    """How far the loop slips aside over how much too high it hangs: at most on elements that are used, and beyond."""
    aside = t["aside [m]"] / t["too high [m]"]
    x = t["fine [m]"] / t["w [m]"]
    used = (x > UNLOCKED) & (x < LONGEST_USED - AT_LEAST)
    return float(aside[used].max()), float(aside[x > LONGEST_USED + AT_LEAST].max())
