"""Boundary of the rope: motions of its ends from those of a host, its point forces, bodies of the shaft."""
