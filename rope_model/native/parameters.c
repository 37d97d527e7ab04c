/* rope_model.parameter_table: the bounds of every parameter; the first that is broken gives the message. */
#include <math.h>
#include <stdio.h>

#include "core.h"
#include "text.h"

typedef struct {
    const char *name;
    enum { REAL, WHOLE, CHOICE } kind;
    int at; /* its offset in the structure of the group */
    double lower, upper;
    int lower_at, upper_at;            /* offset of the real number that is the bound, or NONE */
    const char *bound, *behind, *cure; /* between bound and behind stands that number */
} Parameter;

enum { NONE = -1 };

#include "parameters.inc" /* a table for each group: generated */

typedef struct {
    const char *group; /* "" for none */
    char *message;
} Check;

static void require(const Check *check, int ok, const char *what, const char *value, const char *bound,
                    const char *cure) {
    if (!ok && !check->message[0])
        snprintf(check->message, MESSAGE, "%s%s%s = %s is out of range: it must be %s; %s", check->group,
                 check->group[0] ? ": " : "", what, value, bound, cure);
}

static void real(const Check *check, int ok, const char *what, double x, const char *bound, const char *cure) {
    if (!ok) require(check, ok, what, EXACT(x), bound, cure);
}

static void whole(const Check *check, int ok, const char *what, int x, const char *bound, const char *cure) {
    char value[NUMBER];
    snprintf(value, sizeof value, "%d", x);
    require(check, ok, what, value, bound, cure);
}

static void choice(const Check *check, const Parameter *p, int code) {
    if ((code < 0 || code > p->upper) && !check->message[0])
        snprintf(check->message, MESSAGE, "%s.%s = %d is none of the choices: %s", check->group, p->name, code,
                 p->bound);
}

static double real_at(const void *group, int at) {
    return *(const double *)((const char *)group + at);
}

static int whole_at(const void *group, int at) {
    return *(const int *)((const char *)group + at);
}

static void check_bounds(const Check *check, const Parameter *p, const void *group) {
    const double lower = p->lower_at == NONE ? p->lower : real_at(group, p->lower_at);
    const double upper = p->upper_at == NONE ? p->upper : real_at(group, p->upper_at);
    const int other = p->lower_at == NONE ? p->upper_at : p->lower_at;
    char bound[96];
    snprintf(bound, sizeof bound, "%s%s%s", p->bound, other == NONE ? "" : EXACT(real_at(group, other)), p->behind);
    if (p->kind == REAL) {
        const double x = real_at(group, p->at);
        real(check, lower <= x && x <= upper, p->name, x, bound, p->cure);
    } else if (p->kind == WHOLE) {
        const int x = whole_at(group, p->at);
        whole(check, lower <= x && x <= upper, p->name, x, bound, p->cure);
    }
}

/* all that the table of its parameters says of a group */
static void in_bounds(const Check *check, const Parameter *table, size_t number, const void *group) {
    const Parameter *end = table + number;
    for (const Parameter *p = table; p < end; p++)
        if (p->kind == CHOICE) choice(check, p, whole_at(group, p->at));
    for (const Parameter *p = table; p < end; p++)
        if (p->kind == REAL) {
            const double x = real_at(group, p->at);
            real(check, isfinite(x), p->name, x, "finite", "give a number");
        }
    for (const Parameter *p = table; p < end; p++) check_bounds(check, p, group);
}

#define IN_BOUNDS(check, TABLE, group) in_bounds(check, TABLE, sizeof TABLE / sizeof *TABLE, group)

void mesh_in_bounds(const Mesh *mesh, char *message) {
    const Check check = {"", message};
    message[0] = '\0';
    IN_BOUNDS(&check, MESH_PARAMETERS, mesh);
}

static void check_coupling(const Rope *rope, const Check *check) {
    double Qs = 0.5 * (rope->Qb + rope->Qc), bound = sqrt(rope->Qa * rope->Qd);
    char below[96];
    snprintf(below, sizeof below, "below sqrt(Qa Qd) = %s N m in size", ROUNDED(bound, 4));
    real(check, fabs(Qs) < bound, "(Qb + Qc) / 2", Qs, below,
         "or the strain energy is not positive: check Qb, Qc, Qa and Qd");
}

static void check_counts(const Mesh *mesh, const Check *check) {
    static const char *const segments[] = {"II", "III", "IV", "V", "VI"};
    const int *n = mesh->counts;
    int multiples[] = {2, 4, 2 << ((n[0] > 0) + (n[1] > 0)), 4, 2};
    for (int i = 0; i < 5; i++) {
        int count = n[i], multiple = multiples[i], fine = i == 2;
        char what[40], bound[40];
        snprintf(what, sizeof what, "element count of segment %s", segments[i]);
        snprintf(bound, sizeof bound, "a %smultiple of %d", fine ? "positive " : "", multiple);
        whole(check, count >= (fine ? multiple : 0) && count % multiple == 0, what, count, bound,
              "a transformation moves whole coarse elements through the segment");
    }
    char given[80];
    snprintf(given, sizeof given, "(%d, %d, %d, %d, %d)", n[0], n[1], n[2], n[3], n[4]);
    require(check, (n[0] > 0) == (n[4] > 0) && (n[1] > 0) == (n[3] > 0) && (n[0] > 0 || n[1] == 0), "counts", given,
            "all five segments, or none in III and V, or none in II and VI too",
            "the pattern is the same on both sides and leaves out no length");
}

void check_scene(const Scene *scene, char *message) {
    static const char *const groups[] = {"rope", "layout", "left.swivel", "right.swivel", "mesh", "solver", "model"};
    Check check[7];
    for (int i = 0; i < 7; i++) check[i].group = groups[i], check[i].message = message;
    message[0] = '\0';
    IN_BOUNDS(&check[0], ROPE_PARAMETERS, &scene->rope);
    check_coupling(&scene->rope, &check[0]);
    IN_BOUNDS(&check[1], LAYOUT_PARAMETERS, &scene->layout);
    IN_BOUNDS(&check[2], SWIVEL_PARAMETERS, &scene->swivels[LEFT]);
    IN_BOUNDS(&check[3], SWIVEL_PARAMETERS, &scene->swivels[RIGHT]);
    IN_BOUNDS(&check[4], MESH_PARAMETERS, &scene->mesh);
    check_counts(&scene->mesh, &check[4]);
    IN_BOUNDS(&check[5], SOLVER_PARAMETERS, &scene->solver);
    IN_BOUNDS(&check[6], MODEL_PARAMETERS, &scene->model);
}
