"""Records of a run: its signals over time, and those that the rope's fidelity did not compute."""
