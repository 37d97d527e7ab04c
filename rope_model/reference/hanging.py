"""The rope at rest at the start (docs/theory/ends.md, "Twist at the start" and "The start").

The rope is hung straight and untwisted, then twisted: by its installed twist, by the yaws of its
conveyances, and by the direction in which its ends are apart.  A swivel that starts relaxed and
cannot hold the torque starts where it has slid to: the rope is hung once more while that swivel
turns against its friction.  A straight rope at rest has the same torque all along, so only the
swivel with the least friction turns.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from rope_model.arrays import Array
from rope_model.method.generalized_alpha import Motion
from rope_model.method.swivel_phases import (
    Phase,
    SwivelState,
    beyond_rest,
    kinetic_friction,
    relaxes,
)
from rope_model.parameters import Scene
from rope_model.physics.centreline import line_yaw, nearest_turn
from rope_model.physics.inextensible import left_leg_length
from rope_model.physics.node import ANGLE, END_NODE, POSITION
from rope_model.reference.ends import EndQuintic
from rope_model.reference.energies import Energies, with_energies
from rope_model.reference.equations import HEIGHT
from rope_model.reference.mesh import RopeMesh, mesh_of
from rope_model.reference.outputs import yaw_of
from rope_model.reference.passages import with_passages
from rope_model.reference.state import State
from rope_model.reference.statics import StaticsError, find_equilibrium, hanging_guess
from rope_model.reference.swivel import Ends, slip

TWIST_STEP = 1.0  #: rad, largest increment of twist
SHORTEST_TWIST_STEP = 0.01  #: rad
#: rad, twice the loop's yaw in an increment above which a shorter one is tried; the shortest may
#: pass a limit point
LARGEST_TURN = 2.0


@dataclass(frozen=True)
class Rest:
    """Rope in equilibrium between ``ends``."""

    ends: Ends
    q: Array  #: (nodes, 7), m, 1 and rad
    reaction: Array  #: R (nodes, 7), N and N m
    turn: float  #: rad, of the right end's frame since the first guess: minus twice the loop's yaw


def hang(scene: Scene, t: float, paths: tuple[EndQuintic, EndQuintic]) -> State:
    """Return the rope at rest at ``t`` (s); StaticsError if there is no equilibrium."""
    straight = Ends(scene, paths, (_held(0.0), _held(scene.rope.installed_twist)), (0.0, 0.0))
    left, right = straight.end_motion(t, 2)[0, :, POSITION]
    mesh = mesh_of(scene, left_leg_length(scene.rope.length, left[HEIGHT], right[HEIGHT]))
    guess = hanging_guess(mesh.nodes_s, left, right)
    # in the plane of its ends, at psi to X, an untwisted rope turns its right end by -2 psi
    offset = 2.0 * math.atan2(right[2] - left[2], right[0] - left[0])
    ends = replace(straight, offsets=(0.0, offset))
    first, last = ends.end_motion(t, 2)[0, :, ANGLE].tolist()

    untwisted = _rest(_with_more_offset(ends, first - last), mesh, _with_angle(guess, first), t)
    rest = _twisted(untwisted, mesh, last - first, t)
    side = _sliding_side(rest, t)
    if side is not None:
        held_angle = (last, first)[side]  # of the other end
        slipping = slip(0.0, rest.reaction[END_NODE[side], ANGLE])
        turning = _with_swivel(ends, side, slipping)
        slid = _rest(turning, mesh, _with_angle(guess, held_angle), t)
        angle, _ = slid.ends.relative(side, _at_rest(slid, t))
        rest = _rest(_with_swivel(slid.ends, side, _held(angle)), mesh, slid.q, t, slid.turn)

    motion = _at_rest(rest, t)
    equations = rest.ends.equations(mesh, rest.q)
    energies = with_energies(Energies(), equations, motion)
    yaw = line_yaw(left, right) - 0.5 * rest.turn
    state = State(
        motion=motion,
        mesh=mesh,
        paths=paths,
        swivels=rest.ends.swivels,
        offsets=rest.ends.offsets,
        loop_yaw=float(nearest_turn(yaw_of(rest.q), yaw)),
        step_next=scene.solver.step_max,
        calm_since=t,
        force_mean=(-float(rest.reaction[0, HEIGHT]), -float(rest.reaction[-1, HEIGHT])),
        energies=replace(energies, start=energies.total),
    )
    return with_passages(state)


def _rest(ends: Ends, mesh: RopeMesh, guess: Array, t: float, turn: float = 0.0) -> Rest:
    """Return the equilibrium near ``guess``, whose frame has turned by ``turn`` (rad) so far."""
    found = find_equilibrium(ends.equations(mesh, guess), guess, t)
    return Rest(_with_more_offset(ends, found.turn), found.q, found.reaction, turn + found.turn)


def _twisted(rest: Rest, mesh: RopeMesh, twist: float, t: float) -> Rest:
    """Return the rope with ``twist`` (rad) added in increments."""
    fraction = mesh.nodes_s / mesh.nodes_s[-1]
    size = TWIST_STEP
    left = twist
    while left != 0:
        step = math.copysign(min(size, abs(left)), left)
        q = rest.q.copy()
        q[:, ANGLE] += step * fraction
        shortest = size <= SHORTEST_TWIST_STEP
        try:
            after = _rest(_with_more_offset(rest.ends, step), mesh, q, t, rest.turn)
        except StaticsError as error:
            if shortest:
                raise StaticsError(
                    f"at {twist - left:.4g} of {twist:.4g} rad of twist: {error}"
                ) from error
            size *= 0.5
            continue
        if abs(after.turn - rest.turn) > LARGEST_TURN and not shortest:
            size *= 0.5
            continue
        rest = after
        left -= step
        size = min(2.0 * size, TWIST_STEP)
    return rest


def _sliding_side(rest: Rest, t: float) -> int | None:
    """Return the side of the swivel that slides: of those that cannot hold, the easiest."""
    frictions = {}
    for side, node in enumerate(END_NODE):
        swivel = rest.ends.data(side)
        tension = float(rest.reaction[node, HEIGHT])
        moment = float(rest.reaction[node, ANGLE])
        slides = relaxes(swivel, rest.ends.swivels[side], t)
        if slides and beyond_rest(swivel, tension, moment) >= 0:
            frictions[side] = float(kinetic_friction(swivel, tension))
    return min(frictions, key=frictions.__getitem__, default=None)


def _at_rest(rest: Rest, t: float) -> Motion:
    """Return the motion of the rope at rest at ``t`` (s)."""
    zeros = np.zeros_like(rest.q)
    return Motion(t, rest.q, zeros, zeros, zeros, zeros, 0.0, rest.reaction)


def _held(angle: float) -> SwivelState:
    """Return a swivel that is locked at ``angle`` (rad)."""
    return SwivelState(Phase.LOCKED, angle, 0.0)


def _with_swivel(ends: Ends, side: int, state: SwivelState) -> Ends:
    """Return the ends with another state of the swivel on this side."""
    left, right = ends.swivels
    return replace(ends, swivels=(state, right) if side == 0 else (left, state))


def _with_more_offset(ends: Ends, more: float) -> Ends:
    """Return the ends with ``more`` (rad) added to the offset of the right one."""
    left, right = ends.offsets
    return replace(ends, offsets=(left, right + more))


def _with_angle(q: Array, angle: float) -> Array:
    """Return the rope with this ``angle`` (rad) all along."""
    q = q.copy()
    q[:, ANGLE] = angle
    return q
