/* Hysteresis of rubbing wires along a rope; nothing changes unless wires rub. */
#ifndef WIRES_H
#define WIRES_H

#include <stdbool.h>

#include "formulas.h"
#include "state_structures.h"

/* Start friction between wires, with z = 0, if the rope has it and is not rigid; return true if it started. */
bool start_hysteresis(const Simulator *sim, State *state);
/* Set the history from q and the state's z. */
void wires_history(Simulator *sim, State *state, const double *q, double (*strains)[STRAINS]);
/* Update z to q; return the dissipated energy, J. */
double update_hysteresis(Simulator *sim, State *state, const double *q);
/* Transfer z from the mesh with nodes at old_s to the state's mesh. */
void wires_carry(Simulator *sim, State *state, const double *old_s);

#endif
