"""Mesh of the rope: partitions, their fit to the rope, and transformations between them."""
