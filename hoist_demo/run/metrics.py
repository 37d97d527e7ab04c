"""Metrics of a run for drive engineers.

NaN for those that the run, the rope or its fidelity does not provide.

Arrival. The reference arrives at a known time; the conveyances have arrived when they stay within
``Arrival`` from then on. Residual swing is the height of a conveyance against the rope's end at the
sheave, so that a slow creep of the drive is not counted as swing; it is counted as time.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hoist_demo.cosimulation.run_state import Result
from hoist_demo.design.swing import fit_swing
from hoist_demo.parameters import SIDES, Arrival, Hoist, Winding
from hoist_demo.recording import incidents
from hoist_demo.recording.fidelity import FIDELITY
from hoist_demo.recording.passages import PASSAGE_SIGNALS
from hoist_demo.recording.ropes import as_only_rope
from hoist_demo.recording.time_series import Array, Recording
from rope_model import BODIES, FAR

_STOPPED = "swing_frequency: the run stopped before it arrived"

#: Every metric with its unit and meaning, in the order of the table.
METRICS = {
    "cycle_time": ("s", "from the reference's start until the conveyances have arrived for good"),
    "trajectory_time": ("s", "duration of the reference's motion"),
    "stop_time": (
        "s",
        "from an emergency stop's beginning until both conveyances stand, if both are held",
    ),
    "stop_distance": ("m", "farthest from there, if both are held"),
    "position_error": (
        "m",
        "of the left conveyance at the record's end, positive below the landing; bounded by size",
    ),
    "tracking_error": ("m", "largest, of the left conveyance against the reference"),
    "torque_rms": ("N.m", "of the motor, from the reference's start to its arrival"),
    "torque_peak": ("N.m", "of the motor, magnitude"),
    "torque_limited_time": ("s", "at the torque limit"),
    "motor_energy": ("J", "work of the motor"),
    "motor_energy_drawn": ("J", "the same without what the motor feeds back"),
    "rope_force_ripple": (
        "N",
        "end force of the balance rope less its mean over 1 s, RMS, the worse end",
    ),
    "rope_force_peak": ("N", "largest pull of the balance rope on a conveyance"),
    "rope_force_range": (
        "N",
        "largest less smallest pull on the same conveyance, the worse one: a trip's load cycle",
    ),
    "bending_stress": (
        "Pa",
        "largest in the balance rope, once a trip for what passes through the loop",
    ),
    **dict.fromkeys(
        ("swing_left", "swing_right"), ("m", "residual swing on the head ropes, peak to peak")
    ),
    "swing_frequency": ("Hz", "damped frequency of the strongest mode of the larger swing"),
    "swing_damping": ("1", "damping ratio of the mode of swing_frequency"),
    "sway": (
        "m",
        "largest in-plane distance of the loop's lowest point from its place at rest, whole trip",
    ),
    "sway_across": (
        "m",
        "largest distance out of the plane of the loop's lowest point from its place at rest",
    ),
    "loop_swing": ("m", "of the loop's lowest point in the plane after arrival, peak to peak"),
    "loop_yaw": ("rad", "largest magnitude"),
    "loop_sideways": (
        "m",
        "largest distance of the loop's lowest point from midway between the ends",
    ),
    "loop_rise": ("m", "largest height of the loop's lowest point over its quasi-static place"),
    "loop_turns": (
        "1",
        "largest magnitude, of one side about the other; half a turn: the loop is over",
    ),
    "clearance": ("m", "smallest, between the legs"),
    **{
        f"clearance_{name}": ("m", f"smallest, from {description}")
        for name, description in BODIES.items()
    },
    **dict.fromkeys(("left_slip", "right_slip"), ("rad", "path of the swivel's slip")),
    **dict.fromkeys(("left_slip_time", "right_slip_time"), ("s", "during which the swivel slips")),
    **dict.fromkeys(
        ("left_starting_torque", "right_starting_torque"),
        ("N.m", "at the last instant before it first slips"),
    ),
    **dict.fromkeys(("left_swivel_torque", "right_swivel_torque"), ("N.m", "largest magnitude")),
    "guard_tripped": ("1", "whether a guard of the loop has tripped, and stopped the hoist"),
    "guard_cause": (
        "1",
        f"guard that has tripped: {', '.join(f'{k} {c}' for k, c in incidents.GUARD_CODES.items())}",
    ),
    "guard_time": ("s", "time of the record at which the guard tripped"),
    "slack_time": ("s", "time with slack head ropes, the worse side"),
    "slip_safety": (
        "1",
        "(exp(mu alpha) - 1) / (largest ratio of the head rope tensions - 1): up to 1 they slip",
    ),
    "head_rope_slip": ("m", "to and fro on the sheave; 0 without hoist.lining"),
    "simulated_time": ("s", "simulated time of the record"),
    "coupling_energy": ("J", "largest energy that the coupling's delay creates"),
}

#: Metrics of which more is better; of those that are neither better nor worse nothing is chosen.
MORE_IS_BETTER = frozenset({"slip_safety", "clearance", *(f"clearance_{name}" for name in BODIES)})
NEUTRAL = frozenset(
    {
        "position_error",
        "swing_frequency",
        "swing_damping",
        "guard_cause",
        "guard_time",
        "simulated_time",
    }
)

#: Errors with a direction: bounds and objectives count their magnitude.
SIGNED = frozenset({"position_error"})
#: Metrics that only a trip to the landing has.
ARRIVALS = ("cycle_time", "trajectory_time", "position_error")
#: Those of stops.
STOPS = frozenset({"stop_time", "stop_distance", "guard_tripped", "guard_cause", "guard_time"})

UNITS = {name: unit for name, (unit, _) in METRICS.items()}

_SWIVEL_METRICS = ("slip", "slip_time", "starting_torque", "swivel_torque")

#: Metrics that each of several ropes has of its own; the others are the hoist's.
ROPE_METRICS = frozenset(
    {
        "rope_force_ripple",
        "rope_force_peak",
        "rope_force_range",
        "bending_stress",
        "sway",
        "sway_across",
    }
    | {f"loop_{name}" for name in ("swing", "yaw", "sideways", "rise", "turns")}
    | {"clearance", *(f"clearance_{name}" for name in BODIES)}
    | {f"left_{name}" for name in _SWIVEL_METRICS}
    | {f"right_{name}" for name in _SWIVEL_METRICS}
)


def names_of(metric: str, ropes: Sequence[str]) -> list[str]:
    """Return a metric's names, ``ROPE.metric`` for each of several ropes.

    The only rope's name is "".
    """
    if tuple(ropes) == ("",) or metric not in ROPE_METRICS:
        return [metric]
    return [f"{rope}.{metric}" for rope in ropes]


def name_without_rope(name: str) -> str:
    """Return a metric's name without the rope's."""
    return name.rpartition(".")[2]


_END_SIGNALS = ("fy", "fy_mean", "swivel.rate", "swivel.slipping", "swivel.torque")

#: Outputs of the rope that the host and the metrics use; a study reads no others unless it keeps
#: them.
ROPE_SIGNALS = frozenset(
    {f"left.{name}" for name in _END_SIGNALS}
    | {f"right.{name}" for name in _END_SIGNALS}
    | {f"loop.{name}" for name in ("x", "z", "yaw", "clearance", "rise", "sideways", "turns")}
    | {"stress.bending_max", "energy.work_ends", FIDELITY}
    | PASSAGE_SIGNALS
    | incidents.GUARD_SIGNALS
)

RIPPLE_WINDOW = 1.0  #: Length of the moving mean that is taken off the end force [s].


class Measures(NamedTuple):
    """Metrics of a run by name, and why a swing frequency is missing from them, in words."""

    metrics: dict[str, float]
    missing: str = ""


def measure(result: Result, hoist: Hoist, arrival: Arrival) -> Measures:
    """Return all metrics of a run, NaN for those that it does not provide."""
    metrics = dict.fromkeys(UNITS, math.nan)
    recording = result.recording
    if not recording.signals:
        return Measures(metrics, _STOPPED)
    metrics["simulated_time"] = float(recording.time[-1] - recording.time[0])
    metrics |= _incidents(recording, hoist, result.winding)
    if "energy.work_ends" in recording:
        metrics["coupling_energy"] = _largest(exchange_energy(recording, hoist))
    metrics |= _drive(recording) | _rope(recording)
    for end in SIDES:
        metrics |= _swivel(recording, end)
    if not result.completed:
        return Measures(metrics, _STOPPED)
    metrics |= trip_metrics(result, arrival)
    swing, missing = _swing(recording, hoist, result.trajectory.duration, arrival)
    return Measures(metrics | swing, missing)


def measure_ropes(
    result: Result, hoist: Hoist, arrival: Arrival, ropes: Sequence[str]
) -> dict[str, float]:
    """Return all metrics of a run by their ``names_of`` for these ropes."""
    if tuple(ropes) == ("",):
        return measure(result, hoist, arrival).metrics
    metrics = measure(result, hoist, arrival).metrics
    for key in ROPE_METRICS:
        del metrics[key]
    for rope in ropes:
        one_rope = replace(result, recording=as_only_rope(result.recording, rope))
        of_rope = measure(one_rope, hoist, arrival).metrics
        metrics |= {f"{rope}.{key}": of_rope[key] for key in ROPE_METRICS}
    return metrics


def exchange_energy(recording: Recording, hoist: Hoist) -> Array:
    """Return the energy that the exchange has created since the start [J]."""
    ends = recording["energy.work_ends"] - recording["energy.work_ends"][0]
    return np.asarray(recording["drive.work_from_balance_rope"] + hoist.tail_rope_number * ends)


def trip_metrics(result: Result, arrival: Arrival) -> dict[str, float]:
    """Return the times and torques that only a completed trip has."""
    recording = result.recording
    winding = result.winding
    t = recording.time - recording.time[0]
    if math.isfinite(winding.tracking_end):
        return {}  # the brake has stopped it somewhere, and nothing asked for that place
    travel = recording["conveyance.left.y"] - recording["conveyance.left.y"][0]
    moving = (t >= winding.start_delay) & (t <= result.trajectory.duration)
    torque_rms = math.nan
    if moving.any():
        torque_rms = float(np.sqrt(np.mean(recording["drive.torque"][moving] ** 2)))
    followed = {
        "tracking_error": _largest(recording["reference.position"] - travel),
        "torque_rms": torque_rms,
    }
    if winding.emergency_at is not None:
        # stopped on its way, as asked for or by the safety circuit: it never arrives
        return followed
    landing = recording["reference.position"][-1]
    outside = np.abs(travel - landing) > arrival.position_band
    for end in SIDES:
        outside |= np.abs(recording[f"conveyance.{end}.vy"]) > arrival.speed_band
    last = int(np.flatnonzero(outside)[-1]) if outside.any() else 0
    cycle_time = math.nan
    if last + 1 < t.size:
        cycle_time = max(0.0, float(t[last + 1]) - winding.start_delay)
    return followed | {
        "trajectory_time": result.trajectory.duration - winding.start_delay,
        "cycle_time": cycle_time,
        "position_error": float(landing - travel[-1]),
    }


def _incidents(recording: Recording, hoist: Hoist, winding: Winding) -> dict[str, float]:
    slack = [event.duration for event in incidents.slack_ropes(recording)]
    ratios = incidents.tension_ratios(recording, hoist.tension_ratio_limit)
    slip = incidents.slip(recording)
    metrics = {
        "slack_time": max(slack, default=0.0),
        "slip_safety": hoist.slip_safety(np.max(ratios)),
        "head_rope_slip": 0.0 if slip is None else slip.slid_distance,
    }
    stops = incidents.stops(recording, winding.emergency_at, hoist.sheave_radius)
    if stops and all(stop.held for stop in stops):
        metrics["stop_time"] = max(stop.time or 0.0 for stop in stops)
        metrics["stop_distance"] = max(stop.farthest for stop in stops)
    if recording.has(*incidents.GUARD_SIGNALS):
        trip = incidents.guard_trip(recording)
        metrics["guard_tripped"] = float(trip is not None)
        if trip is not None:
            metrics |= {"guard_cause": float(trip.code), "guard_time": trip.t}
    return metrics


def _drive(recording: Recording) -> dict[str, float]:
    work = np.diff(recording["drive.work_motor"])
    return {
        "torque_peak": _largest(recording["drive.torque"]),
        "torque_limited_time": recording.seconds("drive.torque_limited"),
        "motor_energy": float(np.sum(work)),
        "motor_energy_drawn": float(np.sum(np.maximum(work, 0.0))),
    }


def _rope(recording: Recording) -> dict[str, float]:
    forces = [recording[f"{end}.fy"] for end in SIDES]
    metrics = {
        "rope_force_peak": max(float(np.max(-force)) for force in forces),
        "rope_force_range": max(float(np.ptp(force)) for force in forces),
        "rope_force_ripple": max(_ripple(recording.time, force) for force in forces),
    }
    if "stress.bending_max" in recording:
        metrics["bending_stress"] = _largest(recording["stress.bending_max"])
    for name, signal in (("sway", "loop.x"), ("sway_across", "loop.z")):
        if signal in recording:
            metrics[name] = _largest(recording[signal] - recording[signal][0])
    for name in ("yaw", "turns", "sideways"):
        if f"loop.{name}" in recording:
            metrics[f"loop_{name}"] = _largest(recording[f"loop.{name}"])
    if "loop.rise" in recording:  # a fall is no rise
        metrics["loop_rise"] = float(np.max(recording["loop.rise"]))
    for name in BODIES:
        if f"nearest.{name}.clearance" in recording:
            smallest = float(recording[f"nearest.{name}.clearance"][-1])
            if smallest < FAR:
                metrics[f"clearance_{name}"] = smallest
            else:
                metrics[f"clearance_{name}"] = math.nan
    if "loop.clearance" in recording:
        metrics["clearance"] = float(np.min(recording["loop.clearance"]))
    return metrics


def _swivel(recording: Recording, end: str) -> dict[str, float]:
    swivel = f"{end}.swivel"
    if not recording.has(f"{swivel}.rate", f"{swivel}.slipping", f"{swivel}.torque"):
        return {}
    rate = recording[f"{swivel}.rate"]
    slipping = recording[f"{swivel}.slipping"]
    torque = recording[f"{swivel}.torque"]
    starts = np.flatnonzero(np.diff(slipping) > 0.0)
    starting_torque = math.nan
    if starts.size:
        starting_torque = float(abs(torque[starts[0]]))
    return {
        f"{end}_slip": float(np.sum(np.abs(rate[1:]) * np.diff(recording.time))),
        f"{end}_slip_time": recording.seconds(f"{end}.swivel.slipping"),
        f"{end}_starting_torque": starting_torque,
        f"{end}_swivel_torque": _largest(torque),
    }


def _swing(recording: Recording, hoist: Hoist, arrived: float, arrival: Arrival) -> Measures:
    """Measure the swing of conveyances and loop in the window after the reference's arrival."""
    t = recording.time - recording.time[0]
    in_window = (t >= arrived) & (t <= arrived + arrival.window)
    if np.count_nonzero(in_window) < 2:
        return Measures(
            {}, "swing_frequency: the record ends as the reference arrives: give winding.settle"
        )
    # heights of the conveyances against their ropes' ends at the sheave
    rim = hoist.sheave_radius * recording["drive.angle"]
    swings = {
        "left": (recording["conveyance.left.y"] - rim)[in_window],
        "right": (recording["conveyance.right.y"] + rim)[in_window],
    }
    metrics = {f"swing_{end}": float(np.ptp(swing)) for end, swing in swings.items()}
    if "loop.x" in recording:
        metrics["loop_swing"] = float(np.ptp(recording["loop.x"][in_window]))
    mode = fit_swing(recording.time[in_window], max(swings.values(), key=np.ptp))
    if isinstance(mode, str):
        return Measures(metrics, f"swing_frequency: {mode}")
    return Measures(metrics | {"swing_frequency": mode.frequency, "swing_damping": mode.damping})


def _ripple(time: Array, force: Array) -> float:
    """Return the RMS of the force less its moving mean [N].

    NaN for a record shorter than the window.
    """
    if time.size < 2:
        return math.nan
    count = round(RIPPLE_WINDOW / (time[1] - time[0]))
    if count < 2 or time.size <= count:
        return math.nan
    # odd, so that the mean is centred
    count += 1 - count % 2
    mean = np.convolve(force, np.full(count, 1.0 / count), mode="valid")
    rest = force[count // 2 : count // 2 + mean.size] - mean
    return float(np.sqrt(np.mean(rest**2)))


def _largest(values: Array) -> float:
    """Return the largest magnitude."""
    return float(np.max(np.abs(values)))
