"""Figures drawn by scripts, so that they can be changed and reviewed as text."""
