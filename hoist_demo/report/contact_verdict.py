"""Rows of the verdict on what ropes touch: strikes, guards, and the clearance of neighbours."""

from collections.abc import Iterator, Sequence

from hoist_demo.recording.incidents import GUARD_CODES, guard_trip
from hoist_demo.recording.nearness import RopePair
from hoist_demo.recording.passages import passages
from hoist_demo.recording.time_series import Recording
from hoist_demo.report.formatting import number, rounded
from hoist_demo.report.rope_record import RopeRecord
from hoist_demo.report.verdict_row import NO_BOUND, VerdictRow

_STRIKES = "strikes"
#: Relative error of the forces between two ropes, against the law, that the verdict mentions.
SMALLEST_FORCE_ERROR = 1e-3
_NO_CONTACT = (
    ": each went on as if alone; contact.rope_stiffness = 1e6 and model.fidelity = torsional let "
    "them press each other"
)


def between_ropes(pairs: Sequence[RopePair], ropes: Sequence[RopeRecord]) -> Iterator[VerdictRow]:
    """Yield the clearance of each pair of ropes, and their force on each other."""
    for pair in pairs:
        members = [rope for rope in ropes if rope.data.name in (pair.one, pair.other)]
        yield from _between(pair, error=max(rope.loop_error for rope in members))


def _between(pair: RopePair, error: float) -> Iterator[VerdictRow]:
    """Yield the clearance of two ropes, and how they pressed each other if they may."""
    near = pair.nearest
    if near is not None:
        where = _where(near.t, near.position)
        if near.clearance <= 0.0 and pair.account is None:
            where += _NO_CONTACT
        yield VerdictRow(
            f"clearance between {pair.one} and {pair.other}",
            f"{rounded(near.clearance, error)} m",
            bound=f"above {number(error, 2)} m, its error",
            holds=near.clearance > error,
            where=where,
        )
    account = pair.account
    if account is not None and account.peak > 0.0:
        where = _where(account.peak_t, account.peak_place)
        if account.missed > SMALLEST_FORCE_ERROR:
            where += f"; errs by up to {number(100 * account.missed, 2)} %"
        yield VerdictRow(
            f"force of {pair.one} on {pair.other}", f"{number(account.peak, 3)} N", where=where
        )


def _where(t: float, point: Sequence[float]) -> str:
    """Return instant [s] and place [m] in words."""
    texts = [f"t = {t:.2f} s"]
    for axis, x in zip("xyz", point, strict=True):
        texts.append(f"{axis} = {round(x, 2) + 0.0:.2f} m")
    return ", ".join(texts)


def strikes(ropes: Sequence[RopeRecord], pairs: Sequence[RopePair]) -> VerdictRow:
    """Return the row of what struck what."""
    names = [rope.data.name or "struck" for rope in ropes if passages(rope.recording)]
    names += [f"{pair.one} on {pair.other}" for pair in pairs if pair.touched]
    return VerdictRow(_STRIKES, ", ".join(names) or "none", bound="none", holds=not names)


def guards(recording: Recording, rope: RopeRecord) -> VerdictRow:
    """Return the row of the guards that are set, and of the one that tripped."""
    causes = [cause for cause in GUARD_CODES.values() if rope.parameter(f"guard.{cause}") > 0.0]
    trip = guard_trip(recording)
    holds = trip is None if causes else None
    bound = ", ".join(causes) or NO_BOUND
    if trip is not None:
        return VerdictRow("guards", f"{trip.cause} tripped", bound, holds, f"t = {trip.t:.2f} s")
    return VerdictRow("guards", "none tripped" if causes else "none set", bound, holds)
