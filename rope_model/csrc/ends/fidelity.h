/* Choice of the model's fidelity; `ends` are the present motions, `forces` is the number of point forces. */
#ifndef FIDELITY_H
#define FIDELITY_H

#include "rope.h"

int choose_fidelity(const Scene *scene, const EndMotion ends[2], int forces, char *reason);
int lowest_sufficient(const Scene *scene, const EndMotion ends[2], int forces);
void unsupported_motion(const Scene *scene, int fidelity, const EndMotion ends[2], int forces, char *cause);

#endif
