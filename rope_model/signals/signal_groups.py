"""Groups of signals: those that one function of the engine computes together."""

from rope_model.signals.state_signals import STATE_SIGNALS

#: group of the signals of a source: the first part of their names
_GROUP_BY_SOURCE = {
    "loop": "loop_signals",
    "stress": "stress_signals",
    "shape": "shape_signals",
    "station": "station_signals",
    "status": "error_signals",
    "audit": "audit_signals",
    "contact": "contact_signals",
    "clearance": "clearance_signals",
    "left": "end_signals",
    "right": "end_signals",
}


def c_function_of(name: str) -> str:
    """Return the name of the function in C that computes the signal ``name`` and related ones."""
    if name in STATE_SIGNALS:
        return "state_signals"
    if name.endswith(".added_mass"):
        return "added_mass_signals"
    if name.endswith(".twist"):
        return "stress_signals"
    if name.startswith(("shape.s", "shape.tension", "shape.bending", "shape.torsion")):
        return "along_signals"
    return _GROUP_BY_SOURCE[name.partition(".")[0]]
