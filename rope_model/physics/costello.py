"""Costello's law: tension and torque of a wire rope, coupled through axial strain and twist.

    T = Qa e + Qb tau + 1/2 Qe tau^2        M = Qc e + (Qd + Qe e) tau

Qe = c2 d^2 Qa is the middle term of the torque law M = c1 d T + c2 d^2 T w + c3 G d^4 w (w twist
per length): tension stiffens the rope in torsion.  Its energy is 1/2 Qe e tau^2, which adds the
term 1/2 Qe tau^2 to the tension.

An elastic rope has Qb = Qc (Maxwell-Betti).  Published pairs differ by a few percent; the law is
therefore split.  The conservative part with Qs = (Qb + Qc) / 2 has the energy ``strain_energy``.
The remainder with Qk = (Qb - Qc) / 2 has none; its power is ``nonconservative_power``. Works on
floats, numpy arrays and CasADi expressions.

Sources: G. A. Costello, Theory of Wire Rope, Springer; R. Verreet, The rotation characteristics of
steel wire ropes.
"""

from rope_model.physics.elementary import Scalar


def tension(Qa: Scalar, Qs: Scalar, Qk: Scalar, Qe: Scalar, e: Scalar, tau: Scalar) -> Scalar:
    """Return the tension (N) at axial strain ``e`` and torsional strain ``tau`` (rad/m)."""
    return Qa * e + (Qs + Qk) * tau + 0.5 * Qe * tau * tau


def torque(Qs: Scalar, Qk: Scalar, Qd: Scalar, Qe: Scalar, e: Scalar, tau: Scalar) -> Scalar:
    """Return the torque (N m) about the tangent at axial strain ``e`` and torsional strain ``tau`` (rad/m)."""
    return (Qs - Qk) * e + (Qd + Qe * e) * tau


def strain_energy(Qa: Scalar, Qs: Scalar, Qd: Scalar, e: Scalar, tau: Scalar) -> Scalar:
    """Return the energy per reference length (J/m) of the conservative part."""
    return 0.5 * (Qa * e * e + 2 * Qs * e * tau + Qd * tau * tau)


def stiffening_energy(Qe: Scalar, e: Scalar, tau: Scalar) -> Scalar:
    """Return the energy per reference length (J/m) of the torsional stiffness that grows with tension."""
    return 0.5 * Qe * e * tau * tau


def nonconservative_power(Qk: Scalar, e: Scalar, tau: Scalar, e_t: Scalar, tau_t: Scalar) -> Scalar:
    """Return the power per reference length (W/m) that the strain rates put into the non-conservative part."""
    return Qk * (e_t * tau - e * tau_t)
