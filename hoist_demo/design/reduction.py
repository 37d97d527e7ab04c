"""Small first-order models from linear models along a trip.

    X' = A X + B u ,     y = C X + D u .

1. Modal truncation: kept are the modes that make up more than CONTRIBUTION of any channel somewhere in the band, and
   what the others would yield at rest. Ends that are told to move take the rope along without vibration.
2. Balanced truncation of that, by the Gramians of A - alpha I: the hoist as a whole rests where it is put, and sideways
   modes of the rope have hardly any damping. Channels are scaled to equal largest gains. Poles that this puts right of
   the imaginary axis are moved back to the damping ratio LEAST_DAMPING.
3. Correction: C and D are fitted to the sparse model, by least squares of the relative errors on s = alpha + i omega.
   D has what was left out and yields at once.
4. The states of each height are turned to come as close as they can to those of the height before under the same
   input (orthogonal Procrustes), so that matrices may be interpolated.

The error is measured: largest difference from the sparse model at s = alpha + i omega in the band. That is what shows
within some 1/alpha: notches and peaks of sideways modes, narrower than that, are left out of small models.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray
from scipy.io import savemat
from scipy.sparse.linalg import splu

from hoist_demo.design.linearise import Array, LinearModel, Modes

LEAST_DAMPING = 1e-3  #: Of poles that truncation has made unstable.
CONTRIBUTION = 3e-4  #: Of a mode to a channel's gain, below which it is left out.
SLOWEST = 0.02  #: Hz, lower end of the band in which errors are measured.
BEYOND = 5.0  #: Modes up to so many times the band's upper end are looked at.
ALPHA = 2 * np.pi * SLOWEST  #: 1/s.
_FIT = 1e-4  #: Singular values of the fit, over the largest, below which nothing is changed.
_LEAST = 1e-9  #: Of a channel's largest gain: less is no response.


@dataclass(frozen=True)
class ReducedModel:
    """First-order models in one basis; `A` is (heights, states, states), and so are the others by heights.

    `decibels` and `degrees` are the measured errors (heights, outputs, inputs) against the sparse model between SLOWEST
    and `band` Hz at s = ALPHA + i omega, `share` the largest difference over the channel's largest gain there.
    """

    at: tuple[float, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    A: Array
    B: Array
    C: Array
    D: Array
    rest_inputs: Array
    rest_outputs: Array
    band: float
    decibels: Array
    degrees: Array
    share: Array

    def response(self, height: int, s: Iterable[complex]) -> NDArray[np.complex128]:
        """Transfer functions (len(s), outputs, inputs) at a height, by its place in `at`."""
        return _response(self.A[height], self.B[height], self.C[height], self.D[height], np.asarray(list(s)))

    def state_space(self, height: int) -> Any:
        """Return a height's model as control.StateSpace; ImportError without python-control."""
        try:
            import control
        except ImportError as error:
            raise ImportError(
                "StateSpace needs python-control: pip install 'balance-rope[control]', or take A, B, C and D"
            ) from error
        matrices = (part[height] for part in (self.A, self.B, self.C, self.D))
        # a point is for names of systems there
        inputs, outputs = ([name.replace(".", "_") for name in names] for names in (self.inputs, self.outputs))
        return control.StateSpace(*matrices, inputs=inputs, outputs=outputs)

    def scheduled(self) -> Any:
        """CasADi function (part of the travel, X, u) -> X', y, linear between the heights and constant beyond."""
        part, X, u = (
            ca.SX.sym(name, size) for name, size in (("at", 1), ("X", self.A.shape[1]), ("u", self.B.shape[2]))
        )
        at, heights = np.array(self.at), len(self.at)
        inside = ca.fmin(ca.fmax(part, at[0]), at[-1])
        hats = [ca.SX(1.0)] * heights
        for k in range(heights - 1):
            beyond = ca.fmin(ca.fmax((inside - at[k]) / (at[k + 1] - at[k]), 0.0), 1.0)
            hats[k], hats[k + 1] = hats[k] - beyond, beyond
        A, B, C, D = (
            reduce(lambda x, y: x + y, (hat * ca.DM(M) for hat, M in zip(hats, part, strict=True)))
            for part in (self.A, self.B, self.C, self.D)
        )
        values = [A @ X + B @ u, C @ X + D @ u]
        return ca.Function("plant", [part, X, u], values, ["at", "X", "u"], ["X_rate", "y"])

    def write(self, folder: Path) -> tuple[Path, ...]:
        """Write plant.npz, plant.mat and plant.json; they hold the fields of this class by name."""
        data: dict[str, Any] = {name: np.asarray(value) for name, value in vars(self).items()}
        npz, mat, text = (folder / f"plant.{kind}" for kind in ("npz", "mat", "json"))
        np.savez(npz, **data)
        named = {name: np.array(data[name], dtype=object) for name in ("inputs", "outputs")}
        # MATLAB has the heights last
        savemat(mat, {name: np.moveaxis(x, 0, -1) if x.ndim == 3 else x for name, x in data.items()} | named)
        text.write_text(json.dumps({name: x.tolist() for name, x in data.items()}), encoding="utf-8")
        return npz, mat, text


def reduced(models: Sequence[LinearModel], states: int = 20, band: float = 2.0) -> ReducedModel:
    """Return small models of all heights.

    Parameters
    ----------
    models : sequence of LinearModel
        Of `linearise`, in the order of their heights, with the inputs and outputs that count (`selected`).
    states : int
        Number of states.
    band : float
        Upper end [Hz] of the frequencies that count.

    Raises
    ------
    ValueError
        If there are not so many states, or the models do not share their inputs and outputs.
    """
    first = models[0]
    if any((m.inputs, m.outputs) != (first.inputs, first.outputs) for m in models):
        raise ValueError("the models must share inputs and outputs: select the same of each")
    grid = _line(band)
    systems, errors, before = list[_System](), [], None
    for model in models:
        exact = model.response(grid)
        A, B, C, D = _balanced(_modal(model, band, states), states, np.abs(exact).max(axis=0))
        A, B, C, before = _turned(A, B, C, grid, before)
        C, D = _fitted(A, B, C, D, grid[::2], exact[::2])
        systems.append((A, B, C, D))
        errors.append(_errors(_response(A, B, C, D, grid), exact))
    A, B, C, D = (np.array(parts) for parts in zip(*systems, strict=True))
    decibels, degrees, share = (np.array(parts) for parts in zip(*errors, strict=True))
    rest_inputs, rest_outputs = np.array([m.rest_inputs for m in models]), np.array([m.rest_outputs for m in models])
    return ReducedModel(
        tuple(m.at for m in models), first.inputs, first.outputs, A, B, C, D, rest_inputs, rest_outputs, band,
        decibels, degrees, share,
    )  # fmt: skip


_System = tuple[Array, Array, Array, Array]
Complex = NDArray[np.complex128]


def _line(band: float) -> NDArray[np.complex128]:
    """Complex frequencies at which errors are measured [rad/s]."""
    return np.asarray(ALPHA + 2j * np.pi * np.geomspace(SLOWEST, band, 150), dtype=np.complex128)


def _response(A: Array, B: Array, C: Array, D: Array, s: Complex) -> Complex:
    found: Complex = C @ _states(A, B, s) + D
    return found


def _states(A: Array, B: Array, s: Complex) -> Complex:
    """(s - A)^-1 B, (s, states, inputs)."""
    x = np.linalg.solve(s[:, None, None] * np.eye(len(A)) - A, B[None].astype(complex))
    return np.asarray(x, dtype=np.complex128)


def _errors(found: Complex, exact: Complex) -> tuple[Array, Array, Array]:
    """Largest errors [dB], [degrees] and over the largest gain, (outputs, inputs); 0 where there is no response."""
    largest = np.abs(exact).max(axis=0)
    some = np.abs(exact) > _LEAST * largest
    ratio = np.where(some, found, 1.0) / np.where(some, exact, 1.0)
    share = np.abs(found - exact).max(axis=0) / np.where(largest > 0.0, largest, 1.0)
    decibels = np.abs(20 * np.log10(np.maximum(np.abs(ratio), 1e-300)))
    return decibels.max(axis=0), np.abs(np.angle(ratio, deg=True)).max(axis=0), share


def _modal(model: LinearModel, band: float, least: int) -> _System:
    """First-order model of the modes that matter, at least so many, what follows held ends, and what lags."""
    n, total = model.free, len(model.names)
    found = model.modes(BEYOND * band)
    share = telling(model, found, band)
    modes = found.shapes[:, np.argsort(-share)[: max(least, np.count_nonzero(share > CONTRIBUTION))]]
    told = [k for k in range(n, n + model.held) if model.B[k].any()]
    stiff = (model.stiffness[:n, :n] + ALPHA**2 * model.mass[:n, :n]).tocsc()
    others = np.eye(total)[:, [*told, *range(n + model.held, total)]]
    # what forces bend beyond these modes
    still = splu(stiff).solve(_pushes(model, np.array([ALPHA + 0j]))[0].real)
    still -= modes @ (modes.T @ (model.mass[:n, :n] @ still))
    modes = np.hstack((modes, sl.orth(still / np.maximum(np.linalg.norm(still, axis=0), 1e-300))))
    W = np.hstack((np.vstack((modes, np.zeros((total - n, modes.shape[1])))), others))
    V = W.copy()
    if told:
        V[:n, modes.shape[1] : modes.shape[1] + len(told)] = -splu(stiff).solve(model.stiffness[:n, told].toarray())
    return _first_order(model, V, W)


def telling(model: LinearModel, modes: Modes, band: float) -> Array:
    """Largest part (modes,) that each mode makes up of any channel on s = alpha + i omega in the band."""
    n, s = model.free, _line(band)[:, None]
    omega = 2 * np.pi * modes.frequencies
    # inputs by way of what lags, or by held ends, act on the modes, too
    b = modes.shapes.T @ _pushes(model, s[:, 0])
    b = b / (s**2 + 2 * s * modes.damping * omega + omega**2)[:, :, None]
    c = [np.asarray(A[:, :n] @ modes.shapes) for A in model.maps]
    share = np.zeros(omega.size)
    for i, k in np.ndindex(model.through.shape):
        parts = b[:, :, k] * (c[0][i] + s * c[1][i] + s**2 * c[2][i])
        whole = np.abs(parts.sum(axis=1, keepdims=True))
        share = np.maximum(share, (np.abs(parts) / np.maximum(whole, _LEAST * whole.max() + 1e-300)).max(axis=0))
    return share


def _pushes(model: LinearModel, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Forces (s, free, inputs) on the free coordinates."""
    n = model.free
    others = slice(n, len(model.names))
    M, D, K = (A[:n, others].toarray() for A in (model.mass, model.damping, model.stiffness))
    M_o, D_o, K_o = (A[others, others].toarray() for A in (model.mass, model.damping, model.stiffness))
    found = []
    for z in s:
        moved = np.linalg.solve(z * z * M_o + z * D_o + K_o, model.B[others])
        found.append(model.B[:n] - (z * z * M + z * D + K) @ moved)
    return np.array(found)


def _first_order(model: LinearModel, V: Array, W: Array) -> _System:
    """Return the projected model with the states coordinates, rates, lags."""
    M, D, K = (W.T @ (A @ V) for A in (model.mass, model.damping, model.stiffness))
    B, (C, C_v, C_a) = W.T @ model.B, (np.asarray(A @ V) for A in model.maps)
    m = V.shape[1] - model.lags
    inverse = np.linalg.inv(M[:m, :m])
    a = -inverse @ np.hstack((K[:m, :m], D[:m, :m], K[:m, m:]))
    late = -np.hstack((K[m:, :m], D[m:, :m], K[m:, m:]))
    rate = np.hstack((np.zeros((m, m)), np.eye(m), np.zeros((m, model.lags))))
    pushed = inverse @ B[:m]
    A = np.vstack((rate, a, late))
    out = np.hstack((C[:, :m], C_v[:, :m], C[:, m:])) + C_a[:, :m] @ a
    return A, np.vstack((np.zeros_like(pushed), pushed, B[m:])), out, model.through + C_a[:, :m] @ pushed


def _balanced(system: _System, states: int, gains: Array) -> _System:
    """Return the system with fewer states; ``gains`` (outputs, inputs) scale the channels."""
    A, B, C, D = system
    if not 1 <= states <= len(A):
        raise ValueError(f"states = {states} must be within 1 and {len(A)}, those of its modes: take fewer")
    of_outputs = 1.0 / np.where(gains.max(axis=1) > 0.0, gains.max(axis=1), 1.0)
    of_inputs = 1.0 / np.maximum((of_outputs[:, None] * gains).max(axis=0), 1e-300)
    bound = float(np.linalg.eigvals(A).real.max())
    shifted, B_s, C_s = A - max(ALPHA, 2.0 * bound) * np.eye(len(A)), B * of_inputs, of_outputs[:, None] * C
    X = _root(sl.solve_continuous_lyapunov(shifted, -B_s @ B_s.T))
    Z = _root(sl.solve_continuous_lyapunov(shifted.T, -C_s.T @ C_s))
    U, sigma, Vt = np.linalg.svd(Z.T @ X)
    scale = 1.0 / np.sqrt(sigma[:states])
    V, W = X @ Vt[:states].T * scale, Z @ U[:, :states] * scale
    return _stable(W.T @ A @ V, bound), W.T @ B, C @ V, D


def _fitted(A: Array, B: Array, C: Array, D: Array, s: Complex, exact: Complex) -> tuple[Array, Array]:
    """Return C and D changed as little as the fit to samples needs, channels without response as they are."""
    x = _states(A, B, s)
    known = np.concatenate((x, np.broadcast_to(np.eye(B.shape[1]), (len(s), *[B.shape[1]] * 2))), axis=1)
    missing, found = exact - (C @ x + D), np.hstack((C, D))
    for i, row in enumerate(missing.swapaxes(0, 1)):
        size = np.abs(exact[:, i])
        weight = np.where(size > _LEAST * size.max(axis=0), 1.0 / np.maximum(size, 1e-300), 0.0)
        left, right = np.moveaxis(known * weight[:, None, :], 1, 2).reshape(-1, known.shape[1]), (row * weight).ravel()
        unit = np.maximum(np.linalg.norm(left, axis=0), 1e-300)
        both = np.vstack((left.real, left.imag)) / unit
        found[i] += np.linalg.lstsq(both, np.concatenate((right.real, right.imag)), rcond=_FIT)[0] / unit
    return found[:, : len(A)], found[:, len(A) :]


def _root(X: Array) -> Array:
    """L with X = L L^T, of a matrix that is positive but for rounding."""
    values, vectors = sl.eigh(0.5 * (X + X.T))
    root: Array = vectors * np.sqrt(np.maximum(values, 0.0))
    return root


def _stable(A: Array, bound: float) -> Array:
    """Return A with the poles moved whose real parts are above 0 and the bound."""
    poles, shapes = np.linalg.eig(A)
    unstable = poles.real > max(bound, 0.0)
    if not unstable.any():
        return A
    moved = np.where(unstable, -LEAST_DAMPING * np.abs(poles), poles.real) + 1j * poles.imag
    made: Array = (shapes @ np.diag(moved) @ np.linalg.inv(shapes)).real
    return made


def _turned(A: Array, B: Array, C: Array, s: Complex, before: Array | None) -> tuple[Array, Array, Array, Array]:
    """Return the system in states close to the samples of the height before, and its own samples."""
    x = _states(A, B, s)
    flat = np.moveaxis(x, 1, 0).reshape(len(A), -1)
    samples = np.hstack((flat.real, flat.imag))
    if before is not None:
        U, _, Vt = np.linalg.svd(samples @ before.T)
        T = U @ Vt
        A, B, C, samples = T.T @ A @ T, T.T @ B, C @ T, T.T @ samples
    return A, B, C, samples
