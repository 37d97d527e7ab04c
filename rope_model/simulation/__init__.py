"""The simulated rope: physics and methods joined."""
