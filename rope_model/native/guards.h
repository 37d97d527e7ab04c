/* What the guards of the loop see: rope_model.simulation.guards. */
#ifndef GUARDS_H
#define GUARDS_H

#include "formulas.h"

/* how far the loop's lowest point is above its quasi-static place, and horizontally from midway between the ends */
double guards_rise(const Scene *scene, const State *state, const Arrays *arrays, const LoopBottom *bottom);
double guards_sideways(const Arrays *arrays, const LoopBottom *bottom);
/* the rope hangs at rest */
void guards_start(const Scene *scene, State *state);
/* what they see at the state's instant */
void guards_look(const Scene *scene, State *state);

#endif
