/* The balance rope for C hosts: an FMI shell, or Python by ctypes.  SI units, angles in radians.

   rope_create allocates all memory.  There are no globals: simulators are independent, and one thread at a time may use
   each of them. */
#ifndef ROPE_H
#define ROPE_H

#include <stdbool.h>
#include <stddef.h>

/* generated: MESSAGE, ROPE_WARNINGS, codes of choices, EndMotion, and Scene with its groups of parameters */
#include "parameters.h"
/* generated: Memory, PointForces, TangentCoefficients, LinearFacts */
#include "interface_structures.h"

enum { LEFT, RIGHT };
enum { UP = 1 };                        /* index of the vertical component of a vector */
enum { SLOPE = 3, ANGLE = 6, DOF = 7 }; /* degrees of freedom of a node: r (3), r' (3), theta */
enum { ROPE_ROW = 1 + 2 * ANGLE };      /* numbers of a row of rope_rows */

typedef struct Simulator Simulator;

/* How an action ends.  One that fails has written its reason: into its argument `message` (MESSAGE bytes), or where
   rope_message has it. */
typedef enum { ROPE_FAILED, ROPE_DONE } RopeStatus;

/* Create a rope, not yet initialised.  Return NULL, with the reason in message (MESSAGE bytes), if a parameter is out
   of range, the mesh does not fit the rope, or memory is short. */
Simulator *rope_create(const Scene *scene, const Memory *memory, char *message);
void rope_destroy(Simulator *sim);

/* An action that fails leaves the state unchanged. */

/* Hang the rope at rest at time t between the ends, which must not move. */
RopeStatus rope_initialize(Simulator *sim, double t, const EndMotion ends[2]);
/* Advance to t.  `ends` are the motions at given_at, which is t or earlier; they are extrapolated with constant
   accelerations.  An interval below ROPE_MIN_INTERVAL moves nothing; the next one starts at the same time. */
RopeStatus rope_advance_to(Simulator *sim, double t, const EndMotion ends[2], double given_at);
/* Advance as rope_advance_to does, but stop at the first event after at least 1 ms: a swivel is released, sticks or
   slips; a guard trips; a body is struck.  Guards and bodies are checked every 10 ms and at t.  *event, in: nonzero if
   the previous call stopped at one; unchanged motions are then no new sample.  *event, out: nonzero if this one did. */
RopeStatus rope_advance_to_event(Simulator *sim, double t, const EndMotion ends[2], double given_at, int *event);
/* Replace the parameters of solver, swivels and air by those of `scene`.  Only tunable ones may differ. */
RopeStatus rope_retune(Simulator *sim, const Scene *scene);

/* Apply point forces until the next call.  The rope keeps the pointer to `places`; a saved state has no forces. */
void rope_apply(Simulator *sim, const PointForces *forces);
/* Arc length, r, r', and the rates of r and r' of each node. */
void rope_rows(const Simulator *sim, double (*rows)[ROPE_ROW]);
/* Displacements, m, by forces at `start` that act at the end of a step as long as the last one; linearised.  Refused
   for a rigid rope. */
RopeStatus rope_displacement(Simulator *sim, const PointForces *forces, double (*moved)[3]);
const char *rope_message(const Simulator *sim);

int rope_is_initialized(const Simulator *sim);
double rope_time(const Simulator *sim);
int rope_elements(const Simulator *sim);
const char *rope_fidelity(const Simulator *sim); /* "torsional", "spatial", "planar" or "rigid" */
const char *rope_fidelity_reason(const Simulator *sim);

/* Write a warning about valid results into message (MESSAGE bytes), "" if it does not apply.  `index` is 0
   to ROPE_EXTRAPOLATION; the last one is only for hosts that extrapolate the ends' motions. */
enum { ROPE_EXTRAPOLATION = ROPE_WARNINGS };
void rope_warning(Simulator *sim, int index, char *message);

/* Write the values of outputs, by their numbers in rope_model.signals.signal_table.SIGNALS.  Booleans and
   integers are exact.  A value is computed at the first call after a change of state. */
void rope_signals(Simulator *sim, size_t count, const int *signals, double *values);

/* Differentiate the forces and moments left.fx ... left.mz, right.fx ... right.mz with respect to one of the 26 inputs,
   EndMotion on the left and on the right.  The loads are those at the end of the last communication step, the input is
   that of this step; before the first step it is given at the start or the end of a step of step_max. */
RopeStatus rope_load_derivative(Simulator *sim, int input, int at_step_end, double derivative[12]);
/* Number of communication steps that derivatives and added masses have taken again: 1 after each step of the rope, and
   2 for each input and each added mass. */
size_t rope_repeated_steps(const Simulator *sim);

void rope_linear_facts(Simulator *sim, LinearFacts *facts);
/* Write frame_size numbers of each element, which its functions take: the frame's reference, then the permanent
   curvature and the history of its wires, where these act.  The state must be torsional. */
void rope_frames(Simulator *sim, double *frames);
/* Write the matrix c.q dR/dq + c.v dR/dv + c.a dR/da of Newton's method: symmetric, without the parts that have no
   energy, and without contact.  `nodes` (elements + 1) are the blocks of each node, `next` (elements) those of each
   node (row) with the next one (column); held coordinates are among them. */
void rope_tangent(Simulator *sim, const TangentCoefficients *c, double (*nodes)[DOF][DOF], double (*next)[DOF][DOF]);
/* Release the free swivels of a rope at rest, and bring it to rest again.  The others hold. */
RopeStatus rope_release_free_swivels(Simulator *sim);

/* The complete state is a block of bytes without addresses, valid in every process. */
size_t rope_state_bytes(const Simulator *sim);
void rope_save(const Simulator *sim, void *to);
RopeStatus rope_restore(Simulator *sim, const void *from, size_t bytes);

#endif
