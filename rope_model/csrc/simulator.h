/* The simulator's inside, shared by the files that make it up. */
#ifndef SIMULATOR_H
#define SIMULATOR_H

#include "rope_system.h"
#include "signal_numbers.h" /* generated */

/* A step that nobody has accepted yet; its arrays are the simulator's.  error: local, in rope_system_norm; relative:
   that and the strains' over what is allowed; near: whether it may touch a body */
typedef struct {
    double t, h, error, strains[2], relative, balance[BALANCE];
    int reached, near;
    Progress newton;
} StepResult;

struct Simulator {
    Scene scene;
    Memory memory;
    Mesh mesh;           /* never AUTO_MESH */
    const Chain *chains; /* of the fidelities TORSIONAL to PLANAR */
    int elements, initialized;
    size_t state_bytes;
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
    SelfContactState *own;
    PointForces forces;
    double values[SIGNALS];
    unsigned known; /* bit g: the values of group g are those of the state */
    LoopBottom bottom;
    int bottom_known, nearest_blocks[2]; /* of leg_clearance */
    int64_t work_end;    /* number of Newton iterations beyond which the present advance gives up accuracy */
    int64_t corrections; /* of all searches of an equilibrium since the start began */
    int turned;          /* whether the latest search turned too far */
    char message[MESSAGE];
};

static inline const Chain *chain_of(const Simulator *rope, const State *state) {
    return rope->chains + (state->fidelity == RIGID ? PLANAR : state->fidelity) - TORSIONAL;
}

/* memory.c: a simulator of the scene, all its other memory zero; NULL and a message when there is none */
Simulator *with_memory(const Scene *scene, int elements, const Memory *memory, char *message);

/* state.c */
/* whether what was read from elsewhere can be a state of this rope; trial is scratch */
int state_plausible(const Simulator *rope, State *state);
void state_copy(const Simulator *rope, State *to, const State *from);
void record_event(State *state, int what, int which, double kinetic, double potential);

/* rope_system.c */
System rope_system(const Simulator *rope, State *state);
/* frames, and what else is counted from q, are counted from there from now on */
void rope_system_refer(Simulator *rope, State *state, const double *q);
/* the same, and the angles become those counted along q; returns what theta gains at the right end */
double rope_system_transport(Simulator *rope, State *state, double *q, double *v, double *a, double *b);
/* q, v and a in x, or the first `orders` of them, where they are prescribed at t */
void rope_system_prescribed_motion(const Simulator *rope, const State *state, const System *s, double t, int orders,
                                   double *const x[]);
/* of the present state, into rope->strains */
void rope_system_strains(Simulator *rope);

/* generalized_alpha.c: the trial's arrays are what the step leads to */
StepResult generalized_alpha_step(Simulator *rope, State *state, System *s, double h);
void generalized_alpha_restart(Simulator *rope, State *state, const System *s);
/* by how much b is moved when a step h follows one of length before, 0 after a restart */
double recentring(const Coefficients *method, double h, double before);

/* model.c */
StepResult model_trial(Simulator *rope, State *state, double h);
void model_restart(Simulator *rope, State *state);
void model_commit(Simulator *rope, State *state, const StepResult *trial);
void model_powers(const Simulator *rope, State *state);
/* energies of the state as it is; returns by how much their total changes */
double model_energies(Simulator *rope, State *state);
double model_bottom(const Simulator *rope, const State *state, double t);
/* faced_by now */
void model_faced(const Simulator *rope, const State *state, double t, double *faced);
/* angles of q, v, a, b count from the frames; from now on they count along q */
void with_angles_along(Simulator *rope, State *state, double *q, double *v, double *a, double *b);
void begin_audit(const Simulator *rope, State *state);
/* h: of the communication step, at the start of which the balance of energy had this residual */
void audit_interval(const Simulator *rope, State *state, double h, double residual_before);

/* curvature.c */
int is_curved(const Simulator *rope, const State *state);
Rope partly_curved(const Rope *whole, double part);
/* permanent curvature is counted from q, as the frames are; of no effect on a straight rope */
void curved_reference(Simulator *rope, State *state, const double *q);

/* wires.c: from now on wires rub, if the rope has friction and is not rigid, with z = 0: whether they begin to */
int start_hysteresis(const Simulator *rope, State *state);
/* they begin to move from q and the state's z */
void wires_history(Simulator *rope, State *state, const double *q, double (*strains)[STRAINS]);
/* z becomes that of q; returns what was dissipated, J; of no effect where no wires rub */
double wires_slip(Simulator *rope, State *state, const double *q);
/* z goes from the mesh with nodes at old_s to the state's; of no effect where no wires rub */
void wires_carry(Simulator *rope, State *state, const double *old_s);

/* shaft.c: what the rope came near to, and passed through, at the state's instant */
void with_passages(const Simulator *rope, State *state);

/* events.c: the right end of an interval in which f goes from negative to not negative, not wider than `width` */
double locate(double (*f)(void *, double), void *with, double low, double high, double f_low, double f_high,
              double width);

/* statics.c: q of the state becomes an equilibrium, reaction its residual; v and a are not looked at.
   0 and a message when there is none, or when theta gains more than most_turn (rad) at the right end on the way */
int find_equilibrium(Simulator *rope, State *state, double most_turn, char *message);

/* rigid.c: q, v, a and the reaction as the equilibria between the moving ends have them, all counted from the rigid
   rope; 0 and a message when there is none */
int flexible_start(Simulator *rope, State *state, char *message);

/* hang.c: the state at rest, hung up untwisted, turned in and relaxed, then between these ends; 0 and a message when it
   cannot be */
int hang(Simulator *rope, State *state, const EndMotion ends[2], char *message);
void paths_at_rest(const Simulator *rope, State *state, const EndMotion ends[2], double part); /* on the way to there */

/* switching.c */
void release_swivels(Simulator *rope, State *state);
double next_release(const Simulator *rope, const State *state);
/* the trial shortened to end where a swivel must switch: 1; as it was: 0; -1 when that step fails */
int switching_step(Simulator *rope, State *state, StepResult *trial);
void switch_swivels(Simulator *rope, State *state);
int chatters(const State *state);

/* adaptation.c */
/* how Newton's method ended in the last transformation: CONVERGED, or the state is that of no rope */
int transform_if_due(Simulator *rope, State *state);
void with_loop_yaw(State *state);
int raise_fidelity(Simulator *rope, State *state, const char *why, char *message);

/* stepping.c: the state as the rigid model has it at t, or after one accepted step; 0 and a message when there is none
 */
int as_rigid(Simulator *rope, State *state, double t, char *message);
int step_towards(Simulator *rope, State *state, double t_end, char *message);

/* signals.c: the group of a signal, and the function that puts the group's values at their numbers in (SIGNALS) */
typedef struct {
    int number;
    void (*compute)(Simulator *, double *);
} SignalGroup;
SignalGroup group_of(int signal);

/* sensitivity.c: one of these groups */
void added_mass_signals(Simulator *rope, double *values);

#endif
