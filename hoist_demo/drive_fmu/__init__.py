"""The hoist drive as an FMU: plant, reference and controller behind the names of the balance rope's interface."""
