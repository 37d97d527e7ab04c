/* The equations of motion of a rope, and what acts on it: rope_model.simulation.rope_system and contact.  Arrays have
   DOF entries a node; what a fidelity leaves out stays zero. */
#ifndef ROPE_SYSTEM_H
#define ROPE_SYSTEM_H

#include "formulas.h"

enum {
    BALANCE = 7,
    FRAME = 21,
    STRAINS = 3,
    MOMENTUM = 9,
    AIR_LAW = 9,
    AIR = AIR_LAW + 2 * 4,
    AIR_BALANCE = 7,
    CURVED = 12,
    MOST_LANES = 8 /* the last group of elements may have lanes to spare */
};
/* of physics.element.BALANCE, without the powers, which are the losses */
enum { AXIAL, COUPLING, TORSION, BENDING, KINETIC, SPIN, GRAVITY };

/* of numerics.newton.NewtonStatus */
enum { TOO_MANY, CONVERGED, DIVERGED, NOT_FINITE };

typedef struct {
    int status, iterations, applies; /* applies: whether the latest correction does */
    /* contraction: before the first correction the share of it that is reckoned as left; sum: of the norms of all that
       did apply */
    double norm, error, contraction, sum;
} Progress;

typedef struct {
    double rounds, per_round, slow, unsure, growing;
} NewtonLimits;

/* newton.c: after a correction of this norm; fresh: whether its factorization is new */
Progress newton_judge(Progress before, double norm, double tolerance, int fresh, const NewtonLimits *limits);

enum { FIXED = -1, MOST_BODIES = 10 };
typedef struct {
    int kind, moves_with; /* LEFT or RIGHT, or FIXED */
    Body body;
} Placed;
/* bodies.c: the bodies that are there with the rope's ends at these places: their number */
int placed_bodies(const Shaft *shaft, const double *const ends[2], Placed *bodies);
/* the box around some elements from first on, as body_least_distance takes it; the element behind the last of them */
int bodies_group(int elements, const double *lengths, const double *q, int first, double box[6]);

/* shaft.c: where the rope is nearest to the bodies of each kind now */
void shaft_clearances(const Scene *scene, const Arrays *arrays, double t, Nearest nearest[KINDS]);
/* the same where that is nearer than `nearest` says */
void shaft_nearer(const Scene *scene, const Arrays *arrays, double t, Nearest nearest[KINDS]);

static inline void far_bodies(Nearest nearest[KINDS]) {
    for (int kind = 0; kind < KINDS; kind++) nearest[kind] = (Nearest){.clearance = FAR};
}

/* of physics.contact_element.CONTACT_BALANCE */
enum {
    CONTACT_ENERGY,
    CONTACT_DISSIPATED,
    CONTACT_MOVED,
    CONTACT_LOAD,
    CONTACT_FORCES = CONTACT_LOAD + 6,
    CONTACT_ROPE = CONTACT_FORCES + KINDS, /* the pressure of the rope on itself */
    CONTACT_BALANCE
};

/* the rope where it was last looked at: q and lengths as they were, free: how far at least all was then, in m */
typedef struct {
    double free, *q, *lengths;
} ClearanceCache;

/* the bodies around the rope: where they were last looked for, their speeds, and of each element which it may touch, as
   bits; any: whether there are such.  longest: element then, margin: how far at least what is not near was from all
   elements at the latest look, made or spared, in m */
typedef struct {
    const Scene *scene;
    int bodies, any;
    Placed placed[MOST_BODIES];
    double speeds[MOST_BODIES][3], margin, longest;
    ClearanceCache seen;
    unsigned *near;
} Surroundings;

/* Two places of the rope that press each other. */
typedef struct {
    int elements[2];
    double place;  /* element coordinate in the second element */
    double weight; /* length of rope that the law acts on, m */
    double N[8];   /* shape functions at both places, those of the second negative */
    Touch law;
} SelfContact;

/* Contact of the rope with itself: result and buffers of find_self_contacts. */
typedef struct {
    const Scene *scene;
    int presses; /* whether contacts act; otherwise there is no memory for them */
    int number;
    SelfContact *touches;
    double nearest[2];  /* least distance of centre lines that touch, and its height, m */
    double (*boxes)[6]; /* around each element */
    int *others;        /* elements near the present one */
    double *ways;       /* arc length from the end of the present element to each of them, m */
    double *distances;  /* from the present place to each of them, m */
    double *where;      /* element coordinate of the nearest place in each of them */
    double *scratch;    /* CG_ARRAYS arrays of the size of q, for conjugate gradients */
    ClearanceCache seen;
} SelfContactState;
enum { CG_ARRAYS = 4 };

/* Inner nodes are free and bare; an end node has its free degrees of freedom, and a load, a friction load (load per
   newton of the node's own upward reaction) and an inertia on theta.  frames, aligned to 64 bytes, are what the
   elements' frames are counted from, as `refer` of the chain wrote them.  around: NULL where there are no bodies,
   own: NULL where the rope does not press itself.  forces, at `time`: NULL where there are none.
   air: the numbers of physics.air.AirLaw, the first 0 where there is none.  wires: physics.wire_element.HISTORY of each
   element, NULL where no wires rub; latest: WIRE_LATEST of each, where their latest tangent was, scratch as frames are.
   curved: physics.curved_element.CURVED numbers of each element, NULL of a rope without permanent curvature. */
typedef struct {
    int elements, free[2][DOF];
    const double *lengths;
    double *frames;
    Surroundings *around;
    SelfContactState *own;
    const PointForces *forces;
    const double *wires, *curved;
    double time, *latest, P[PARAMETERS], air[AIR_LAW], load[2], friction_load[2], inertia[2], shortest;
} System;

typedef struct {
    /* q, v, a move until R, the last known reactions on input, is zero where free; v and a follow by c[1], c[2].  The
       first tangents have the axial strains of the q `before`, if there is one */
    Progress (*solve)(const System *, void *work, double *q, double *v, double *a, double *R, const double c[3],
                      double tolerance, const double *before, double balance[BALANCE]);
    /* J x = M a with the J that solve was left with, work as it left it */
    void (*resolve)(const System *, void *work, const double *q, const double *v, const double *a, const double *change,
                    const double *known, double *x);
    /* J x = -R on the free degrees of freedom; factorized: J is as the latest call left it */
    void (*newton_step)(const System *, void *work, const double *q, const double *v, const double *a,
                        const double *known, const double c[3], int factorized, double *x, double *R);
    /* R may be NULL */
    void (*evaluate)(const System *, const double *q, const double *v, const double *a, const double *known, double *R,
                     double balance[BALANCE]);
    void (*losses)(const System *, const double *q, const double *v, double powers[2]);
    /* of physics.air.AIR_BALANCE */
    void (*air)(const System *, const double *q, const double *v, double sums[AIR_BALANCE]);
    void (*strains)(const System *, const double *q, double (*strains)[STRAINS]);
    /* of physics.element.MOMENTUM, q being what the frames are counted from; with the spin of what turns at the ends */
    void (*momentum)(const System *, const double *q, const double *v, double sums[MOMENTUM]);
    /* the frames of the system are counted from q from now on */
    void (*refer)(const System *, const double *q);
    /* the same, and what the angles gain by it: each element's `transport` of physics.element */
    void (*transport)(const System *, const double *q, const double *v, const double *a, double (*gained)[3]);
} Chain;

/* contact/surroundings.c */
/* Find the elements that may touch a body, now or after a move by `margin` (m). */
void find_near_bodies(const System *s, const double *q, const double *v, double margin);
/* Add elements that came near during Newton's corrections, the sum of whose norms is given; return whether any did. */
int add_near_bodies(const System *s, const double *q, double corrections);
/* Remember the configuration, and tell later whether no clearance can have fallen below `least` (m) since. */
void remember_configuration(const System *s, ClearanceCache *seen, const double *q);
int clearance_exceeds(const System *s, const ClearanceCache *seen, const double *q, double least);

/* physics/contact_element.c: contact forces on an element, whose nodes' r and r' are twelve numbers */
enum { CONTACT_DOF = 12 };
void contact_residual(const System *s, int element, const double *q, const double *v, double R[CONTACT_DOF]);
void contact_tangent(const System *s, int element, const double *q, const double *v, const double c[3],
                     double tangent[CONTACT_DOF][CONTACT_DOF]);
/* added to the sums */
void contact_sums(const System *s, int element, const double *q, const double *v, double sums[CONTACT_BALANCE]);

/* contact/point_forces.c */
/* A place with a force. */
typedef struct {
    int element;
    double start; /* arc length where the element begins, m */
    double N[4];  /* shape functions at the place */
    double force[3];
} Pushed;
/* Go on to a place, which is not before the previous one. */
void elements_at(const System *s, int number, Pushed *at);
/* to R; and what they do as a load, and their power */
void nodal_forces(const System *s, double *R);
void point_forces_push(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]);
/* r (or its speed) at a place of an element */
static inline void at_places(const double *x, int element, const double N[4], double y[3]) {
    const double *a = x + (size_t)element * DOF, *b = a + DOF;
    for (int i = 0; i < 3; i++) y[i] = N[0] * a[i] + N[1] * a[SLOPE + i] + N[2] * b[i] + N[3] * b[SLOPE + i];
}

/* self_contact.c: where the rope touches itself, and how often it presses there, with tangents along (cq, cv) of q and
 * v */
int find_self_contacts(const System *s, const double *q, const double *v, double cq, double cv);
/* to R, and the product of the tangent with x to y */
void self_contact_take_force(const SelfContactState *own, double *R);
void self_contact_times(const SelfContactState *own, const double *x, double *y);
void self_contact_sums(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]);

/* rope_system.c: of bodies and of the rope with itself, all elements, where they are */
void rope_system_outside(const System *s, const double *q, const double *v, double sums[CONTACT_BALANCE]);
/* the longest of the elements that may touch a body, m; 0 for none */
double longest_near(const System *s);
/* the largest of the numbers x (nodes x DOF) where the rope is free, those of r' times `slopes`; infinite when one is
   no number */
double rope_system_norm(const System *s, const double *x, double slopes);

/* rope_kernels.c: bytes of work that a chain of so many elements needs, whatever the fidelity; aligned to 64 bytes */
size_t chain_work_bytes(int elements);
/* bytes of the frames of so many elements */
size_t chain_frames_bytes(int elements);
/* of the fidelities TORSIONAL to PLANAR, in the fastest form that this processor runs */
const Chain *fastest_chains(void);

#endif
