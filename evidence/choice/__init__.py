"""Which fidelity of the model a scene needs, and which terms of the equations."""
