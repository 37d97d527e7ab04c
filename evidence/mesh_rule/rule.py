"""The rule's constants held against the laws, on the ropes that judge it."""

import math
from typing import NamedTuple

import numpy as np

from evidence.mesh_rule import laws
from evidence.mesh_rule.laws import Laws
from evidence.mesh_rule.scenes import JUDGE, draw
from evidence.tables import Array, Table
from rope_model.method.mesh_error import ADDED, ELEMENTS_OF_TRANSFORMATION
from rope_model.method.mesh_fit import COVER_ERROR, MAX_LENGTH, fit_lengths
from rope_model.physics.elementary import sqrt
from rope_model.solver_parameters import Mesh

#: ropes: the rule itself costs nothing
MANY = 400
#: loop elements over w on which it hangs too low by more than it trembles; how far from MAX_LENGTH one is beyond doubt
RESOLVABLE = 0.35
AT_LEAST = 0.05


class Shares(NamedTuple):
    """By the laws, one per rope: parts of the error asked for that the rule's lengths make; error of the moment.

    That of the loop's elements is after a trip along the whole rope.
    """

    loop: Array
    cover: Array
    moment: Array


def shares(found: Laws, asked: float) -> Shares:
    """Of the rule's lengths for the error ``asked`` (m), on MANY ropes of the judging seed."""
    loop = []
    cover = []
    moment = []
    for d in draw(JUDGE, MANY):
        of = fit_lengths(d.scene(Mesh()), asked, math.log10(COVER_ERROR / asked))
        fine = np.array(of.fine_length)
        layer = sqrt(d.rope.EI / (0.5 * d.rope.mass_per_length * d.layout.gravity * d.rope.length))
        transformations = d.rope.length / (ELEMENTS_OF_TRANSFORMATION * of.fine_length)
        at_rest = float(laws.loop_error(found.loop.values, fine, np.array(d.w)))
        loop.append(at_rest * (1.0 + ADDED * transformations) / asked)
        cover.append(
            float(laws.cover_error(found.cover.values, fine, np.array(of.cover), np.array(d.w)))
            / asked
        )
        moment.append(
            float(laws.moment_error(found.ends.values, np.array(of.end), np.array(layer)))
        )
    return Shares(np.array(loop), np.array(cover), np.array(moment))


def slip(t: Table) -> tuple[float, float]:
    """How far the loop slips aside over how much too low it hangs: at most on elements that are used, and beyond."""
    aside = t["aside [m]"] / np.abs(t["too low [m]"])
    x = t["fine [m]"] / t["w [m]"]
    used = (x > RESOLVABLE) & (x < MAX_LENGTH)
    return float(aside[used].max()), float(aside[x > MAX_LENGTH + AT_LEAST].max())
