/* The balance rope for C hosts: an FMI shell, or Python by ctypes.  SI units, angles in radians.

   The simulator does what rope_model.simulation.simulator.RopeSimulator does, step for step; tests hold the two equal.
   All memory is taken by rope_create; nothing is allocated afterwards.  There are no globals: simulators are
   independent of each other, and one may be used by one thread at a time. */
#ifndef ROPE_H
#define ROPE_H

#include <stddef.h>

#include "parameters.h" /* codes of choices; Rope, Layout, Swivel, Mesh, Accuracy, Solver, Model, Scene and EndMotion: generated */

enum { LEFT, RIGHT };
/* degrees of freedom of a node: r (3), r' (3), theta */
enum { SLOPE = 3, ANGLE = 6, DOF = 7 };
/* room for a message, its end included */
enum { MESSAGE = 512 };

/* where memory comes from and goes to; as calloc and free */
typedef struct {
    void *(*take)(size_t number, size_t size);
    void (*give_back)(void *);
} Memory;

typedef struct Simulator Simulator;

/* A rope for the scene, not yet initialised.  NULL, and message (MESSAGE bytes) says why, for a parameter out of range,
   a mesh that does not fit the rope, or no memory. */
Simulator *rope_create(const Scene *scene, const Memory *memory, char *message);
void rope_destroy(Simulator *rope);

/* The calls below return 1 when all is well; 0 when not, then rope_message says why and the state is what it was. */
int rope_initialize(Simulator *rope, double t, const EndMotion ends[2]);
/* less than ROPE_SHORTEST_INTERVAL ahead nothing moves, and the time is not lost: the next step begins where this one
   did.  The motions are those at the instant given_at, t or before, and are extrapolated with constant accelerations */
int rope_advance_to(Simulator *rope, double t, const EndMotion ends[2], double given_at);
/* the same, or less: to the first instant at which a swivel is released, sticks or slips, a guard trips or a body is
   struck, but for a ms at least; *event tells whether there was one.  Guards and bodies are looked at every 10 ms and
   at t.  Is *event set before, the last step ended at one: the motions of before are then no new sample. */
int rope_advance_to_event(Simulator *rope, double t, const EndMotion ends[2], double given_at, int *event);

/* Takes the solver, swivels and air of `scene`.  The caller changes tunable parameters only. */
int rope_retune(Simulator *rope, const Scene *scene);
/* Forces at places of the rope: the arc length from its left end, m, in ascending order, and the force at `start` and
   at `stop`, N, linear between them and held beyond. */
typedef struct {
    int number;
    double start, stop;
    const double (*places)[7];
} PointForces;
/* They act until others are given.  The places stay the caller's and must stay where they are; they are no part of the
   state. */
void rope_apply(Simulator *rope, const PointForces *forces);
/* of each node: arc length, r, r', and the rates of both */
void rope_rows(const Simulator *rope, double (*rows)[13]);
/* by how much each of the places is moved by their forces at `start`, when those come in at the end of a step as long
   as the last, as far as the equations are linear in it */
void rope_displacement(Simulator *rope, const PointForces *forces, double (*moved)[3]);
const char *rope_message(const Simulator *rope);

int rope_is_initialized(const Simulator *rope);
double rope_time(const Simulator *rope);
int rope_elements(const Simulator *rope);
const char *rope_fidelity(const Simulator *rope); /* "torsional" ... */
const char *rope_fidelity_reason(const Simulator *rope);

/* A warning about valid results, by its number below ROPE_WARNINGS, or ROPE_EXTRAPOLATION for hosts that extrapolate
   the ends' motions: a sentence in message (MESSAGE bytes), or "". */
enum { ROPE_WARNINGS = 13, ROPE_EXTRAPOLATION = ROPE_WARNINGS };
void rope_warning(Simulator *rope, int number, char *message);

/* The values of outputs, by their numbers in rope_model.simulation.outputs.signal_table.SIGNALS; booleans and integers
   are exact.  Computed when first asked for after a change of state. */
void rope_signals(Simulator *rope, size_t number, const int *signals, double *values);

/* Derivative of the twelve forces and moments left.fx ... left.mz, right.fx ... right.mz to one of the 26 inputs
   (13 of EndMotion on the left, then on the right), given for the start or the end of a step as long as the last. */
int rope_load_derivative(Simulator *rope, int input, int at_step_end, double derivative[12]);

/* The complete state: plain bytes without addresses, the same in every process. */
size_t rope_state_bytes(const Simulator *rope);
void rope_save(const Simulator *rope, void *to);
int rope_restore(Simulator *rope, const void *from, size_t bytes);

#endif
