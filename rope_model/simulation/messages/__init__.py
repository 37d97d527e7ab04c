"""Messages of the rope, and their cases."""
