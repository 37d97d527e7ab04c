/* Direct solver for symmetric positive definite band matrices. */

#include "banded.h"

#include <stddef.h>

void solve_banded(int rows, int width, double *A, int columns, double *b) {
    const ptrdiff_t row = width + 1;
    for (int i = 0; i < rows; i++)
        for (int k = 1; k <= width && i + k < rows; k++) {
            double *pivot = A + row * i;
            double *below = pivot + row * k;
            double *x = b + (ptrdiff_t)columns * i;
            const double factor = pivot[k] / pivot[0];
            for (int j = k; j <= width; j++) below[j - k] -= factor * pivot[j];
            for (int c = 0; c < columns; c++) x[(ptrdiff_t)columns * k + c] -= factor * x[c];
        }
    for (int i = rows - 1; i >= 0; i--) {
        double *pivot = A + row * i;
        double *x = b + (ptrdiff_t)columns * i;
        const double inverse = 1 / pivot[0];
        for (int k = 1; k <= width && i + k < rows; k++)
            for (int c = 0; c < columns; c++) x[c] -= pivot[k] * x[(ptrdiff_t)columns * k + c];
        for (int c = 0; c < columns; c++) x[c] *= inverse;
    }
}
