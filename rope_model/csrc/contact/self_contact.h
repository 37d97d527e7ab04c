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

/* Contact of the rope with itself: result and buffers of find_self_contacts. */
typedef struct SelfContactState {
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

/* Find contacts of the rope with itself, with tangents along (c_q, c_v) of q and v; return their number. */
int find_self_contacts(const System *sys, const double *q, const double *v, double c_q, double c_v);
void self_contact_take_force(const SelfContactState *self_contact, double *R); /* Subtract forces from R. */
/* Add the product of the tangent with x to y. */
void self_contact_times(const SelfContactState *self_contact, const double *x, double *y);
void self_contact_sums(const System *sys, const double *q, const double *v, double sums[CONTACT_BALANCE]);

#endif
