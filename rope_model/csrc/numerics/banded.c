/* Banded systems of equations: rope_model.numerics.banded. */

#include "core.h"

void solve_banded(int rows, int width, double *A, int columns, double *b) {
    const ptrdiff_t row = width + 1;
    for (int i = 0; i < rows; i++)
        for (int k = 1; k <= width && i + k < rows; k++) {
            double *own = A + row * i, *below = own + row * k, *x = b + (ptrdiff_t)columns * i;
            const double factor = own[k] / own[0];
            for (int j = k; j <= width; j++) below[j - k] -= factor * own[j];
            for (int c = 0; c < columns; c++) x[(ptrdiff_t)columns * k + c] -= factor * x[c];
        }
    for (int i = rows - 1; i >= 0; i--) {
        double *own = A + row * i, *x = b + (ptrdiff_t)columns * i;
        const double inverse = 1 / own[0];
        for (int k = 1; k <= width && i + k < rows; k++)
            for (int c = 0; c < columns; c++) x[c] -= own[k] * x[(ptrdiff_t)columns * k + c];
        for (int c = 0; c < columns; c++) x[c] *= inverse;
    }
}
