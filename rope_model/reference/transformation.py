"""Transformation of the mesh (docs/theory/mesh.md, "A transformation").

The fields q, v, a, b and the rate of a are transferred to the new mesh.  A cubic through merged
elements is slightly too short or too long, which the axial stiffness would turn into a blow.  So
the rope is brought into equilibrium with its accelerations, restrained by an inertia that
corresponds to the time T:

    R(q + x, v, a + x / T^2) = 0

q + x is the new shape; v and a stay as they are.  The integrator continues without a restart.
"""

from dataclasses import replace

import numpy as np

from rope_model.method.stepping import RELAXATION_TIME
from rope_model.parameters import Scene
from rope_model.reference.energies import with_energies
from rope_model.reference.mesh import transformed
from rope_model.reference.newton import Cause, Failure, Guess, solve
from rope_model.reference.state import LoggedEvent, State
from rope_model.reference.transfer import transferred

FIELDS = ("q", "v", "a", "b", "a_rate")


def with_mesh_for(scene: Scene, state: State, t: float) -> State | Failure:
    """Return the state on the mesh for the loop at ``t`` (s), or itself if that serves."""
    mesh = transformed(state.mesh, state.bottom_s(scene, t))
    if mesh is state.mesh:
        return state
    m = state.motion
    old = np.array([getattr(m, name) for name in FIELDS])
    new = transferred(old, state.mesh.nodes_s, mesh.nodes_s)
    reaction = np.zeros_like(new[0])
    reaction[[0, -1]] = m.reaction[[0, -1]]
    motion = replace(m, **dict(zip(FIELDS, new, strict=True)), reaction=reaction)
    moved = replace(state, mesh=mesh, motion=motion)

    equations = moved.equations(scene)
    guess = Guess(motion.q, motion.v, motion.a)
    time = RELAXATION_TIME
    while True:
        c = (1.0, 0.0, time**-2)
        tolerance = scene.solver.newton_tolerance
        found = solve(equations, guess, c, tolerance, prestress=motion.q)
        if found.cause is None:
            break
        if time <= scene.solver.step_min:
            return Failure(Cause.NEW_MESH, m.t, "a transformation of the mesh")
        time = max(0.5 * time, scene.solver.step_min)
        moved = moved.counted(rejections=1)
    relaxed = replace(moved, motion=replace(motion, q=found.q)).with_angles(equations)

    after = with_energies(state.energies, relaxed.equations(scene), relaxed.motion)
    change = after.total - state.energies.total
    energies = replace(after, transformations=after.transformations + change)
    events = (*state.events, LoggedEvent(m.t, "transformation"))
    return replace(relaxed, energies=energies, events=events).counted(transformations=1)
