"""Figures of docs/howto/hoist.md: a cycle, emergency stops, and the reference with creep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hoist_demo.cases.installed import INSTALLED
from hoist_demo.control.trajectory import s_curve

from .winding import Run

SHOWN = "monopol-1000"
CREEPS = ((1.0, 0.0), (0.5, 3.0), (1.0, 5.0))  # m/s, m


def cycle(run: Run) -> Figure:
    """Speed, torque and power, tensions, slip safety over a trip."""
    figure = Figure(figsize=(8.0, 9.0), layout="constrained")
    speed, drive, tensions, safety = figure.subplots(4, 1, sharex=True)
    t = run["time"]
    speed.plot(t, run["speed"], color="C0")
    _label(speed, "speed [m/s]", f"{SHOWN}: payload raised by {run['position'][-1]:.0f} m")
    drive.plot(t, 1e-3 * run["torque"], color="C0", label="motor torque [kN m]")
    drive.plot(t, 1e-4 * run["power"], color="C1", label="motor power [10 kW]")
    _label(drive, "motor", None)
    tensions.plot(t, 1e-3 * run["tension_left"], color="C0", label="left, with payload")
    tensions.plot(t, 1e-3 * run["tension_right"], color="C1", label="right")
    _label(tensions, "head ropes at the sheave [kN]", None)
    _safety(safety, run, "C0", "moving")
    safety.plot(t, run["static_slip_safety"], color="C2", label="at rest here")
    safety.axhline(1.0, color="0.5", linestyle="--", label="slips below")
    _label(safety, "slip safety [-]", None)
    safety.set_xlabel("time [s]")
    return figure


def emergency_stops(runs: dict[str, Run], at: float) -> Figure:
    """Speed, brake torque and tension ratio of the emergency stops."""
    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    speed, brake, ratio = figure.subplots(3, 1, sharex=True)
    for k, (law, run) in enumerate(runs.items()):
        t, color = run["time"] - at, f"C{k}"
        speed.plot(t, run["speed"], color=color, label=law)
        brake.plot(t, 1e-3 * run["brake_torque"], color=color, label=law)
        ratio.plot(t, run["tension_left"] / run["tension_right"], color=color, label=law)
    limit = next(iter(runs.values())).hoist.tension_ratio_limit
    ratio.axhline(limit, color="0.5", linestyle="--", label="slips beyond")
    ratio.axhline(1.0 / limit, color="0.5", linestyle="--")
    _label(speed, "rim speed [m/s]", f"{SHOWN}: emergency stops of the rising payload")
    _label(brake, "brake torque [kN m]", None)
    _label(ratio, "tension, left / right [-]", None)
    ratio.set_yscale("log", base=2)
    ratio.set_xlim(-1.0, 20.0)
    ratio.set_xlabel("time since the trip [s]")
    return figure


def creep() -> Figure:
    """Reference of the trip without creep and with two of them, over time and over the way to the landing."""
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    over_time, over_way = figure.subplots(1, 2, sharey=True)
    trip = INSTALLED[SHOWN].winding
    for k, (c, length) in enumerate(CREEPS):
        reference = s_curve(replace(trip, creep_speed=c, creep_distance=length))
        t = np.linspace(trip.start_delay, reference.duration, 4001)
        position, speed, *_ = reference.sample(t).T
        label = f"{c:g} m/s over {length:g} m" if length > 0.0 else "no creep"
        over_time.plot(t - trip.start_delay, speed, color=f"C{k}", label=label)
        over_way.plot(trip.travel - position, speed, color=f"C{k}", label=label)
    _label(over_time, "speed asked for [m/s]", None)
    _label(over_way, "", None)
    over_time.set_xlabel("time since the start [s]")
    over_way.set_xlabel("way to the landing [m]")
    over_time.set_xlim(left=76.0)
    over_time.set_ylim(0.0, 4.0)
    over_way.set_xlim(12.0, 0.0)
    return figure


def _safety(axes: Axes, run: Run, color: str, label: str) -> None:
    axes.plot(run["time"], run["slip_safety"], color=color, label=label)
    axes.set_ylim(0.0, 2.0 * float(np.max(run["static_slip_safety"])))


def _label(axes: Axes, quantity: str, title: str | None) -> None:
    axes.set_ylabel(quantity)
    axes.grid(alpha=0.3)
    if title:
        axes.set_title(title)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", fontsize="small")
