/* Bodies in the shaft, and the rope among them: rope_model.simulation.contact.bodies and contact.shaft. */
#ifndef BODIES_H
#define BODIES_H

#include "formulas.h"

enum { FIXED = -1, MOST_BODIES = 10 };
typedef struct {
    int kind, moves_with; /* LEFT or RIGHT, or FIXED */
    Body body;
} Placed;
/* bodies.c: the bodies that are there with the rope's ends at these places: their number */
int placed_bodies(const Shaft *shaft, const double *const ends[2], Placed *bodies);
/* the box around some elements from first on, as body_least_distance takes it; the element behind the last of them */
int bodies_group(int elements, const double *lengths, const double *q, int first, double box[6]);

/* shaft.c: where the rope is nearest to the bodies of each kind now */
void shaft_clearances(const Scene *scene, const Arrays *arrays, double t, Nearest nearest[KINDS]);
/* the same where that is nearer than `nearest` says */
void shaft_nearer(const Scene *scene, const Arrays *arrays, double t, Nearest nearest[KINDS]);

static inline void not_near(Nearest nearest[KINDS]) {
    for (int kind = 0; kind < KINDS; kind++) nearest[kind] = (Nearest){.clearance = FAR};
}

#endif
