/* Direct solver for symmetric positive definite band matrices. */
#ifndef BANDED_H
#define BANDED_H

/* Solve A x = b in place for all columns of b (rows x columns).  A is symmetric, positive definite and overwritten; a
   row (width + 1) holds the diagonal and the entries right of it. */
void solve_banded(int rows, int width, double *A, int columns, double *b);

#endif
