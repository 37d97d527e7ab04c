"""Balance rope suspension rotor (BRSR): the friction of its bearing.

A set-valued law, not a regularised one, for the relative angle b and the moment M of the conveyance on the rope:

    stick: b_t = 0 and |M| <= M_static        slip: M = -M_dynamic sgn(b_t)
    M_static = 1/2 mu_s d_m T + M_seal        M_dynamic = 1/2 mu_k d_m T + M_seal

with the tension T at the rope's end.  A bearing does not carry less when the rope pushes: T counts from zero.
"""

from typing import Any

from rope_model.physics.elementary import larger


def friction_moment(mu: Any, mean_diameter: Any, seal_moment: Any, tension: Any) -> Any:
    """Largest moment in N m that friction with coefficient ``mu`` transmits at ``tension`` (N)."""
    return 0.5 * mu * mean_diameter * larger(tension, 0.0) + seal_moment
