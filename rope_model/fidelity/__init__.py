"""Fidelity of the model: its choice, and the effects that it leaves out."""
