"""A hoist at rest."""

from __future__ import annotations

from evidence.hoist.winding import dead_weights
from hoist_demo.drive.plant import (
    HoistPlant,
    PlantInput,
    PlantState,
)


def rest_at(plant: HoistPlant, heights: tuple[float, float]) -> tuple[PlantState, PlantInput]:
    forces = dead_weights(plant.hoist, *heights, 0.0)
    state = plant.equilibrium(*heights, *forces)
    return state, PlantInput(float(state.x[0]), *forces)


def state_with(plant: HoistPlant, state: PlantState, **values: float) -> PlantState:
    """The state with some of its numbers replaced."""
    x = state.x.copy()
    for name, value in values.items():
        x[plant.state_names.index(name)] = value
    return state._replace(x=x)
