/* Root search for events: the instant at which a function of time first leaves the negative side.

   It is the regula falsi with the Illinois modification. It bisects after two rounds in a row that do not halve
   the interval, or where a value is infinite (the function may be kinked). */

#include "events.h"

#include "formulas.h"

double locate(double (*f)(void *, double), void *data, Bracket bracket, double width) {
    while (bracket.high - bracket.low > width) {
        const double x = events_trial_x(&bracket, width);
        if (!(bracket.low < x && x < bracket.high)) break;
        bracket = events_narrowed_bracket(&bracket, x, f(data, x));
    }
    return bracket.high;
}
