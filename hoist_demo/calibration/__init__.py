"""From measurements of a rope to its properties: what was measured, the fit, and what it leaves open."""
