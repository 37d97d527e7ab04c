"""Warnings about valid results, by the engine's rules, as far as they follow from this state.

Not computed are the warnings that need more than the published system has: the audit of momentum
and waves, the clearance of the legs, several equilibria at the start, the fit of the given motions.
"""

from typing import NamedTuple, cast

from rope_model.method.audit import Audit
from rope_model.method.generalized_alpha import Motion
from rope_model.parameters import Scene
from rope_model.reference.energies import Energies
from rope_model.reference.state import State
from rope_model.state import Crossing, RopeState
from rope_model.warnings.result_warnings import WARNINGS

#: warnings that the reference rope computes; of ``unresolved_bend`` the part by the mesh alone, not
#: by the sharpest bend on the way
COMPUTED = ("passed_sides", "leg_contact", "yaw_at_rest", "unresolved_bend", "no_air")
#: warnings whose causes the reference rope refuses or does not have
IMPOSSIBLE = ("passed_bodies", "neglected_effects", "accuracy_given_up", "blind_guards")
#: warnings that the engine alone computes
NOT_COMPUTED = ("other_rests", "missing_loads", "unresolved_waves", "unfit_inputs")


class Judged(NamedTuple):
    """State as the rules of these warnings read it, by the names of the engine's state."""

    motion: Motion
    offsets: tuple[float, float]
    loop_yaw: float
    crossing: Crossing
    energy_balance: Energies
    fidelity: str = "torsional"
    audit: Audit = Audit()


def warnings_of(scene: Scene, state: State) -> dict[str, str]:
    """Return the warnings that apply to a valid state: sentences by subject."""
    texts = {name: warning_of(name, scene, state) for name in COMPUTED}
    return {name: text for name, text in texts.items() if text}


def warning_of(name: str, scene: Scene, state: State) -> str:
    """Return the warning ``name`` of COMPUTED, or '' if it does not apply."""
    judged = Judged(
        motion=state.motion,
        offsets=state.offsets,
        loop_yaw=state.loop_yaw,
        crossing=state.crossing,
        energy_balance=state.energies,
    )
    # the rules read no other field of it
    return WARNINGS[name](scene, cast(RopeState, judged))
