"""Whether an exchange will be stable, told before it begins.

A force that is one step old answers to the acceleration of one step ago, |F| = m_a |a|, and the drive's mass M turns
it into |a| = m_a / M |a| one step later: the added mass of the rope's end over the mass that it hangs on decides. m_a
grows with the step, as Z H in the time in which an axial wave goes down the leg and back (impedance Z = sqrt(Qa rho),
so that the bound is H < 2 M / Z for a held force), and towards the mass of what hangs there for longer steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .interface import Scheme, Vector


@dataclass(frozen=True)
class Outlook:
    """Largest ratio m_a / M, its parts, and what the scheme allows."""

    ratio: float  # -
    added_mass: float  # kg
    mass: float  # kg
    limit: float  # -

    @property
    def stable(self) -> bool:
        """Whether the scheme is expected to be stable."""
        return self.ratio < self.limit

    def warning(self, name: str, H: float) -> str:
        """What to tell the user, "" when all is well."""
        if self.stable:
            return ""
        return (
            f"coupling {name} with H = {H:g} s: the rope's added mass {self.added_mass:.4g} kg over the conveyance's "
            f"{self.mass:.4g} kg is {self.ratio:.3g}, above {self.limit:.3g}: the run is expected to be unstable. "
            "Take semi-implicit-1, an iterative scheme, or a shorter step"
        )


def outlook(scheme: Scheme, added_mass: Vector, mobility: Vector) -> Outlook:
    """For added masses (n,) at a communication step and the drive's mobility (n, n).

    Either end of the rope may become the long leg in the course of a trip, so that the largest added mass is held
    against the smallest mass.
    """
    mass = 1.0 / float(np.max(np.diag(mobility)))
    added = float(np.max(added_mass))
    return Outlook(added / mass, added, mass, scheme.limit)
