/* What the outputs are computed from; their numbers and groups are generated into signal_numbers.h by
   rope_model.native.tables. */
#ifndef SIGNALS_H
#define SIGNALS_H

#include "core.h"
#include "signal_numbers.h"

/* response.c: the loop's lowest point, kept while the state stays */
const LoopBottom *bottom_now(Simulator *rope);
/* those of the state, into rope->strains */
void compute_strains(Simulator *rope);
/* groups that are computed where the equations are, at their numbers in values (SIGNALS) */
void added_mass_signals(Simulator *rope, double *values);
void contact_signals(Simulator *rope, double *values);

#endif
