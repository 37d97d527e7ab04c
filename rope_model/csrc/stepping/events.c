/* Where a function of time first leaves the negative side: rope_model.simulation.stepping.events. */

#include "simulator.h"

double locate(double (*f)(void *, double), void *with, double low, double high, double f_low, double f_high,
              double width) {
    Bracket at = {low, high, f_low, f_high, 0, 0};
    while (at.high - at.low > width) {
        const double x = trial_place(&at, width);
        if (!(at.low < x && x < at.high)) break;
        at = narrowed(&at, x, f(with, x));
    }
    return at.high;
}
