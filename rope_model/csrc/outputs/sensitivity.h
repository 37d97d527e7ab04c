/* Derivatives of the end loads with respect to the motions of the ends. */
#ifndef SENSITIVITY_H
#define SENSITIVITY_H

#include "rope.h"

void added_mass_signals(Simulator *sim, double *values); /* values of a group of signals.c */

#endif
