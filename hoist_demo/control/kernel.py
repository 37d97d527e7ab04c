"""The control law as a CasADi function, for whoever makes C of it."""

from dataclasses import fields
from functools import cache
from types import SimpleNamespace
from typing import Any

import casadi as ca

from hoist_demo.control.controller import Gains, SpeedController
from hoist_demo.parameters import Hoist
from hoist_demo.parameters.hoist import with_numbers

#: What the law takes before the gains and the hoist's numbers, in their own orders.
ARGUMENTS = ("position", "speed_asked", "acceleration", "travel", "speed", "holding_torque", "integral", "h")


@cache
def law_kernel(parts: Hoist) -> Any:
    """Return SpeedController.law as (ARGUMENTS, Gains and hoist's numbers in a vector) -> (torque, limited, integral).

    One text for all hoists with these parts (`Hoist.parts`).
    """
    gains = {field.name: ca.SX.sym(field.name) for field in fields(Gains)}
    given, p = ca.SX.sym("given", len(ARGUMENTS)), ca.SX.sym("p", len(parts.numbers))
    hoist = with_numbers(parts, ca.vertsplit(p))
    s, v, a, travel, speed, hold, integral, h = ca.vertsplit(given)
    outputs = SpeedController(hoist, hold, SimpleNamespace(**gains)).law((s, v, a), travel, speed, integral, h)
    return ca.Function("law", [ca.vertcat(given, *gains.values(), p)], [ca.vertcat(*outputs)])
