"""Natural frequencies of the hanging rope over its depth: from 60 m to 480 m, ends at one height.

The deeper the shaft, the slower the rope swings out of the plane of its loop: like a pendulum, with
1 / sqrt(depth).
"""

from rope_model import EndMotion, Model, Rope, Scene, Swivel
from rope_model.analysis.modes import natural_modes
from rope_model.engine import NativeRope


def frequencies(length: float) -> tuple[float, float]:
    """The lowest frequency (Hz) out of plane and in it, of an uncoupled rope of this length (m)."""
    scene = Scene(
        rope=Rope(length=length, Qb=0.0, Qc=0.0),
        right=Swivel(mode="free"),
        model=Model("torsional"),  # by itself it would leave out what is out of plane
    )
    rope = NativeRope(scene)  # it gives its matrices
    status = rope.initialize(0.0, EndMotion(), EndMotion())
    if not status.valid:
        raise RuntimeError(status.message)
    rope.release_free_swivels()  # a rope that has just been hung has its swivels locked
    modes = natural_modes(rope)
    out = modes.out_of_plane > 0.5
    return float(modes.frequencies[out][0]), float(modes.frequencies[~out][0])


for length in (60.0, 240.0, 480.0, 120.0):
    out, within = frequencies(length)
    print(f"{length:5.0f} m  in plane {within:.4f} Hz  out of plane (Hz): {out:.5f}")
