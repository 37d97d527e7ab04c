/* Contact of the rope with itself. */
#ifndef SELF_CONTACT_H
#define SELF_CONTACT_H

#include <stdbool.h>
#include <stdint.h>

#include "contact_balance.h"
#include "formulas.h"
#include "obstacles.h"
#include "rope.h"
#include "system.h"

/* Two places of the rope in contact. */
typedef struct {
    int elements[2];
    double xi;     /* element coordinate in the second element */
    double weight; /* length of rope that the law acts on, m */
    double N[8];   /* shape functions at both places, those of the second negative */
    ContactTerms terms;
} SelfContact;

/* An element near the present one. */
typedef struct {
    int element;
    double arc_gap;  /* arc length from the end of the present element to its start, m */
    double distance; /* from the present place, m; infinite where its strand has been taken */
    double xi;       /* element coordinate of its nearest place */
} Neighbour;

/* Scratch of find_self_contacts, and of the solution of equations with contacts. */
typedef struct {
    double (*boxes)[6];    /* bounding box of each element */
    Neighbour *neighbours; /* of the present element */
    double *cg;            /* CG_ARRAYS arrays of the size of q, for conjugate gradients */
} SelfContactWork;
enum { CG_ARRAYS = 4 };

/* Contact of the rope with itself: result of find_self_contacts, and its memory. */
typedef struct SelfContactState {
    const Scene *scene;
    bool presses; /* true if contacts act; otherwise there is no memory for them */
    int count;    /* number of contacts */
    SelfContact *contacts;
    double least_distance; /* of centre lines that touch, m; the diameter if none do */
    double least_y;        /* height of that place, m */
    ClearanceCache cache;
    SelfContactWork work;
    int64_t solutions; /* of the chain's equations by conjugate gradients so far */
} SelfContactState;

/* Find contacts of the rope with itself, with tangents along (c_q, c_v) of q and v; return their number. */
int find_self_contacts(const System *sys, const double *q, const double *v, double c_q, double c_v);
void self_contact_take_force(const SelfContactState *self_contact, double *R); /* Subtract forces from R. */
/* Add the product of the tangent with x to y. */
void self_contact_times(const SelfContactState *self_contact, const double *x, double *y);
void self_contact_sums(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]);

#endif
