"""What contact must satisfy, measured."""

import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from evidence.claims import Measurement, above, below
from evidence.contact import wall
from evidence.contact.brush import FINE, FITTED, brush, errors, leaning, past
from evidence.contact.plectoneme import grown, soft_rod
from evidence.contact.rebound import exact_speed, rebound
from evidence.contact.scenes import fallen, let_down, pulled, touch_down
from evidence.contact.turned import struck_legs, turned
from rope_model.solver_parameters import Mesh

#: s, steps of the rebound; and s/m, its damping
STEPS = (2e-3, 1e-3, 5e-4, 2.5e-4)
DAMPING = 0.5


def _touch_down() -> Iterator[Measurement]:
    x = touch_down(EI=10.0, element=0.08, stiffness=1e7)
    yield below("height in the bending layer, off by, of the largest", x.layer, 0.01)
    yield below("height half way up the leg, off by", abs(x.leg), 1e-4)
    yield below("force of the floor, off by", abs(x.force), 1e-6)


def _fallen() -> Iterator[Measurement]:
    for EI, element, bound in ((1.0, 0.1, 0.1), (0.1, 0.05, 0.05)):
        what = f"impulse of the floor after 0.8 s, EI = {EI:g} N m^2, off by"
        yield below(what, abs(fallen(EI, element, 0.8)), bound)


def _pulled() -> Iterator[Measurement]:
    for friction, bound in ((0.0, 1e-4), (0.2, 5e-4), (0.5, 3e-3)):
        yield below(f"tension, friction {friction:g}, off by", abs(pulled(friction, 0.1)), bound)


def _leaning() -> Iterator[Measurement]:
    off = leaning(FITTED) / leaning(Mesh("eem", 1000)) - 1.0
    yield below("force at rest, off that of 1000 elements by", abs(off), 0.01)


def _brushed() -> Iterator[Measurement]:
    ours = brush(past())
    fine = brush(past(), Mesh("eem", FINE[0]), FINE[1])
    yield below("samples inside the divider without a force", ours.gaps + fine.gaps, 1)
    what = f"impulse, off that of {FINE[0]} elements and steps of {1e3 * FINE[1]:g} ms by"
    yield below(what, abs(ours.impulse / fine.impulse - 1.0), 0.01)
    yield below("peak, off theirs by", abs(ours.peak / fine.peak - 1.0), 0.01)
    told = ours.told[0] / errors(ours, fine)[0]
    yield above("error told of the pressure over that found", told, 1.0 / 3.0)
    yield below("and at most", told, 3.0)


def _wall() -> Iterator[Measurement]:
    ours = wall.ours()
    chain = wall.chain()
    yield below("impulse, off the chain's by", abs(ours.impulse / chain.impulse - 1.0), 0.01)
    yield below("peak, off the chain's by", abs(ours.peak / chain.peak - 1.0), 0.02)
    yield below("impulse up to any instant, off by, of the whole", ours.off(chain), 0.04)
    # either begins within 1 ms of its first sample: a tenth of the blow
    blow = np.sqrt(np.square(ours.blow() - chain.blow()).mean()) / chain.peak
    yield below(
        "force of the first blow over time, off by, root mean square over the peak", blow, 0.05
    )


def _rebound() -> Iterator[Measurement]:
    exact = exact_speed(1.0, DAMPING)
    off = [rebound(1.0, DAMPING, 1e6, h).speed / exact - 1.0 for h in STEPS]
    yield below(f"speed after it, steps of {1e3 * STEPS[-1]:g} ms, off by", abs(off[-1]), 1e-3)
    yield above("order in the step", np.polyfit(np.log(STEPS), np.log(np.abs(off)), 1)[0], 1.8)
    for stiffness in (1e5, 1e7):
        h = STEPS[-1] * math.sqrt(1e6 / stiffness)
        off_by = abs(rebound(1.0, DAMPING, stiffness, h).speed / exact - 1.0)
        yield below(f"speed after it, stiffness {stiffness:g} N/m^2, off by", off_by, 1e-3)
    deep = [rebound(1.0, DAMPING, k, STEPS[-1] * math.sqrt(1e6 / k)).depth for k in (1e4, 1e6)]
    yield above("order of the depth in 1/stiffness", math.log10(deep[0] / deep[1]) / 2.0, 0.4)
    free = rebound(1.0, 0.0, 1e6, STEPS[-1])
    yield below("energy unexplained without damping, of the kinetic", abs(free.unexplained), 1e-4)


def _energies(unexplained: Callable[[float], float], *stiffnesses: float) -> Iterator[Measurement]:
    for stiffness in stiffnesses:
        what = f"energy unexplained, stiffness {stiffness:g} N/m^2, of the work done"
        yield below(what, abs(unexplained(stiffness)), 1e-3)


def _turned() -> Iterator[Measurement]:
    smooth = turned(0.0)
    rough = turned(0.2)
    yield below("angle of the ply, off by", abs(smooth.angle - 1.0), 0.02)
    for name, x in (("without friction", smooth), ("friction 0.2", rough)):
        growth = np.diff(np.interp(np.arange(1.0, 4.01, 0.25), x.turns, x.torque))
        yield above(
            f"least growth of the torque per quarter turn, {name}", growth.min(), 0.0, "N m"
        )
        stiffer = growth[-4:].sum() / growth[:4].sum()
        yield above(f"its growth in the fourth turn over that in the second, {name}", stiffer, 1.0)
        yield below(f"energy unexplained, {name}, of the work done", abs(x.unexplained), 1e-3)
    yield below(
        "times that the legs passed through each other", smooth.crossings + rough.crossings, 1
    )


def _plectoneme() -> Iterator[Measurement]:
    ours = grown()
    exact = soft_rod(grown().found.tension)
    yield above("turns of its strands about each other", ours.turns, 2.0)
    # that strands are soft makes 0.03 to 0.06; the weight grows with what hangs, which tells in the way of the ends
    for name, what, bound in (
        ("torque", "torque", 0.01),
        ("angle", "angle of its helices", 0.01),
        ("nearer", "way of the ends per turn", 0.02),
    ):
        off = getattr(ours.found, name) / getattr(exact, name) - 1.0
        yield below(f"{what}, off the closed form by", abs(off), bound)
    yield below("times that its strands passed through each other", ours.crossings, 1)


CASES: dict[str, Callable[[], Iterator[Measurement]]] = {
    "a rope that lies on a floor": _touch_down,
    "a rope that falls on a floor": _fallen,
    "a rope pulled half around a divider": _pulled,
    "a leg that leans on a thin divider": _leaning,
    "a leg that brushes a thin divider": _brushed,
    "a leg that swings against a wall": _wall,
    "a rope that strikes a floor flat": _rebound,
    "a loop let down among bodies of every kind": partial(_energies, let_down, 1e5, 1e6),
    "legs turned slowly about each other": _turned,
    "legs that strike each other": partial(_energies, struck_legs, 1e6, 1e7),
    "a rod in tension wound into a plectoneme": _plectoneme,
}
