"""Exact cases of contact (evidence.contact), and the closed form of a plectoneme where its energy is least."""

import math

import pytest

from evidence.contact.checks import CASES
from evidence.contact.plectoneme import BEND, STIFFNESS, soft_rod
from evidence.contact.plectoneme import DIAMETER as WOUND_DIAMETER
from rope_model.physics.contact import ONSET

#: of cases that take seconds
LONG = ("divider", "every kind", "falls", "legs", "rod", "swing")


@pytest.mark.parametrize(
    "case", [pytest.param(c, marks=[pytest.mark.slow] if any(word in c for word in LONG) else []) for c in CASES]
)
def test_exact_case(case: str) -> None:
    for measurement in CASES[case]():
        assert measurement.holds, measurement


@pytest.mark.parametrize("tension", [1000.0, 2000.0])
def test_the_closed_form_of_a_plectoneme_is_where_its_energy_is_least(tension: float) -> None:
    """Per length that lies in it; more of it costs nothing."""
    x, k, onset = soft_rod(tension), STIFFNESS, ONSET * WOUND_DIAMETER

    def energy(a: float, R: float) -> float:
        p = WOUND_DIAMETER - 2.0 * R
        pressed = k * (onset**2 / 6.0 + 0.5 * (p - onset) * p)
        bent, turn = 0.5 * BEND * math.sin(a) ** 4 / R**2, 0.5 * math.sin(2.0 * a) / R
        return bent + 0.5 * pressed + tension - x.torque * turn

    assert WOUND_DIAMETER - 2.0 * x.radius > onset
    # rounding of the roots
    assert energy(x.angle, x.radius) == pytest.approx(0.0, abs=1e-8 * tension)
    da, dR = 1e-3 * x.angle, 1e-3 * x.radius
    around = [
        energy(x.angle + i * da, x.radius + j * dR) for i, j in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1))
    ]
    assert all(0.0 < more < 1e-4 * tension for more in around)
