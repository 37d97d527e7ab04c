/* Contact forces of bodies on r and r' of both nodes of an element. */
#ifndef CONTACT_ELEMENT_H
#define CONTACT_ELEMENT_H

#include "contact_balance.h"
#include "system.h"

enum { CONTACT_DOF = 12 };
void contact_residual(const System *sys, int element, const double *q, const double *v, double R[CONTACT_DOF]);
void contact_tangent(const System *sys, int element, const double *q, const double *v, const TangentCoefficients *c,
                     double tangent[CONTACT_DOF][CONTACT_DOF]);
/* Add to the sums. */
void contact_sums(const System *sys, int element, const double *q, const double *v, double sums[CONTACT_BALANCE]);

#endif
