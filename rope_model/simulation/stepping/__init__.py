"""Static equilibrium at the start, and single time steps with their events."""
