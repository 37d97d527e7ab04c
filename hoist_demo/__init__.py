"""Host of the balance rope: a friction hoist in CasADi, co-simulated with the rope.

Reads from top to bottom as components -> parameters -> reference -> rope_plant (fmu_rope, inprocess_rope) -> equations
-> plant (loads) -> emergency -> controller -> presets -> coupling -> partners -> recording, plain_data -> checkpoint ->
host -> summary, events, html, figures, report -> cli. `design` shapes and optimises trips, `study` winds many times;
see there. `settings` and `progress` serve the commands.

Signs. Heights and vertical forces are positive upwards; a positive travel, sheave angle and torque lift the left
conveyance. Forces of the balance rope are those on the conveyance, so that a hanging rope has `fy` < 0. SI units.
"""

from importlib.metadata import version

__version__ = version("balance-rope")
