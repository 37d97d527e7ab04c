"""Rope under identification: from shares of the ranges of its data to predictions of measurements."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

import rope_model
from hoist_demo.calibration.measurements import Measurements, Track
from hoist_demo.calibration.prediction import RopePredictor
from hoist_demo.calibration.tracks import Markers
from hoist_demo.files.rope_file import FOLLOWING
from rope_model import Datum, Scene
from rope_model.arrays import Array
from rope_model.scene_names import scene_with_values


@dataclass(frozen=True)
class CalibrationProblem:
    """Rope under identification: its ranges of the catalogue, and the scene in which it hangs."""

    catalogue_rope: rope_model.KnownRope
    scene: Scene
    # ranges of parameters beside the properties
    sought: Mapping[str, Datum] = field(default_factory=dict)

    @property
    def data(self) -> dict[str, Datum]:
        """Data of the properties and of the other parameters sought."""
        return {**self.catalogue_rope.data, **self.sought}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of everything sought: all that has a range."""
        return tuple(name for name, datum in self.data.items() if datum.high > datum.low)

    def value(self, name: str, norm_params: Array) -> float:
        """Return the value at its share of its range."""
        return self.data[name].at(float(norm_params[self.names.index(name)]))

    def rope(self, norm_params: Array) -> rope_model.Rope:
        """Return the rope at these shares of the ranges.

        What the file fixes beyond the properties is the scene's.
        """
        data = self.catalogue_rope.data
        values = {name: datum.low for name, datum in data.items()}
        for name in self.names:
            if name in data:
                values[name] = self.value(name, norm_params)
        rope = self.catalogue_rope.rope(**values)
        return replace(self.scene.rope, **{name: getattr(rope, name) for name in FOLLOWING})

    def scene_at(self, norm_params: Array) -> Scene:
        """Return the scene with the rope at these shares of the ranges."""
        values = {name: self.value(name, norm_params) for name in self.sought}
        return scene_with_values(self.scene.with_(rope=self.rope(norm_params)), values)

    def predictor(self, norm_params: Array) -> RopePredictor:
        """Return the predictor for the rope with these normalised parameters."""
        return RopePredictor(self.scene_at(norm_params))

    def predict(
        self, norm_params: Array, measurements: Measurements, predictor: RopePredictor | None = None
    ) -> Array:
        """Predict all values of the measurements in turn.

        ``norm_params`` are the rope's, then those of starts.
        """
        predictor = predictor or self.predictor(norm_params)
        for m in measurements:
            if isinstance(m, Track):
                for trip, times in m.readings():
                    predictor.plan(trip, m.signal, times)
        starts = iter(norm_params[len(self.names) :].tolist())
        predictions: list[float] = []
        for m in measurements:
            if isinstance(m, Markers):
                predictions += m.predict(predictor, *islice(starts, m.starts)).tolist()
                predictor.windings += 1
            else:
                predictions += m.predict(predictor)
        return np.array(predictions)
