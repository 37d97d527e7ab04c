"""Bodies around the rope, and forces that act at places of it."""
