"""A rope whose wires slide on each other."""

from dataclasses import replace

from rope_model import Mesh, Rope, Scene, Solver


def scene(mesh: Mesh | None = None, **rope: float) -> Scene:
    made = replace(Rope(length=10.0, EI_stick=3000.0, slip_moment=2.0), **rope)
    solver = Solver(step_max=0.01, tolerance=100.0)
    return Scene(rope=made, mesh=mesh or Mesh("eem", elements=10), solver=solver)
