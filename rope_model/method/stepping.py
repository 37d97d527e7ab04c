"""Constants and formulas of stepping through a communication step."""

from rope_model.method.newton import STEP_ITERATIONS
from rope_model.physics.elementary import Scalar, maximum

#: largest number of Newton iterations of a communication step: over 6 times that of 120 drawn trips
MAX_ITERATIONS = 5_000.0
#: s, length of the communication step above which that number grows in proportion
LIMIT_INTERVAL = 0.05


def max_iterations(interval: Scalar, step_max: Scalar) -> Scalar:
    """Return the Newton iterations after which a communication step fails; a short step_max needs more."""
    return (
        MAX_ITERATIONS * maximum(interval / LIMIT_INTERVAL, 1.0)
        + 2.0 * STEP_ITERATIONS * interval / step_max
    )


#: s, shorter intervals are skipped: hosts that end on a multiple of their step have such remainders
MIN_INTERVAL = 1e-9
#: largest number of steps, rejected ones included, of a communication step: some hundred seconds
MAX_STEPS = 20000
#: practically no bound
UNBOUNDED = 2**31 - 1
#: s, beyond it the shortest steps are lost in the rounding of the time
MAX_START_TIME = 1e10

#: part of a step above which one that step_min bounds counts as the same: the search for an event
#: fails
SHORTER = 0.75

#: s, above 1/omega of the legs' longitudinal (0.02 s) and torsional modes (0.06 s), below that of
#: the loop (1 s)
SETTLING_TIME = 0.1
#: m, tolerance of the strains
NEWTON_TOLERANCE = 1e-7
#: s, time between equilibria: around a loop of 1 m at 8 m/s both errors of their second
#: differences, that of the method and that by rounding, are 1e-3 m/s^2
DIFFERENCE = 2e-3

#: s, slower motions keep their shape in a transformation, unless Newton's method needs a shorter
#: time
RELAXATION_TIME = 0.1
