"""Properties of a rope from measurements: the measurements, the fit, and what it leaves open."""
