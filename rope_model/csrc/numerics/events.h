/* Root search for events. */
#ifndef EVENTS_H
#define EVENTS_H

/* Return the right end of an interval, at most `width` wide, in which f changes from negative to nonnegative. */
double locate(double (*f)(void *, double), void *data, double low, double high, double f_low, double f_high,
              double width);

#endif
