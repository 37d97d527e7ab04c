"""Partitions of the rope, and what changes from one to the next."""
