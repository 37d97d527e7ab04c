/* The simulator: scene, states, and the memory in which its functions work. */
#ifndef SIMULATOR_H
#define SIMULATOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "chain.h"
#include "communication_step.h"
#include "formulas.h"
#include "loop.h"
#include "obstacles.h"
#include "self_contact.h"
#include "signal_numbers.h"
#include "state_structures.h"

/* Shape to which the element functions refer a state: reference of the frames, permanent curvature, history of the
   wires. It belongs to one state at a time; rope_system_refer and rope_system_adopt make it that of another. */
typedef struct {
    const State *of;      /* the state that it belongs to; a rigid one needs none */
    double *frames;       /* of the elements */
    double *wires;        /* WIRE_ELEMENT_HISTORY_SIZE numbers an element; or NULL */
    double *curved;       /* CURVED_SIZE numbers an element; or NULL */
    double left_slope[3]; /* r' of the left end */
} Reference;

/* Scratch of the simulator's functions, no part of its state. */
typedef struct {
    NodalArrays trial;           /* arrays of the latest trial step */
    double *x;                   /* (nodes x DOF) */
    double (*strains)[STRAINS];  /* of the elements */
    double (*gained)[ROTATIONS]; /* of the elements, from Chain.transport */
    double *wire_tangents;       /* for System.wire_tangents; NULL without friction between wires */
    void *chain;                 /* chain_work_bytes */
} Workspace;

/* Searches for the equilibria of the present start. */
typedef struct {
    int64_t corrections; /* of all of them */
    int64_t solutions;   /* of the chain's equations, for contact of the rope with itself */
    bool turned;         /* true if the latest one turned more than allowed */
} EquilibriumSearch;

struct Simulator {
    Scene scene;
    Memory memory;
    Mesh mesh;           /* never AUTO_MESH */
    const Chain *chains; /* one for each fidelity from TORSIONAL to PLANAR */
    int elements;
    bool initialized;
    size_t state_bytes;
    State *state;
    State *next;   /* an advance works on next; both swap when it succeeds */
    State *spare;  /* scratch, as for the trial whether a swivel sticks */
    State *start;  /* state before the last communication step, if last.taken */
    HostStep last; /* that step */
    Replay replay;
    Workspace work;
    Reference reference;
    Obstacles *obstacles;
    SelfContactState *self_contact;
    PointForces forces;
    double values[SIGNALS];
    unsigned computed_groups; /* bit g: the values of group g belong to the state */
    LoopBottom bottom;
    bool bottom_known;
    int nearest_blocks[2]; /* `pair` of leg_clearance */
    int64_t newton_limit;  /* Newton iterations after which the present advance gives up accuracy */
    EquilibriumSearch search;
    char message[MESSAGE];
};

static inline const Chain *chain_of(const Simulator *sim, const State *state) {
    return sim->chains + (state->fidelity == RIGID ? PLANAR : state->fidelity) - TORSIONAL;
}

#endif
