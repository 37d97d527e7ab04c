"""How far the estimates are off that choose the fidelity of the model."""
