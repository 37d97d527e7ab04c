"""Generation of the engine's C from formulas and tables, and the build of its library."""
