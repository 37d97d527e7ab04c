"""Paths of the rope's ends for tests: to a motion at once, and behind the motions that a host gives."""

from dataclasses import dataclass, field
from typing import NamedTuple

from rope_model import Rope, Scene
from rope_model.boundary import quintic
from rope_model.boundary.end_paths import EndMotion, EndPath
from rope_model.boundary.input_filter import FilterSettings, InputFilter, filter_settings
from rope_model.boundary.input_misfit import add_misfit
from rope_model.boundary.input_path import PathMeasures, filter_path, path_measures
from rope_model.boundary.input_sample import filter_sample
from rope_model.parameters import CHOICES
from rope_model.solver_parameters import Inputs, Trusted

NO_MEASURES = PathMeasures((0.0,) * 6, (0.0,) * 4, (0.0,) * 4)


#: m, length of the rope from the end to the loop
LEG = 60.0


class FilterStep(NamedTuple):
    """Next path of an end, the filter at its end, and the measures that decide whether the rope can follow the path."""

    filter: InputFilter
    path: EndPath
    measures: PathMeasures


def led(path: EndPath, stop: float, target: EndMotion) -> EndPath:
    """The path from the end of ``path`` on that arrives at ``stop`` with the motion ``target``."""
    h = stop - path.stop
    now = path.motion(path.stop)
    then = (*target.position, target.yaw), (*target.velocity, target.yaw_rate)
    accelerations = (*target.acceleration, (target.yaw_rate - now[1][3]) / h)
    x, y, z, yaw = (
        quintic.coefficients(h, axis[:3], axis[3:])
        for axis in zip(*now, *then, accelerations, strict=True)
    )
    return EndPath(path.stop, stop, (x, y, z, yaw))


def settings_of(scene: Scene) -> FilterSettings:
    """Return the settings of the ends' filters in ``scene``."""
    return filter_settings(scene, [*CHOICES["inputs.given"]].index(scene.inputs.given))


def usual_manner(
    trusted: Trusted = "all", bandwidth: float = 1.0, estimate: float = 17.0
) -> FilterSettings:
    """By default with the bandwidths (rad/s) of the 120 m rope at the standard level."""
    return settings_of(Scene(inputs=Inputs(trusted, bandwidth, estimate)))


@dataclass
class Follower:
    """An end that follows what it is given, from rest at ``at``."""

    at: EndMotion = field(default_factory=EndMotion)
    settings: FilterSettings = field(default_factory=usual_manner)

    def __post_init__(self) -> None:
        self.path = EndPath.at_rest(0.0, self.at)
        self.filter = InputFilter.at_rest(0.0, self.at)

    def step(self, stop: float, given: EndMotion, given_at: float | None = None) -> FilterStep:
        """On to ``stop`` by the motion ``given`` of the instant ``given_at``, or else of ``stop``."""
        at = stop if given_at is None else given_at
        state = filter_sample(self.filter, self.settings, at, stop - self.path.stop, given)
        self.path = filter_path(self.path, state, stop, self.settings.observer)
        measures = path_measures(self.path, state)
        self.filter = add_misfit(state, self.path, self.settings, Rope(), LEG)
        return FilterStep(self.filter, self.path, measures)
