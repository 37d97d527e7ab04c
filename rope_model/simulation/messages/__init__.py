"""What the rope says, and in which case."""
