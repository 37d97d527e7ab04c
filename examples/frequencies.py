"""Natural frequencies of the hanging rope over its depth: from 60 m to 480 m, ends at one height.

The deeper the shaft, the slower the rope swings out of the plane of its loop: like a pendulum, with
1 / sqrt(depth).
"""

from rope_model import EndMotion, Model, Rope, RopeSimulator, Scene, Solver, Swivel
from rope_model.simulation.outputs.modal import natural_modes


def frequencies(length: float) -> tuple[float, float]:
    """The lowest frequency (Hz) out of plane and in it, of an uncoupled rope of this length (m)."""
    scene = Scene(
        rope=Rope(length=length, Qb=0.0, Qc=0.0),
        right=Swivel(mode="free"),
        model=Model("torsional"),  # by itself it would leave out what is out of plane
        solver=Solver(kernels="portable"),  # interpreted: one equilibrium is no reason to compile
    )
    rope = RopeSimulator(scene)  # the Python form: its equations of motion can be looked at
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    if not status.valid:
        raise RuntimeError(status.message)
    rope.advance_to(0.02, EndMotion(), EndMotion())  # the start is at rest, with the swivels locked
    modes = natural_modes(rope.system, rope.state.motion.q)
    out = modes.out_of_plane > 0.5
    return float(modes.frequencies[out][0]), float(modes.frequencies[~out][0])


for length in (60.0, 240.0, 480.0, 120.0):
    out, within = frequencies(length)
    print(f"{length:5.0f} m  in plane {within:.4f} Hz  out of plane (Hz): {out:.5f}")
