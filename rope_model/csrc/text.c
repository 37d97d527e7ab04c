#include "text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Write x if it is not finite; some C libraries print "-nan" or "nan(ind)". */
static int not_finite(char *room, double x) {
    if (isfinite(x)) return 0;
    strcpy(room, isnan(x) ? "nan" : x > 0 ? "inf" : "-inf");
    return 1;
}

/* Replace the comma of some locales. */
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

/* True if the text "d.ddde+xx" reads back as x, or the next text up does: below a power of two, where numbers are twice
   as dense, the nearest text may belong to another number. */
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
