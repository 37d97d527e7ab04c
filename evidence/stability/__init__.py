"""Scenes in which a plausible method breaks: the measurement that shows it breaking, and ours."""
