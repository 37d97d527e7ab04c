"""Ropes of the catalogue: data as ranges with sources, and the properties that follow from them."""

import math
from itertools import chain

import numpy as np
import pytest
from numpy.testing import assert_allclose
from shares import share_of

from rope_model import BEARINGS, CONSTRUCTIONS, Rope, rope
from rope_model.catalogue import PROPERTIES, SHEAR, STEEL_MODULUS, Datum, properties_of, rope_of
from rope_model.physics import costello

constructions = pytest.mark.parametrize("name", CONSTRUCTIONS)


@constructions
def test_every_datum_is_a_range_with_a_source(name: str) -> None:
    known = rope(name, diameter=0.046)
    assert known.data.keys() == PROPERTIES.keys()
    of_bearings = chain.from_iterable(data.values() for data in BEARINGS.values())
    for datum in [*known.data.values(), *of_bearings]:
        assert 0 <= datum.low < datum.middle < datum.high
        # what is called published says where, and none of it is ours
        assert datum.source
        assert datum.status != "published" or (
            "http" in datum.source and "ours" not in datum.source
        )
        assert datum.status == "assumed" or "ours" not in datum.source


@constructions
def test_any_value_of_the_ranges_is_a_rope(name: str) -> None:
    rng = np.random.default_rng(3)
    known = rope(name, diameter=0.05)
    for shares in rng.random((200, len(PROPERTIES))).round():  # corners
        # a rope whose strain energy is not positive is refused
        known.rope(
            **{key: datum.at(u) for (key, datum), u in zip(known.data.items(), shares, strict=True)}
        )


def test_properties_of_a_rope_give_it_back() -> None:
    known = rope("18x7", diameter=0.04, length=300.0, lay="left-hand")
    made = known.rope(torque_factor=0.03, bending_stiffness=150.0)
    assert_allclose(made.Qc, -0.03 * made.Qa * 0.04)
    again = rope_of(0.04, 300.0, "left-hand", **properties_of(made))
    for name in ("mass_per_length", "Qa", "Qb", "Qc", "Qd", "EI", "rhoJ", "length", "diameter"):
        assert_allclose(getattr(again, name), getattr(made, name), rtol=1e-14)
    assert_allclose(properties_of(Rope())["torque_factor"], 2.336e5 / (1.2e8 * 0.044))


def test_a_sample_shows_the_properties() -> None:
    """Held: the torque c1 d T. Turned at constant tension: D per twist (by the law of physics.costello)."""
    made = rope("34x7", diameter=0.046).rope(torque_factor=0.015, torsional_stiffness=900.0)
    T = 5e4
    assert_allclose(
        costello.torque(made.Qs, made.Qk, made.Qd, 0.0, T / made.Qa, 0.0), 0.015 * 0.046 * T
    )
    tau = 0.02
    e = (T - made.Qb * tau) / made.Qa
    turned = costello.torque(made.Qs, made.Qk, made.Qd, 0.0, e, tau)
    assert_allclose(turned - 0.015 * 0.046 * T, 900.0 * tau, rtol=1e-9)


@constructions
def test_bending_begins_at_the_sum_of_the_wires(name: str) -> None:
    construction = CONSTRUCTIONS[name]
    d = 0.046
    wire = 2 * math.sqrt(construction.area[0] * d**2 / (construction.wires * math.pi))
    alone = construction.wires * STEEL_MODULUS * math.pi * wire**4 / 64
    data = rope(name, diameter=d).data
    assert_allclose(data["bending_stiffness"].low, alone)
    assert_allclose(data["torsional_stiffness"].low, 2 * SHEAR * alone)


def test_mass_is_that_of_the_standard() -> None:
    # kg per 100 m: W d^2 with d in mm
    assert_allclose(rope("34x7", diameter=0.046).data["mass_per_length"].low, 0.390 * 46**2 / 100)
    assert_allclose(rope("6x36", diameter=0.030).data["mass_per_length"].high, 0.409 * 30**2 / 100)


@pytest.mark.parametrize(
    "datum", [Datum(2.0, 8.0, "m", "assumed", ""), Datum(0.0, 8.0, "m", "assumed", "")]
)
def test_shares_of_a_range(datum: Datum) -> None:
    assert_allclose([datum.at(0), datum.at(1)], [datum.low, datum.high])
    assert_allclose(datum.at(0.5), datum.middle)
    assert_allclose(share_of(datum, datum.at(0.3)), 0.3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"construction": "7x7", "diameter": 0.04},
            "construction = '7x7' is out of range: it must be one of 34x7",
        ),
        (
            {"construction": "34x7", "diameter": 46.0},
            "diameter = 46.0 is out of range.*give it in metres",
        ),
        (
            {"construction": "34x7", "diameter": 0.04, "lay": "z"},
            "lay = 'z' is out of range: it must be one of right",
        ),
    ],
)
def test_what_the_catalogue_lacks_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        rope(**arguments)  # type: ignore[arg-type]
