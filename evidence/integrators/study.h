/* What study.c gives to native.py and to the product's sources. */
#ifndef STUDY_H
#define STUDY_H

#include "simulator.h"

/* the method from now on: its kind, and the rows of a tableau, MOST_STAGES of as many numbers */
void study_select(int kind, int stages, const double *rows);
Trial trial_step(Simulator *rope, State *state, double h);

#endif
