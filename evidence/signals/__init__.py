"""Motions as tables and sensors send them: how far the end forces are off, and what the rope says."""
