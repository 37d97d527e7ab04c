"""Books of force, moment and energy, kept from the rope's nodes and its loads on the conveyances."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from invariants.case import Array, Case
from invariants.features import Draws
from invariants.runs import FORCES, MOMENTS, Compared, Record, Refused, start, wind
from rope_model import BalanceRope
from rope_model.method.audit import JUDGED_INTERVAL, MISSING_FORCE
from rope_model.physics.hermite import GAUSS, interpolate

#: of the largest end force in a step, beside what the audit has: rounding of the sums
ROUNDING = 1e-7
#: of the largest end force in the mean over a run: what Newton's method leaves in a step alternates
MISSING_IN_THE_MEAN = 1e-4
#: of the largest end force at rest: statics leaves 1e-6 N at each node
MISSING_AT_REST = 1e-6
#: of the largest end force times the longest arm: statics leaves 1e-6 N at each node
MISSING_MOMENT = 1e-6
#: of the energy that has gone through the ends: the product promises no number; trips at the
#: defaults have 1e-4
MISSING_ENERGY = 1e-3
SHARE = 3.0


def feels_weight_alone(case: Case) -> bool:
    """Whether nothing but weight and ends acts on the rope: no air, no bodies, no dead load."""
    shaft = case.scene.shaft
    bodies = (
        shaft.lining.width,
        shaft.conveyance.width,
        shaft.head_ropes.diameter,
        shaft.divider_1.size,
    )
    stands = shaft.contact.stiffness > 0 and (any(bodies) or shaft.sump.level > -1e6)
    return case.force is None and shaft.air.density == 0 and not stands


def require(holds: bool, why: str) -> None:
    if not holds:
        raise Refused(f"not for {why}")


def integrals(rope: BalanceRope) -> tuple[Array, Array, Array]:
    """Momentum (3,) per mass per length, the first moment of the length (3,), and the length, by Gauss points."""
    rows = rope.rows()
    s = rows[:, 0]
    r = rows[:, 1:4]
    d = rows[:, 4:7]
    v = rows[:, 7:10]
    d_t = rows[:, 10:13]
    l = np.diff(s)[:, None]
    momentum = np.zeros(3)
    first = np.zeros(3)
    for xi, weight in GAUSS:
        momentum += (weight * l * interpolate(xi, l, v[:-1], d_t[:-1], v[1:], d_t[1:])[0]).sum(
            axis=0
        )
        first += (weight * l * interpolate(xi, l, r[:-1], d[:-1], r[1:], d[1:])[0]).sum(axis=0)
    return momentum, first, np.asarray(l.sum())


def momentum(case: Case, draws: Draws) -> Iterator[Compared]:
    """Mean vertical end forces of each communication step, the weight, and the change of the momentum."""
    require(feels_weight_alone(case), "air, bodies and dead loads")
    found: list[float] = []

    def kept(rope: BalanceRope, k: int) -> BalanceRope:
        found.append(float(integrals(rope)[0][1]))
        return rope

    record = wind(case, kept)
    require(record.rope.fidelity != "rigid", "a rigid rope, which has no nodes' rates")
    last = len(record.rows) - 1
    found = [*found[:last], float(integrals(record.rope)[0][1])]
    rope = case.scene.rope
    h = np.diff(record.times)
    weight = rope.mass_per_length * rope.length * case.scene.layout.gravity
    pulls = (record["left.fy_mean"] + record["right.fy_mean"])[1:]
    missing = rope.mass_per_length * np.diff(found[: last + 1]) / h + pulls + weight
    if last:
        # fy_mean is the audited impulse; the audit takes short steps together
        audited = record.unbalanced
        joined = np.maximum(1.0, JUDGED_INTERVAL / h)
        unreported = audited
        if "missing_loads" in record.rope.warnings():
            unreported = 0.0
        yield Compared(
            "force missing in a step beside the audit's",
            float(np.abs(missing / joined).max()),
            audited + ROUNDING * record.force,
        )
        yield Compared("audited force", unreported, MISSING_FORCE * record.force)
        mean = abs(float((missing * h).sum())) / float(h.sum())
        yield Compared(
            "force missing in the mean of the run", mean, MISSING_IN_THE_MEAN * record.force
        )


def rest(case: Case, draws: Draws) -> Iterator[Compared]:
    """Forces and moments about three axes on a rope at rest."""
    require(feels_weight_alone(case), "air, bodies and dead loads")
    record = start(case)
    require(record.rope.fidelity != "rigid", "a rigid rope, which has no moments")
    rope = case.scene.rope
    row = record.rope.rows()
    _, first, length = integrals(record.rope)
    weight = rope.mass_per_length * case.scene.layout.gravity
    forces = record.several(FORCES)[0].reshape(2, 3)
    moments = record.several(MOMENTS)[0].reshape(2, 3)
    if record.rope.fidelity != "torsional":
        moments = np.zeros((2, 3))
    ends = row[[0, -1], 1:4]
    missing_force = forces.sum(axis=0) + np.array([0.0, weight * float(length), 0.0])
    yield Compared(
        "force missing at rest", float(np.abs(missing_force).max()), MISSING_AT_REST * record.force
    )
    if record.rope.fidelity == "torsional":
        down = np.cross(first, [0.0, -weight, 0.0])
        middle = ends.mean(axis=0)
        arms = np.cross(ends - middle, forces).sum(axis=0) - (
            down - np.cross(middle * float(length), [0, -weight, 0])
        )
        missing = moments.sum(axis=0) + arms
        arm = float(np.abs(ends[1] - ends[0]).max()) + case.scene.layout.spacing
        yield Compared(
            "moment missing at rest",
            float(np.abs(missing).max()),
            MISSING_MOMENT * record.force * arm,
        )


def energy(case: Case, draws: Draws) -> Iterator[Compared]:
    """Energy that appears: the integrator may lose some, and create none beyond its error."""
    record = wind(case)
    require(record.rope.fidelity != "rigid", "a rigid rope, whose energy is its ends'")
    throughput = energy_throughput(record)
    worst = float(record["energy.residual"].max())
    relative = MISSING_ENERGY + SHARE * float(record["status.end_force_error"][-1])
    # the strain of a rope at rest is known to the residual of statics
    yield Compared("energy that appears", worst, relative * throughput)


def energy_throughput(record: Record) -> float:
    """Energy moved by the ends against their forces, with the largest kinetic energy and change of strain (J)."""
    forces = record.several(FORCES).reshape(-1, 2, 3)
    ends = [record.case.at(float(t)) for t in record.times]
    speeds = np.array([(left.velocity, right.velocity) for left, right in ends])
    h = np.diff(record.times, prepend=record.times[0])
    moved = float((np.abs((forces * speeds).sum(axis=2)).sum(axis=1) * h).sum())
    strain = record["energy.strain"]
    # at rest waves of a thousandth of the strain energy are nothing
    return (
        moved
        + float(record["energy.kinetic"].max())
        + float(np.ptp(strain))
        + 1e-3 * float(strain.max())
    )


RELATIONS: tuple[Callable[[Case, Draws], Iterator[Compared]], ...] = (momentum, rest, energy)
