"""Contact of the rope: bodies around it, the rope itself, neighbours, and forces at points of it."""
