/* What the parts of the simulator share; rope.h is for hosts. */
#ifndef CORE_H
#define CORE_H

#include "rope.h"
#include "state.h"

#define PI 3.14159265358979323846

static const char *const SIDE_NAMES[2] = {"left", "right"};

/* partition.c; messages have room for MESSAGE bytes and are "" when all is well.  `bottom` is the arc length of the
   loop's lowest point by the ends' heights. */
/* of the elements at the loop, m */
double mesh_fine_length(const Pattern *pattern, const double *lengths);
Mesh mesh_fit(const Scene *scene);
/* number of elements of the mesh on a rope of `length`; 0 and a message when it does not fit.  mesh is not AUTO_MESH */
int mesh_elements(const Mesh *mesh, double length, char *message);
/* `elements` as mesh_elements counts them: the count looks at every place of the loop */
void mesh_partition(const Mesh *mesh, double length, double bottom, int elements, Pattern *pattern, double *lengths);
void mesh_transform(Pattern *pattern, int direction, int elements, double *lengths);
/* length: of the rope */
/* s (elements + 1) from lengths (elements) */
void mesh_arc_lengths(int elements, const double *lengths, double *s);

/* transfer.c: rope_model.simulation.mesh.transfer */
/* what the elements between nodes at s with the values x (nodes x DOF) have at `at`: y (places x DOF) */
void transfer_interpolate(int nodes, const double *x, const double *s, int places, const double *at, double *y);
/* every one of the fields x (nodes x DOF; at most 8) carried from the nodes old_s to as many at new_s; work: scratch,
   TRANSFER_WORK(fields) numbers a node */
#define TRANSFER_WORK(fields) (10 + 14 * (fields))
void transfer_fields(int nodes, const double *old_s, const double *new_s, int fields, double *const *x, double *work);

/* shape.c: rope_model.simulation.outputs.diagnostics, statics.hanging_guess */
typedef struct {
    double s, position[3], yaw;
} LoopBottom;
/* the angle with the full turns that bring it closest to the last one: adaptation.nearest_turn */
double shape_nearest_turn(double angle, double last);
int shape_lowest_node(int nodes, const double *q);
/* yaw of the line from the left to the right end */
double shape_direction(const Arrays *m);
LoopBottom shape_loop_bottom(int nodes, const double *q, const double *s);
/* smallest free distance of the legs `above` or more over the lowest point, and the height of it */
/* scratch: some 10 kB on the stack */
double shape_leg_clearance(int nodes, const double *q, const double *s, const LoopBottom *bottom, double loop,
                           double diameter, double above);
/* turns of one side of the rope about the other, over the height, and the height around which they change most */
typedef struct {
    double number, sharpest_y;
} LoopTurns;
/* whether neither leg comes near the other, nor has turned by more than a quarter against the line `across`, which
   leads from left to right: diagnostics.legs_apart */
int shape_legs_apart(const Arrays *m, const double across[2], double diameter, double above);
LoopTurns shape_loop_turns(const Arrays *m, const LoopBottom *bottom);
/* at (points): arc lengths from end to end, denser around the loop's lowest point; total: length of the rope;
   loop: loop_width() */
void shape_places(double total, double bottom_s, double loop, int points, double *at);
/* xyz (points x 3): the centre line at the places, at most 161 */
void shape_points(int nodes, const double *q, const double *s, int points, const double *at, double *xyz);
/* tension (points) at the places, which ascend, by the balance of momentum to the left of them */
void shape_tension(const Arrays *arrays, double rho, double gravity, int points, const double *at, double *tension);
/* from k on the last element whose middle is not right of `at`, or k; what has `value` in the middle of this element
   k and `next` in that of the following one, linear in between and constant beyond the outermost: numpy.interp */
int shape_middle_before(int nodes, const double *s, int k, double at);
double shape_interpolate_midpoints(int nodes, const double *s, int k, double at, double value, double next);
/* q (nodes x DOF); message "" when all is well */
void shape_hanging_guess(int nodes, const double *s, const double left[3], const double right[3], double *q,
                         char *message);

/* of END_MOTION_NAMES */
static inline double end_value(const EndMotion *motion, int place) {
    return ((const double *)motion)[place];
}

/* ends.c: rope_model.simulation.ends.ends */
/* limits: of formulas.h's follow_limits */
void end_refusal(const Inputs *inputs, const EndMotion *target, const double limits[3][4], int side, char *message);
void end_frozen(const Inputs *inputs, double t, const Following *following, int side, char *message);
/* of the conveyance's yaw in theta */
static const double YAW_SENSE[2] = {-1.0, 1.0};
/* about the tangent, on the rope's end with this row of the reaction */
double swivel_moment(const Scene *scene, const State *state, int side, const double *reaction);
/* angle and rate of the rope's end with theta against the conveyance */
void swivel_relative(const State *state, int side, double t, double theta, double theta_t, double relative[2]);

/* fidelity.c: rope_model.simulation.fidelity and rigid; ends: present motions */
const char *fidelity_name(int fidelity);
/* `forces`: on so many places of the rope */
int fidelity_choose(const Scene *scene, const EndMotion ends[2], int forces, char *reason);
int fidelity_lowest_sufficient(const Scene *scene, const EndMotion ends[2], int forces);
void fidelity_unsupported_motion(const Scene *scene, int fidelity, const EndMotion ends[2], int forces, char *what);

/* rigid.c: rope_model.simulation.rigid; q, v, a, reaction (nodes x DOF); message "" when all is well */
void rigid_rope(const Scene *scene, const EndMotion ends[2], double t, int nodes, const double *s, double *q, double *v,
                double *a, double *reaction, double *kinetic, double *gravity, char *message);
/* tension (points) at the places `at` with the heights y */
void rigid_tension(const Arrays *arrays, double rho, double gravity, int points, const double *at, const double *y,
                   double *tension);

/* guards.c: rope_model.simulation.outputs.guards, what the guards of the loop see */
/* how far the loop's lowest point is above its quasi-static place, and horizontally from midway between the ends */
double guards_rise(const Scene *scene, const State *state, const Arrays *arrays, const LoopBottom *bottom);
double guards_sideways(const Arrays *arrays, const LoopBottom *bottom);
/* the rope hangs at rest */
void guards_start(const Scene *scene, State *state);
/* what they see at the state's instant */
void guards_look(const Scene *scene, State *state);

/* parameters.c: rope_model.parameters, the same bounds and messages with the group's name before, as in
   "rope: Qa = ..."; "" when all is well */
void check_scene(const Scene *scene, char *message);
/* the same of a mesh alone, but for its counts */
void mesh_in_bounds(const Mesh *mesh, char *message);

#endif
