"""rope_model against another discretisation of the same equations: a discrete rod on scipy's integrators.

The rod itself is checked first, by what it must obey whatever its mesh.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from evidence.discrete_rod import cases
from evidence.discrete_rod.cases import SHORT, Case, Comparison, Winding
from evidence.discrete_rod.rod import GRAVITY, Rod, join, split
from evidence.discrete_rod.solve import HELD, first_guess
from rope_model.parameter_table import LEAST_POSITIVE

Array = NDArray[np.float64]

REST = Winding(12.0, np.inf)


def disturb(rod: Rod, size: float) -> Array:
    """A state in which everything moves and nothing is symmetric."""
    rng = np.random.default_rng(7)
    p = split(first_guess(rod))
    x, v = (z + size * rng.standard_normal(z.shape) for z in (p.x, p.v))
    m, w = (0.1 * size * rng.standard_normal(z.shape) for z in (p.m, p.w))
    return np.asarray(join(p._replace(x=x, v=v, m=m, w=w)))


def short(edges: int, **changes: float) -> Rod:
    return Rod(np.full(edges, SHORT.length / edges), replace(SHORT, **changes), REST.rod)


def energy(rod: Rod, y: Array) -> Array:
    """J, of the columns of ``y``; written without the rod's own forces."""
    c = rod.rope
    p = split(y)
    L = rod.cells[:, None]
    l = rod.lengths[:, None]
    left, right = (np.broadcast_to(z[:, None], (3, y.shape[1]))[None] for z in rod.ends(0.0)[0])
    x = np.concatenate((left, p.x, right))
    edge = np.diff(x, axis=0)
    size = np.sqrt((edge**2).sum(axis=1))
    clamp = np.broadcast_to(np.array([0.0, 1.0, 0.0])[:, None], left.shape[1:])[None]
    t = np.concatenate((-clamp, edge / size[:, None], clamp))
    cosine = (t[:-1] * t[1:]).sum(axis=1)
    e = size / l - 1
    tau = p.m / L
    mean = 0.5 * (np.concatenate((l * e, 0 * e[:1])) + np.concatenate((0 * e[:1], l * e))) / L
    strain = 0.5 * c.Qa * l.T @ e**2 + (L.T @ (c.Qb * mean * tau + 0.5 * c.Qd * tau**2))
    bending = 0.5 * c.EI * (1 / L).T @ (4 * (1 - cosine) / (1 + cosine))
    gravity = c.mass_per_length * GRAVITY * L.T @ x[:, 1]
    motion = (
        0.5 * c.mass_per_length * L[1:-1].T @ (p.v**2).sum(axis=1) + 0.5 * c.rhoJ * l.T @ p.w**2
    )
    return np.asarray((strain + bending + gravity + motion)[0])


def test_an_undamped_elastic_rod_keeps_its_energy() -> None:
    rod = short(24, beta_K=0.0, Qb=1e5, Qc=1e5)
    y = disturb(rod, 0.05)
    rates = rod.rates(0.0, y, HELD)
    power = energy(rod, y[:, None] + 1e-30j * rates[:, None])[0].imag / 1e-30
    # against the power of one kind of force alone
    assert abs(power) < 1e-11 * np.abs(rates * y).sum() * rod.rope.mass_per_length


def test_turning_as_a_whole_neither_strains_nor_is_damped() -> None:
    still = short(24)
    y = disturb(still, 0.05)
    omega = np.array([0.0, 0.7, 0.0])
    place = still.ends(0.0)[0]
    turning = replace(still, ends=lambda t: np.array([place, np.cross(omega, place), 0 * place]))
    p = split(y)
    edge = np.diff(np.vstack((place[0], p.x, place[1])), axis=0)
    w = (edge / np.linalg.norm(edge, axis=1)[:, None]) @ omega
    y = join(p._replace(v=np.cross(omega, p.x), w=w, b_t=np.array([-0.7, 0.7])))
    rods = turning, replace(turning, rope=replace(turning.rope, beta_K=0.0))
    damped, free = (rod.evaluate(0.0, y[:, None], HELD).rates[:, 0] for rod in rods)
    np.testing.assert_allclose(split(damped).m, 0.0, atol=1e-13)
    np.testing.assert_allclose(damped, free, atol=1e-9 * np.abs(free).max())


def test_a_spinning_limp_chain_keeps_its_angular_momentum() -> None:
    # no stiffness but along: the clamps pass on no couple, and what is left is the spin's
    rod = short(16, EI=LEAST_POSITIVE, Qb=0.0, Qc=0.0, Qd=LEAST_POSITIVE)
    y = disturb(rod, 0.05)
    y[[3, *range(11, y.size - 3, 8)]] += 1e4  # rad/s
    loads = rod.evaluate(0.0, y[:, None], HELD)
    p = split(y)
    c = rod.rope
    rates = split(loads.rates[:, 0])
    ends = rod.ends(0.0)[0]
    edge, edge_t = (
        np.diff(np.vstack((a, z, b)), axis=0)
        for z, a, b in ((p.x, *ends), (p.v, 0 * ends[0], 0 * ends[1]))
    )
    t = edge / np.linalg.norm(edge, axis=1)[:, None]
    t_t = (edge_t - t * np.sum(t * edge_t, axis=1)[:, None]) / np.linalg.norm(edge, axis=1)[:, None]
    mass = c.mass_per_length * rod.cells[1:-1, None]
    weight = np.array([0.0, -GRAVITY, 0.0])
    spin = np.sum(c.rhoJ * (rod.lengths * p.w)[:, None] * t_t, axis=0)
    change = np.sum(np.cross(p.x, mass * rates.v), axis=0) + spin
    couple = np.sum(np.cross(p.x, mass * weight), axis=0)
    end_weight = c.mass_per_length * rod.cells[[0, -1], None] * weight
    couple += np.sum(np.cross(ends, loads.reaction[:, :, 0] + end_weight), axis=0)
    assert np.linalg.norm(spin) > 1.0
    np.testing.assert_allclose(
        change, couple, atol=1e-9 * np.abs(loads.reaction).max() * SHORT.length
    )


def test_the_sparse_jacobian_is_the_derivative_of_the_rates() -> None:
    rod = short(12)
    y = disturb(rod, 0.05)
    direction = np.random.default_rng(5).standard_normal(y.size)
    slope = rod.evaluate(0.0, (y + 1e-30j * direction)[:, None], -1.0).rates[:, 0].imag / 1e-30
    np.testing.assert_allclose(rod.jacobian(0.0, y, -1.0) @ direction, slope, rtol=1e-10, atol=1e-6)


def judge(case: Case) -> dict[str, Comparison]:
    """Every quantity of ours within what the two codes' own convergence allows; the comparisons."""
    compared = case.compare()
    for name, c in compared.items():
        assert c.differences[-1] <= c.acceptance, (
            f"{case.name}, {name}: {c.differences} against {c.acceptance}"
        )
    return compared


REST_120, UNCOUPLED, COUPLED, WINDING, RELEASE = cases.cases()


@pytest.mark.slow
def test_the_rope_at_rest_yaws_as_the_discrete_rod_does() -> None:
    compared = judge(replace(REST_120, ours_on=(400, 800), rod_on=(100, 200, 400)))
    # second order in every quantity: the limit is one
    assert [c.order for c in compared.values()] == pytest.approx([2.0] * len(compared), abs=0.1)


@pytest.mark.slow
def test_the_rope_vibrates_in_and_out_of_plane_as_the_discrete_rod_does() -> None:
    assert len(judge(replace(UNCOUPLED, ours_on=(300, 600), rod_on=(100, 200)))) == 8


@pytest.mark.slow
def test_a_swivel_lets_the_rope_go_as_it_does_the_discrete_rod() -> None:
    times = np.linspace(0.0, 0.5, 51)
    ours, rod = (
        partial(release, times=times) for release in (cases.release_ours, cases.release_rod)
    )
    assert "sticks at [s]" in judge(Case("release", ours, rod, (80, 160), (40, 80)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", [REST_120, UNCOUPLED, COUPLED, WINDING, RELEASE], ids=lambda case: case.name
)
def test_the_page_shows_no_disagreement(case: Case) -> None:
    judge(case)
