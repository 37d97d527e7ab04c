/* Operations on a chain of elements, with a table of them for each fidelity: chain_of_fidelity.inc. */
#ifndef CHAIN_H
#define CHAIN_H

#include <stdbool.h>
#include <stddef.h>

#include "formulas.h"
#include "newton.h"
#include "rope.h"
#include "state_structures.h"
#include "system.h"

/* change of an element's angles with its frame: theta from node to node, theta_t and theta_tt at the right node */
enum { THETA, THETA_T, THETA_TT, ROTATIONS };
enum { MAX_LANES = 8 }; /* the last group of elements may have lanes to spare */

/* Operations on a chain of elements at one fidelity: `solve` is FN(solve) of chain_of_fidelity.inc, called
   torsional_solve and so on; the others are FN(...) of that file and of element_sums.inc, as CHAIN in
   chains_of_form.inc lists them. */
typedef struct {
    /* Newton's method: correct q, v, a of `trial` until the residual is zero where free; v and a follow q by c.v and
       c.a.  Its `reaction` holds the last known reactions on input, the residual on output.  The first tangents take
       axial strains from q `before` unless it is NULL. */
    Progress (*solve)(const System *, void *work, const NodalArrays *trial, const TangentCoefficients *c,
                      double tolerance, const double *before, double balance[ENERGIES]);
    /* Solve J x = M change, with J at q, v, a, reaction of `at` and the factors that solve left in `work`. */
    void (*resolve)(const System *, void *work, const NodalArrays *at, const double *change, double *x);
    /* Solve J x = -R at q, v, a, reaction of `at`, on the free degrees of freedom; `factorized` keeps the factors of
       the latest call. */
    void (*newton_step)(const System *, void *work, const NodalArrays *at, const TangentCoefficients *c,
                        bool factorized, double *x, double *R);
    void (*evaluate)(const System *, const double *q, const double *v, const double *a, const double *reaction,
                     double *R, double balance[ENERGIES]); /* R may be NULL */
    void (*losses)(const System *, const double *q, const double *v, double powers[LOSSES]);
    void (*air)(const System *, const double *q, const double *v, double sums[AIR_BALANCE]);
    void (*strains)(const System *, const double *q, const double *v, double (*strains)[STRAINS]);
    /* Momentum with the spin of the swivels; the frames must be referred to q. */
    void (*momentum)(const System *, const double *q, const double *v, double sums[MOMENTUM]);
    /* Refer the system's frames to q. */
    void (*refer)(const System *, const double *q);
    /* Refer the frames to q, and return the change of each element's angles (`transport` of physics.element). */
    void (*transport)(const System *, const double *q, const double *v, const double *a, double (*gained)[ROTATIONS]);
    /* Write the blocks of the tangent J: those of each node, and those of each node (row) with the next (column). */
    void (*blocks)(const System *, void *work, const double *q, const double *v, const double *a,
                   const TangentCoefficients *c, double (*nodes)[DOF][DOF], double (*next)[DOF][DOF]);
    /* Write the frame of each element to the begin of its row, which has `length` numbers. */
    void (*frame_rows)(const System *, size_t length, double *rows);
} Chain;

/* Return the largest entry of x (nodes x DOF) where the rope is free, with r' times `slopes`; infinite if one is not
   finite. */
double chain_norm(const System *sys, const double *x, double slopes);
/* Return the error that Newton's method assumes after its first correction, over that correction; `predicted` is true
   if the correction takes axial strains from the start of the step. */
double assumed_newton_error(const System *sys, double tolerance, bool predicted);
/* Bytes of `work` for a chain of any fidelity, aligned to 64 bytes. */
size_t chain_work_bytes(int elements);
size_t chain_frames_bytes(int elements);
/* Return the chains of the fidelities TORSIONAL to PLANAR, in the fastest form that this processor runs. */
const Chain *fastest_chains(void);

#endif
