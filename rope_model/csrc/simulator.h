/* The simulator's inside, shared by the files that make it up. */
#ifndef SIMULATOR_H
#define SIMULATOR_H

#include "chain.h"
#include "core.h"
#include "shaft.h"
#include "signal_numbers.h" /* generated */

/* A step that nobody has accepted yet, as numerics.generalized_alpha.StepResult; its arrays are the simulator's. */
typedef struct {
    double t, h, place, error, balance[BALANCE]; /* error: of place and strain over what is allowed */
    int reached, near;                           /* near: whether it may touch a body */
    Progress newton;
} Trial;

struct Simulator {
    Scene scene;
    Memory memory;
    Mesh mesh;           /* never AUTO_MESH */
    const Chain *chains; /* of the fidelities TORSIONAL to PLANAR */
    int elements, initialized;
    size_t state_bytes;
    void *block;                /* all the memory behind the pointers that follow */
    State *state, *next;        /* next is what an advance works on; they change places when it succeeds */
    State *spare;               /* what would be if a swivel stuck, and what is looked at but not kept */
    Arrays trial;               /* of the latest trial; scratch at other times */
    double *x;                  /* nodes x DOF of scratch */
    double (*strains)[STRAINS]; /* scratch */
    double *frames;             /* counted from the state, but from what is worked on while it is */
    double *wires;              /* physics.wire_element.HISTORY of the elements, counted as the frames are; or NULL */
    double *curved;             /* physics.curved_element.CURVED of the elements, counted alike; or NULL */
    double *latest;             /* of the system, where there are such */
    void *work;                 /* of the chain */
    Surroundings *around;
    OwnContact *own;
    PointForces forces;
    double values[SIGNALS];
    unsigned known; /* bit g: the values of group g are those of the state */
    LoopBottom bottom;
    int bottom_known;
    int64_t work_end;        /* number of Newton iterations beyond which the present advance gives up accuracy */
    int corrections, turned; /* of the latest search of an equilibrium: how many, and whether it turned too far */
    char message[MESSAGE];
};

/* memory.c: a simulator of the scene, all its other memory zero; NULL and a message when there is none */
Simulator *with_memory(const Scene *scene, int elements, const Memory *memory, char *message);

/* response.c: the loop's lowest point, kept while the state stays */
const LoopBottom *bottom_now(Simulator *rope);
/* those of the state, into rope->strains */
void compute_strains(Simulator *rope);
/* groups that are computed where the equations are, at their numbers in values (SIGNALS) */
void added_mass_signals(Simulator *rope, double *values);
void contact_signals(Simulator *rope, double *values);

/* state.c */
/* whether what was read from elsewhere can be a state of this rope; trial is scratch */
int state_plausible(const Simulator *rope, State *state);
void state_copy(const Simulator *rope, State *to, const State *from);
void record_event(State *state, int what, int which, double kinetic, double potential);

/* step.c: rope_model.simulation.model and numerics.generalized_alpha */
System system_of(const Simulator *rope, State *state);
const Chain *chain_of(const Simulator *rope, const State *state);
void prescribed_motion(const Simulator *rope, const State *state, int side, double t, double rows[3][DOF]);
/* q, v and a in x, or the first `orders` of them, where they are prescribed at t */
void prescribe(const Simulator *rope, const State *state, const System *s, double t, int orders, double *const x[]);
Trial trial_step(Simulator *rope, State *state, double h);
void restart(Simulator *rope, State *state);
void commit(Simulator *rope, State *state, const Trial *trial);
void set_powers(const Simulator *rope, State *state);
/* energies of the state as it is; returns by how much their total changes */
double update_energies(Simulator *rope, State *state);
/* the largest of the numbers x (nodes x DOF) where the rope is free, those of r' times `slopes`; infinite when one is
   no number */
double largest_of(const System *s, const double *x, double slopes);
double bottom_of(const Simulator *rope, const State *state, double t);
const double *end_row(const double *x, int nodes, int side);
double locate(double (*f)(void *, double), void *with, double low, double high, double f_low, double f_high,
              double width);

/* audit.c: rope_model.simulation.outputs.audit and model, which see */
void audit_restart(const Simulator *rope, State *state, const System *s);
void audit_begin(const Simulator *rope, State *state);
void audit_step(const Simulator *rope, State *state, const System *s, double h, double moved_by,
                const double before[2]);
void audit_interval(const Simulator *rope, State *state, double h, double residual_before);

/* the frames are counted from q from now on */
void refer(Simulator *rope, State *state, const double *q);
/* the same, and the angles become those counted along q; returns what theta gains at the right end */
double transport_angles(Simulator *rope, State *state, double *q, double *v, double *a, double *b);

/* curvature.c: rope_model.simulation.curvature */
int is_curved(const Simulator *rope, const State *state);
/* permanent curvature is counted from q, as the frames are; of no effect on a straight rope */
void refer_curved(Simulator *rope, State *state, const double *q);

/* wires.c: rope_model.simulation.wires; of no effect where no wires rub, but for the first and the last */
/* from now on they do, if the rope has friction and is not rigid, with z = 0 */
void begin_rubbing(Simulator *rope, State *state);
/* they begin to move from q and the state's z */
void refer_wires(Simulator *rope, State *state, const double *q);
/* z becomes that of q; returns what was dissipated, J */
double slip_wires(Simulator *rope, State *state, const double *q);
/* z goes from the mesh with nodes at old_s to the state's */
void carry_wires(Simulator *rope, State *state, const double *old_s);

/* statics.c: q of the state becomes an equilibrium, reaction its residual; v and a are not looked at.
   0 and a message when there is none, or when theta gains more than most_turn (rad) at the right end on the way */
int find_equilibrium(Simulator *rope, State *state, double most_turn, char *message);

/* hang.c: the state at rest, hung up untwisted and then turned in; 0 and a message when it cannot be */
int hang(Simulator *rope, State *state, char *message);

/* switching.c */
void release_swivels(Simulator *rope, State *state);
double next_release(const Simulator *rope, const State *state);
/* the trial shortened to end where a swivel must switch: 1; as it was: 0; -1 when that step fails */
int switching_step(Simulator *rope, State *state, Trial *trial);
void switch_swivels(Simulator *rope, State *state);
int chatters(const State *state);

/* adaptation.c */
void transform_if_due(Simulator *rope, State *state);
void with_loop_yaw(State *state);
int raise_fidelity(Simulator *rope, State *state, const char *why, char *message);
int rigid_state(Simulator *rope, State *state, double t, char *message);

#endif
