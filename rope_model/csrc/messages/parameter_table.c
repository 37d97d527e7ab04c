/* Bounds of the parameters; the first violation gives the message. Formulas and tables:
   rope_model/parameter_table.py. */

#include "parameter_table.h"

#include <math.h>
#include <stdio.h>

#include "rope.h"
#include "text.h"

typedef struct {
    const char *group; /* "" for none */
    char *message;
} Check;

static void refuse(const Check *check, const char *name, const char *value, const char *bound, const char *cure) {
    if (!check->message[0])
        snprintf(check->message, MESSAGE, "%s%s%s = %s is out of range: it must be %s; %s", check->group,
                 check->group[0] ? ": " : "", name, value, bound, cure);
}

static void require_finite(const Check *check, const char *name, double x) {
    if (!isfinite(x)) refuse(check, name, EXACT(x), "finite", "give a number");
}

static void real(const Check *check, const char *name, double x, double lower, double upper, const char *bound,
                 const char *cure) {
    if (!(lower <= x && x <= upper)) refuse(check, name, EXACT(x), bound, cure);
}

static void whole(const Check *check, const char *name, int x, double lower, double upper, const char *bound,
                  const char *cure) {
    if (!(lower <= x && x <= upper)) refuse(check, name, ROUNDED(x, 10), bound, cure);
}

static void choice(const Check *check, const char *name, int code, int last, const char *choices) {
    if ((code < 0 || code > last) && !check->message[0])
        snprintf(check->message, MESSAGE, "%s.%s = %d is none of the choices: %s", check->group, name, code, choices);
}

/* Join the text of a bound that contains a number. */
static const char *joined(char buffer[96], const char *before, const char *number, const char *behind) {
    snprintf(buffer, 96, "%s%s%s", before, number, behind);
    return buffer;
}

#define JOINED(before, number, behind) joined((char[96]){0}, before, number, behind)

#include "parameters.inc" /* generated: check_scene, and a function for each group, as check_rope */

RopeStatus require_in_bounds(const Mesh *mesh, char *message) {
    message[0] = '\0';
    check_mesh(&(Check){"", message}, mesh);
    return message[0] ? ROPE_FAILED : ROPE_DONE;
}
