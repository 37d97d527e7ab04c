"""The trip that the loops of masters wind: its size, and what the path of its ends may miss in any steps."""

from __future__ import annotations

import numpy as np

#: of y, vy and ay behind a jerk j that is extrapolated over steps up to H, over j H^3, j H^2 and j H: in any steps
MISSED = np.array([1.2, 1.2, 5.9])
#: that of ay in steps of which none is much shorter than the one before
MISSED_ACCELERATION = 3.4
TRAVEL, DURATION = 90.0, 25.0
#: m/s^3, of the trip at its start
JERK = 60 * TRAVEL / DURATION**3
