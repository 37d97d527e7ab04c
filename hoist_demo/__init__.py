"""Host of the balance rope: a friction hoist in CasADi, co-simulated with the rope.

The rooms are listed, with imports that point down, in docs/architecture.md.

Signs. Heights and vertical forces are positive upwards; a positive travel, sheave angle and torque
lift the left conveyance. Forces of the balance rope are those on the conveyance, so that a hanging
rope has ``fy`` < 0. SI units.
"""

from importlib.metadata import version

__version__ = version("balance-rope")
