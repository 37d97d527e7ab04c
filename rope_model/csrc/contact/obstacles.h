/* Bodies around a rope for its equations of motion, and the elements that they may touch. */
#ifndef OBSTACLES_H
#define OBSTACLES_H

#include <stdbool.h>
#include <stddef.h>

#include "bodies.h"
#include "rope.h"
#include "system.h"

/* Configuration of the latest contact detection. */
typedef struct {
    double free;     /* lower bound of all distances, m */
    double *q;       /* copy */
    double *lengths; /* copy */
} ClearanceCache;

/* Bodies around the rope. */
typedef struct Obstacles {
    const Scene *scene;
    int bodies;
    bool any;                  /* true if an element may touch a body */
    Placed placed[MAX_BODIES]; /* bodies at the latest contact detection */
    double speeds[MAX_BODIES][3];
    double margin;  /* lower bound of the distances of elements not in `near`, m */
    double longest; /* longest element, m */
    ClearanceCache cache;
    unsigned *near; /* bodies that each element may touch, one bit each */
} Obstacles;

/* True if an element may touch a body, by the latest contact detection. */
static inline bool near_bodies(const System *sys) {
    return sys->obstacles != NULL && sys->obstacles->any;
}

/* Find the elements that may touch a body, now or after a move by `margin` (m). */
void find_near_bodies(const System *sys, const double *q, const double *v, double margin);
/* Add elements that came near during Newton's corrections, whose norms sum to `corrections`; return true if any did. */
bool add_near_bodies(const System *sys, const double *q, double corrections);
void remember_configuration(const System *sys, ClearanceCache *cache, const double *q);
/* True if no clearance can have fallen below `least` (m) since remember_configuration. */
bool clearance_exceeds(const System *sys, const ClearanceCache *cache, const double *q, double least);
double longest_near(const System *sys); /* Length of the longest element that may touch a body, m; 0 for none. */

#endif
