"""Prediction of the stability of an exchange.

The rope's forces at the ends of steps after a pulse of the end's acceleration, held over one step,
are measured on the rope itself, F_k = -sum_j m_j a_(k-j); m_0 is larger than the added mass m_a,
that of an acceleration that grows. The scheme drives the mass M of the next step with forces of
past ones, weighted by w,

    M a_(k+1) = sum_i w_i F_(k-i) ,
    semi-implicit:  (M + m_a) a_(k+1) = sum_i w_i (F_(k-i) + m_a a_(k-i)) .

The largest root of this recursion is the growth per step. For a held force and a rope that is only
a mass it is m_0 / M; for one that is only an impedance Z the bound is H < 2 M / Z; and where steps
are as long as the period of an axial wave in the leg it is larger than either. The hoist's own
springs are left out: they are slow against a step.
"""

import logging
import math
from dataclasses import dataclass

import numpy as np

from hoist_demo.cosimulation.schemes.explicit import SemiImplicit
from hoist_demo.cosimulation.schemes.interface import CoupledSystem, InterfaceMotion, Scheme, Vector
from rope_model import Status

_log = logging.getLogger(__name__)
RESPONSE_STEPS = 48  #: Steps for which the rope's response is followed.
PULSE = 0.05  #: Acceleration of the trial [m/s^2].
STILL_STEPS = 4  #: Steps without a pulse after which a rope may be found to hang still.
STILL_CHANGE = 1e-7  #: Largest relative change of its forces until then.
#: Growth per step from which the user is warned: below, the rope's damping beyond RESPONSE_STEPS
#: decides.
MARGIN = 1.01


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
            f"coupling {name} with H = {H:g} s: disturbances are expected to grow "
            f"{self.growth_per_step:.3g} times per step (the rope resists like "
            f"{self.resistance:.4g} kg, the conveyance has {self.mass:.4g} kg, "
            "and waves run in the rope): the run will be unstable. Take a shorter step, semi-implicit-0 or "
            "implicit-impulse"
        )


def predict_stability(
    scheme: Scheme, name: str, coupled: CoupledSystem, t: float, H: float
) -> StabilityEstimate | None:
    """Predict the scheme's stability by trial steps of the rope at rest.

    Returns None where the response of the rope is not known. Raises ValueError for a scheme that
    takes steps back with a rope that cannot, ParticipantFailed for one that lacks the added masses.
    """
    if scheme.needs_added_mass:
        coupled.added_mass()
    if coupled.rope.save() is None:
        if scheme.needs_rollback:
            raise ValueError(
                f"scheme = '{name}' takes steps back, but this rope cannot save its state: "
                "take semi-implicit-1 or gauss-seidel-1, or an FMU with canGetAndSetFMUstate"
            )
        return None
    try:
        response = measure_response(coupled, t, H)
    except TrialFailed as failure:
        _log.info("the coupling's stability is not known: %s", failure.status.message)
        return None
    # the worst end and the smallest mass: in the course of a trip either leg may become the long
    # one
    mass = 1.0 / float(np.max(np.diag(coupled.drive.accelerance())))
    added = np.zeros(response.shape[1])
    if isinstance(scheme, SemiImplicit):
        added = added_mass_of_step(coupled, t, H)
    ends = zip(response.T, added.tolist(), strict=True)
    worst = max(
        (growth_per_step(scheme, end, mass, added_mass) for end, added_mass in ends),
        default=math.nan,
    )
    estimate = StabilityEstimate(worst, resistance=float(np.max(response[0])), mass=mass)
    if warning := estimate.warning(name, H):
        _log.warning("%s", warning)
    return estimate


class TrialFailed(Exception):
    """Trial step of the rope that failed with ``status``."""

    def __init__(self, status: Status) -> None:
        super().__init__(status.message)
        self.status = status


def measure_response(coupled: CoupledSystem, t: float, H: float) -> Vector:
    """Return the masses m_j of held ends, (RESPONSE_STEPS, n) [kg]; the rope is taken back.

    All ends get their pulse at once, alternately up and down, so that the loop stays where it is.
    The rope's forces without a pulse, as after swivels have just been released, are subtracted.
    Raises TrialFailed for a step that fails.
    """
    at_rest = coupled.drive.position()
    pulse = np.where(np.arange(at_rest.size) % 2 == 0, PULSE, -PULSE)
    undisturbed = _forces_after_pulse(coupled, t, H, 0.0 * pulse)
    disturbed = _forces_after_pulse(coupled, t, H, pulse)
    return np.asarray((undisturbed - disturbed) / pulse)


def _forces_after_pulse(coupled: CoupledSystem, t: float, H: float, pulse: Vector) -> Vector:
    """Return the rope's forces after a pulse of acceleration [m/s^2] in a first step of H [s].

    Shape (RESPONSE_STEPS, n) [N]; the rope is taken back. Raises TrialFailed for a step that fails.
    """
    forces = np.zeros((RESPONSE_STEPS, pulse.size))
    at_rest = coupled.drive.position()
    acceleration = pulse
    snapshot = coupled.rope.save()
    try:
        for k in range(RESPONSE_STEPS):
            displacement = pulse * H * H * (k + 0.5)
            motion = InterfaceMotion(at_rest + displacement, pulse * H, acceleration)
            status = coupled.step_rope(t + k * H, H, motion)
            if not status.valid:
                raise TrialFailed(status)
            forces[k], _ = coupled.forces()
            acceleration = 0.0 * pulse
            if k == STILL_STEPS and not pulse.any() and _are_still(forces[: k + 1]):
                forces[k:] = forces[k]
                break
        return forces
    finally:
        coupled.restore_rope(snapshot)


def _are_still(forces: Vector) -> bool:
    """Return True if the forces (steps, n) have not changed since the first step."""
    return np.allclose(forces[:-1], forces[-1], rtol=STILL_CHANGE, atol=0.0)


def added_mass_of_step(coupled: CoupledSystem, t: float, H: float) -> Vector:
    """Return the added masses over a trial step of H [s] with held ends, (n,) [kg]."""
    still = np.zeros_like(coupled.drive.position())
    snapshot = coupled.rope.save()
    try:
        coupled.step_rope(t, H, InterfaceMotion(coupled.drive.position(), still, still))
        return coupled.added_mass()
    finally:
        coupled.restore_rope(snapshot)


def growth_per_step(scheme: Scheme, response: Vector, mass: float, added_mass: float) -> float:
    """Return the largest root of the recursion for one end; 0 if no past forces are used.

    ``response`` is (RESPONSE_STEPS,) in kg; the scheme adds ``added_mass`` [kg] to ``mass``.
    """
    w = np.array(scheme.weights)
    if not w.size:
        return 0.0
    past = -np.convolve(w, response)  # F_(k-i) by the accelerations a_k, a_(k-1), ...
    past[: w.size] += w * added_mass
    polynomial = np.concatenate([[1.0], -past / (mass + added_mass)])
    return float(np.max(np.abs(np.roots(polynomial)), initial=0.0))
