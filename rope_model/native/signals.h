/* Values of the output signals; their numbers are generated into signal_numbers.h by rope_model.native.tables. */
#ifndef SIGNALS_H
#define SIGNALS_H

#include "core.h"
#include "signal_numbers.h"

/* what is computed together: the functions of rope_model.simulation.signals */
enum {
    END_SIGNALS,
    LOOP_SIGNALS,
    STRESS_SIGNALS,
    ENERGY_SIGNALS,
    AUDIT_SIGNALS,
    ERROR_SIGNALS,
    SHAPE_SIGNALS,
    ALONG_SIGNALS,
    ADDED_MASS_SIGNALS,
    CLEARANCE_SIGNALS,
    NEAREST_SIGNALS,
    CONTACT_SIGNALS,
    GUARD_SIGNALS,
    STATION_SIGNALS
};

/* -1 for a number that is no signal's */
int signal_group(int signal);

/* The values of a group at their numbers in values (SIGNALS); the others stay.  Added masses and contact are not
   computed here.  strains (elements x 3), columns as in physics.element.STRAINS, is read for STRESS_SIGNALS,
   ALONG_SIGNALS and STATION_SIGNALS only; bottom, as shape_loop_bottom gives it, for these, LOOP_SIGNALS and
   SHAPE_SIGNALS. */
void signals_of(int group, const Scene *scene, const State *state, const Arrays *arrays, const double (*strains)[3],
                const LoopBottom *bottom, double *values);

#endif
