/* Hysteresis of rubbing wires along a rope; nothing changes unless wires rub. */
#ifndef WIRES_H
#define WIRES_H

#include <stdbool.h>

#include "formulas.h"
#include "state_structures.h"

/* Below, `wires` has WIRE_ELEMENT_HISTORY_SIZE numbers an element, Simulator.wires. */

/* Start friction between wires, with z = 0, if the rope has it (`wires` is not NULL) and is not rigid; return true if
   it started. */
bool start_hysteresis(const double *wires, State *state);
/* Set the history `wires` from q and the state's z. */
void wires_history(const Rope *rope, State *state, const double *q, double (*strains)[STRAINS], double *wires);
/* Update z to q; return the dissipated energy, J. */
double update_hysteresis(const double *wires, State *state, const double *q);
/* Transfer z from the mesh with nodes at old_s to the state's mesh; `before`, as large as z, is scratch. */
void wires_carry(State *state, const double *old_s, double *before);

#endif
