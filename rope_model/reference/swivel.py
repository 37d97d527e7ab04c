"""Balance rope suspension rotors (BRSR): stick and slip of both ends, boundary conditions.

    stick:  b_t = 0 and |M| <= M_s          slip:  M = -M_k sgn b_t
    M_s = 1/2 mu_s d_m T + M_seal           M_k = 1/2 mu_k d_m T + M_seal

(docs/theory/ends.md, eq-swivel) with the relative angle b and the moment M of the conveyance on the
rope.  The tension T at a plumb end is its vertical reaction.  Position and tangent of an end are
held; only its stretch |r'| is free.  theta is free while the swivel slips and else held at

    theta = offset + s yaw + b,    s = -1 on the left, +1 on the right

(docs/theory/ends.md, eq-theta).  The offset belongs to the frame: theta counts along the rope from
the left end, so that of the right end changes as the rope turns in space.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rope_model.arrays import Array
from rope_model.boundary.end_conditions import YAW_SENSE
from rope_model.method.generalized_alpha import Motion
from rope_model.method.swivel_phases import (
    Phase,
    SwivelState,
    moment_of_swivel,
    slip_load,
    swivel_excess,
)
from rope_model.parameters import Scene, Swivel
from rope_model.physics import element
from rope_model.physics.element import parameters
from rope_model.physics.node import ANGLE, END_NODE, NODE_DOF, POSITION
from rope_model.reference.ends import YAW, EndQuintic
from rope_model.reference.equations import ALONG, HEIGHT, STRETCH, Equations, frame_at
from rope_model.reference.mesh import RopeMesh

OUTWARD = (-1.0, 1.0)  #: X of the suspensions at rest, in half spacings


@dataclass(frozen=True)
class Ends:
    """Both ends of a rope between conveyances."""

    scene: Scene
    paths: tuple[EndQuintic, EndQuintic]
    swivels: tuple[SwivelState, SwivelState]
    offsets: tuple[float, float]  #: rad

    def equations(self, mesh: RopeMesh, q: Array) -> Equations:
        """Return the equations on ``mesh``; ``q`` is the reference of the frame."""
        held = np.zeros(q.shape, dtype=bool)
        inertia = np.zeros_like(q)
        load = np.zeros_like(q)
        friction = np.zeros(len(q))
        for side, node in enumerate(END_NODE):
            swivel = self.data(side)
            now = self.swivels[side]
            moment = slip_load(swivel, now)
            held[node] = True
            held[node, STRETCH] = False
            inertia[node, ANGLE] = swivel.inertia
            held[node, ANGLE] = now.phase is not Phase.SLIP
            load[node, ANGLE] = moment.constant
            friction[node] = moment.per_tension
        law = element.element_functions()  # another one here is a trial in the reference alone
        return Equations(
            law=law,
            lengths=mesh.lengths,
            material=np.array(parameters(self.scene.rope, self.scene.layout.gravity)),
            frame=frame_at(q, mesh.lengths, law),
            held=held,
            held_motion=lambda t: self.end_motion(t, len(q)),
            load=load,
            inertia=inertia,
            friction=friction,
        )

    def data(self, side: int) -> Swivel:
        """Return the parameters of the swivel on this side."""
        return (self.scene.left, self.scene.right)[side]

    def end_motion(self, t: float, nodes: int) -> Array:
        """Return q, v, a (3, nodes, 7) at ``t`` (s), of which the held entries count."""
        motion = np.zeros((3, nodes, NODE_DOF))
        for side, node in enumerate(END_NODE):
            path = self.paths[side].at(t)
            motion[:, node, POSITION] = path[:, :YAW]
            motion[0, node, ALONG] += OUTWARD[side] * 0.5 * self.scene.layout.spacing
            motion[:, node, ANGLE] = YAW_SENSE[side] * path[:, YAW]
            motion[0, node, ANGLE] += self.offsets[side] + self.swivels[side].angle
        return motion

    def relative(self, side: int, motion: Motion) -> tuple[float, float]:
        """Return the swivel's angle b (rad) and its rate (rad/s)."""
        node = END_NODE[side]
        path = self.paths[side].at(motion.t)
        angle = motion.q[node, ANGLE] - self.offsets[side] - YAW_SENSE[side] * path[0, YAW]
        rate = motion.v[node, ANGLE] - YAW_SENSE[side] * path[1, YAW]
        return float(angle), float(rate)

    def moment(self, side: int, motion: Motion) -> float:
        """Return the moment M (N m) of the conveyance on the rope's end, about the tangent."""
        R = motion.reaction[END_NODE[side]]
        state = self.swivels[side]
        return float(moment_of_swivel(self.data(side), state, float(R[HEIGHT]), float(R[ANGLE])))

    def excess(self, side: int, motion: Motion) -> float:
        """Return the event function of a swivel: negative while it may stay in its phase."""
        R = motion.reaction[END_NODE[side]]
        rate = self.relative(side, motion)[1]
        state = self.swivels[side]
        return float(swivel_excess(self.data(side), state, float(R[HEIGHT]), float(R[ANGLE]), rate))


def slip(angle: float, moment: float) -> SwivelState:
    """Return a swivel that begins to slip against the holding ``moment`` (N m)."""
    return SwivelState(Phase.SLIP, angle, math.copysign(1.0, -moment))


def stick(angle: float) -> SwivelState:
    """Return a swivel that sticks at ``angle`` (rad)."""
    return SwivelState(Phase.STICK, angle, 0.0)
