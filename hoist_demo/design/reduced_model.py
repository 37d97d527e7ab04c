"""A small first-order model of a hoist at several heights: its response, its use in tools, its files.

    X' = A X + B u ,     y = C X + D u .

Cubic splines interpolate between heights. ``reduction`` makes such a model.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.io import savemat

from rope_model.arrays import Array
from rope_model.files import whole_file, write_text

Complex = NDArray[np.complex128]
SLOWEST = 0.02  #: Hz, lower end of the band in which errors are measured.
ALPHA = 2 * np.pi * SLOWEST  #: 1/s.
#: Error of a channel's gain up to which a small model stands for the sparse one: 6 %.
MAX_DECIBELS = 0.5
MAX_DEGREES = 5.0  #: Error of a channel's phase likewise.
_BY_HEIGHT = 3  #: Dimensions of an array that has a matrix for each height.


class StateSpace(NamedTuple):
    """A first-order model of one height."""

    A: Array
    B: Array
    C: Array
    D: Array

    def states(self, s: Complex) -> Complex:
        """Return (s - A)^-1 B, (len(s), states, inputs)."""
        x = np.linalg.solve(
            s[:, None, None] * np.eye(len(self.A)) - self.A, self.B[None].astype(complex)
        )
        return np.asarray(x, dtype=np.complex128)

    def response(self, s: Complex) -> Complex:
        """Return the transfer functions (len(s), outputs, inputs)."""
        return np.asarray(self.C @ self.states(s) + self.D)


@dataclass(frozen=True)
class ReducedModel:
    """First-order models in one basis, by heights: ``A`` is (heights, states, states).

    ``decibels`` and ``degrees`` are the measured errors (heights, outputs, inputs) against the
    sparse model between SLOWEST and ``band`` Hz at s = ALPHA + i omega, ``share`` the largest
    difference over the channel's largest gain there.
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
        """Transfer functions (len(s), outputs, inputs) at a height, by its place in ``at``."""
        return self._at(height).response(np.asarray(list(s)))

    def _at(self, height: int) -> StateSpace:
        return StateSpace(self.A[height], self.B[height], self.C[height], self.D[height])

    def state_space(self, height: int) -> Any:
        """Return a height's model as control.StateSpace; ImportError without python-control."""
        try:
            import control
        except ImportError as error:
            raise ImportError(
                "StateSpace needs python-control: pip install 'balance-rope[control]', or take A, B, C and D"
            ) from error
        # a point is for names of systems there
        inputs = [name.replace(".", "_") for name in self.inputs]
        outputs = [name.replace(".", "_") for name in self.outputs]
        return control.StateSpace(*self._at(height), inputs=inputs, outputs=outputs)

    def scheduled(self) -> Any:
        """CasADi function (part of the travel, X, u) -> X', y, of cubic splines between heights, constant beyond."""
        part = ca.MX.sym("at")
        X = ca.MX.sym("X", self.A.shape[1])
        u = ca.MX.sym("u", self.B.shape[2])
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
        self._require_no_growth(ca.Function("A", [part], [A]))
        values = [A @ X + B @ u, C @ X + D @ u]
        return ca.Function("plant", [part, X, u], values, ["at", "X", "u"], ["X_rate", "y"])

    def _require_no_growth(self, interpolated_A: Any) -> None:
        """Raise ValueError where the model between heights grows faster than any at a height."""
        at = self.at
        largest_rate = max(0.0, np.linalg.eigvals(self.A).real.max()) + ALPHA
        # at the heights and the quarters between them
        for x in np.interp(np.arange(0, len(at) - 0.9, 0.25), range(len(at)), at):
            rate = np.linalg.eigvals(interpolated_A(x).full()).real.max()
            if rate > largest_rate:
                raise ValueError(
                    f"the model at = {x:.3g}, between heights, grows by {rate:.3g} 1/s and must by no more than "
                    f"{largest_rate:.3g}: take more heights, denser at the ends, or fewer states"
                )

    def write(self, folder: Path) -> tuple[Path, ...]:
        """Write plant.npz, plant.mat and plant.json; they hold the fields of this class by name."""
        data: dict[str, Any] = {name: np.asarray(value) for name, value in vars(self).items()}
        npz = folder / "plant.npz"
        with whole_file(npz) as draft:
            np.savez(draft, **data)
        for_matlab = {}
        for name, values in data.items():
            if values.ndim == _BY_HEIGHT:
                for_matlab[name] = np.moveaxis(values, 0, -1)  # MATLAB has the heights last
            else:
                for_matlab[name] = values
        for name in ("inputs", "outputs"):
            for_matlab[name] = np.array(data[name], dtype=object)
        mat = folder / "plant.mat"
        with whole_file(mat) as draft:
            savemat(draft, for_matlab)
        text = folder / "plant.json"
        write_text(text, json.dumps({name: x.tolist() for name, x in data.items()}))
        return npz, mat, text
