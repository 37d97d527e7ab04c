"""Small first-order models from linear models along a trip.

    X' = A X + B u ,     y = C X + D u .

1. Of one height, modal truncation: kept are the modes that make up most of any channel somewhere in the band. Of
   several heights a rational Krylov basis W: angle and heights of the hoist, which the rest follows slowly, and the
   responses (s^2 M + s D + K)^-1 M W at a few complex s. It chooses no modes: each height has the same motions, made
   orthonormal by W (W^T M W)^(-1/2), the smallest change. Matrices are then smooth between heights, also where modes of
   hoist and rope meet. Either model is stable as the sparse one is, and has what the drive feels; the loop moves in
   too many modes. Ends that are told to move take the rope along without vibration.
2. Static correction: C and D are fitted to the sparse model, by least squares of the relative errors on
   s = alpha + i omega. They have what was left out and yields at once.

Cubic splines interpolate between heights. Heights are best dense at the ends of the trip, where head ropes are short.
Sources: A. Ruhe, Lin. Alg. Appl. 58, 1984; H. Panzer et al., Parametric model order reduction by matrix interpolation,
at-Automatisierungstechnik 58, 2010.

The error is measured: largest difference from the sparse model at s = alpha + i omega in the band. That is what shows
within some 1/alpha: notches and peaks of sideways modes, narrower than that, are left out of small models.
"""

import json
import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.io import savemat
from scipy.sparse.linalg import splu

from hoist_demo.design.linear_model import Array, LinearModel, Modes
from rope_model.files import whole_file, write_text

SLOWEST = 0.02  #: Hz, lower end of the band in which errors are measured.
BEYOND = 5.0  #: Modes up to so many times the band's upper end are looked at.
ALPHA = 2 * np.pi * SLOWEST  #: 1/s.
#: Error of a channel's gain up to which a small model stands for the sparse one: 6 %.
MAX_DECIBELS = 0.5
MAX_DEGREES = 5.0  #: Error of a channel's phase likewise.
#: States beside those of lags and moved ends from which a sufficient number is looked for.
MIN_STATES = 8
MAX_STATES = 41  #: States up to which it is looked for.
_log = logging.getLogger(__name__)
_FIT = 1e-2  #: Price of a change of C and D by the fit, over that of an error.
_SHIFT = 0.3  #: Re s / 2 pi of the basis [Hz].
_FIRST_SHIFT = 0.5  #: Im s of the first shift, over the band.
_SHIFT_STEP = 0.447  #: Im s from one shift to the next, over the band.
_SHIFT_WRAP = 1.2  #: Im s at which the shifts begin again, over the band.
#: Least kinetic energy of a motion that is new to a basis, over all that are new.
_RANK_TOLERANCE = 1e-3
#: Least kinetic energy of the new motions, over that of what they come from.
_RELATIVE_RANK_TOLERANCE = 1e-12
_NEGLIGIBLE = 1e-9  #: Of a channel's largest gain: less is no response.


class NoSmallModel(ValueError):
    """Linear model of which no small model has errors within the bounds."""


class UnfitStates(NoSmallModel):
    """Number of states that no small model of a linear model has."""


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

    @property
    def excess(self) -> str | None:
        """Return the channel whose error is farthest above the bounds, as a sentence; None if all are within."""
        excess = np.maximum(self.decibels / MAX_DECIBELS, self.degrees / MAX_DEGREES)
        if float(excess.max(initial=0.0)) <= 1.0:
            return None
        height, i, k = np.unravel_index(int(np.argmax(excess)), excess.shape)
        return (
            f"at = {self.at[height]:.3g}: a model of {self.A.shape[1]} states errs by "
            f"{self.decibels[height, i, k]:.2g} dB and {self.degrees[height, i, k]:.2g} degrees from "
            f"{self.inputs[k]} to {self.outputs[i]}, up to {self.band:g} Hz; at most {MAX_DECIBELS:g} dB and "
            f"{MAX_DEGREES:g} degrees are usable"
        )

    def response(self, height: int, s: Iterable[complex]) -> NDArray[np.complex128]:
        """Transfer functions (len(s), outputs, inputs) at a height, by its place in `at`."""
        return _response(
            self.A[height], self.B[height], self.C[height], self.D[height], np.asarray(list(s))
        )

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
        inputs, outputs = (
            [name.replace(".", "_") for name in names] for names in (self.inputs, self.outputs)
        )
        return control.StateSpace(*matrices, inputs=inputs, outputs=outputs)

    def scheduled(self) -> Any:
        """CasADi function (part of the travel, X, u) -> X', y, of cubic splines between heights, constant beyond."""
        part, X, u = (
            ca.MX.sym(x, size)
            for x, size in (("at", 1), ("X", self.A.shape[1]), ("u", self.B.shape[2]))
        )
        at = self.at
        options = {"degree": [min(3, len(self.at) - 1)]}
        inside = ca.fmin(ca.fmax(part, at[0]), at[-1])

        def between(values: Array) -> Any:
            if len(at) == 1:
                return ca.DM(values[0])
            # CasADi has columns first
            flat = values.transpose(0, 2, 1).ravel()
            return ca.reshape(
                ca.interpolant("part", "bspline", [at], flat, options)(inside), *values.shape[1:]
            )

        A, B, C, D = (between(values) for values in (self.A, self.B, self.C, self.D))
        interpolated_A = ca.Function("A", [part], [A])
        largest_rate = max(0.0, np.linalg.eigvals(self.A).real.max())
        for x in np.interp(np.arange(0, len(at) - 0.9, 0.25), range(len(at)), at):
            if (
                rate := np.linalg.eigvals(interpolated_A(x).full()).real.max()
            ) > largest_rate + ALPHA:
                raise ValueError(
                    f"the model at = {x:.3g}, between heights, grows by {rate:.3g} 1/s and must by no more than "
                    f"{largest_rate + ALPHA:.3g}: take more heights, denser at the ends, or fewer states"
                )
        values = [A @ X + B @ u, C @ X + D @ u]
        return ca.Function("plant", [part, X, u], values, ["at", "X", "u"], ["X_rate", "y"])

    def write(self, folder: Path) -> tuple[Path, ...]:
        """Write plant.npz, plant.mat and plant.json; they hold the fields of this class by name."""
        data: dict[str, Any] = {name: np.asarray(value) for name, value in vars(self).items()}
        npz, mat, text = (folder / f"plant.{kind}" for kind in ("npz", "mat", "json"))
        with whole_file(npz) as draft:
            np.savez(draft, **data)
        names = {name: np.array(data[name], dtype=object) for name in ("inputs", "outputs")}
        # MATLAB has the heights last
        with whole_file(mat) as draft:
            savemat(
                draft,
                {name: np.moveaxis(x, 0, -1) if x.ndim == 3 else x for name, x in data.items()}
                | names,
            )
        write_text(text, json.dumps({name: x.tolist() for name, x in data.items()}))
        return npz, mat, text


def reduced(
    models: Sequence[LinearModel], states: int | None = None, band: float = 2.0
) -> ReducedModel:
    """Return small models of all heights.

    Parameters
    ----------
    models : sequence of LinearModel
        Of `linearise`, in the order of their heights, with the inputs and outputs that count (`selected`).
    states : int, optional
        Largest number of states, or one more: a mode takes two, a lag one, an end that is moved two. Left out: the
        fewest with which every channel errs by at most MAX_DECIBELS and MAX_DEGREES at every height.
    band : float
        Upper end [Hz] of the frequencies that count.

    Raises
    ------
    ValueError
        If there are not so many states, or the models do not share their inputs and outputs; without `states`, if
        MAX_STATES leave a larger error.
    """
    first = models[0]
    if any((m.inputs, m.outputs) != (first.inputs, first.outputs) for m in models):
        raise ValueError("the models must share inputs and outputs: select the same of each")
    reduction = _Reduction(models, band)
    if states is None:
        return reduction.smallest()
    small = reduction.of(states)
    excess = small.excess
    if excess is not None:
        _log.warning("%s: take more states", excess)
    return small


class _Reduction:
    """Models of several heights and what all their small models are made of and measured by."""

    def __init__(self, models: Sequence[LinearModel], band: float) -> None:
        self._models = models
        self._band = band
        self._grid = _line(band)
        self._exact = [model.response(self._grid) for model in models]

    def smallest(self) -> ReducedModel:
        """Return the model of the fewest states whose error is within the bounds; ValueError without one."""
        first = self._models[0]
        others = first.lags + 2 * len(driven_coordinates(first))
        small = None
        for states in range(others + MIN_STATES, MAX_STATES + 1, 2):
            try:
                small = self.of(states)
            except UnfitStates:
                if small is None:
                    raise
                break
            if small.excess is None:
                return small
        if small is None:
            raise NoSmallModel(
                f"inputs that take {others} states must take fewer than {MAX_STATES}: select fewer"
            )
        raise NoSmallModel(
            f"{small.excess}: state the number of states to take such a model, or select other channels"
        )

    def of(self, states: int) -> ReducedModel:
        """Return the models of so many states, with their errors."""
        first = self._models[0]
        band = self._band
        grid = self._grid
        systems: list[_System] = []
        errors = []
        for model, basis, exact in zip(self._models, self._bases(states), self._exact, strict=True):
            A, B, C, D = _projected(model, basis)
            C, D = _fitted(A, B, C, D, grid[::2], exact[::2])
            systems.append((A, B, C, D))
            errors.append(_errors(_response(A, B, C, D, grid), exact))
        A, B, C, D = (np.array(parts) for parts in zip(*systems, strict=True))
        decibels, degrees, share = (np.array(parts) for parts in zip(*errors, strict=True))
        rest_inputs = np.array([m.rest_inputs for m in self._models])
        rest_outputs = np.array([m.rest_outputs for m in self._models])
        return ReducedModel(
            tuple(m.at for m in self._models),
            first.inputs,
            first.outputs,
            A,
            B,
            C,
            D,
            rest_inputs,
            rest_outputs,
            band,
            decibels,
            degrees,
            share,
        )

    def _bases(self, states: int) -> list[Array]:
        """Return motions (free, count) of each height, orthonormal by M, with the same meaning at all heights."""
        first = self._models[0]
        driven = len(driven_coordinates(first))
        count = (states - first.lags) // 2 - driven
        other_states = first.lags + 2 * driven
        if len(self._models) > 1:
            return _krylov_bases(self._models, self._band, states, count, other_states)
        shapes = self._shapes
        _require_states(states, count, 1, shapes.shape[1], other_states)
        return [shapes[:, :count]]

    @cached_property
    def _shapes(self) -> Array:
        """Shapes (free, modes) of the only height, the most telling mode first."""
        (model,) = self._models
        modes = model.modes(BEYOND * self._band)
        return modes.shapes[:, np.argsort(-modal_participation(model, modes, self._band))]


_System = tuple[Array, Array, Array, Array]
Complex = NDArray[np.complex128]


def _line(band: float) -> NDArray[np.complex128]:
    """Return the complex frequencies at which errors are measured [rad/s]."""
    # a response on this line has no detail finer than alpha
    return np.asarray(
        ALPHA + 2j * np.pi * np.arange(SLOWEST, band, SLOWEST / 2), dtype=np.complex128
    )


def _response(A: Array, B: Array, C: Array, D: Array, s: Complex) -> Complex:
    return np.asarray(C @ _states(A, B, s) + D)


def _states(A: Array, B: Array, s: Complex) -> Complex:
    """(s - A)^-1 B, (s, states, inputs)."""
    x = np.linalg.solve(s[:, None, None] * np.eye(len(A)) - A, B[None].astype(complex))
    return np.asarray(x, dtype=np.complex128)


def _errors(response: Complex, exact: Complex) -> tuple[Array, Array, Array]:
    """Largest errors [dB], [degrees] and over the largest gain, (outputs, inputs); 0 where there is no response."""
    largest = np.abs(exact).max(axis=0)
    some = np.abs(exact) > _NEGLIGIBLE * largest
    ratio = np.where(some, response, 1.0) / np.where(some, exact, 1.0)
    share = np.abs(response - exact).max(axis=0) / np.where(largest > 0.0, largest, 1.0)
    decibels = np.abs(20 * np.log10(np.maximum(np.abs(ratio), 1e-300)))
    return decibels.max(axis=0), np.abs(np.angle(ratio, deg=True)).max(axis=0), share


def driven_coordinates(model: LinearModel) -> list[int]:
    """Return the held coordinates that an input moves."""
    return [k for k in range(model.free, model.free + model.held) if model.B[k].any()]


def _require_states(states: int, count: int, minimum: int, maximum: int, other_states: int) -> None:
    if not minimum <= count <= maximum:
        low = 2 * minimum + other_states
        high = 2 * maximum + other_states + 1  # an odd one is left over
        raise UnfitStates(f"states = {states} must be within {low} and {high}: take as many")


def _krylov_bases(
    models: Sequence[LinearModel], band: float, states: int, count: int, other_states: int
) -> list[Array]:
    """Return bases of the hoist's motions and of responses to the inputs and to these.

    ``other_states`` are those of inputs.
    """
    n = models[0].free
    hoist_coordinates = [
        k for k, name in enumerate(models[0].names[:3]) if not name.startswith("rope.")
    ]
    minimum = max(len(hoist_coordinates), 1)
    _require_states(states, count, minimum, n - 3 + minimum, other_states)
    masses = [0.5 * (m.mass + m.mass.T)[:n, :n] for m in models]
    bases = [
        _orthonormal(_quasi_static_motions(m, hoist_coordinates), M)
        for m, M in zip(models, masses, strict=True)
    ]
    pushes = [
        np.hstack((M @ W, m.stiffness[:n, driven_coordinates(m)].toarray()))
        for m, M, W in zip(models, masses, bases, strict=True)
    ]
    for k in range(count):
        if not (missing := count - bases[0].shape[1]):
            break
        s = 2 * np.pi * complex(_SHIFT, band * ((_FIRST_SHIFT + k * _SHIFT_STEP) % _SHIFT_WRAP))
        directions = [
            _krylov_directions(*of, s) for of in zip(models, masses, bases, pushes, strict=True)
        ]
        T = _common_directions(
            [x.T @ (M @ x) for x, M in zip(directions, masses, strict=True)], missing
        )
        if not T.size:
            maximum = 2 * bases[0].shape[1] + other_states + 1
            raise UnfitStates(
                f"states = {states} must be at most {maximum}, for the inputs move no more: "
                "take fewer"
            )
        bases = [
            np.hstack((W, _orthonormal(x @ T, M)))
            for W, x, M in zip(bases, directions, masses, strict=True)
        ]
    return bases


def _quasi_static_motions(model: LinearModel, hoist_coordinates: Sequence[int]) -> Array:
    """Slow motions (free, coordinates) of the hoist's ``hoist_coordinates``, which the rest follows."""
    n = model.free
    rest = np.setdiff1d(np.arange(n), hoist_coordinates)
    K = (model.stiffness[:n, :n] + (2 * np.pi * _SHIFT) ** 2 * model.mass[:n, :n]).tocsc()
    W = np.eye(n)[:, hoist_coordinates]
    W[rest] = -splu(K[rest][:, rest].tocsc()).solve(K[rest][:, hoist_coordinates].toarray())
    return W


def _krylov_directions(
    model: LinearModel, M: sp.csc_matrix, W: Array, push: Array, s: complex
) -> Array:
    """Return motions at ``s`` under the ``push``, real and imaginary parts, less their parts in the basis ``W``."""
    n = model.free
    z = splu((s * s * model.mass + s * model.damping + model.stiffness)[:n, :n].tocsc()).solve(
        push.astype(complex)
    )
    x = np.hstack((z.real, z.imag))
    x = x / np.sqrt(np.maximum(np.einsum("ij,ij->j", x, M @ x), 1e-300))
    for _ in range(2):  # once is not enough for rounding
        x = x - W @ (W.T @ (M @ x))
    return np.asarray(x)


def _common_directions(energies: Sequence[Array], maximum: int) -> Array:
    """Return combinations (directions, up to ``maximum``) of directions with these kinetic energies.

    They are new at every height.
    """
    if min(np.trace(energy) for energy in energies) < _RELATIVE_RANK_TOLERANCE:
        return np.empty((len(energies[0]), 0))
    shares = [energy / np.trace(energy) for energy in energies]
    T = np.linalg.eigh(sum(shares))[1][:, ::-1][:, :maximum]
    while (
        T.shape[1] > 1
        and min(np.linalg.eigvalsh(T.T @ share @ T)[0] for share in shares) < _RANK_TOLERANCE
    ):
        T = T[:, :-1]
    return T


def _orthonormal(W: Array, M: sp.csc_matrix) -> Array:
    """Return W (W^T M W)^(-1/2), the orthonormal basis nearest to W."""
    squares, axes = np.linalg.eigh(W.T @ (M @ W))
    return np.asarray(W @ (axes / np.sqrt(squares)) @ axes.T)


def _projected(model: LinearModel, basis: Array) -> _System:
    """First-order model of the motions, what follows held ends, and what lags."""
    n = model.free
    total = len(model.names)
    count = basis.shape[1]
    driven = driven_coordinates(model)
    others = np.eye(total)[:, [*driven, *range(n + model.held, total)]]
    W = np.hstack((np.vstack((basis, np.zeros((total - n, count)))), others))
    V = W.copy()
    if driven:
        stiff = (model.stiffness[:n, :n] + ALPHA**2 * model.mass[:n, :n]).tocsc()
        V[:n, count : count + len(driven)] = -splu(stiff).solve(
            model.stiffness[:n, driven].toarray()
        )
    return _first_order(model, V, W)


def modal_participation(model: LinearModel, modes: Modes, band: float) -> Array:
    """Return the largest share (modes,) of each mode in any channel on s = alpha + i omega in the band."""
    s = _line(band)[:, None]
    omega = 2 * np.pi * modes.frequencies
    # inputs by way of what lags, or by held ends, act on the modes, too
    pushes = _pushes(model, s[:, 0])
    # one product of matrices: one for each frequency reads all shapes each time
    b = modes.shapes.T @ np.hstack([part for one in pushes for part in (one.real, one.imag)])
    b = b.reshape(omega.size, len(pushes), 2, -1).transpose(1, 2, 0, 3)
    b = b[:, 0] + 1j * b[:, 1]
    b = b / (s**2 + 2 * s * modes.damping * omega + omega**2)[:, :, None]
    c = [np.asarray(A[:, : model.free] @ modes.shapes) for A in model.maps]
    share = np.zeros(omega.size)
    for i, k in np.ndindex(model.through.shape):
        parts = b[:, :, k] * (c[0][i] + s * c[1][i] + s**2 * c[2][i])
        whole = np.abs(parts.sum(axis=1, keepdims=True))
        share = np.maximum(
            share,
            (np.abs(parts) / np.maximum(whole, _NEGLIGIBLE * whole.max() + 1e-300)).max(axis=0),
        )
    return share


def _pushes(model: LinearModel, s: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Forces (s, free, inputs) on the free coordinates."""
    n = model.free
    others = slice(n, len(model.names))
    M, D, K = (A[:n, others].toarray() for A in (model.mass, model.damping, model.stiffness))
    M_o, D_o, K_o = (
        A[others, others].toarray() for A in (model.mass, model.damping, model.stiffness)
    )
    forces = []
    for z in s:
        moved = np.linalg.solve(z * z * M_o + z * D_o + K_o, model.B[others])
        forces.append(model.B[:n] - (z * z * M + z * D + K) @ moved)
    return np.array(forces)


def _first_order(model: LinearModel, V: Array, W: Array) -> _System:
    """Return the projected model with the states coordinates, rates, lags."""
    M, D, K = (W.T @ (A @ V) for A in (model.mass, model.damping, model.stiffness))
    B = W.T @ model.B
    C, C_v, C_a = (np.asarray(A @ V) for A in model.maps)
    m = V.shape[1] - model.lags
    inverse = np.linalg.inv(M[:m, :m])
    a = -inverse @ np.hstack((K[:m, :m], D[:m, :m], K[:m, m:]))
    late = -np.hstack((K[m:, :m], D[m:, :m], K[m:, m:]))
    rate = np.hstack((np.zeros((m, m)), np.eye(m), np.zeros((m, model.lags))))
    pushed = inverse @ B[:m]
    A = np.vstack((rate, a, late))
    out = np.hstack((C[:, :m], C_v[:, :m], C[:, m:])) + C_a[:, :m] @ a
    return (
        A,
        np.vstack((np.zeros_like(pushed), pushed, B[m:])),
        out,
        model.through + C_a[:, :m] @ pushed,
    )


def _fitted(
    A: Array, B: Array, C: Array, D: Array, s: Complex, exact: Complex
) -> tuple[Array, Array]:
    """Return C and D changed as little as the fit to samples needs, channels without response as they are."""
    x = _states(A, B, s)
    regressors = np.concatenate(
        (x, np.broadcast_to(np.eye(B.shape[1]), (len(s), *[B.shape[1]] * 2))), axis=1
    )
    missing = exact - (C @ x + D)
    coefficients = np.hstack((C, D))
    for i, row in enumerate(missing.swapaxes(0, 1)):
        size = np.abs(exact[:, i])
        weight = np.where(
            size > _NEGLIGIBLE * size.max(axis=0), 1.0 / np.maximum(size, 1e-300), 0.0
        )
        left = np.moveaxis(regressors * weight[:, None, :], 1, 2).reshape(-1, regressors.shape[1])
        right = (row * weight).ravel()
        unit = np.linalg.norm(left, axis=0)
        unit[unit == 0.0] = 1.0  # a lag that no input moves
        both = np.vstack((left.real / unit, left.imag / unit, _FIT * np.eye(unit.size)))
        right_hand_side = np.concatenate((right.real, right.imag, np.zeros(unit.size)))
        coefficients[i] += np.linalg.lstsq(both, right_hand_side, rcond=None)[0] / unit
    return coefficients[:, : len(A)], coefficients[:, len(A) :]
