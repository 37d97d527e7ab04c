"""Figures and data of docs/hoist.md: `python -m evidence.hoist` (1 min).

Cycles and emergency stops of the presets with dead weights for their balance ropes: what the drive has to do, and
whether the head ropes would slip. How the balance rope itself moves is the FMU's business and not shown here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from evidence.rendering import DOCS, filled, markdown, number
from evidence.tables import Table, read, table, write
from hoist_demo.cases.installed import INSTALLED
from hoist_demo.control.controller import ControllerState, Gains, Measurement, SpeedController
from hoist_demo.control.trajectory import s_curve
from hoist_demo.drive.plant import HoistPlant, PlantInput, energy_residual
from hoist_demo.parameters import GRAVITY, EmergencyLaw, Hoist, Winding

SHOWN = "monopol-1000"
CREEPS = ((1.0, 0.0), (0.5, 3.0), (1.0, 5.0))  # m/s, m
STEP = 0.02  # s

COLUMNS = {
    "time": "s",
    "position": "m",
    "speed": "m/s",
    "acceleration": "m/s2",
    "torque": "N.m",
    "power": "W",
    "brake_torque": "N.m",
    "tension_left": "N",
    "tension_right": "N",
    "tension_ratio": "1",
    "static_tension_ratio": "1",
    "slip_safety": "1",
    "static_slip_safety": "1",
    "energy_residual": "J",
}
"""Columns of a run; position and acceleration are those of the left conveyance, the speed is that of the rim."""


@dataclass(frozen=True)
class Run:
    """A trip, one row per step."""

    hoist: Hoist
    table: NDArray[np.float64]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.table[:, list(COLUMNS).index(name)]


def dead_weights(hoist: Hoist, y_left: float, y_right: float, acceleration: float) -> tuple[float, float]:
    """Forces of one balance rope on the conveyances [N]: its legs' weight and inertia at an acceleration [m/s^2]."""
    half, half_difference = hoist.tail_rope_length / 2.0, (y_left - y_right) / 2.0
    return (
        -hoist.tail_rope_mass * (half + half_difference) * (GRAVITY + acceleration),
        -hoist.tail_rope_mass * (half - half_difference) * (GRAVITY - acceleration),
    )


def wind(hoist: Hoist, winding: Winding, gains: Gains, step: float = STEP) -> Run:
    """One trip; the dead weights accelerate as the reference does, so that the coupling has no delay to answer for."""
    plant, reference = HoistPlant(hoist), s_curve(winding)
    start = (0.0, hoist.shaft_travel) if winding.travel > 0.0 else (hoist.shaft_travel, 0.0)
    state = plant.equilibrium(*start, *dead_weights(hoist, *start, 0.0))
    shown = at_rest = plant.outputs(state, PlantInput(float(state.x[0]), *dead_weights(hoist, *start, 0.0)))
    controller, memory = SpeedController(hoist, at_rest.torque, gains), ControllerState()
    rows = []
    for k in range(math.ceil((reference.duration + winding.settle) / step)):
        point = reference.at(k * step)
        measured = Measurement(shown.y_left - start[0], hoist.sheave_radius * shown.rate)
        command = controller.command(point, measured, memory, step)
        rope = dead_weights(hoist, shown.y_left, shown.y_right, point.acceleration)
        u = PlantInput(command.torque, *rope, brake=command.brake)
        moved = plant.step(state, step, u)
        if not moved.valid:
            raise RuntimeError(f"t = {k * step:g} s: {moved.message}")
        state, memory, shown = moved.state, command.state, plant.outputs(moved.state, u)
        rows.append(
            (
                (k + 1) * step,
                shown.y_left - start[0],
                hoist.sheave_radius * shown.rate,
                shown.a_left,
                shown.torque,
                shown.power,
                shown.brake_torque,
                shown.tension_left,
                shown.tension_right,
                shown.tension_ratio,
                shown.static_tension_ratio,
                hoist.slip_safety(shown.tension_ratio),
                hoist.slip_safety(shown.static_tension_ratio),
                energy_residual(at_rest, shown, state.work),
            )
        )
    return Run(hoist, np.array(rows))


def stop(name: str, law: EmergencyLaw, at: float) -> Run:
    """A preset's trip, stopped by the brake at a time [s]."""
    preset = INSTALLED[name]
    winding = replace(preset.winding, emergency_at=at, emergency_law=law)
    return wind(preset.hoist, winding, preset.gains)


def _cycle(run: Run) -> Figure:
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


def _stops(runs: dict[str, Run], at: float) -> Figure:
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


def _creep() -> Figure:
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


#: columns of the table ``presets``, and those of them that docs/hoist.md shows
SUMMARY = (
    "preset", "winding time [s]", "final error [mm]", "peak torque [kN m]", "peak power [MW]", "peak tension [kN]",
    "tension ratio", "static tension ratio", "slip safety", "static slip safety", "energy residual [J]",
)  # fmt: skip
SHOWN_COLUMNS = (*SUMMARY[:2], *SUMMARY[3:7], *SUMMARY[8:10])


def _summary(name: str, run: Run) -> tuple[str, ...]:
    """A preset's row."""
    moving = np.flatnonzero(np.abs(run["speed"]) > 0.01)
    values = (
        run["time"][moving[-1]] - run["time"][moving[0]],
        1e3 * (run["position"][-1] - run.hoist.shaft_travel),
        1e-3 * np.max(np.abs(run["torque"])),
        1e-6 * np.max(np.abs(run["power"])),
        1e-3 * np.max(run["tension_left"]),
        np.max(run["tension_ratio"]),
        np.max(run["static_tension_ratio"]),
        np.min(run["slip_safety"]),
        np.min(run["static_slip_safety"]),
        np.max(np.abs(run["energy_residual"])),
    )
    return name, *(f"{value:.4g}" for value in values)


def with_presets(text: str, t: Table) -> str:
    """docs/hoist.md with the table between its marks."""
    rows = [
        (f"`{t['preset'][i]}`", *(number(t[name][i], ".4g") for name in SHOWN_COLUMNS[1:]))
        for i in range(t["preset"].size)
    ]
    return filled(text, "presets", markdown(rows, *SHOWN_COLUMNS))


def main() -> None:
    """Wind every preset, stop one of them, write figures and data and the table of docs/hoist.md."""
    data, images, page = DOCS / "data" / "hoist", DOCS / "images" / "hoist", DOCS / "hoist.md"
    images.mkdir(parents=True, exist_ok=True)
    runs = {name: wind(preset.hoist, preset.winding, preset.gains) for name, preset in INSTALLED.items()}
    at = 40.0
    laws: tuple[EmergencyLaw, ...] = ("deceleration", "torque", "two-stage")
    stops: dict[str, Run] = {law: stop(SHOWN, law, at) for law in laws}
    names = [f"{column} [{unit}]" for column, unit in COLUMNS.items()]
    kept = {"cycle": runs[SHOWN], **{f"stop-{law}": run for law, run in stops.items()}}
    presets = table(SUMMARY, [_summary(name, run) for name, run in runs.items()])
    write({"presets": presets, **{name: table(names, run.table[::5].tolist()) for name, run in kept.items()}}, data)
    with matplotlib.rc_context({"font.size": 9.0}):
        for name, figure in {"cycle": _cycle(runs[SHOWN]), "stops": _stops(stops, at), "creep": _creep()}.items():
            figure.savefig(images / f"{name}.png", dpi=110, metadata={"Software": None})
    page.write_text(with_presets(page.read_text(encoding="utf-8"), read(data)["presets"]), encoding="utf-8")
    for law, run in stops.items():
        after = run["time"] > at
        distance = run["position"][-1] - run["position"][after][0]
        safety = float(np.min(run["slip_safety"][after]))
        print(f"{law:<14} stops within {distance:.1f} m, smallest slip safety {safety:.2f}")


if __name__ == "__main__":
    main()
