"""Small first-order models from linear models along a trip.

    X' = A X + B u ,     y = C X + D u .

1. Motions. Of one height, modal truncation: kept are the modes that make up most of any channel
   somewhere in the band. Of several heights the basis of ``krylov_basis``, which chooses no modes:
   matrices are smooth between heights, also where modes of hoist and rope meet. Either model is
   stable as the sparse one is, and has what the drive feels; the loop moves in too many modes. Ends
   that are told to move take the rope along without vibration.
2. Static correction: C and D are fitted to the sparse model, by least squares of the relative errors
   on s = alpha + i omega. They have what was left out and yields at once.

``reduced_model`` interpolates between heights. Heights are best dense at the ends of the trip,
where head ropes are short.

The error is measured: largest difference from the sparse model at s = alpha + i omega in the band. That is what shows
within some 1/alpha: notches and peaks of sideways modes, narrower than that, are left out of small models.
"""

import logging
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import splu

from hoist_demo.design.krylov_basis import NoSmallModel, StateCount, UnfitStates, krylov_bases
from hoist_demo.design.linear_model import LinearModel, UndampedModes
from hoist_demo.design.reduced_model import ALPHA, SLOWEST, Complex, ReducedModel, StateSpace
from rope_model.arrays import Array

#: Modes up to so many times the band's upper end are looked at.
BEYOND = 5.0
#: States beside those of lags and moved ends from which a sufficient number is looked for.
MIN_STATES = 8
MAX_STATES = 41  #: States up to which it is looked for.
_log = logging.getLogger(__name__)
_FIT = 1e-2  #: Price of a change of C and D by the fit, over that of an error.
_NEGLIGIBLE = 1e-9  #: Of a channel's largest gain: less is no response.
_SMALLEST_DIVISOR = 1e-300


def reduced(
    models: Sequence[LinearModel], states: int | None = None, band: float = 2.0
) -> ReducedModel:
    """Return small models of all heights.

    Parameters
    ----------
    models : sequence of LinearModel
        Of ``linearise``, in the order of their heights, with the inputs and outputs that count
        (``selected``).
    states : int, optional
        Largest number of states, or one more: a mode takes two, a lag one, an end that is moved two. Left out: the
        fewest with which every channel errs by at most MAX_DECIBELS and MAX_DEGREES at every height.
    band : float
        Upper end [Hz] of the frequencies that count.

    Raises
    ------
    ValueError
        If there are not so many states, or the models do not share their inputs and outputs;
        without ``states``, if MAX_STATES leave a larger error.
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
        others = self._other_states
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
        systems: list[StateSpace] = []
        errors: list[_Errors] = []
        for model, basis, exact in zip(self._models, self._bases(states), self._exact, strict=True):
            system = _fitted(_projected(model, basis), self._grid[::2], exact[::2])
            systems.append(system)
            errors.append(_errors(system.response(self._grid), exact))
        first = self._models[0]
        return ReducedModel(
            at=tuple(model.at for model in self._models),
            inputs=first.inputs,
            outputs=first.outputs,
            A=np.array([system.A for system in systems]),
            B=np.array([system.B for system in systems]),
            C=np.array([system.C for system in systems]),
            D=np.array([system.D for system in systems]),
            rest_inputs=np.array([model.rest_inputs for model in self._models]),
            rest_outputs=np.array([model.rest_outputs for model in self._models]),
            band=self._band,
            decibels=np.array([error.decibels for error in errors]),
            degrees=np.array([error.degrees for error in errors]),
            share=np.array([error.share for error in errors]),
        )

    @property
    def _other_states(self) -> int:
        """Number of states that do not vibrate."""
        first = self._models[0]
        return first.lags + 2 * len(first.driven)

    def _bases(self, states: int) -> list[Array]:
        """Return motions (free, count) of each height, orthonormal by M, with the same meaning at all heights."""
        count = StateCount(states, self._other_states)
        if len(self._models) > 1:
            return krylov_bases(self._models, self._band, count)
        shapes = self._shapes
        count.require_motions(1, shapes.shape[1])
        return [shapes[:, : count.motions]]

    @cached_property
    def _shapes(self) -> Array:
        """Shapes (free, modes) of the only height, the most telling mode first."""
        (model,) = self._models
        modes = model.modes(BEYOND * self._band)
        return modes.shapes[:, np.argsort(-modal_participation(model, modes, self._band))]


def _line(band: float) -> Complex:
    """Return the complex frequencies at which errors are measured [rad/s]."""
    # a response on this line has no detail finer than alpha
    return np.asarray(
        ALPHA + 2j * np.pi * np.arange(SLOWEST, band, SLOWEST / 2), dtype=np.complex128
    )


class _Errors(NamedTuple):
    """Largest errors of each channel (outputs, inputs) on the line; 0 where there is no response."""

    decibels: Array
    degrees: Array
    share: Array  # over the channel's largest gain


def _errors(response: Complex, exact: Complex) -> _Errors:
    """Return the errors of the ``response`` of a small model."""
    largest = np.abs(exact).max(axis=0)
    some = np.abs(exact) > _NEGLIGIBLE * largest
    ratio = np.where(some, response, 1.0) / np.where(some, exact, 1.0)
    decibels = np.abs(20 * np.log10(np.maximum(np.abs(ratio), _SMALLEST_DIVISOR)))
    degrees = np.abs(np.angle(ratio, deg=True))
    share = np.abs(response - exact).max(axis=0) / np.where(largest > 0.0, largest, 1.0)
    return _Errors(decibels.max(axis=0), degrees.max(axis=0), share)


def _projected(model: LinearModel, basis: Array) -> StateSpace:
    """First-order model of the motions, what follows held ends, and what lags."""
    n = model.free
    total = len(model.names)
    count = basis.shape[1]
    driven = model.driven
    others = np.eye(total)[:, [*driven, *range(n + model.held, total)]]
    W = np.hstack((np.vstack((basis, np.zeros((total - n, count)))), others))
    V = W.copy()
    if driven:
        stiff = (model.stiffness[:n, :n] + ALPHA**2 * model.mass[:n, :n]).tocsc()
        V[:n, count : count + len(driven)] = -splu(stiff).solve(
            model.stiffness[:n, driven].toarray()
        )
    return _first_order(model, V, W)


def modal_participation(model: LinearModel, modes: UndampedModes, band: float) -> Array:
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
            (np.abs(parts) / np.maximum(whole, _NEGLIGIBLE * whole.max() + _SMALLEST_DIVISOR)).max(
                axis=0
            ),
        )
    return share


def _pushes(model: LinearModel, s: Complex) -> Complex:
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


def _first_order(model: LinearModel, V: Array, W: Array) -> StateSpace:
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
    return StateSpace(
        A=np.vstack((rate, a, late)),
        B=np.vstack((np.zeros_like(pushed), pushed, B[m:])),
        C=np.hstack((C[:, :m], C_v[:, :m], C[:, m:])) + C_a[:, :m] @ a,
        D=model.through + C_a[:, :m] @ pushed,
    )


def _fitted(system: StateSpace, s: Complex, exact: Complex) -> StateSpace:
    """Return the system with C and D changed as little as the fit to samples needs.

    Channels without response keep theirs.
    """
    x = system.states(s)
    inputs = system.B.shape[1]
    regressors = np.concatenate(
        (x, np.broadcast_to(np.eye(inputs), (len(s), inputs, inputs))), axis=1
    )
    missing = exact - (system.C @ x + system.D)
    coefficients = np.hstack((system.C, system.D))
    for i, row in enumerate(missing.swapaxes(0, 1)):
        size = np.abs(exact[:, i])
        weight = np.where(
            size > _NEGLIGIBLE * size.max(axis=0), 1.0 / np.maximum(size, _SMALLEST_DIVISOR), 0.0
        )
        left = np.moveaxis(regressors * weight[:, None, :], 1, 2).reshape(-1, regressors.shape[1])
        right = (row * weight).ravel()
        unit = np.linalg.norm(left, axis=0)
        unit[unit == 0.0] = 1.0  # a lag that no input moves
        both = np.vstack((left.real / unit, left.imag / unit, _FIT * np.eye(unit.size)))
        right_hand_side = np.concatenate((right.real, right.imag, np.zeros(unit.size)))
        coefficients[i] += np.linalg.lstsq(both, right_hand_side, rcond=None)[0] / unit
    states = len(system.A)
    return system._replace(C=coefficients[:, :states], D=coefficients[:, states:])
