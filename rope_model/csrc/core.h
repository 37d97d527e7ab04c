/* What the parts of the simulator share; rope.h is for hosts. */
#ifndef CORE_H
#define CORE_H

#include <math.h>
#include <string.h>

#include "rope.h"
#include "state.h"

#if defined(_MSC_VER)
#define RESTRICT __restrict
#else
#define RESTRICT restrict
#endif

#define PI 3.14159265358979323846

static const char *const SIDE_NAMES[2] = {"left", "right"};

/* rows of the left and of the right end */
static inline const double *end_row(const double *x, int nodes, int side) {
    return x + (side ? (size_t)(nodes - 1) * DOF : 0);
}

static inline int lowest_node(int nodes, const double *q) {
    int lowest = 0;
    for (int k = 1; k < nodes; k++)
        if (q[(ptrdiff_t)DOF * k + 1] < q[(ptrdiff_t)DOF * lowest + 1]) lowest = k;
    return lowest;
}

/* rope_system.c: s (elements + 1) from lengths (elements) */
void arc_lengths(int elements, const double *lengths, double *s);

/* partition.c; messages have room for MESSAGE bytes and are "" when all is well.  `bottom` is the arc length of the
   loop's lowest point by the ends' heights. */
/* of the elements at the loop, m */
double partition_fine(const Pattern *pattern, const double *lengths);
Mesh fit_mesh(const Scene *scene);
/* places (PLACES_FACED) of the dividers along the legs, INFINITY where none may press them: formulas.h's faced_places
   on the mesh that suits the rope, nowhere on one that is given */
void faced_by(const Scene *scene, double left, double right, double *faced);
/* number of elements of the mesh on a rope of `length`; 0 and a message when it does not fit.  mesh is not AUTO_MESH */
int partition_elements(const Mesh *mesh, double length, const double *faced, char *message);
/* `elements` as partition_elements counts them: the count looks at every place of the loop */
void partition(const Mesh *mesh, double length, double bottom, const double *faced, int elements, Pattern *pattern,
               double *lengths);
void partition_transform(Pattern *pattern, int direction, const double *faced, int elements, double *lengths);
/* whether a window is so far from its divider that it moves without the loop */
int window_due(const Pattern *pattern, const double *faced);

/* banded.c: A x = b for all columns of b (rows x columns), which becomes x; A, symmetric and positive definite, is
   lost: each of its rows (width + 1) holds the diagonal and the entries right of it, nearest first */
void solve_banded(int rows, int width, double *A, int columns, double *b);

/* transfer.c: what the elements between nodes at s with the values x (nodes x DOF) have at `at`: y (places x DOF) */
void transfer_interpolate(int nodes, const double *x, const double *s, int places, const double *at, double *y);
/* every one of the fields x (nodes x DOF; at most 8) carried from the nodes old_s to as many at new_s; work: scratch,
   TRANSFER_WORK(fields) numbers a node */
#define TRANSFER_WORK(fields) (10 + 14 * (fields))
void transfer_fields(int nodes, const double *old_s, const double *new_s, int fields, double *const *x, double *work);

/* adaptation.c: the angle with the full turns that bring it closest to the last one */
double nearest_turn(double angle, double last);

/* diagnostics.c */
typedef struct {
    double s, position[3], yaw;
} LoopBottom;
/* yaw of the line from the left to the right end */
double diagnostics_direction(const Arrays *m);
LoopBottom loop_bottom(int nodes, const double *q, const double *s);
/* smallest free distance of the legs `above` or more over the lowest point; `pair`, not
   negative: the parts that were nearest the last time, for speed, and are now; some 10 kB of stack */
double leg_clearance(int nodes, const double *q, const double *s, const LoopBottom *bottom, double loop,
                     double diameter, double above, int pair[2]);
/* turns of one side of the rope about the other, over the height, and the height around which they change most */
typedef struct {
    double number, sharpest_y;
} LoopTurns;
/* whether neither leg comes near the other, nor has turned by more than a quarter against the line `across`, which
   leads from left to right */
int legs_apart(const Arrays *m, const double across[2], double diameter, double above);
LoopTurns loop_turns(const Arrays *m, const LoopBottom *bottom);
/* at (points): arc lengths from end to end, denser around the loop's lowest point; total: length of the rope;
   loop: loop_width() */
void shape_places(double total, double bottom_s, double loop, int points, double *at);
/* xyz (points x 3): the centre line at the places, at most 161 */
void diagnostics_shape(int nodes, const double *q, const double *s, int points, const double *at, double *xyz);
/* tension (points) at the places, which ascend, by the balance of momentum to the left of them */
void diagnostics_tension(const Arrays *arrays, double rho, double gravity, int points, const double *at,
                         double *tension);
/* from k on the last element whose middle is not right of `at`, or k; what has `value` in the middle of this element
   k and `next` in that of the following one, linear in between and constant beyond the outermost: numpy.interp */
int middle_before(int nodes, const double *s, int k, double at);
double interpolate_midpoints(int nodes, const double *s, int k, double at, double value, double next);

/* statics.c: q (nodes x DOF); message "" when all is well */
void hanging_guess(int nodes, const double *s, const double left[3], const double right[3], double *q, char *message);

/* of END_MOTION_NAMES */
static inline double end_value(const EndMotion *motion, int place) {
    return ((const double *)motion)[place];
}

/* ends.c; limits: of formulas.h's filter_limits */
void ends_refusal(const Scene *scene, const EndMotion *target, const double limits[14], int side, char *message);
void ends_frozen(const Inputs *inputs, double t, const InputFilter *end_filter, int side, char *message);
/* about the tangent, on the rope's end with this row of the reaction */
double ends_moment(const Scene *scene, const State *state, int side, const double *reaction);
/* angle and rate of the rope's end with theta against the conveyance */
void ends_relative(const State *state, int side, double t, double theta, double theta_t, double relative[2]);
/* q, v and a of an end where they are prescribed */
void ends_prescribed_motion(const Scene *scene, const State *state, int side, double t, double rows[3][DOF]);

/* fidelity.c; ends: present motions, `forces`: on so many places of the rope */
const char *fidelity_name(int fidelity);
int choose_fidelity(const Scene *scene, const EndMotion ends[2], int forces, char *reason);
int lowest_sufficient(const Scene *scene, const EndMotion ends[2], int forces);
void unsupported_motion(const Scene *scene, int fidelity, const EndMotion ends[2], int forces, char *what);

/* rigid.c: q, v, a, reaction (nodes x DOF); message "" when all is well */
void rigid_rope(const Scene *scene, const EndMotion ends[2], double t, int nodes, const double *s, double *q, double *v,
                double *a, double *reaction, double *kinetic, double *gravity, char *message);
/* tension (points) at the places `at` with the heights y */
void rigid_tension(const Arrays *arrays, double rho, double gravity, int points, const double *at, const double *y,
                   double *tension);
/* what the tensions at the ends gain by a change of one end's place, speed and acceleration along an axis */
void tension_change(const Scene *scene, const EndMotion ends[2], int side, int axis, const double change[3],
                    double gained[2]);

/* guards.c: how far the loop's lowest point is above its quasi-static place */
double guards_rise(const Scene *scene, const State *state, const Arrays *arrays, const LoopBottom *bottom);
/* the rope hangs at rest */
void guards_at_rest(const Scene *scene, State *state);
/* what they see at the state's instant */
void with_guards(const Scene *scene, State *state);

/* parameter_table.c: the same bounds and messages with the group's name before, as in "rope: Qa = ..."; "" when all is
   well */
void check_scene(const Scene *scene, char *message);
/* the same of a mesh alone, but for its counts */
void require_in_bounds(const Mesh *mesh, char *message);

#endif
