/* Ends of the rope: checks of the host's motions, prescribed motion, moments of the swivels. */
#ifndef ENDS_H
#define ENDS_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "state_structures.h"

/* Return "left" or "right". */
const char *side_name(int side);
/* Return an entry of a motion by its number in END_MOTION_NAMES. */
static inline double end_value(const EndMotion *motion, int index) {
    static const size_t offsets[] = END_MOTION_OFFSETS;
    double value;
    memcpy(&value, (const char *)motion + offsets[index], sizeof value);
    return value;
}

static inline void set_end_value(EndMotion *motion, int index, double value) {
    static const size_t offsets[] = END_MOTION_OFFSETS;
    memcpy((char *)motion + offsets[index], &value, sizeof value);
}

/* Refuse a target motion that is out of range, or whose `measures`, from path_measures, exceed the
 * scene's. */
RopeStatus check_motion(const Scene *scene, const EndMotion *target, const double measures[PATH_MEASURES], int side,
                        char *message);
/* Return the axial strain at an end, in an array x like q; of the next node where a clamp gives this one's. */
double end_strain(const Scene *scene, int nodes, const double *q, const double *x, int side);
/* Refuse a motion that has not changed for longer than hold_max. */
RopeStatus check_input_age(const Inputs *inputs, double t, const InputFilter *end_filter, int side, char *message);
/* Return the tension at an end of a motion, N. */
double ends_tension(const Scene *scene, const NodalArrays *nodal, int side);
/* Return the moment about the tangent on the rope's end, N m: from the swivel's phase in `state`, and from the motion
   and the reactions in `nodal`. */
double ends_moment(const Scene *scene, const State *state, const NodalArrays *nodal, int side);
/* Turn of the rope's end against its conveyance. */
typedef struct {
    double angle; /* rad */
    double rate;  /* rad/s */
} RelativeTurn;
/* Return the turn at t of an end, from theta and its rate. */
RelativeTurn ends_relative(const State *state, int side, double t, double theta, double theta_t);
/* Return the present angle of an end against its conveyance, rad. */
double swivel_angle(State *state, int side);
/* Write which degrees of freedom of an end are not prescribed. */
void ends_freedom(const Scene *scene, const State *state, int side, bool free[DOF]);
/* Prescribed q, v and a of an end. */
void ends_prescribed_motion(const Scene *scene, const State *state, int side, double t, double rows[3][DOF]);
/* Return the arc length of the loop's lowest point from the heights of the ends at t. */
double bottom_arc_length(const Scene *scene, const EndPath paths[2], double t);
/* Call mesh_dividers with the heights of the ends at t. */
void dividers_on_rope(const Scene *scene, const EndPath paths[2], double t, double *divider_s);

#endif
