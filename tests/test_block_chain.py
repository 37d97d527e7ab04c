"""The block elimination against a dense solve, the compiled kernels against the portable ones, the kernel cache."""

import logging
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from conftest import Array

from rope_model import compiler as kernels
from rope_model.physics.element import NODE_DOF, element_functions
from rope_model.simulation.rope_kernels import RopeKernels

needs_compiler = pytest.mark.skipif(
    kernels.find_compiler() is None, reason="no C compiler: nothing to compare with"
)
#: the arguments of ``evaluate``
STATE = ("q", "v", "a", "R", "l", "F", "load", "friction_load", "node_mass", "P")
P = np.array([1.3, 9.8, 5.0, 0.8, 0.3, 2.0, 1.5, 0.4, 0.3, 1.2, 0.9, 0.5, 0.2])


def random_chain(elements: int, seed: int) -> dict[str, Array]:
    """Arguments of ``newton_step``: a crooked, twisted rope in motion, a third of its freedoms held."""
    rng = np.random.default_rng(seed)
    nodes = (elements + 1, NODE_DOF)
    l = rng.uniform(0.5, 1.5, elements)
    q = 0.2 * rng.normal(size=nodes)
    q[:, 0] += np.concatenate(([0.0], np.cumsum(l)))
    q[:, 3] += 1.0
    free = (rng.uniform(size=nodes) < 0.67).astype(float)
    normal = partial(rng.normal, size=nodes)
    return {
        "q": q,
        "v": normal(),
        "a": normal(),
        "R": normal(),
        "l": l,
        "F": RopeKernels(elements, "portable").reference(q + 0.1 * normal(), l)[0],
        "load": normal(),
        "friction_load": normal(),
        "node_mass": rng.uniform(0.0, 0.5, nodes),
        "free": free,
        "P": P,
        "c": np.array([1.0, 3.0, 40.0]),
    }


def direct(x: dict[str, Array]) -> tuple[Array, Array]:
    element, elements = element_functions(), x["l"].size
    size = NODE_DOF * (elements + 1)
    R, J = np.zeros(size), np.zeros((size, size))
    for i in range(elements):
        at = slice(NODE_DOF * i, NODE_DOF * (i + 2))
        motion = [x[k][i : i + 2].ravel() for k in "qva"]
        R_e, J_e = element.tangent(*motion, x["l"][i], x["F"][i], x["P"], *x["c"], motion[0])
        R[at] += np.asarray(R_e).ravel()
        J[at, at] += np.asarray(J_e)
    R += (
        x["node_mass"] * x["a"] - x["load"] - x["friction_load"] * np.maximum(x["R"][:, 1:2], 0.0)
    ).ravel()
    J += x["c"][2] * np.diag(x["node_mass"].ravel())
    free = np.flatnonzero(x["free"].ravel())
    correction = np.zeros(size)
    correction[free] = np.linalg.solve(J[np.ix_(free, free)], -R[free])
    return correction.reshape(x["q"].shape), R.reshape(x["q"].shape)


@pytest.mark.parametrize("elements", [1, 2, 7])
@pytest.mark.parametrize("seed", range(3))
def test_the_direction_is_that_of_a_dense_solve(elements: int, seed: int) -> None:
    x = random_chain(elements, seed)
    correction, R = RopeKernels(elements, "portable").newton_step(*x.values())
    expected, R_expected = direct(x)
    assert np.all(np.isfinite(expected))
    # elimination without pivoting of a well-conditioned matrix: rounding times its condition of 1e3
    np.testing.assert_allclose(correction, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
    np.testing.assert_allclose(R, R_expected, rtol=0, atol=1e-13 * np.abs(R_expected).max())


def test_assess_tells_the_residual_that_direction_uses_and_sums_the_balances() -> None:
    elements = 6
    x, k, element = (
        random_chain(elements, 4),
        RopeKernels(elements, "portable"),
        element_functions(),
    )
    R, sums = k.evaluate(*(x[name] for name in STATE))
    np.testing.assert_allclose(
        R, k.newton_step(*x.values())[1], rtol=1e-13, atol=1e-13
    )  # rounding: two texts of code
    balances, strains = [], []
    for i in range(elements):
        q, v = (x[name][i : i + 2].ravel() for name in "qv")
        balances.append(np.asarray(element.balance(q, v, x["l"][i], x["F"][i], P)).ravel())
        strains.append(np.asarray(element.strains(q, v, x["l"][i], x["F"][i])).ravel())
    np.testing.assert_allclose(sums, np.sum(balances, axis=0), rtol=1e-12)
    np.testing.assert_allclose(k.strains(x["q"], x["v"], x["l"], x["F"])[0], strains, rtol=1e-12)


@needs_compiler
def test_the_compiled_kernels_give_what_the_portable_ones_give() -> None:
    elements = 8  # the size other tests compile too
    compiled, portable = RopeKernels(elements, "compiled"), RopeKernels(elements, "portable")
    assert (compiled.form, portable.form) == ("compiled", "portable")
    for seed in range(3):
        x = random_chain(elements, seed)
        state = [x[name] for name in STATE]
        pairs = [
            *zip(compiled.newton_step(*x.values()), portable.newton_step(*x.values()), strict=True),
            *zip(compiled.evaluate(*state), portable.evaluate(*state), strict=True),
            *zip(
                *(
                    kernels.strains(*(x[name] for name in "qvlF"))
                    for kernels in (compiled, portable)
                ),
                strict=True,
            ),
        ]
        for ours, reference in pairs:
            assert np.all(np.isfinite(reference))
            # the same operations; the compiler may order a sum differently
            np.testing.assert_allclose(
                ours, reference, rtol=1e-12, atol=1e-12 * np.abs(reference).max()
            )


def test_the_kernels_leave_their_arguments_alone_and_give_their_results_away() -> None:
    x, k = random_chain(2, 0), RopeKernels(2, "portable")
    kept = {name: value.copy() for name, value in x.items()}
    first = k.newton_step(*x.values())[0]
    copy = first.copy()
    k.newton_step(*(x | {"a": 2 * x["a"]}).values())
    np.testing.assert_array_equal(first, copy)
    for name, value in kept.items():
        np.testing.assert_array_equal(x[name], value)


def small_function(factor: float = 2.0) -> ca.Function:
    x = ca.SX.sym("x", 3)
    return ca.Function("small", [x], [factor * ca.sin(x)])


@needs_compiler
def test_a_second_build_finds_the_first_ones_library_and_others_make_another(
    tmp_path, monkeypatch
) -> None:
    build = partial(kernels.build_library, compiler=kernels.find_compiler(), folder=tmp_path)
    first = build([small_function()])
    made = first.stat().st_mtime_ns
    assert build([small_function()]) == first
    assert first.stat().st_mtime_ns == made
    assert sorted(file.suffix for file in tmp_path.iterdir()) == [
        ".o",
        first.suffix,
    ]  # no scratch left
    other = build([small_function(3.0)])
    monkeypatch.setattr(kernels, "FLAGS", (*kernels.FLAGS, "-DOTHER"))
    assert len({first, other, build([small_function()])}) == 3


def test_what_many_want_at_once_is_made_once(tmp_path: Path) -> None:
    file, runs = tmp_path / "made", []

    def make() -> None:
        runs.append(file.exists())
        time.sleep(0.1)  # the others have come
        file.write_text("whole")

    with ThreadPoolExecutor(4) as threads:
        made = [*threads.map(lambda _: kernels.make_once(file, make), range(4))]
    assert made == [file] * 4
    assert runs == [False]
    assert [*tmp_path.iterdir()] == [file]


def test_without_a_compiler_auto_is_portable_and_compiled_says_what_to_do(monkeypatch, caplog):
    small = [small_function()]
    build = partial(kernels.build_library, small, folder=kernels.cache_folder())
    monkeypatch.setattr(kernels, "find_compiler", lambda: None)
    with caplog.at_level(logging.INFO, logger=kernels.__name__):
        functions, form = kernels.prepare(small, build, "auto")
    assert form == "portable"
    assert "portable" in caplog.text
    np.testing.assert_allclose(
        np.asarray(functions[0]([0, 1, 2])).ravel(), 2 * np.sin([0, 1, 2]), rtol=1e-15
    )
    with pytest.raises(RuntimeError, match="install a C compiler"):
        kernels.prepare(small, build, "compiled")
