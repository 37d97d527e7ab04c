#include "text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* some libraries write "-nan" or "nan(ind)" */
static int not_finite(char *room, double x) {
    if (isfinite(x)) return 0;
    strcpy(room, isnan(x) ? "nan" : x > 0 ? "inf" : "-inf");
    return 1;
}

/* the locale may put a comma */
static const char *with_point(char *room) {
    char *comma = strchr(room, ',');
    if (comma) *comma = '.';
    return room;
}

const char *text_number(char room[NUMBER], double x, int digits) {
    if (not_finite(room, x)) return room;
    snprintf(room, NUMBER, "%.*g", digits, x);
    return with_point(room);
}

/* Whether room, "d.ddde+xx", is x.  Below a power of two the numbers are twice as dense: there the nearest text may be
   another number's, and the next text up is tried. */
static int reads_back(char *room, double x) {
    char *last = strchr(room, 'e') - 1;
    if (strtod(room, NULL) == x) return 1;
    if (*last == '9') return 0;
    ++*last;
    return strtod(room, NULL) == x;
}

const char *text_exact(char room[NUMBER], double x) {
    int decimals = 0, exponent;
    if (not_finite(room, x)) return room;
    do snprintf(room, NUMBER, "%.*e", decimals, x);
    while (!reads_back(room, x) && ++decimals < 17);
    exponent = atoi(strchr(room, 'e') + 1);
    if (exponent >= -4 && exponent < 16) {
        decimals = decimals - exponent;
        snprintf(room, NUMBER, "%.*f", decimals > 1 ? decimals : 1, x);
    }
    return with_point(room);
}
