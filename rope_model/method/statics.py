"""Constants and formulas of the search for the rope at rest."""

from rope_model.physics.elementary import SMALLEST_DIVISOR, Scalar, less, maximum

#: last full Newton correction in ``system.norm``, over the rope's length
REST_TOLERANCE = 1e-11
FIRST_TIME = 0.1  #: s, first pseudo-time step tau
SHORTEST_TIME = 1e-7  #: s, tau at which the search gives up
#: s, tau beyond which the inertia does not matter
SETTLED = 1e3
NEWTON_TIME = 1e8  #: s, tau above which corrections are Newton's
LONGEST_TIME = 1e12  #: s
SHRINK = 0.3  #: factor of tau after a correction that is not taken
SHRINK_OF_INFINITE = 0.1  #: the same after one that is not finite
LEAST_GROWTH = 1.5  #: least factor of tau after a correction that is taken
LARGEST_GROWTH = 10.0
#: work of the forces after a correction over that before it, above which it is not taken: it grows
#: where a rope goes to and fro between two shapes
MAX_GAIN = 3.0
ROUNDED = 10.0  #: unbalanced force over that by which rounding stretches the shortest element
#: corrections with forces balanced to rounding, after which remaining motion costs no energy; tau
#: takes at most 51 from its first value to its last
BALANCED = 200
#: m or rad, largest move by a correction; beside a thin body no more than half of the way through
#: it
MAX_MOVE = 0.3
#: corrections after which MAX_GAIN is 1: none may end higher than it began
PATIENCE = 300
#: Qk over Qs below which the coupling is symmetric for the search: what its tangent then lacks
#: leaves this part of the error, and a correction is as good as full; rounding of Qb or Qc is no
#: reason for shorter ones
SYMMETRIC = 1e-6


def lacks_symmetry(Qs: Scalar, Qk: Scalar) -> Scalar:
    """Return whether the part Qk of the coupling without energy is large enough to shorten corrections."""
    return less(SYMMETRIC * abs(Qs), abs(Qk))


def relaxation(change: Scalar, last: Scalar) -> Scalar:
    """Return the part of a correction to take, from the ``change`` of the squared error by the part ``last`` before.

    The part w of a correction that multiplies the error by i r changes its square by (1 - w)^2 + (w
    r)^2.
    """
    return 1.0 / (
        1.0 + maximum((change - (1.0 - last) ** 2) / maximum(last * last, SMALLEST_DIVISOR), 0.0)
    )


FLOOR_STEP = 0.25  #: m, by which the floor rises beneath a rope that is laid down on it
MAX_FLOOR_STEPS = 40
CURVATURE_STEPS = 8  #: increments of the permanent curvature
#: increments of the position and lean of ends that are not plumb: 0.1 rad each at most
PLACING_STEPS = 32
TWIST_STEP = 1.0  #: rad, largest increment of twist
MIN_TWIST_STEP = 0.01  #: rad, smallest increment of twist
#: rad, largest turn of the frame at the right end, twice the loop's yaw, on the branch of
#: equilibria
MAX_TURN = 2.0
MAX_CORRECTIONS = 10_000  #: largest number of corrections of one equilibrium
#: corrections of all equilibria after which twisting is given up: a fifth above the largest number
#: of 60 drawn ropes
MAX_TWISTING = 100_000
#: corrections after which laying a rope down is given up: more than twice the largest number of 200
#: drawn ropes
MAX_LAYING = 20_000
#: solutions for contact of the rope with itself, in all equilibria of a start, after which it is
#: given up: some seconds.  A rope that goes on winding about itself takes ever more, as each
#: correction has more contacts to solve for: 900 m with strong coupling had 50,000 in 3000
#: corrections, and as large an imbalance as before
MAX_CONTACT_SOLUTIONS = 20_000
