/* Generalized-alpha method with variable steps. */
#ifndef GENERALIZED_ALPHA_H
#define GENERALIZED_ALPHA_H

#include <stdbool.h>

#include "formulas.h"
#include "newton.h"
#include "state_structures.h"
#include "system.h"

/* A trial step; its arrays are Workspace.trial. */
typedef struct {
    double t;           /* end of the step, s */
    double h;           /* its length, s */
    double error;       /* local error, by chain_norm */
    double strains[2];  /* local error of the strains at the ends */
    double error_ratio; /* largest local error divided by its tolerance */
    double balance[ENERGIES];
    bool converged; /* true if Newton's method converged */
    bool near;      /* true if the rope may touch a body */
    Progress newton;
} StepResult;

StepResult generalized_alpha_step(Simulator *sim, State *state, System *sys, double h); /* Step into the trial. */
void generalized_alpha_restart(Simulator *sim, State *state, const System *sys);
/* Return the time by which b is moved when a step h follows one of length `before` (0 after a restart). */
double recentring(const Coefficients *method, double h, double before);

#endif
