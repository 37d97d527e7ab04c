"""What is published, measured and assumed of a rope, and what follows from it: docs/assumed_data.md."""
