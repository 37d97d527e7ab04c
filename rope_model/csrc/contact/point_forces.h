/* Point forces of a host on the elements. */
#ifndef POINT_FORCES_H
#define POINT_FORCES_H

#include "contact_balance.h"
#include "system.h"

/* Point force on an element. */
typedef struct {
    int element;
    double start; /* arc length where the element begins, m */
    double N[4];  /* shape functions at the place */
    double force[3];
} PointForce;

void elements_at(const System *sys, int index, PointForce *point); /* Advance to a place, in ascending order. */
void nodal_forces(const System *sys, double *R);                   /* Subtract the point forces from R. */
/* Add load and power of the point forces. */
void point_forces_push(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]);

#endif
