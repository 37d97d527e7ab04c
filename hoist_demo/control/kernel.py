"""The control law as a CasADi function, for whoever makes C of it."""

from dataclasses import fields
from functools import cache
from types import SimpleNamespace
from typing import Any

import casadi as ca

from hoist_demo.control.controller import Gains, LawResult, SpeedController
from hoist_demo.parameters import Hoist
from hoist_demo.parameters.hoist import with_numbers

#: Arguments of the law before the gains and the hoist's numbers, which have their own orders.
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
RESULTS = LawResult._fields  #: Results of the law, in their order.


@cache
def law_kernel(structure: Hoist) -> Any:
    """Return SpeedController.law as a function of one vector that gives RESULTS.

    The vector has ARGUMENTS, Gains and the hoist's numbers. One text for all hoists of this
    ``Hoist.equation_structure``.
    """
    gains = {field.name: ca.SX.sym(field.name) for field in fields(Gains)}
    arguments = ca.SX.sym("arguments", len(ARGUMENTS))
    p = ca.SX.sym("p", len(structure.numbers))
    hoist = with_numbers(structure, ca.vertsplit(p))
    s, v, a, travel, speed, holding_torque, integral, h = ca.vertsplit(arguments)
    controller = SpeedController(hoist, holding_torque, SimpleNamespace(**gains))
    results = controller.law((s, v, a), travel, speed, integral, h)
    return ca.Function("law", [ca.vertcat(arguments, *gains.values(), p)], [ca.vertcat(*results)])
