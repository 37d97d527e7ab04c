"""The balance ropes of a hoist, one or several that differ, ready to wind."""
