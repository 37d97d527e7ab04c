/* Root search for events. */
#ifndef EVENTS_H
#define EVENTS_H

#include "formulas.h"

/* Return the right end of an interval, at most `width` wide, in which f changes from negative to nonnegative. `bracket`
   has the ends of the interval to search, and f there. */
double locate(double (*f)(void *, double), void *data, Bracket bracket, double width);

#endif
