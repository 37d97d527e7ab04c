"""The rope at rest, and one step of it."""
