"""The trip that the loops of masters wind: its size, and what the path of its ends may miss in any steps."""

import numpy as np

MISSED = np.array([0.27, 0.62, 3.4])
TRAVEL, DURATION = 90.0, 25.0
#: m/s^3, of the trip at its start
JERK = 60 * TRAVEL / DURATION**3
