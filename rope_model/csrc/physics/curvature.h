/* Permanent curvature along the present shape of a rope. */
#ifndef CURVATURE_H
#define CURVATURE_H

#include <stdbool.h>

#include "state_structures.h"

bool is_curved(const double *curved, const Rope *rope, int fidelity);
Rope partly_curved(const Rope *whole, double fraction); /* The rope with a fraction of its permanent curvature. */
/* Carry e1 of the left end from r' = before to r' = after. */
void carry_director(State *state, const double *before, const double *after);
void start_director(State *state, const double *q); /* Set e1 of the left end of a rope q that is hung up. */
/* Refer the permanent curvature to q; `curved` has CURVED_SIZE numbers an element. */
void curved_reference(double *curved, const Rope *rope, State *state, const double *q);

#endif
