/* rope_model.parameter_table: the bounds of every parameter; the first that is broken gives the message. */
#include <math.h>
#include <stdio.h>

#include "core.h"
#include "text.h"

typedef struct {
    const char *group; /* "" for none */
    char *message;
} Check;

static void refuse(const Check *check, const char *what, const char *value, const char *bound, const char *cure) {
    if (!check->message[0])
        snprintf(check->message, MESSAGE, "%s%s%s = %s is out of range: it must be %s; %s", check->group,
                 check->group[0] ? ": " : "", what, value, bound, cure);
}

static void require_finite(const Check *check, const char *what, double x) {
    if (!isfinite(x)) refuse(check, what, EXACT(x), "finite", "give a number");
}

static void real(const Check *check, const char *what, double x, double lower, double upper, const char *bound,
                 const char *cure) {
    if (!(lower <= x && x <= upper)) refuse(check, what, EXACT(x), bound, cure);
}

static void whole(const Check *check, const char *what, int x, double lower, double upper, const char *bound,
                  const char *cure) {
    if (!(lower <= x && x <= upper)) refuse(check, what, ROUNDED(x, 10), bound, cure);
}

static void choice(const Check *check, const char *what, int code, int last, const char *choices) {
    if ((code < 0 || code > last) && !check->message[0])
        snprintf(check->message, MESSAGE, "%s.%s = %d is none of the choices: %s", check->group, what, code, choices);
}

/* a bound with a number in it, that of another parameter */
static const char *joined(char room[96], const char *before, double x, const char *behind) {
    snprintf(room, 96, "%s%s%s", before, EXACT(x), behind);
    return room;
}

#define JOINED(before, x, behind) joined((char[96]){0}, before, x, behind)

static void check_coupling(const Check *check, const Rope *rope) {
    double Qs = 0.5 * (rope->Qb + rope->Qc), bound = sqrt(rope->Qa * rope->Qd);
    char below[96];
    snprintf(below, sizeof below, "below sqrt(Qa Qd) = %s N m in size", ROUNDED(bound, 4));
    if (!(fabs(Qs) < bound))
        refuse(check, "(Qb + Qc) / 2", EXACT(Qs), below,
               "or the strain energy is not positive: check Qb, Qc, Qa and Qd");
}

static void check_sticking(const Check *check, const Rope *rope) {
    if (!(rope->EI_stick == 0 || rope->EI_stick > rope->EI))
        refuse(check, "EI_stick", EXACT(rope->EI_stick), JOINED("0 or above EI = ", rope->EI, " N m2"),
               "use 0 for no friction between the wires; EI is that of wires that slide");
}

static void check_counts(const Check *check, const Mesh *mesh) {
    static const char *const segments[] = {"II", "III", "IV", "V", "VI"};
    const int *n = mesh->counts;
    const int multiples[] = {2, 4, 2 << ((n[0] > 0) + (n[1] > 0)), 4, 2};
    for (int i = 0; i < 5; i++) {
        int count = n[i], multiple = multiples[i], fine = i == 2;
        char what[40], bound[40];
        snprintf(what, sizeof what, "element count of segment %s", segments[i]);
        snprintf(bound, sizeof bound, "a %smultiple of %d", fine ? "positive " : "", multiple);
        if (count < (fine ? multiple : 0) || count % multiple != 0)
            refuse(check, what, ROUNDED(count, 10), bound,
                   "a transformation moves whole coarse elements through the segment");
    }
    char given[80];
    snprintf(given, sizeof given, "(%d, %d, %d, %d, %d)", n[0], n[1], n[2], n[3], n[4]);
    if ((n[0] > 0) != (n[4] > 0) || (n[1] > 0) != (n[3] > 0) || (n[0] == 0 && n[1] != 0))
        refuse(check, "counts", given, "all five segments, or none in III and V, or none in II and VI too",
               "the pattern is the same on both sides and leaves out no length");
}

#include "parameters.inc" /* check_scene, and check_rope and so on, a function for each group: generated */

void mesh_in_bounds(const Mesh *mesh, char *message) {
    message[0] = '\0';
    check_mesh(&(Check){"", message}, mesh);
}
