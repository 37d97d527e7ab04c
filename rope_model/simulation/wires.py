"""Hysteresis of rubbing wires along a rope: physics.wire_friction at the Gauss points of its elements.

z of each point is state: (elements, 9), empty without friction, which is off in the rigid rope and while a rope is hung
up, so that it begins with z = 0.

A transformation carries z as the mean over the length of rope that belongs to a point, its weight in the element: the
integral of z stays, and that of z^2 can only fall.  Points with an unchanged length of rope keep z to the bit.
"""

from typing import NamedTuple

import numpy as np

from rope_model.arrays import Array
from rope_model.parameters import Rope, Scene
from rope_model.physics.element import POINTS, WEIGHTS
from rope_model.physics.wire_element import wire_functions
from rope_model.physics.wire_friction import (
    POINT_STATE_SIZE,
    bouc_wen_step,
    section_at,
    slip_curvature,
    wire_stiffness,
)
from rope_model.rules.state import NO_HYSTERESIS


class HysteresisUpdate(NamedTuple):
    """State z after a step, and the wires' dissipation in it, J."""

    z: Array
    dissipated: float


def start_hysteresis(scene: Scene, elements: int) -> Array:
    """Return z of a flexible rope that has come to rest with no moment between its wires."""
    return (
        np.zeros((elements, NO_HYSTERESIS.shape[1]))
        if wire_stiffness(scene.rope)
        else NO_HYSTERESIS
    )


def history(rope: Rope, q: Array, lengths: Array, z: Array, strains: Array) -> Array:
    """Return the histories (elements, HISTORY_SIZE) of elements that move on from ``q`` and ``z``.

    ``strains`` (elements, ...) begin with e and tau.
    """
    known = np.concatenate((_sections(q, lengths), z.reshape(lengths.size, len(POINTS), 3)), axis=2)
    stiffness = wire_stiffness(rope)
    k0 = slip_curvature(rope, stiffness, *strains.T[:2])
    return np.column_stack((known.reshape(lengths.size, -1), k0, np.full(lengths.size, stiffness)))


def update_hysteresis(history: Array, q: Array, lengths: Array) -> HysteresisUpdate:
    """Return the update from the ``history`` to the rope ``q``."""
    before, (k0, stiffness) = (
        history[:, :-2].reshape(lengths.size, -1, POINT_STATE_SIZE),
        history[:, -2:].T,
    )
    step = bouc_wen_step(
        before.transpose(2, 0, 1), _sections(q, lengths).transpose(2, 0, 1), k0[:, None]
    )
    work = float(stiffness * lengths @ (step.dissipated @ np.array(WEIGHTS)))
    return HysteresisUpdate(np.stack(step.z, axis=2).reshape(lengths.size, -1), work)


def latest_tangent(history: Array, q: Array, lengths: Array, before: Array) -> Array:
    """Return the latest tangents (elements, TANGENT_SIZE) at ``q``, which follow those ``before``."""
    nodes = np.concatenate((q[:-1], q[1:]), axis=1).T
    return np.array(wire_functions("torsional").latest(nodes, lengths[None], history.T, before.T)).T


def carry(z: Array, old_lengths: Array, new_lengths: Array) -> Array:
    """Return ``z`` on elements of other lengths."""
    if not z.size:
        return z
    point_z = z.reshape(-1, 3)
    old, new = _cells(old_lengths), _cells(new_lengths)
    total = np.vstack((np.zeros(3), np.cumsum(np.diff(old)[:, None] * point_z, axis=0)))
    at_ends = np.stack([np.interp(new, old, column) for column in total.T], axis=1)
    carried = np.diff(at_ends, axis=0) / np.diff(new)[:, None]
    # m, difference of arc lengths below which cells are the same
    tolerance = 1e-9 * float(old[-1])
    nearest = np.clip(np.searchsorted(old, new - tolerance), 0, old.size - 1)
    same = np.abs(old[nearest] - new) <= tolerance
    unchanged = same[:-1] & same[1:] & (np.diff(nearest) == 1)
    carried[unchanged] = point_z[nearest[:-1][unchanged]]
    return carried.reshape(new_lengths.size, -1)


def _sections(q: Array, lengths: Array) -> Array:
    """Return the sections (elements, points, 7) at the points."""
    nodes = np.concatenate((q[:-1], q[1:]), axis=1).T
    return np.stack([np.stack(section_at(xi, lengths, nodes), axis=1) for xi in POINTS], axis=1)


def _cells(lengths: Array) -> Array:
    """Return the arc lengths (m) between which the rope belongs to one point each."""
    return np.concatenate(([0.0], np.cumsum(np.outer(lengths, WEIGHTS).ravel())))
