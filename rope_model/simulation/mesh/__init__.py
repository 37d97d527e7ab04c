"""Partitions of the rope, and the change from one to the next."""
