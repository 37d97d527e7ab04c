"""Prediction of a run's stability, from a trial step of its rope at rest that is taken back."""

from __future__ import annotations

import logging

from hoist_demo.cosimulation.schemes.interface import Load, Memory, Pair, Scheme
from hoist_demo.cosimulation.schemes.stability import StabilityEstimate, estimate_stability, measure_response
from hoist_demo.parameters import Coupling

_log = logging.getLogger(__name__)


def estimate_stability_at_rest(
    scheme: Scheme, coupling: Coupling, pair: Pair, memory: Memory
) -> StabilityEstimate | None:
    """Predict the stability of the scheme; None if it is unknown, ValueError if the rope lacks what it needs."""
    name, H = coupling.scheme, coupling.step
    if scheme.needs_added_mass and pair.rope.added_mass() is None:
        raise ValueError(
            f"scheme = '{name}' needs the rope's added mass, outputs left.added_mass and right.added_mass, "
            "which this rope has not got: take gauss-seidel-1 or iterative-secant"
        )
    if (snapshot := pair.rope.save()) is None:
        if scheme.needs_rollback:
            raise ValueError(
                f"scheme = '{name}' takes steps back, but this rope cannot save its state: take semi-implicit-1 "
                "or gauss-seidel-1, or an FMU with canGetAndSetFMUstate"
            )
        return None
    pair.rope.free(snapshot)
    here = pair.drive.motion(Load.constant(memory.last.force), 1.0)
    answer, cause = measure_response(pair, coupling.start, H, here)
    if cause:
        _log.info("the coupling's stability is not known: %s", cause)
        return None
    seen = estimate_stability(scheme, answer, pair.drive.mobility())
    if warning := seen.warning(name, H):
        _log.warning("%s", warning)
    return seen
