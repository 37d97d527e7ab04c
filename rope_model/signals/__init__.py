"""Outputs of the rope: their table, and formulas of those that follow from the state."""
