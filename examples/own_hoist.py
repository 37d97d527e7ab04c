"""A hoist of one's own, 150 m deep, with head rope modes, a brake and a catalogue's balance rope.

    python examples/own_hoist.py build/rope.fmu

Writes the recording to signals.csv beside the FMU.
"""

import sys
from pathlib import Path

from hoist_demo.control.controller import Gains
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.files.rope_file import FOLLOWING
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.parameters.components import Brake
from hoist_demo.recording.time_series import write_csv
from hoist_demo.report.rows import render, render_verdict
from hoist_demo.report.summary import summarize
from hoist_demo.report.verdict import judge
from rope_model import rope

if len(sys.argv) != 2:
    sys.exit("usage: python examples/own_hoist.py FMU")
fmu = Path(sys.argv[1])
hoist = Hoist(
    conveyance_mass=14e3,
    payload_left=8e3,
    sheave_mass=12e3,
    sheave_radius=1.6,
    torque_limit=4e5,
    head_rope_number=4,
    head_rope_mass=2.5,
    head_rope_stiffness=3.2e7,
    head_rope_length_up=25.0,
    head_rope_modes=2,
    shaft_travel=150.0,
    tail_rope_mass=10.0,
    tail_rope_length=185.0,
    brake=Brake(torque=3.5e5),
)
winding = Winding(travel=150.0, speed=10.0, acceleration=0.8, settle=5.0)
gains = Gains(speed=3.0 * hoist.moving_mass, integral_time=2.0, position=0.5)
catalogue_rope = rope("34x7", diameter=0.049, length=hoist.tail_rope_length)
known = catalogue_rope.rope(mass_per_length=hoist.tail_rope_mass)
balance_rope = {f"rope.{name}": getattr(known, name) for name in FOLLOWING}
balance_rope["layout.spacing"] = 2.2
plant = FmuRope(fmu, balance_rope)
result = Host(plant, hoist, winding, gains=gains).run()
data = plant.data()
plant.close()
print(render_verdict(judge(result, hoist, [data])))
print(render(summarize(result, hoist, winding, Coupling())))
write_csv(result.recording, fmu.with_name("signals.csv"))
