/* Declarations that all parts of the simulator share; rope.h is for hosts. */
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

/* Return the row of an end in x (nodes x DOF). */
static inline const double *end_row(const double *x, int nodes, int side) {
    return x + (side ? (size_t)(nodes - 1) * DOF : 0);
}

static inline int lowest_node(int nodes, const double *q) {
    int lowest = 0;
    for (int k = 1; k < nodes; k++)
        if (q[(ptrdiff_t)DOF * k + 1] < q[(ptrdiff_t)DOF * lowest + 1]) lowest = k;
    return lowest;
}

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

/* Below, s (nodes) are arc lengths of the nodes, m; q, v, a and reaction are nodes x DOF.  A message has MESSAGE bytes
   and is "" on success. */

/* ends/ends.c */
/* Refuse a target motion that is out of range, or whose `measures`, from path_measures, exceed the scene's. */
void ends_refusal(const Scene *scene, const EndMotion *target, const double measures[14], int side, char *message);
/* Return the axial strain at an end, in an array x like q; of the next node where a clamp gives this one's. */
double end_strain(const Scene *scene, int nodes, const double *q, const double *x, int side);
/* Refuse a motion that has not changed for longer than hold_max. */
void stale_input_error(const Inputs *inputs, double t, const InputFilter *end_filter, int side, char *message);
/* Return the tension at an end, N, from its rows of q and of the reaction. */
double ends_tension(const Scene *scene, int side, const double *q, const double *reaction);
/* Return the moment about the tangent on the rope's end, N m, from the end's rows of q and of the reaction. */
double ends_moment(const Scene *scene, const SwivelState *now, int side, const double *q, const double *reaction);
/* Angle and rate of the rope's end against the conveyance, from theta and its rate. */
void ends_relative(const State *state, int side, double t, double theta, double theta_t, double relative[2]);
/* Prescribed q, v and a of an end. */
void ends_prescribed_motion(const Scene *scene, const State *state, int side, double t, double rows[3][DOF]);

/* fidelity.c; `ends` are the present motions, `forces` is the number of point forces */
const char *fidelity_name(int fidelity);
int choose_fidelity(const Scene *scene, const EndMotion ends[2], int forces, char *reason);
int lowest_sufficient(const Scene *scene, const EndMotion ends[2], int forces);
void unsupported_motion(const Scene *scene, int fidelity, const EndMotion ends[2], int forces, char *cause);

/* mesh/partition.c; `bottom_s` is the arc length of the loop's lowest point, `divider_s` has DIVIDERS entries */
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

/* mesh/transfer.c */
/* Interpolate x (nodes x DOF) at arc lengths `places`: y (count x DOF). */
void transfer_interpolate(int nodes, const double *x, const double *s, int count, const double *places,
                          double (*y)[DOF]);
/* Transfer up to 8 fields x (nodes x DOF) between meshes; `work` has TRANSFER_WORK(fields) numbers a node. */
#define TRANSFER_WORK(fields) (10 + 14 * (fields))
void transfer_fields(int nodes, const double *old_s, const double *new_s, int fields, double *const *x, double *work);

/* numerics/banded.c */
/* Solve A x = b in place for all columns of b (rows x columns).  A is symmetric, positive definite and overwritten; a
   row (width + 1) holds the diagonal and the entries right of it. */
void solve_banded(int rows, int width, double *A, int columns, double *b);

/* outputs/diagnostics.c */
typedef struct {
    double s, position[3], yaw;
} LoopBottom;
typedef struct {
    double number;     /* turns of one side of the rope about the other */
    double sharpest_y; /* height around which they change most, m */
} LoopTurns;
double ends_yaw(const NodalArrays *nodal); /* Return the yaw of the line from the left to the right end. */
LoopBottom loop_bottom(int nodes, const double *q, const double *s);
/* Return the smallest clearance between the legs, m, from `above` the loop's bottom upwards.  `pair`, not negative, has
   the blocks that were nearest in the last call, to speed up the search.  Takes 10 kB of stack. */
double leg_clearance(int nodes, const double *q, const double *s, const LoopBottom *bottom, double loop,
                     double diameter, double above, int pair[2]);
/* True if the legs are certainly apart, and within a quarter turn of `across`, the line from left to right. */
bool legs_apart(const NodalArrays *nodal, const double across[2], double diameter, double above);
LoopTurns loop_turns(const NodalArrays *nodal, const LoopBottom *bottom);
/* Ascending arc lengths `places` (points) over the whole rope, denser around the bottom; `loop` is loop_width(). */
void shape_places(double total, double bottom_s, double loop, int points, double *places);
/* Coordinates xyz (points x 3) of the centre line at arc lengths `places`, which ascend. */
void diagnostics_shape(int nodes, const double *q, const double *s, int points, const double *places, double (*xyz)[3]);
/* Tension (points), N, at arc lengths `places`, which ascend, by the balance of momentum to the left of them. */
void diagnostics_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                         double *tension);
/* Return the last element from k on whose middle is at or before arc length `place`, or k. */
int middle_before(int nodes, const double *s, int k, double place);
/* Interpolate linearly between the middles of element k (`value`) and k + 1 (`next`), as numpy.interp does. */
double interpolate_midpoints(int nodes, const double *s, int k, double place, double value, double next);

/* outputs/guards.c */
/* Return the height of the loop's bottom above its quasi-static position, m. */
double guards_rise(const Scene *scene, const State *state, const NodalArrays *arrays, const LoopBottom *bottom);
void set_rise_reference(const Scene *scene, State *state); /* Reset the guards of a rope at rest. */
void update_guards(const Scene *scene, State *state);      /* Update the guards at the state's time. */

/* parameter_table.c */
/* Check all parameters; a message names the group, as in "rope: Qa = ...". */
void check_scene(const Scene *scene, char *message);
void require_in_bounds(const Mesh *mesh, char *message); /* Check a mesh alone, except its counts. */

/* rigid.c */
void rigid_rope(const Scene *scene, const EndMotion ends[2], double t, int nodes, const double *s, double *q, double *v,
                double *a, double *reaction, double *kinetic, double *gravity, char *message);
/* Tension (points), N, at arc lengths `places` with heights y. */
void rigid_tension(const NodalArrays *arrays, double rho, double gravity, int points, const double *places,
                   const double *y, double *tension);

/* rope_system.c */
/* Arc lengths s (elements + 1) of the nodes from element lengths (elements). */
void arc_lengths(int elements, const double *lengths, double *s);

/* stepping/statics.c */
/* Initial shape q of a rope between two suspension points. */
void hanging_guess(int nodes, const double *s, const double left[3], const double right[3], double *q, char *message);

#endif
