"""What a run leaves behind: its signals over time, and which of them the rope's fidelity has not computed."""
