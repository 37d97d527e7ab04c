"""The hanging shape is found from any data set; what cannot hang is refused by name."""

from functools import cache

import numpy as np
import pytest
from conftest import Chain, portable_system, straight
from numpy.typing import NDArray

from rope_model.parameters import Rope
from rope_model.simulation.rope_kernels import RopeKernels
from rope_model.simulation.rope_system import POSITION, RopeSystem, arc_lengths, parameter_vector
from rope_model.simulation.stepping.statics import Equilibrium, StaticsError, find_equilibrium, hanging_guess

Array = NDArray[np.float64]

G = 9.81
COUPLING = 2.336e5


@cache
def kernels(elements: int) -> RopeKernels:
    return RopeKernels(elements)


def tmn_lengths(height: float) -> Array:
    """120 m with the pattern 2, 1, 0.5, 0.25 m around the lowest point: 90 elements."""
    fine = np.repeat([1.0, 0.5, 0.25, 0.5, 1.0], [2, 4, 40, 4, 2])
    left = round((60 + height / 2 - fine.sum() / 2) / 2)
    return np.concatenate((np.full(left, 2.0), fine, np.full(round((120 - fine.sum()) / 2) - left, 2.0)))


def hang(rope: Rope, lengths: Array, spacing: float, height: float) -> tuple[RopeSystem, Equilibrium]:
    ends = np.array([[-spacing / 2, height / 2, 0.0], [spacing / 2, -height / 2, 0.0]])
    chain = Chain.unloaded(np.zeros((lengths.size + 1, 7)))
    chain.held[[0, -1]] = True
    chain.held[[0, -1], 4] = False
    chain.values[[0, -1], POSITION] = ends
    guess = hanging_guess(arc_lengths(lengths), *ends)
    system = RopeSystem(kernels(lengths.size), lengths, parameter_vector(rope, G), chain, guess)
    return system, find_equilibrium(system, guess)


def assert_hangs(rope: Rope, system: RopeSystem, e: Equilibrium) -> None:
    weight = rope.mass_per_length * G * rope.length
    # the theory's bound; measured 1e-10
    np.testing.assert_allclose(e.reaction[[0, -1], 1].sum(), weight, rtol=1e-9)
    # rounding of 60 m coordinates in the strain of the shortest element: 1e-5 N, ten times that at most
    rounding = rope.Qa * 60.0 * np.finfo(float).eps / system.lengths.min()
    np.testing.assert_allclose(e.reaction[system.free], 0.0, atol=10 * rounding)
    # nowhere compressed, nowhere folded
    t = e.q[:, 3:6] / np.linalg.norm(e.q[:, 3:6], axis=1)[:, None]
    assert np.min(np.sum(t[1:] * t[:-1], axis=1)) > 0
    np.testing.assert_allclose(np.linalg.norm(e.q[:, 3:6], axis=1), 1.0, atol=1e-3)
    # work bound: continuation, not creeping
    assert e.iterations < 400


@pytest.mark.parametrize("coupling", [0.0, COUPLING])
@pytest.mark.parametrize("height", [0.0, 80.0])
@pytest.mark.parametrize("spacing", [1.5, 2.0, 3.0])
@pytest.mark.parametrize("EI", [50.0, 300.0, 1000.0])
def test_the_hanging_shape_is_found(EI: float, spacing: float, height: float, coupling: float) -> None:
    rope = Rope(EI=EI, Qb=coupling, Qc=coupling)
    system, e = hang(rope, tmn_lengths(height), spacing, height)
    assert_hangs(rope, system, e)


@pytest.mark.parametrize(
    ("EI", "height"),
    [(20.0, 37.0), (50.0, 0.0), (300.0, 0.0), (1000.0, 0.0), (50.0, 80.0), (300.0, 80.0), (1000.0, 80.0)],
)
def test_the_hanging_shape_is_found_on_a_coarse_mesh(EI: float, height: float) -> None:
    # elements of 3 m around a loop 2 m wide: the shape is poor, but it is found and carries the weight
    rope = Rope(EI=EI)
    _, e = hang(rope, np.full(40, 3.0), 2.0, height)
    weight = rope.mass_per_length * G * rope.length
    np.testing.assert_allclose(e.reaction[[0, -1], 1].sum(), weight, rtol=1e-9)


@pytest.mark.parametrize(
    ("left", "right"), [((-1.0, 0.0, 0.0), (1.0, 130.0, 0.0)), ((-50.0, 0.0, 0.0), (50.0, 0.0, 0.0))]
)
def test_ends_too_far_apart_are_refused_with_the_cure(
    left: tuple[float, float, float], right: tuple[float, float, float]
) -> None:
    with pytest.raises(StaticsError, match="give a longer rope or bring the ends together"):
        hanging_guess(np.linspace(0.0, 120.0, 41), np.array(left), np.array(right))


def test_a_search_without_success_says_what_is_left_and_what_to_check() -> None:
    # a free end under a load that nothing balances
    s = np.linspace(0.0, 1.0, 3)
    chain = Chain.unloaded(straight(s))
    chain.loads[-1, 1] = 5.0
    rod = Rope(length=1.0, mass_per_length=1.0, Qa=10.0, Qb=0.0, Qc=0.0, Qd=1.0, EI=1.0, rhoJ=0.1)
    system = portable_system(np.diff(s), parameter_vector(rod, 0.0), chain)
    with pytest.raises(StaticsError, match=r"N are left unbalanced; .* elements that are shorter"):
        find_equilibrium(system, chain.values, max_iterations=50)
