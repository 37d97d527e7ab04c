"""The swing that an arrival leaves most of: a pole of the hoist's linear model under its speed controller.

The speed loop is closed, and friction at the rim is viscous, as tanh is at rest:

    u = F(s) y ,   F = [[-R k_v (1 + 1 / (T_i s)) (R, k_s)], [-c, 0]] ,   y = (rate, y_left) ,

so that neither a held sheave nor a free one is taken, but the sheave as the controller holds it. Of a trip of constant
jerks a mode takes up its response to a torque over the square of its frequency.

The poles are those of a small model as long as its own measured error is within the bounds of
``reduction``. Where no number of states is enough, they are sought on the sparse model itself: from
the highest peak of the swing on the imaginary axis by the secant method on 1 / swing(s), which
converges to the poles that matter. Source: J. Rommes and N. Martins, IEEE Trans. Power Syst. 21,
2006 (dominant poles).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hoist_demo.cases.case import Case
from hoist_demo.design.krylov_basis import NoSmallModel
from hoist_demo.design.linear_model import LinearModel
from hoist_demo.design.linearise import linearise
from hoist_demo.design.reduced_model import SLOWEST, ReducedModel
from hoist_demo.design.reduction import reduced
from rope_model.arrays import Array

LASTING = 0.3  #: Damping ratio of a mode that swings after an arrival, at most.
BAND = 2.0  #: Upper end of the frequencies that count [Hz].
SWING_INPUTS = ("torque_command", "torque")
SWING_OUTPUTS = ("rate", "y_left", "angle", "y_right")
_RATE, _Y_LEFT, _ANGLE, _Y_RIGHT = range(len(SWING_OUTPUTS))
_COMMAND, _TORQUE = range(len(SWING_INPUTS))
_STEPS = 30  #: Of the secant method, at most; from a peak it takes about eight.
_CONVERGED = 1e-8  #: Last step of the secant method over the pole.
_PEAKS = 5  #: Peaks from which poles of the sparse model are sought.
_STEP = 1e-3  #: First step of the secant method over the frequency.

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class ArrivalSwing:
    """Swing that an arrival leaves most of."""

    frequency: float  # Hz, damped
    damping: float  # 1, ratio


@dataclass(frozen=True)
class SpeedLoop:
    """Speed loop and friction at the rim of a hoist, by the outputs that they feed back."""

    rim: float  # m, radius of the sheave
    error: Array  # (outputs,): error of the speed [m/s], by outputs
    proportional: float  # N m s/m
    integral: float  # N m/m
    rubbing: float  # N m s/rad

    @staticmethod
    def of(case: Case) -> "SpeedLoop":
        hoist = case.hoist
        gains = case.gains
        rim = hoist.sheave_radius
        error = np.zeros(len(SWING_OUTPUTS))
        error[_RATE] = -rim
        error[_Y_LEFT] = -gains.position
        proportional = rim * gains.speed
        coulomb, _ = hoist.travel_loss
        return SpeedLoop(
            rim,
            error,
            proportional,
            proportional / gains.integral_time,
            coulomb / hoist.loss_speed * rim**2,
        )

    @property
    def swings(self) -> Array:
        """Heights of both conveyances against the ropes' ends at the sheave (2, outputs)."""
        rows = np.zeros((2, len(SWING_OUTPUTS)))
        rows[0, _Y_LEFT] = 1.0
        rows[0, _ANGLE] = -self.rim
        rows[1, _Y_RIGHT] = 1.0
        rows[1, _ANGLE] = self.rim
        return rows

    @property
    def gain(self) -> Array:
        """What is fed back at once (inputs, outputs)."""
        gain = np.zeros((len(SWING_INPUTS), len(SWING_OUTPUTS)))
        gain[_COMMAND] = self.proportional * self.error
        gain[_TORQUE, _RATE] = -self.rubbing
        return gain


def swing_at_arrival(case: Case, start: float) -> ArrivalSwing:
    """Return the swing after a trip that begins with the left conveyance at height ``start`` [m].

    ValueError where neither a small model nor the sparse one has such a swing.
    """
    hoist = case.hoist
    at = min(max((start + case.winding.travel) / hoist.shaft_travel, 0.0), 1.0)
    (model,) = linearise(case, [at])
    selected = model.selected(SWING_INPUTS, SWING_OUTPUTS)
    loop = SpeedLoop.of(case)
    try:
        small = reduced([selected], band=BAND)
    except NoSmallModel as error:
        pole = pole_of_sparse(selected, loop)
        if pole is None:
            raise ValueError(
                f"{error}; nor has the complete model a swing that lasts: give shaper.frequency"
            ) from None
    else:
        pole = _pole_of_small(small, loop)
        if pole is None:
            raise ValueError(
                f"shaper.frequency = 0 must be given at {at * hoist.shaft_travel:.6g} m: no swing with a damping ratio "
                f"below {LASTING:g} follows from the linear model: measure it, or take another controller"
            )
    return ArrivalSwing(frequency=pole.imag / (2 * np.pi), damping=-pole.real / abs(pole))


def _lasts(pole: complex) -> bool:
    return pole.imag > 0.0 and -pole.real < LASTING * abs(pole)


def _pole_of_small(small: ReducedModel, loop: SpeedLoop) -> complex | None:
    """Return the pole of a small model with its loop closed that an arrival excites most; None without one."""
    A = small.A[0]
    B = small.B[0]
    C = small.C[0]
    D = small.D[0]
    gain = loop.gain
    # u = gain y + the integral part's torque, with y = C X + D u
    inverse = np.linalg.inv(np.eye(len(SWING_INPUTS)) - gain @ D)
    fed_back = inverse @ np.column_stack((gain @ C, np.eye(len(SWING_INPUTS))[_COMMAND]))
    outputs = np.column_stack((C, np.zeros(len(SWING_OUTPUTS)))) + D @ fed_back
    states = np.column_stack((A, np.zeros(len(A)))) + B @ fed_back
    closed = np.vstack((states, loop.integral * (loop.error @ outputs)))
    poles, shapes = np.linalg.eig(closed)
    commanded = np.append(
        B @ inverse[:, _COMMAND], loop.integral * (loop.error @ D @ inverse[:, _COMMAND])
    )
    excited = np.linalg.solve(shapes, commanded.astype(complex))
    moved = np.abs(loop.swings @ outputs @ shapes).max(axis=0)
    swings = moved * np.abs(excited / poles**2)
    lasting = [k for k, pole in enumerate(poles.tolist()) if _lasts(pole)]
    return max(((swings[k], complex(poles[k])) for k in lasting), default=(0.0, None))[1]


def pole_of_sparse(model: LinearModel, loop: SpeedLoop) -> complex | None:
    """Return the pole of the complete model with its loop closed that an arrival excites most; None without one."""
    omega = 2 * np.pi * np.arange(SLOWEST, BAND, SLOWEST / 2)
    sizes = np.abs(_closed(model, loop, (1j * omega).astype(np.complex128))) / omega[:, None] ** 2
    found: list[tuple[float, complex]] = []
    for swing in range(sizes.shape[1]):
        size = sizes[:, swing]
        peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
        for k in peaks[np.argsort(-size[peaks])][:_PEAKS].tolist():
            pole = _secant(model, loop, swing, 1j * float(omega[k]))
            if pole is not None and _lasts(pole) and pole.imag < 2 * np.pi * BAND:
                found.append((_residue(model, loop, swing, pole) / abs(pole) ** 2, pole))
    return max(found, key=lambda one: one[0], default=(0.0, None))[1]


def _closed(model: LinearModel, loop: SpeedLoop, s: Complex) -> Complex:
    """Return the swings (len(s), 2) by a torque that is added to the command, the loop closed."""
    H = model.response(s)
    feedback = np.broadcast_to(loop.gain, (len(s), *loop.gain.shape)).astype(complex)
    feedback[:, _COMMAND] += loop.integral / s[:, None] * loop.error
    u = np.linalg.inv(np.eye(len(SWING_INPUTS)) - feedback @ H)[:, :, _COMMAND]
    return np.asarray(np.einsum("oy,syu,su->so", loop.swings, H, u))


def _secant(model: LinearModel, loop: SpeedLoop, swing: int, start: complex) -> complex | None:
    """Return the pole to which the secant method on 1 / swing leads from a start; None if it does not converge."""

    def inverse(s: complex) -> complex:
        return 1.0 / complex(_closed(model, loop, np.array([s]))[0, swing])

    old = start * (1.0 + _STEP)
    new = start
    value_old = inverse(old)
    value = inverse(new)
    for _ in range(_STEPS):
        if value == value_old:
            return None
        step = -value * (new - old) / (value - value_old)
        old = new
        value_old = value
        new += step
        if abs(step) < _CONVERGED * abs(new):
            return new
        value = inverse(new)
    return None


def _residue(model: LinearModel, loop: SpeedLoop, swing: int, pole: complex) -> float:
    """Return the size of the swing's residue at a pole."""
    offset = _STEP * abs(pole) * np.exp(0.5j * np.pi * np.arange(4))
    around = np.asarray(pole + offset, dtype=np.complex128)
    return float(abs(np.mean(offset * _closed(model, loop, around)[:, swing])))
