/* Numbers in messages: the C library's text, made that of Python. */

#include "text.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_DECIMALS = 16 }; /* of a double in scientific notation */

/* Write x if it is not finite; some C libraries print "-nan" or "nan(ind)". */
static bool not_finite(char *buffer, double x) {
    if (isfinite(x)) return false;
    strcpy(buffer, isnan(x) ? "nan" : x > 0 ? "inf" : "-inf");
    return true;
}

/* Put a point for the decimal separator, of one or more bytes, of the host's locale. */
static const char *with_point(char *buffer) {
    char *at = buffer + strspn(buffer, "+-0123456789eE.");
    if (!*at) return buffer;
    const char *rest = at + 1 + strcspn(at + 1, "0123456789eE");
    *at = '.';
    memmove(at + 1, rest, strlen(rest) + 1);
    return buffer;
}

const char *text_number(char buffer[NUMBER], double x, int digits) {
    if (not_finite(buffer, x)) return buffer;
    snprintf(buffer, NUMBER, "%.*g", digits, x);
    return with_point(buffer);
}

/* True if the text "d.ddde+xx" reads back as x, or the next text up does: below a power of two, where numbers are twice
   as dense, the nearest text may belong to another number. */
static bool reads_back(char *buffer, double x) {
    char *last = strchr(buffer, 'e') - 1;
    if (strtod(buffer, NULL) == x) return true;
    if (*last == '9') return false;
    ++*last;
    return strtod(buffer, NULL) == x;
}

const char *text_exact(char buffer[NUMBER], double x) {
    int decimals = 0;
    if (not_finite(buffer, x)) return buffer;
    snprintf(buffer, NUMBER, "%.*e", decimals, x);
    while (!reads_back(buffer, x) && decimals < MAX_DECIMALS) snprintf(buffer, NUMBER, "%.*e", ++decimals, x);
    const int exponent = atoi(strchr(buffer, 'e') + 1);
    if (exponent >= -4 && exponent < 16) {
        decimals = decimals - exponent;
        snprintf(buffer, NUMBER, "%.*f", decimals > 1 ? decimals : 1, x);
    }
    return with_point(buffer);
}

const char *text_short(char buffer[NUMBER], double x) {
    text_exact(buffer, x);
    char *point = strchr(buffer, '.');
    if (point && !strcmp(point, ".0")) *point = '\0';
    return buffer;
}

void copy_text(char *to, size_t room, const char *from) {
    size_t length = strlen(from);
    if (length >= room) {
        length = room - 1;
        while (length && ((unsigned char)from[length] & 0xC0) == 0x80) length--; /* a character's later bytes */
    }
    memcpy(to, from, length);
    to[length] = '\0';
}
