"""Prediction of the stability of an exchange.

The rope's forces at the ends of steps after a pulse of the end's acceleration, held over one step, are measured on the
rope itself, F_k = -sum_j m_j a_(k-j); m_0 is larger than the added mass m_a, that of an acceleration that grows. The
scheme drives the mass M of the next step with forces of past ones, weighted by w,

    M a_(k+1) = sum_i w_i F_(k-i) ,     semi-implicit:  (M + m_a) a_(k+1) = sum_i w_i (F_(k-i) + m_a a_(k-i)) .

The largest root of this recursion is the growth per step. For a held force and a rope that is only a mass it is
m_0 / M; for one that is only an impedance Z the bound is H < 2 M / Z; and where steps are as long as the period of an
axial wave in the leg it is larger than either. The hoist's own springs are left out: they are slow against a step.
"""

import logging
import math
from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.schemes.explicit import SemiImplicit
from hoist_demo.cosimulation.schemes.interface import CoupledSystem, InterfaceMotion, Scheme, Vector

_log = logging.getLogger(__name__)
RESPONSE_STEPS = 48  #: Steps for which the rope's response is followed.
PULSE = 0.05  #: Acceleration of the trial [m/s^2].
STILL_STEPS = 4  #: Steps without a pulse after which a rope may be found to hang still.
STILL_CHANGE = 1e-7  #: Largest relative change of its forces until then.
MARGIN = 1.01  #: Growth per step from which the user is warned: below, the rope's damping beyond these steps decides.


@dataclass(frozen=True)
class StabilityEstimate:
    """Predicted stability of a scheme."""

    growth_per_step: float  # factor of a disturbance in one communication step
    resistance: float  # kg, m_0 of the rope's end
    mass: float  # kg, that it acts on

    @property
    def stable(self) -> bool:
        """True if disturbances are expected to die out."""
        return self.growth_per_step < MARGIN

    def warning(self, name: str, H: float) -> str:
        """Return the warning to the user; "" if all is well."""
        if self.stable:
            return ""
        return (
            f"coupling {name} with H = {H:g} s: disturbances are expected to grow {self.growth_per_step:.3g} times per "
            f"step (the rope resists like {self.resistance:.4g} kg, the conveyance has {self.mass:.4g} kg, and waves "
            "run in the rope): the run will be unstable. Take a shorter step, semi-implicit-0 or implicit-impulse"
        )


def predict_stability(
    scheme: Scheme, name: str, coupled: CoupledSystem, t: float, H: float
) -> StabilityEstimate | None:
    """Predict the scheme's stability by trial steps of the rope at rest; None if unknown, ValueError if impossible."""
    if scheme.needs_added_mass:
        coupled.added_mass()
    if coupled.rope.save() is None:
        if scheme.needs_rollback:
            raise ValueError(
                f"scheme = '{name}' takes steps back, but this rope cannot save its state: take semi-implicit-1 "
                "or gauss-seidel-1, or an FMU with canGetAndSetFMUstate"
            )
        return None
    response, cause = measure_response(coupled, t, H)
    if cause:
        _log.info("the coupling's stability is not known: %s", cause)
        return None
    # the worst end and the smallest mass: either end of the rope may become the long leg in the course of a trip
    mass = 1.0 / float(np.max(np.diag(coupled.drive.accelerance())))
    added = (
        added_mass_of_step(coupled, t, H)
        if isinstance(scheme, SemiImplicit)
        else np.zeros(response.shape[1])
    )
    ends = zip(response.T, added.tolist(), strict=True)
    worst = max(
        (growth_per_step(scheme, end, mass, added_mass) for end, added_mass in ends),
        default=math.nan,
    )
    seen = StabilityEstimate(worst, float(np.max(response[0])), mass)
    if warning := seen.warning(name, H):
        _log.warning("%s", warning)
    return seen


def measure_response(coupled: CoupledSystem, t: float, H: float) -> tuple[Vector, str]:
    """Masses m_j, (RESPONSE_STEPS, n) [kg], of held ends, and the cause where that fails; the rope is taken back.

    All ends get their pulse at once, alternately up and down, so that the loop stays where it is. What the rope does
    without it, as one whose swivels have just been released, is taken off.
    """
    at_rest = coupled.drive.position()
    sign = np.where(np.arange(at_rest.size) % 2 == 0, PULSE, -PULSE)
    response = np.zeros((2, RESPONSE_STEPS, sign.size))
    for pulse, forces in zip((0.0 * sign, sign), response, strict=True):
        if cause := _pushed(coupled, t, H, at_rest, pulse, forces):
            return np.zeros((RESPONSE_STEPS, sign.size)), cause
    return (response[0] - response[1]) / sign, ""


def _pushed(
    coupled: CoupledSystem, t: float, H: float, at_rest: Vector, pulse: Vector, forces: Vector
) -> str:
    """Fill `forces` with the rope's response to a pulse; return the cause of a failure, else ""."""
    snapshot = coupled.rope.save()
    try:
        for k in range(RESPONSE_STEPS):
            displacement = pulse * H * H * (k + 0.5)
            acceleration = pulse if k == 0 else 0.0 * pulse
            motion = InterfaceMotion(at_rest + displacement, pulse * H, acceleration)
            if cause := coupled.step_rope(t + k * H, H, motion):
                return cause
            forces[k] = coupled.forces()[0]
            if (
                k == STILL_STEPS
                and not pulse.any()
                and np.allclose(forces[:k], forces[k], rtol=STILL_CHANGE, atol=0.0)
            ):
                forces[k:] = forces[k]
                break
        return ""
    finally:
        coupled.restore_rope(snapshot)


def added_mass_of_step(coupled: CoupledSystem, t: float, H: float) -> Vector:
    """Return the added masses over a trial step of held ends that is as long as the run's, (n,) [kg]."""
    snapshot, still = coupled.rope.save(), np.zeros_like(coupled.drive.position())
    try:
        coupled.step_rope(t, H, InterfaceMotion(coupled.drive.position(), still, still))
        return coupled.added_mass()
    finally:
        coupled.restore_rope(snapshot)


def growth_per_step(scheme: Scheme, response: Vector, mass: float, added_mass: float) -> float:
    """Largest root of the recursion for one end, `response` (RESPONSE_STEPS,) in kg; 0 if no past forces are used.

    `added_mass` [kg] is what the scheme adds to `mass`.
    """
    w = np.array(scheme.weights)
    if not w.size:
        return 0.0
    past = -np.convolve(w, response)  # F_(k-i) by the accelerations a_k, a_(k-1), ...
    past[: w.size] += w * added_mass
    return float(
        np.max(np.abs(np.roots(np.concatenate([[1.0], -past / (mass + added_mass)]))), initial=0.0)
    )
