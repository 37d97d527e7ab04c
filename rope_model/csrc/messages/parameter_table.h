/* Bounds of the parameters. */
#ifndef PARAMETER_TABLE_H
#define PARAMETER_TABLE_H

#include "rope.h"

/* Check all parameters; a message names the group, as in "rope: Qa = ...". */
RopeStatus check_scene(const Scene *scene, char *message);
RopeStatus require_in_bounds(const Mesh *mesh, char *message); /* Check a mesh alone, except its counts. */

#endif
