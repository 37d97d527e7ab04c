"""Payloads that change while the hoist dwells between two trips of a duty."""

from dataclasses import dataclass, replace

from hoist_demo.parameters import Hoist

#: Parts of a dwell between which the payload changes to that of the next trip [assumed].
LOADING_PARTS = (0.25, 0.75)


@dataclass(frozen=True)
class Loading:
    """Change of the payloads to those of the next trip, evenly in the middle of a dwell.

    Rarer changes would be stairs in the acceleration, which the rope takes for a table that is too
    coarse.
    """

    hoist: Hoist  # of the trip that ends
    next_hoist: Hoist | None  # of the trip that follows; None: nothing changes
    arrival: float  # s, end of the trip's reference after its start
    dwell: float  # s

    def changes(self, t: float, period: float) -> bool:
        """Return True if a payload may change in the period [s] that ends at t [s], or before it."""
        if self.next_hoist is None:
            return False
        first, last = (self.arrival + part * self.dwell for part in LOADING_PARTS)
        return first < t < last + 2.0 * period

    def hoist_at(self, t: float) -> Hoist | None:
        """Return the hoist with its payloads at t [s] after the start; None before they change."""
        dwelt = t - self.arrival
        first, last = (part * self.dwell for part in LOADING_PARTS)
        next_hoist = self.next_hoist
        if next_hoist is None or dwelt <= first:
            return None
        part = min((dwelt - first) / (last - first), 1.0)
        now = self.hoist
        left = now.payload_left + part * (next_hoist.payload_left - now.payload_left)
        right = now.payload_right + part * (next_hoist.payload_right - now.payload_right)
        return replace(now, payload_left=left, payload_right=right)
