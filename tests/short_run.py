"""A short motion of a rope of 30 m, for tests that look at it all along."""

from collections.abc import Iterator

from rope_model import BalanceRope, EndMotion


def stations(rope: BalanceRope, steps: int) -> Iterator[BalanceRope]:
    """The rope each 10 ms while both ends move, the left one sideways too."""
    assert rope.initialize(0.0, EndMotion(), EndMotion(y=6.0)).valid
    yield rope
    for k in range(1, steps + 1):
        t = 0.01 * k
        left = EndMotion(y=t**3, vy=3 * t**2, ay=6 * t, z=t**3, vz=3 * t**2, az=6 * t)
        assert rope.advance_to(t, left, EndMotion(y=6.0 - t**3, vy=-3 * t**2, ay=-6 * t)).valid
        yield rope
