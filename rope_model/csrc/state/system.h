/* Equations of motion of a rope at one instant, for the functions of a Chain.

   Arrays q, v, a, x and R have DOF entries per node; degrees of freedom that a fidelity omits stay zero. */
#ifndef SYSTEM_H
#define SYSTEM_H

#include <stdbool.h>
#include <stddef.h>

#include "formulas.h"
#include "rope.h"

/* A rope at one instant.  Inner nodes are free; point forces and contact load them. */
typedef struct {
    int elements;
    bool free[2][DOF]; /* degrees of freedom of the end nodes that are not prescribed */
    const double *lengths;
    double *frames;              /* reference of the elements' frames, from Chain.refer; aligned to 64 bytes */
    struct Obstacles *obstacles; /* NULL without bodies */
    struct SelfContactState *self_contact; /* NULL without contact of the rope with itself */
    const PointForces *forces;             /* NULL without forces */
    const double *wires;  /* WIRE_ELEMENT_HISTORY_SIZE numbers an element; NULL without friction between wires */
    const double *curved; /* CURVED_SIZE numbers an element; NULL without permanent curvature */
    double time;          /* time at which point forces are evaluated, s */
    /* WIRE_ELEMENT_TANGENT_SIZE numbers an element, of the latest tangent; scratch, aligned as frames */
    double *wire_tangents;
    double P[ELEMENT_PARAMETERS]; /* parameters of the element functions */
    bool air_acts;                /* else `air` is not read */
    double air[AIR_COEFFICIENTS]; /* numbers of AirCoefficients, in their order */
    double load[2];               /* moments on theta of the ends, N m, besides friction_load */
    double friction_load[2];      /* the part of them that grows with the tension, N m per N */
    bool plumb[2];                /* ends whose tension is their vertical reaction */
    double inertia[2];            /* of theta at the ends, kg m^2 */
    double shortest;              /* length of the shortest element, m */
    int corrections;              /* Newton corrections of a step that is taken again; 0: until it converges */
} System;

/* Return the tension at an end, which is plumb or not, from its rows of q and of the reaction. */
static inline double tension_at_end(bool plumb, int side, const double *q, const double *reaction) {
    return plumb ? reaction[UP] : swivel_tension_along(side ? 1 : -1, q + SLOPE, reaction);
}

/* Interpolate r, or its speed, in an element with shape functions N. */
static inline void at_places(const double *x, int element, const double N[4], double y[3]) {
    const double *a = x + (size_t)element * DOF;
    const double *b = a + DOF;
    for (int i = 0; i < 3; i++) y[i] = N[0] * a[i] + N[1] * a[SLOPE + i] + N[2] * b[i] + N[3] * b[SLOPE + i];
}

#endif
