"""Motions as tables, sensors and slower parts send them: how far the end forces are off, and what the rope says."""
