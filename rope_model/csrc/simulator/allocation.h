/* Memory of a simulator. */
#ifndef ALLOCATION_H
#define ALLOCATION_H

#include "rope.h"

/* Allocate a simulator of the scene, zero except for its pointers. */
Simulator *allocate_simulator(const Scene *scene, int elements, const Memory *memory, char *message);

#endif
