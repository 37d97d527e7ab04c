/* Partitions of the rope into elements; `bottom_s` is the arc length of the loop's lowest point, `divider_s` has
   DIVIDERS entries. */
#ifndef PARTITION_H
#define PARTITION_H

#include <stdbool.h>

#include "state_structures.h"

double partition_fine_length(const Pattern *pattern, const double *lengths); /* Of elements in the loop segment, m. */
Mesh fit_mesh(const Scene *scene);
/* Arc lengths of the legs that face a divider; INFINITY for none, and for a mesh that the user gives. */
void mesh_dividers(const Scene *scene, double left, double right, double *divider_s);
/* Return the number of elements of a mesh other than AUTO_MESH; 0 with a message if it does not fit the length. */
int partition_elements(const Mesh *mesh, double length, const double *divider_s, char *message);
/* Fill pattern and lengths; partition_elements counts the elements. */
void partition(const Mesh *mesh, double length, double bottom_s, const double *divider_s, int elements,
               Pattern *pattern, double *lengths);
void partition_transform(Pattern *pattern, int direction, const double *divider_s, int elements, double *lengths);
bool window_due(const Pattern *pattern, const double *divider_s); /* True if a divider has left its window. */
/* Arc lengths s (elements + 1) of the nodes from element lengths (elements). */
void arc_lengths(int elements, const double *lengths, double *s);

#endif
