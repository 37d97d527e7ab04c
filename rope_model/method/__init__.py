"""Method of both ropes, as constants and formulas: mesh, time steps, Newton, statics, phases of a swivel, audit."""
