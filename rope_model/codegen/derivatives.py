"""Derivatives of formulas, by CasADi, for C alone."""

from typing import Annotated, Any

import casadi as ca

from rope_model.boundary.end_paths import MOTION_BOUNDS, EndMotion, EndPath
from rope_model.boundary.input_filter import FilterSettings, InputFilter
from rope_model.boundary.input_path import filter_path
from rope_model.boundary.input_sample import filter_sample
from rope_model.physics.elementary import Scalar, Vector


def path_change(
    path: EndPath,
    state: InputFilter,
    settings: FilterSettings,
    given_at: Scalar,
    stop: Scalar,
    end: EndMotion,
    change: Annotated[Vector, len(MOTION_BOUNDS)],
) -> Annotated[tuple[tuple[Any, ...], ...], 6, 6]:
    """Return the derivatives of the coefficients of an end's next path, by PATH and LEANS.

    The path leads from the end of ``path``, with the filter's ``state`` there, to ``stop``.  The
    host's motion ``end`` of the instant ``given_at`` changes along ``change``.
    """
    sample = filter_sample(state, settings, given_at, stop - path.stop, end)
    following = filter_path(path, sample, stop, settings.observer)
    quintics = [*following.coefficients, *following.leans]
    ca.GlobalOptions.setSimplificationOnTheFly(
        True
    )  # else most of the derivative's terms are products with 0
    inputs = ca.vertcat(*vars(end).values())
    direction = ca.vertcat(*change)
    moved = iter(
        ca.vertsplit(
            ca.jtimes(ca.vertcat(*(c for row in quintics for c in row)), inputs, direction)
        )
    )
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    return tuple(tuple(next(moved) for _ in row) for row in quintics)
