/* The simulator and the functions of the files that make it up. */
#ifndef SIMULATOR_H
#define SIMULATOR_H

#include "rope_system.h"
#include "signal_numbers.h" /* generated */

/* A trial step; its arrays are Simulator.trial. */
typedef struct {
    double t, h;        /* end and length of the step, s */
    double error;       /* local error, by rope_system_norm */
    double strains[2];  /* local error of the strains at the ends */
    double error_ratio; /* largest local error divided by its tolerance */
    double balance[BALANCE];
    bool converged; /* true if Newton's method converged */
    bool near;      /* true if the rope may touch a body */
    Progress newton;
} StepResult;

/* What the host asked for in a communication step.  All members have eight bytes: none is padding. */
typedef struct {
    double stop;       /* time to advance to, s */
    double given_at;   /* instant of the motions, s */
    double asked_at;   /* the same, as the host gave it: motions held through an event keep their first instant */
    EndMotion ends[2]; /* motions */
    int64_t to_event;  /* true if an event ends it */
    int64_t taken;     /* true if it led from Simulator.start to Simulator.state */
} HostStep;

/* Phases of both swivels, and the senses of their slips. */
typedef struct {
    signed char phase[2], sign[2];
} Phases;

/* An internal step: its length and its end, s, Newton's corrections, and the phases in it and after it. */
typedef struct {
    double h, t;
    int corrections;
    Phases during, after;
} TakenStep;
enum { MAX_TAKEN = 4096 }; /* internal steps of a communication step that can be differentiated */

/* The last communication step, to be taken again with other motions of the ends: outputs/sensitivity.c. */
typedef struct {
    bool recording, repeating; /* true while it is recorded, or taken again */
    bool known;                /* true if the rest is that of the last step */
    int count;                 /* number of internal steps */
    int corrections;           /* of the step that is taken again */
    int fidelity;              /* at its end */
    Phases after;              /* at its end */
    double duration;           /* s */
    TakenStep *steps;          /* (MAX_TAKEN) */
    Path paths[2];
    bool at_step_end; /* true if the derivatives are those to inputs of the step's end */
    unsigned derived; /* bit i: the derivatives to input i are known */
    size_t repeats;   /* number of communication steps that were recorded or taken again, since the rope was created */
    double derivatives[2 * END_MOTIONS][2 * 6];
} Replay;

struct Simulator {
    Scene scene;
    Memory memory;
    Mesh mesh;           /* never AUTO_MESH */
    const Chain *chains; /* one for each fidelity from TORSIONAL to PLANAR */
    int elements;
    bool initialized;
    size_t state_bytes;
    State *state, *next; /* an advance works on next; both swap when it succeeds */
    State *spare;        /* scratch, as for the trial whether a swivel sticks */
    State *start;        /* state before the last communication step, if last.taken */
    HostStep last;       /* that step */
    Replay replay;
    NodalArrays trial;          /* arrays of the latest trial step; scratch otherwise */
    double *x;                  /* scratch (nodes x DOF) */
    double (*strains)[STRAINS]; /* scratch */
    double (*gained)[3];        /* scratch, for Chain.transport */
    double *frames;             /* of the elements in the state, or during an advance in the state in progress */
    double *wires;              /* WIRE_HISTORY_SIZE numbers an element, of the same state as frames; or NULL */
    double *curved;             /* CURVATURE_SIZE numbers an element, of the same state as frames; or NULL */
    double left_slope[3];       /* r' of the left end where frames and curved belong */
    double *latest;             /* friction of the wires at the last tangent, see System.latest; or NULL */
    void *work;                 /* scratch of the chain */
    Obstacles *obstacles;
    SelfContactState *self_contact;
    PointForces forces;
    double values[SIGNALS];
    unsigned computed_groups; /* bit g: the values of group g belong to the state */
    LoopBottom bottom;
    bool bottom_known;
    int nearest_blocks[2]; /* nearest_blocks: `pair` of leg_clearance */
    int64_t newton_limit;  /* Newton iterations after which the present advance gives up accuracy */
    int64_t corrections;   /* Newton corrections of all equilibria of the present start */
    int64_t solutions;     /* and solutions of the chain's equations for contact of the rope with itself */
    bool turned;           /* true if the latest equilibrium turned more than allowed */
    char message[MESSAGE];
};

static inline const Chain *chain_of(const Simulator *sim, const State *state) {
    return sim->chains + (state->fidelity == RIGID ? PLANAR : state->fidelity) - TORSIONAL;
}

/* Below, functions with a message return 0 on failure. */

/* contact/shaft.c */
/* Record clearances and passages of the rope at the state's time. */
void update_passages(const Simulator *sim, State *state);

/* curvature.c */
bool is_curved(const Simulator *sim, const State *state);
Rope partly_curved(const Rope *whole, double fraction); /* The rope with a fraction of its permanent curvature. */
/* Carry e1 of the left end from r' = before to r' = after. */
void carry_director(State *state, const double *before, const double *after);
void start_director(State *state, const double *q); /* Set e1 of the left end of a rope q that is hung up. */
void curved_reference(Simulator *sim, State *state, const double *q); /* Refer the permanent curvature to q. */

/* ends/switching.c */
void release_swivels(Simulator *sim, State *state);
double next_release(const Simulator *sim, const State *state);
/* Shorten the trial to end where a swivel must switch.  Return 1 if it was shortened, 0 if not, -1 on failure. */
int switching_step(Simulator *sim, State *state, StepResult *trial);
void switch_swivels(Simulator *sim, State *state);
Phases phases_of(const State *state);
/* Set the phases of swivels, which hold where they are, and restart unless nothing changes. */
void set_phases(Simulator *sim, State *state, const Phases *phases);
bool chatters(const State *state);

/* memory.c */
/* Allocate a simulator of the scene, zero except for its pointers. */
Simulator *allocate_simulator(const Scene *scene, int elements, const Memory *memory, char *message);

/* mesh/adaptation.c */
/* Transform the mesh as often as due; return the status of Newton's method.  The state is void unless CONVERGED. */
int transform_if_due(Simulator *sim, State *state);
void update_loop_yaw(State *state);
int raise_fidelity(Simulator *sim, State *state, const char *why, char *message);

/* model.c */
StepResult model_trial(Simulator *sim, State *state, double h);
void model_restart(Simulator *sim, State *state);
double largest_end_force(const NodalArrays *nodal); /* Return the largest component, N. */
void model_commit(Simulator *sim, State *state, const StepResult *trial);
void model_powers(const Simulator *sim, State *state);
double model_energies(Simulator *sim, State *state); /* Update energies; return the change of their total. */
/* Return the arc length of the loop's lowest point from the heights of the ends at t. */
double model_bottom_s(const Simulator *sim, const Path paths[2], double t);
/* Call mesh_dividers with the heights of the ends at t. */
void model_dividers(const Simulator *sim, const Path paths[2], double t, double *divider_s);
/* Refer frames and angles of q, v, a, b to q. */
void update_angles(Simulator *sim, State *state, double *q, double *v, double *a, double *b);
void begin_audit(const Simulator *sim, State *state);
/* Audit a communication step of length h; residual_before is the residual of the energy balance at its start. */
void audit_interval(const Simulator *sim, State *state, double h, double residual_before);

/* numerics/generalized_alpha.c */
StepResult generalized_alpha_step(Simulator *sim, State *state, System *sys, double h); /* Step into sim->trial. */
void generalized_alpha_restart(Simulator *sim, State *state, const System *sys);
/* Return the time by which b is moved when a step h follows one of length `before` (0 after a restart). */
double recentring(const Coefficients *method, double h, double before);

/* outputs/sensitivity.c */
void added_mass_signals(Simulator *sim, double *values); /* compute of a SignalGroup */

/* outputs/signals.c */
typedef struct {
    int index;
    void (*compute)(Simulator *, double *); /* writes the values of the group into (SIGNALS) */
} SignalGroup;
SignalGroup group_of(int signal);

/* rigid.c */
/* Set q, v, a and reaction from equilibria between the moving ends, referred to the rigid rope. */
int flexible_start(Simulator *sim, State *state, char *message);

/* rope_system.c */
System rope_system(const Simulator *sim, State *state);
void rope_system_refer(Simulator *sim, State *state, const double *q); /* Refer frames, curvature, wires to q. */
/* Refer frames and angles to q; return the change of theta at the right end. */
double rope_system_transport(Simulator *sim, State *state, double *q, double *v, double *a, double *b);
/* Set prescribed entries at t of q, v and a in x, or of the first `orders` of them. */
void rope_system_prescribed_motion(const Simulator *sim, const State *state, const System *sys, double t, int orders,
                                   double *const x[]);
void rope_system_strains(Simulator *sim); /* Strains of the present state, into sim->strains. */

/* stepping/host_step.c */
/* Take the host's step from sim->state to sim->next.  *event becomes true if an event has ended it. */
int take_host_step(Simulator *sim, const HostStep *host, int *event);

/* state.c */
/* True if the step can have led from `start` to `state`. */
bool host_step_plausible(const HostStep *host, const State *start, const State *state);
/* True if restored bytes can be a state of this rope.  Overwrites sim->trial. */
bool state_plausible(const Simulator *sim, State *state);
void state_copy(const Simulator *sim, State *to, const State *from);
/* Copy q, v, a, b, a_rate and reaction. */
void copy_fields(const NodalArrays *to, const NodalArrays *from);
void record_event(State *state, int what, int which, double kinetic, double potential);

/* stepping/events.c */
/* Return the right end of an interval, at most `width` wide, in which f changes from negative to nonnegative. */
double locate(double (*f)(void *, double), void *data, double low, double high, double f_low, double f_high,
              double width);

/* stepping/hang.c */
/* Hang the rope at rest, untwisted; then twist it, relax it, and move the ends to `ends`. */
int hang(Simulator *sim, State *state, const EndMotion ends[2], char *message);
/* Let the free swivels of a rope at rest turn, and bring it to rest again. */
int let_turn(Simulator *sim, State *state, char *message);
/* Set paths at rest, a fraction `placed` of the way to `ends`. */
void paths_at_rest(const Simulator *sim, State *state, const EndMotion ends[2], double placed);

/* stepping/statics.c */
/* Set q to an equilibrium, reaction to its residual.  Fail if theta turns by over max_turn (rad) at the right end. */
int find_equilibrium(Simulator *sim, State *state, double max_turn, char *message);

/* stepping/stepping.c */
int as_rigid(Simulator *sim, State *state, double t, char *message);         /* Move the rigid model to t. */
int step_towards(Simulator *sim, State *state, double t_end, char *message); /* Take one accepted step. */
/* Take the recorded step of the replay again, from a state nearby. */
int repeat_step(Simulator *sim, State *state, const TakenStep *step, char *message);

/* wires.c; nothing changes unless wires rub */
/* Start friction between wires, with z = 0, if the rope has it and is not rigid; return true if it started. */
bool start_hysteresis(const Simulator *sim, State *state);
/* Set the history from q and the state's z. */
void wires_history(Simulator *sim, State *state, const double *q, double (*strains)[STRAINS]);
/* Update z to q; return the dissipated energy, J. */
double update_hysteresis(Simulator *sim, State *state, const double *q);
/* Transfer z from the mesh with nodes at old_s to the state's mesh. */
void wires_carry(Simulator *sim, State *state, const double *old_s);

#endif
