"""Why a fidelity of the model serves, or does not: texts of both forms, as in messages."""

from __future__ import annotations


def cannot_follow(fidelity: str, why: str) -> str:
    return f"the {fidelity} model cannot follow {why:.300}"


def fixed_model_cannot_follow(fidelity: str, why: str) -> str:
    return f"the {fidelity} model cannot follow {why:.300}; set model.fidelity = auto (or torsional)"


def while_swivels_hold(why: str) -> str:
    return f"{why:.300} while its swivels hold"


def applied_forces() -> str:
    return "forces that are applied to places of the rope"


def errs_too_much(tolerance_percent: float, error_percent: float) -> str:
    return f"the ends within the tolerance of {tolerance_percent:.3g} %: it errs by an estimated {error_percent:.3g} %"


def would_go_slack(tension: float) -> str:
    return f"a rope that goes slack (tension {tension:.4g} N)"


def as_asked() -> str:
    return "as asked for"


def held_where_initialised(why: str) -> str:
    return f"{why:.300} where the rope is initialised with its swivels held"


def may_touch() -> str:
    return "the rope may touch a body in the shaft"


def may_touch_itself() -> str:
    return "the rope may touch itself"


def guards_watch() -> str:
    return "guards watch the loop, which may turn and swing"


def in_air() -> str:
    return "the air may carry the rope along"


def is_curved(curvature: float) -> str:
    return f"the rope has a permanent curvature of {curvature:g} 1/m"


def is_pushed() -> str:
    return "forces are applied to places of the rope"


def no_torque() -> str:
    return "no torque acts and nothing acts out of plane"


def coupled(Qb: float, Qc: float) -> str:
    return f"tension and torsion are coupled (Qb = {Qb:g}, Qc = {Qc:g} N m)"


def twisted(angle: float) -> str:
    return f"the rope is twisted by {angle:g} rad"


def torque_and_more(torque: str, why: str) -> str:
    return f"{torque:.200}; the spatial model cannot follow {why:.200}"


def errs_little(
    fidelity: str, error_percent: float, tolerance_percent: float, speed: float, acceleration: float, jerk: float
) -> str:
    return (
        f"the {fidelity} model errs by an estimated {error_percent:.2g} %, within the tolerance of "
        f"{tolerance_percent:.3g} %, for ends at up to {speed:g} m/s, {acceleration:g} m/s^2 and {jerk:g} m/s^3"
    )
