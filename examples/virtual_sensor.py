"""A Kalman filter that estimates the rope's pulls and the right conveyance's height.

Its signals are those of the drive: it has the motor's torque and measures, with noise, the left
conveyance's height, the sheave's speed and load cells of the head ropes. Its model is interpolated
at the height that it estimates. A signal is seen as far as the error is below its size, which is
the error of a table of values at rest over the height. Arguments name trips; without, all of them
are wound.
"""

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import expm, solve

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.inprocess_rope import InProcessRope, rope_scene
from hoist_demo.design.linearise import linearise
from hoist_demo.design.reduction import reduced
from hoist_demo.run.data import build

Array = NDArray[np.float64]
H = 0.01  # s
INPUTS = ("torque", "force_left", "force_right")
MEASURED = {"y_left": ("conveyance.left.y", 1e-3), "rate": ("drive.rate", 2e-3)}
MEASURED |= {f"tension_{side}": (f"drive.tension_{side}", 300.0) for side in ("left", "right")}
ESTIMATED = {name: name for name in ("left.fy", "right.fy", "loop.x", "loop.yaw")}
ESTIMATED["y_right"] = "conveyance.right.y"
WALK = np.array([2e4, 1e4, 1e4])  # N m and N per root of a second, of loads beside the model
TRIPS: dict[str, dict[str, Any]] = {
    "as designed": {},
    "no payload": {"hoist.payload_left": 0.0},
    "head ropes 20 % softer": {"hoist.head_rope_stiffness": 20.8e6},
    "rope half as stiff": {"rope.Qa": 60e6, "rope.EI": 150.0},
}

DESIGN = find_case("rope-120")
TRAVEL = DESIGN.hoist.shaft_travel
HEIGHTS = (1 - np.cos(np.pi * np.arange(9) / 8)) / 2
SIGNALS = (*MEASURED, *ESTIMATED)
MODEL = reduced([model.selected(INPUTS, SIGNALS) for model in linearise(DESIGN, HEIGHTS)], 17)
AT_REST = CubicSpline(MODEL.at, MODEL.rest_outputs)
RHO = rope_scene(DESIGN.rope).rope.mass_per_length
RADIUS = DESIGN.hoist.sheave_radius
STATES = MODEL.A.shape[1]
SEEN = len(MEASURED)


def tables() -> Iterator[CubicSpline]:
    """Discrete model and its equilibrium a metre above, over the height."""
    rows = []
    for A, B, C, D in zip(MODEL.A, MODEL.B, MODEL.C, MODEL.D, strict=True):
        whole = np.block([[A, B, B[:, :1]], [np.zeros((4, STATES + 4))]])
        seen = np.hstack((C, D))
        equilibrium = np.block([[A, B[:, :1]], [C[:1], np.zeros((1, 1))]])
        above = solve(equilibrium, np.append(np.zeros(STATES), 1.0))
        rows.append((expm(H * whole)[: STATES + 3], seen, above, seen[:, : STATES + 1] @ above))
    for parts in zip(*rows, strict=True):
        yield CubicSpline(MODEL.at, np.array(parts))


def estimates(measured: Array, torque: Array) -> Array:
    """Estimates of ESTIMATED at all samples; at first the hoist is at rest."""
    step, seen, above, higher = tables()
    x = np.zeros(STATES + 3)
    h = measured[0, 0] / TRAVEL
    found = []
    longer = 0.0
    held = torque[0]
    noise = np.diag([sigma**2 for _, sigma in MEASURED.values()])
    walk = np.diag(np.append(np.full(STATES, 1e-14), H * WALK**2))
    P = walk + np.diag(np.append(np.zeros(STATES), WALK**2))
    for y, u in zip(measured, torque, strict=True):
        C = seen(h)
        F = step(h)
        known = AT_REST(h) + C[:, STATES] * (u - held)
        known[-1] += longer
        gain = solve(C[:SEEN] @ P @ C[:SEEN].T + noise, C[:SEEN] @ P, assume_a="pos").T
        x = x + gain @ (y - known[:SEEN] - C[:SEEN] @ x)
        found.append((C @ x + known)[SEEN:])
        # the rope that flows pulls by its momentum, too
        found[-1][:2] -= RHO * (RADIUS * (C @ x + known)[1]) ** 2
        x = F @ np.append(x, u - held)
        P = F[:, :-1] @ (P - gain @ C[:SEEN] @ P) @ F[:, :-1].T + walk
        P = (P + P.T) / 2
        # the operating point follows the height
        way = C[0, :STATES] @ x[:STATES]
        x[:STATES] -= way * above(h)[:-1]
        longer += way * (1.0 + higher(h)[-1])
        held = held + way * above(h)[-1]
        h = min(max(h + way / TRAVEL, 0.0), 1.0)
    return np.array(found)


print(f"{'RMS error / size':>24}" + "".join(f"{name:>20}" for name in ESTIMATED))
for trip in sys.argv[1:] or TRIPS:
    run = build("rope-120", TRIPS[trip])
    rope = InProcessRope(rope_scene(run.rope_values))
    host = Host(rope, run.hoist, run.winding, run.coupling, run.gains)
    record = host.run().recording
    noise = np.random.default_rng(1).normal(size=(SEEN, record.time.size))
    measured = np.array(
        [record[name] + s * n for (name, s), n in zip(MEASURED.values(), noise, strict=True)]
    ).T
    estimated = estimates(measured, record["drive.torque"])
    still = AT_REST(np.clip(measured[:, 0] / TRAVEL, 0.0, 1.0))[:, SEEN:]
    true = np.array([record[name] for name in ESTIMATED.values()]).T
    errors, sizes = (np.sqrt(((true - part) ** 2).mean(axis=0)) for part in (estimated, still))
    cells = [f"{error:.2g} / {size:.2g}" for error, size in zip(errors, sizes, strict=True)]
    print(f"{trip:>24}" + "".join(f"{cell:>20}" for cell in cells), flush=True)
