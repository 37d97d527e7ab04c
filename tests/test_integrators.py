"""The study of time integration: the methods' coefficients, their steps on the rope, and what is made of its record."""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from evidence.integrators.measure import CHECK_PARTS, EARLIER, EVEN, PARTS, STEP
from evidence.integrators.methods import ALPHA, BDF2, ESDIRK3, ESDIRK4, SDIRK2, Method, bathe
from evidence.integrators.native import rope_by
from evidence.integrators.reading import verdicts
from evidence.promise.scenes import Sample
from evidence.promise.wind import Run, errors, wind
from evidence.rendering import DOCS
from evidence.tables import Table, read, rows
from hoist_demo.parameters import Winding as Trip
from rope_model import Layout, Mesh, Rope, Scene, Solver, balance_rope
from rope_model.numerics.kernels import find_compiler

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="the study needs a C compiler")
WITH_STAGES = (bathe(0.8), SDIRK2, ESDIRK3, ESDIRK4)


def _matrix(method: Method) -> np.ndarray:
    """Butcher's A with the start as its first stage."""
    A = np.zeros((len(method.rows) + 1, len(method.rows) + 1))
    for k, row in enumerate(method.rows):
        A[k + 1, : len(row)] = row
    return A


@pytest.mark.parametrize("method", WITH_STAGES, ids=lambda m: m.name)
def test_every_method_with_stages_meets_the_conditions_of_its_order(method: Method) -> None:
    A = _matrix(method)
    b, c = A[-1], A.sum(axis=1)
    conditions = [(1, b.sum(), 1), (2, b @ c, 1 / 2), (3, b @ c**2, 1 / 3), (3, b @ A @ c, 1 / 6)]
    conditions += [(4, b @ c**3, 1 / 4), (4, b @ (c * (A @ c)), 1 / 8), (4, b @ A @ c**2, 1 / 12)]
    conditions += [(4, b @ A @ A @ c, 1 / 24)]
    for order, found, wanted in conditions:
        if order <= method.order:
            assert_allclose(found, wanted, rtol=1e-10)  # the coefficients' own rounding
    assert_allclose(c[-1], 1.0, rtol=1e-12)


@pytest.mark.parametrize("method", [bathe(0.8), ESDIRK3, ESDIRK4], ids=lambda m: m.name)
def test_stages_of_the_methods_that_begin_explicitly_are_of_second_order(method: Method) -> None:
    A = _matrix(method)
    assert_allclose(A @ A.sum(axis=1), A.sum(axis=1) ** 2 / 2, atol=1e-10)


# on the rope

#: so short a trip that no mesh follows the loop, and so smooth that the methods show their order
ROPE = Rope(length=20.0, EI=500.0, Qa=1e5, Qd=3e3, Qb=0.0, Qc=0.0, beta_K=0.0)
SMOOTH = Sample(
    0,
    Scene(
        Rope(length=20.0, EI=500.0, Qa=1e5, Qd=3e3, Qb=0.0, Qc=0.0, beta_K=0.0),
        Layout(1.5),
        mesh=Mesh("eem", elements=10),
    ),
    Trip(travel=3.0, speed=1.5, acceleration=1.0, jerk=1.0, start_delay=0.0),
    0.02,
)
#: on a rope whose ends are held a place is of one order more than the stages, at most
ORDERS = ((ALPHA, 2), (BDF2, 2), (bathe(0.8), 2), (ESDIRK3, 3), (ESDIRK4, 3))


def _wound(method: Method, part: int) -> Run:
    """With even steps, parts of the communication step."""
    solver = Solver(step_max=SMOOTH.interval / part, tolerance=1e6, newton_tolerance=1e-11)
    return wind(SMOOTH, SMOOTH.interval, partial(rope_by, method), solver=solver)


@cache
def _exact() -> Run:
    return _wound(ESDIRK4, 16)


@needs_compiler
@pytest.mark.parametrize(("method", "order"), ORDERS, ids=[method.name for method, _ in ORDERS])
def test_the_loop_errs_with_the_order_of_the_method(method: Method, order: int) -> None:
    long, short = (errors(_wound(method, part), _exact())[2] for part in (2, 4))
    assert_allclose(np.log2(long / short), order, atol=0.3)


@needs_compiler
def test_the_study_s_generalized_alpha_is_the_product_s() -> None:
    ours, theirs = (wind(SMOOTH, SMOOTH.interval, build) for build in (partial(rope_by, ALPHA), balance_rope))
    assert np.array_equal(ours.signals, theirs.signals)
    assert ours.work == theirs.work


# the record


@cache
def _methods() -> Table:
    return read(DOCS / "data" / "integrators")["methods"]


def test_even_steps_of_generalized_alpha_gain_nothing_on_themselves() -> None:
    own = [v for v in verdicts(_methods(), EARLIER) if v.name == EVEN]
    assert len(own) == len({*PARTS, *CHECK_PARTS})
    assert_allclose([v.gain for v in own], 1.0, rtol=1e-4)  # six digits are recorded


def test_two_methods_agree_on_what_is_true() -> None:
    """Generalized-alpha errs by a quarter with half the step: so its finest steps tell how far the reference errs."""
    long, short = (rows(_methods(), method=EVEN, **{"step [s]": STEP / part})["end force"] for part in CHECK_PARTS)
    assert (short < 0.3 * long).all()
