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
ARGUMENTS = (
    "position",
    "speed_asked",
    "acceleration",
    "travel",
    "speed",
    "holding_torque",
    "integral",
    "h",
)


@cache
def law_kernel(structure: Hoist) -> Any:
    """Return SpeedController.law as (ARGUMENTS, Gains and hoist's numbers in a vector) -> (torque, limited, integral).

    One text for all hoists of this `Hoist.equation_structure`.
    """
    gains = {field.name: ca.SX.sym(field.name) for field in fields(Gains)}
    arguments, p = ca.SX.sym("arguments", len(ARGUMENTS)), ca.SX.sym("p", len(structure.numbers))
    hoist = with_numbers(structure, ca.vertsplit(p))
    s, v, a, travel, speed, hold, integral, h = ca.vertsplit(arguments)
    outputs = SpeedController(hoist, hold, SimpleNamespace(**gains)).law(
        (s, v, a), travel, speed, integral, h
    )
    return ca.Function("law", [ca.vertcat(arguments, *gains.values(), p)], [ca.vertcat(*outputs)])
