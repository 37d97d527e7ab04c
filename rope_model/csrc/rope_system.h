/* Equations of motion of a rope, and the forces on it.

   Arrays q, v, a, x and R have DOF entries per node; degrees of freedom that a fidelity omits stay zero. */
#ifndef ROPE_SYSTEM_H
#define ROPE_SYSTEM_H

#include "formulas.h" /* generated, with BALANCE, FRAME_SIZE, STRAINS, MOMENTUM, AIR_BALANCE and CURVATURE_SIZE */

enum { AIR_COEFFICIENTS = 9, AIR_SIZE = AIR_COEFFICIENTS + 2 * 4 };
enum { MAX_LANES = 8 }; /* the last group of elements may have lanes to spare */

typedef struct {
    int status;         /* a NewtonStatus, as CONVERGED */
    int iterations;     /* corrections so far */
    bool applies;       /* true if the latest correction applies */
    double norm;        /* norm of the latest correction that applied */
    double error;       /* error estimate after it */
    double contraction; /* ratio of the latest norms; before the first correction the share of it assumed to remain */
    double sum;         /* sum of the norms of corrections that applied */
} Progress;

typedef struct {
    double rounds, per_round, slow, unsure, growing;
} NewtonLimits;

enum { FIXED = -1, MAX_BODIES = 10 };
typedef struct {
    int kind, moves_with; /* moves_with: LEFT, RIGHT or FIXED */
    Body body;
} Placed;

/* Entries of physics.contact_element.CONTACT_BALANCE, and the pressure of the rope on itself. */
enum { CONTACT_ENERGY, CONTACT_DISSIPATED, CONTACT_MOVED, CONTACT_LOAD, CONTACT_FORCES = CONTACT_LOAD + 6 };
enum { CONTACT_ROPE = CONTACT_FORCES + KINDS, CONTACT_BALANCE };

/* Configuration of the latest contact detection. */
typedef struct {
    double free;         /* lower bound of all distances, m */
    double *q, *lengths; /* copies */
} ClearanceCache;

/* Bodies around the rope. */
typedef struct {
    const Scene *scene;
    int bodies;
    bool any;                  /* true if an element may touch a body */
    Placed placed[MAX_BODIES]; /* bodies at the latest contact detection */
    double speeds[MAX_BODIES][3];
    double margin;  /* lower bound of the distances of elements not in `near`, m */
    double longest; /* longest element, m */
    ClearanceCache cache;
    unsigned *near; /* bodies that each element may touch, one bit each */
} Obstacles;

/* Two places of the rope in contact. */
typedef struct {
    int elements[2];
    double xi;     /* element coordinate in the second element */
    double weight; /* length of rope that the law acts on, m */
    double N[8];   /* shape functions at both places, those of the second negative */
    ContactTerms terms;
} SelfContact;

/* Contact of the rope with itself: result and buffers of find_self_contacts. */
typedef struct {
    const Scene *scene;
    bool presses; /* true if contacts act; otherwise there is no memory for them */
    int count;    /* number of contacts */
    SelfContact *contacts;
    double nearest[2];  /* least distance of centre lines that touch, and its height, m */
    double (*boxes)[6]; /* bounding box of each element */
    int *others;        /* elements near the present one */
    double *arc_gaps;   /* arc length from the end of the present element to each of them, m */
    double *distances;  /* distance of each of them from the present place, m */
    double *xi;         /* element coordinate of the nearest place in each of them */
    double *scratch;    /* CG_ARRAYS arrays of the size of q, for conjugate gradients */
    ClearanceCache cache;
    int64_t solutions; /* of the chain's equations by conjugate gradients so far */
} SelfContactState;
enum { CG_ARRAYS = 4 };

/* Point force on an element. */
typedef struct {
    int element;
    double start; /* arc length where the element begins, m */
    double N[4];  /* shape functions at the place */
    double force[3];
} PointForce;

/* A rope at one instant.  Inner nodes are free and without loads. */
typedef struct {
    int elements;
    bool free[2][DOF]; /* degrees of freedom of the end nodes that are not prescribed */
    const double *lengths;
    double *frames;                 /* reference of the elements' frames, from Chain.refer; aligned to 64 bytes */
    Obstacles *obstacles;           /* NULL without bodies */
    SelfContactState *self_contact; /* NULL without contact of the rope with itself */
    const PointForces *forces;      /* NULL without forces */
    const double *wires;            /* WIRE_HISTORY_SIZE numbers an element; NULL without friction between wires */
    const double *curved;           /* CURVATURE_SIZE numbers an element; NULL without permanent curvature */
    double time;                    /* time at which point forces are evaluated, s */
    double *latest; /* WIRE_TANGENT_SIZE numbers an element, of the latest tangent; scratch, aligned as frames */
    double P[PARAMETERS], air[AIR_COEFFICIENTS]; /* air: AirCoefficients, whose first number is 0 without air */
    double load[2], friction_load[2];            /* moments on theta of the ends; friction per newton of tension */
    bool plumb[2];                               /* ends whose tension is their vertical reaction */
    double inertia[2], shortest;                 /* inertia: of theta at the ends; shortest: element, m */
    int corrections; /* Newton corrections of a step that is taken again; 0: until it converges */
} System;

/* Return the tension at an end, which is plumb or not, from its rows of q and of the reaction. */
static inline double tension_at_end(bool plumb, int side, const double *q, const double *reaction) {
    return plumb ? reaction[1] : tension_along(side ? 1 : -1, q + SLOPE, reaction);
}

/* Operations on a chain of elements at one fidelity. */
typedef struct {
    /* Newton's method: correct q, v, a until R is zero where free; v and a follow q by c[1] and c[2].  R holds the last
       known reactions on input.  The first tangents take axial strains from q `before` unless it is NULL. */
    Progress (*solve)(const System *, void *work, double *q, double *v, double *a, double *R, const double c[3],
                      double tolerance, const double *before, double balance[BALANCE]);
    /* Solve J x = M change with the factors that solve left in `work`. */
    void (*resolve)(const System *, void *work, const double *q, const double *v, const double *a, const double *change,
                    const double *reaction, double *x);
    /* Solve J x = -R on the free degrees of freedom; `factorized` keeps the factors of the latest call. */
    void (*newton_step)(const System *, void *work, const double *q, const double *v, const double *a,
                        const double *reaction, const double c[3], bool factorized, double *x, double *R);
    void (*evaluate)(const System *, const double *q, const double *v, const double *a, const double *reaction,
                     double *R, double balance[BALANCE]); /* R may be NULL */
    void (*losses)(const System *, const double *q, const double *v, double powers[2]);
    void (*air)(const System *, const double *q, const double *v, double sums[AIR_BALANCE]);
    void (*strains)(const System *, const double *q, const double *v, double (*strains)[STRAINS]);
    /* Momentum with the spin of the swivels; the frames must be referred to q. */
    void (*momentum)(const System *, const double *q, const double *v, double sums[MOMENTUM]);
    /* Refer the system's frames to q. */
    void (*refer)(const System *, const double *q);
    /* Refer the frames to q, and return the change of each element's angles (`transport` of physics.element). */
    void (*transport)(const System *, const double *q, const double *v, const double *a, double (*gained)[3]);
    /* Write the blocks of the tangent J: those of each node, and those of each node (row) with the next (column). */
    void (*blocks)(const System *, void *work, const double *q, const double *v, const double *a, const double c[3],
                   double (*nodes)[DOF][DOF], double (*next)[DOF][DOF]);
    /* Write the frame of each element to the begin of its row, which has `length` numbers. */
    void (*frame_rows)(const System *, size_t length, double *rows);
} Chain;

/* contact/bodies.c */
/* Place the bodies of the shaft for rope ends at `ends`; return their number. */
int placed_bodies(const Shaft *shaft, const double *const ends[2], Placed *bodies);
/* Box around a group of elements from `first` on, for body_least_distance; return the element after the group. */
int bodies_group(int elements, const double *lengths, const double *q, int first, double box[6]);

/* contact/point_forces.c */
void elements_at(const System *sys, int index, PointForce *point); /* Advance to a place, in ascending order. */
void nodal_forces(const System *sys, double *R);                   /* Subtract the point forces from R. */
/* Add load and power of the point forces. */
void point_forces_push(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]);
/* Interpolate r, or its speed, in an element with shape functions N. */
static inline void at_places(const double *x, int element, const double N[4], double y[3]) {
    const double *a = x + (size_t)element * DOF, *b = a + DOF;
    for (int i = 0; i < 3; i++) y[i] = N[0] * a[i] + N[1] * a[SLOPE + i] + N[2] * b[i] + N[3] * b[SLOPE + i];
}

/* contact/self_contact.c */
/* Find contacts of the rope with itself, with tangents along (cq, cv) of q and v; return their number. */
int find_self_contacts(const System *sys, const double *q, const double *v, double cq, double cv);
void self_contact_take_force(const SelfContactState *self_contact, double *R); /* Subtract forces from R. */
/* Add the product of the tangent with x to y. */
void self_contact_times(const SelfContactState *self_contact, const double *x, double *y);
void self_contact_sums(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]);

/* contact/shaft.c */
static inline void far_bodies(Nearest nearest[KINDS]) {
    for (int kind = 0; kind < KINDS; kind++) nearest[kind] = (Nearest){.clearance = FAR};
}
/* Find the place of the rope nearest to the bodies of each kind. */
void shaft_clearances(const Scene *scene, const NodalArrays *arrays, double t, Nearest nearest[KINDS]);
/* Update `nearest` where the rope is nearer. */
void shaft_nearer(const Scene *scene, const NodalArrays *arrays, double t, Nearest nearest[KINDS]);

/* contact/obstacles.c */
/* Find the elements that may touch a body, now or after a move by `margin` (m). */
void find_near_bodies(const System *sys, const double *q, const double *v, double margin);
/* Add elements that came near during Newton's corrections, whose norms sum to `corrections`; return true if any did. */
bool add_near_bodies(const System *sys, const double *q, double corrections);
void remember_configuration(const System *sys, ClearanceCache *cache, const double *q);
/* True if no clearance can have fallen below `least` (m) since remember_configuration. */
bool clearance_exceeds(const System *sys, const ClearanceCache *cache, const double *q, double least);

/* numerics/newton.c */
/* Judge a correction of this norm; `fresh` is true if its factorization is new. */
Progress newton_judge(Progress before, double norm, double tolerance, bool fresh, const NewtonLimits *limits);
/* Let the iteration end after that number of corrections. */
Progress newton_repeated(Progress progress, int corrections);

/* physics/contact_element.c; contact forces on r and r' of both nodes; contact_sums adds to its sums */
enum { CONTACT_DOF = 12 };
void contact_residual(const System *sys, int element, const double *q, const double *v, double R[CONTACT_DOF]);
void contact_tangent(const System *sys, int element, const double *q, const double *v, const double c[3],
                     double tangent[CONTACT_DOF][CONTACT_DOF]);
void contact_sums(const System *sys, int element, const double *q, const double *v, double sums[CONTACT_BALANCE]);

/* rope_kernels.c */
/* Bytes of `work` for a chain of any fidelity, aligned to 64 bytes. */
size_t chain_work_bytes(int elements);
size_t chain_frames_bytes(int elements);
/* Return the chains of the fidelities TORSIONAL to PLANAR, in the fastest form that this processor runs. */
const Chain *fastest_chains(void);

/* rope_system.c */
/* Sum the contact of all elements with bodies and of the rope with itself. */
void external_sums(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]);
double longest_near(const System *sys); /* Length of the longest element that may touch a body, m; 0 for none. */
/* Return the largest entry of x where the rope is free, entries of r' times `slopes`; infinite if one is not finite. */
double rope_system_norm(const System *sys, const double *x, double slopes);

#endif
