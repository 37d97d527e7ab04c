"""A rope with a permanent curvature."""

from dataclasses import replace

from rope_model import Mesh, Rope, Scene, Solver

K0 = 0.3
EI = 1.7


def scene(mesh: Mesh | None = None, **rope: float) -> Scene:
    made = replace(Rope(length=10.0, initial_curvature=K0, initial_curvature_angle=1.0), **rope)
    solver = Solver(step_max=0.01, tolerance=100.0)
    return Scene(rope=made, mesh=mesh or Mesh("eem", elements=10), solver=solver)
