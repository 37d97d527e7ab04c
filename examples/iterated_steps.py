"""The FMU in a loop of one's own, by FMPy's low-level interface.

Steps are taken back and repeated until forces agree. The right conveyance, 100 kg on a head rope (a
spring with a damper), is unloaded by 500 kg within half a second; 840 kg of balance rope hang below
it. A loop that takes the force of the step before is unstable: the rope is the heavier part.

    python examples/iterated_steps.py build/rope.fmu
"""

import sys

import fmpy
from fmpy.fmi2 import FMU2Slave

MASS = 100.0  # kg
STIFFNESS = 4e5  # N/m
DAMPING = 1e4  # N s/m
PAYLOAD = 500.0 * 9.81  # N
UNLOADING = 0.5  # s
HEIGHT = 90.0  # m
H = 0.01  # s, communication step
STEPS = 300
TOLERANCE = 0.1  # N, of the forces
#: kg, force over acceleration within a step of the trapezoidal rule
INERTIA = MASS + DAMPING * H / 2 + STIFFNESS * H**2 / 4

if len(sys.argv) != 2:
    sys.exit("usage: python examples/iterated_steps.py FMU")
path = sys.argv[1]
description = fmpy.read_model_description(path)
fmu = FMU2Slave(
    guid=description.guid,
    unzipDirectory=fmpy.extract(path),
    modelIdentifier=description.coSimulation.modelIdentifier,
    instanceName="rope",
)
number = {variable.name: variable.valueReference for variable in description.modelVariables}
MOTION = [number[f"right.{name}"] for name in ("y", "vy", "ay")]


def read(name: str) -> float:
    """One output."""
    return float(fmu.getReal([number[name]])[0])


def move(motion: list[float], force: float) -> list[float]:
    """Height above rest, speed and acceleration of the conveyance one step later.

    ``force`` (N) acts beyond that at rest.
    """
    y, v, a = motion
    y_half = y + H * v + H**2 * a / 4
    v_half = v + H * a / 2
    new = (force - DAMPING * v_half - STIFFNESS * y_half) / INERTIA
    return [y_half + H**2 * new / 4, v_half + H * new / 2, new]


fmu.instantiate()
fmu.setBoolean([number["inputs_at_step_end"]], [True])  # the motions are those at the end of a step
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.setReal(MOTION, [HEIGHT, 0.0, 0.0])
fmu.exitInitializationMode()
rest = force = read("right.fy")
motion = [0.0, 0.0, 0.0]
exchanges = 0
for k in range(STEPS):
    start = fmu.getFMUState()
    contraction = 1 + read("right.added_mass") / INERTIA
    lifted = PAYLOAD * min((k + 1) * H / UNLOADING, 1.0)
    while True:
        exchanges += 1
        tried = move(motion, force - rest + lifted)
        y, v, a = tried
        fmu.setReal(MOTION, [HEIGHT + y, v, a])
        fmu.doStep(k * H, H)
        change = read("right.fy") - force
        if abs(change) < TOLERANCE:
            break
        # Newton's method: by the trapezoidal rule too the acceleration grows over the step, as for
        # the added mass
        force += change / contraction
        fmu.setFMUState(start)
    fmu.freeFMUState(start)
    motion = tried
fmu.terminate()
fmu.freeInstance()
print(
    f"{exchanges / STEPS:.1f} exchanges per step; {1e3 * motion[0]:.3f} mm up, "
    "over what the head rope gives:"
)
print(motion[0] * STIFFNESS / PAYLOAD)
