"""Record of drive and exchange at each sample: names, units and values.

A row keeps the numbers as they come; what follows from them is computed once, for all rows, when the run has ended.
"""

from hoist_demo.control.controller import Command
from hoist_demo.control.trajectory import TrajectoryPoint
from hoist_demo.cosimulation.participants.hoist_partner import HoistPartner
from hoist_demo.cosimulation.schemes.interface import SchemeState, Vector
from hoist_demo.drive.equations import LOSS_NAMES, WORK_NAMES
from hoist_demo.drive.outputs import OUTPUT_INDEX, tension_ratio
from hoist_demo.parameters import SIDES, Hoist
from hoist_demo.recording.time_series import TIME, Recording

_REFERENCE = ("position", "speed", "acceleration", "jerk")
DRIVE_UNITS = {
    TIME: "s",
    **dict(
        zip((f"reference.{name}" for name in _REFERENCE), ("m", "m/s", "m/s2", "m/s3"), strict=True)
    ),
    **{
        f"conveyance.{side}.{n}": unit
        for side in SIDES
        for n, unit in (("y", "m"), ("vy", "m/s"), ("ay", "m/s2"))
    },
    "drive.angle": "rad",
    "drive.rate": "rad/s",
    "drive.torque_command": "N.m",
    "drive.torque": "N.m",
    "drive.torque_limited": "1",
    "drive.motor_power": "W",
    "drive.brake_torque": "N.m",
    **{f"drive.tension_{side}": "N" for side in SIDES},
    "drive.tension_ratio": "1",
    "drive.static_tension_ratio": "1",
    "drive.slip_safety": "1",
    "drive.slip": "m",
    "drive.slip_speed": "m/s",
    **{
        f"drive.{name}_{side}": unit
        for name, unit in (("pull", "N"), ("slack", "m"), ("jam", "N"))
        for side in SIDES
    },
    **{
        f"drive.work_{name}": "J"
        for name in ("motor", "losses", "slip", "rope_damping", "from_balance_rope")
    },
    **{f"drive.energy_{name}": "J" for name in ("kinetic", "potential", "residual")},
    "coupling.energy": "J",
    "coupling.exchanges": "1",
}

_MOTION = {"y": "y", "v": "vy", "a": "ay"}
#: Signals that are numbers of OUTPUTS.
_SHOWN_AS = {
    **{
        f"{name}_{side}": f"conveyance.{side}.{spelt}"
        for side in SIDES
        for name, spelt in _MOTION.items()
    },
    **{
        f"{name}_{side}": f"drive.{name}_{side}"
        for side in SIDES
        for name in ("tension", "pull", "slack", "jam")
    },
    **{
        n: f"drive.{n}"
        for n in ("angle", "rate", "torque", "brake_torque", "energy_kinetic", "energy_potential")
    },
}
_BESIDE = "beside."  #: Before the names of what a row has beside them.
#: What `drive_row` gives, by name.
ROW = (
    TIME,
    *(f"reference.{name}" for name in _REFERENCE),
    *(f"drive.{name}" for name in ("torque_command", "torque_limited", "slip", "slip_speed")),
    *("coupling.energy", "coupling.exchanges"),
    *(_SHOWN_AS.get(name, _BESIDE + name) for name in OUTPUT_INDEX),
    *(f"{_BESIDE}work_{name}" for name in WORK_NAMES),
    *(f"{_BESIDE}losses_{name}" for name in LOSS_NAMES),
)


def drive_row(
    t: float,
    reference: TrajectoryPoint,
    command: Command,
    drive: HoistPartner,
    scheme_state: SchemeState,
) -> tuple[tuple[float, ...], Vector, Vector]:
    """Return the drive's record at a sample, in parts; `with_drive_signals` computes the rest."""
    slip_state = drive.state.slip_state
    numbers = (
        t,
        *reference[:4],
        command.torque,
        command.limited,
        slip_state.slid_distance,
        slip_state.speed,
    )
    return (
        (*numbers, scheme_state.residual, scheme_state.exchanges),
        drive.outputs,
        drive.state.work_totals,
    )


def with_drive_signals(rows: Recording, hoist: Hoist) -> Recording:
    """Compute DRIVE_UNITS from a table of ROW, and pass on the rope's signals."""
    recorded = rows.signals
    motor, losses, ropes, left, right = (recorded[f"{_BESIDE}work_{name}"] for name in WORK_NAMES)
    ratio = tension_ratio(recorded["drive.tension_left"], recorded["drive.tension_right"])
    kinetic, potential = recorded["drive.energy_kinetic"], recorded["drive.energy_potential"]
    gained = kinetic + potential - kinetic[:1] - potential[:1]
    computed = {
        "drive.motor_power": recorded["drive.torque"] * recorded[f"{_BESIDE}motor_rate"],
        "drive.tension_ratio": ratio,
        "drive.static_tension_ratio": tension_ratio(
            recorded[f"{_BESIDE}static_tension_left"], recorded[f"{_BESIDE}static_tension_right"]
        ),
        "drive.slip_safety": hoist.slip_safety(ratio),
        "drive.work_motor": motor,
        "drive.work_losses": losses,
        "drive.work_slip": recorded[f"{_BESIDE}losses_lining"],
        "drive.work_rope_damping": ropes,
        "drive.work_from_balance_rope": left + right,
        "drive.energy_residual": motor + left + right - losses - ropes - gained,
    }
    drive = {name: computed[name] if name in computed else recorded[name] for name in DRIVE_UNITS}
    rope = {name: values for name, values in recorded.items() if name not in ROW}
    signals, units = drive | rope, {**rows.units, **DRIVE_UNITS}
    return Recording(signals, {name: units[name] for name in signals})
