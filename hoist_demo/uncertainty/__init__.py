"""Uncertainty of a winding from that of its rope, and the datum that causes it."""
