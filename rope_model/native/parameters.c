/* rope_model.parameters: the bounds of every parameter; the first that is broken gives the message.  The fields of a
   group that are real come first in its structure, so that they are read as an array. */
#include <math.h>
#include <stdio.h>

#include "core.h"
#include "text.h"

#define LEAST 1e-15 /* of what must be above 0 */

typedef struct {
    const char *group;
    char *message;
} Check;

static void require(const Check *check, int ok, const char *what, const char *value, const char *bound,
                    const char *cure) {
    if (!ok && !check->message[0])
        snprintf(check->message, MESSAGE, "%s: %s = %s is out of range: it must be %s; %s", check->group, what, value,
                 bound, cure);
}

static void real(const Check *check, int ok, const char *what, double x, const char *bound, const char *cure) {
    if (!ok) require(check, ok, what, EXACT(x), bound, cure);
}

static void whole(const Check *check, int ok, const char *what, int x, const char *bound, const char *cure) {
    char value[NUMBER];
    snprintf(value, sizeof value, "%d", x);
    require(check, ok, what, value, bound, cure);
}

static void all_finite(const Check *check, const char *const *names, const double *values, int number) {
    for (int i = 0; i < number; i++) real(check, isfinite(values[i]), names[i], values[i], "finite", "give a number");
}

static void choice(const Check *check, const char *field, int code, int number, const char *codes) {
    if ((code < 0 || code >= number) && !check->message[0])
        snprintf(check->message, MESSAGE, "%s.%s = %d is none of the choices: %s", check->group, field, code, codes);
}

static void rope_checked(const Rope *rope, const Check *check) {
    static const char *const names[] = {"length", "mass_per_length", "Qa", "Qb", "Qc", "Qd", "EI", "rhoJ", "beta_K",
                                        "diameter", "installed_twist"};
    static const int positive[] = {0, 1, 2, 5, 6, 7, 9};
    const double *values = (const double *)rope;
    double Qs = 0.5 * (rope->Qb + rope->Qc), bound = sqrt(rope->Qa * rope->Qd);
    char below[96];
    all_finite(check, names, values, 11);
    for (int k = 0; k < 7; k++) {
        int i = positive[k];
        real(check, values[i] >= LEAST, names[i], values[i], "at least 1e-15", "check the rope's data sheet");
    }
    real(check, rope->diameter <= 1.0, "diameter", rope->diameter, "at most 1 m", "give it in metres");
    real(check, rope->length <= 1e4, "length", rope->length, "at most 1e4 m", "give it in metres");
    real(check, fabs(rope->installed_twist) <= 1e3, "installed_twist", rope->installed_twist, "within +-1000 rad",
         "give it in radians");
    real(check, rope->beta_K >= 0, "beta_K", rope->beta_K, ">= 0 s", "use 0 for no material damping");
    snprintf(below, sizeof below, "below sqrt(Qa Qd) = %s N m in size", ROUNDED(bound, 4));
    real(check, fabs(Qs) < bound, "(Qb + Qc) / 2", Qs, below,
         "or the strain energy is not positive: check Qb, Qc, Qa and Qd");
}

static void layout_checked(const Layout *layout, const Check *check) {
    static const char *const names[] = {"spacing", "gravity"};
    all_finite(check, names, (const double *)layout, 2);
    real(check, layout->spacing >= LEAST, "spacing", layout->spacing, "at least 1e-15 m",
         "give the distance between the conveyances");
    real(check, layout->gravity >= LEAST, "gravity", layout->gravity, "at least 1e-15 m/s^2", "the rope must hang");
}

static void swivel_checked(const Swivel *swivel, const Check *check) {
    static const char *const names[] = {"mean_diameter", "mu_static", "mu_kinetic",
                                        "seal_moment",   "inertia",   "release_time"};
    char above[64];
    choice(check, "mode", swivel->mode, 3, "0 locked, 1 free, 2 coulomb");
    all_finite(check, names, (const double *)swivel, 6);
    real(check, swivel->mean_diameter >= LEAST, "mean_diameter", swivel->mean_diameter, "at least 1e-15 m",
         "take the bearing's d_m");
    real(check, swivel->mu_kinetic >= 0, "mu_kinetic", swivel->mu_kinetic, ">= 0",
         "friction takes energy, never gives");
    snprintf(above, sizeof above, ">= mu_kinetic = %s", EXACT(swivel->mu_kinetic));
    real(check, swivel->mu_static >= swivel->mu_kinetic, "mu_static", swivel->mu_static, above,
         "a swivel that slips more easily than it slides cannot stick");
    real(check, swivel->seal_moment >= 0, "seal_moment", swivel->seal_moment, ">= 0 N m", "friction takes energy");
    real(check, swivel->inertia >= LEAST, "inertia", swivel->inertia, "at least 1e-15 kg m^2",
         "without inertia a release is a jump in spin: give the rotor's (0.05 is typical)");
}

static void mesh_checked(const Mesh *mesh, const Check *check) {
    static const char *const segments[] = {"II", "III", "IV", "V", "VI"};
    choice(check, "kind", mesh->kind, 3, "0 tmn, 1 eem, 2 auto");
    real(check, 1e-5 <= mesh->loop_error && mesh->loop_error <= 1.0, "loop_error", mesh->loop_error, "1e-5 to 1 m",
         "5e-3 m suits most studies");
    whole(check, 2 <= mesh->elements && mesh->elements <= 20000, "elements", mesh->elements, "2 to 20000",
          "use fewer or more");
    real(check, isfinite(mesh->coarse_length) && mesh->coarse_length >= LEAST, "coarse_length", mesh->coarse_length,
         "at least 1e-15 m", "2 m suits a 120 m rope");
    whole(check, 0 <= mesh->end_levels && mesh->end_levels <= 8, "end_levels", mesh->end_levels, "0 to 8",
          "2 resolves the clamped ends");
    real(check, 0 <= mesh->leg_growth && mesh->leg_growth <= 1e4, "leg_growth", mesh->leg_growth, "0 to 1e4 m",
         "1 m suits a 1000 m rope");
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
         "the ladder is the same on both sides and leaves out no step");
}

static void solver_checked(const Solver *solver, const Check *check) {
    static const char *const names[] = {"step_max", "step_min", "tolerance", "newton_tolerance", "rho_inf"};
    all_finite(check, names, (const double *)solver, 5);
    real(check, LEAST <= solver->step_max && solver->step_max <= 1, "step_max", solver->step_max, "in [1e-15, 1] s",
         "10 ms suits most ropes");
    real(check, LEAST <= solver->step_min && solver->step_min <= solver->step_max, "step_min", solver->step_min,
         "in [1e-15, step_max]", "use 1e-5 s");
    real(check, LEAST <= solver->tolerance && solver->tolerance <= 1, "tolerance", solver->tolerance, "in [1e-15, 1]",
         "1e-3 is a good start");
    real(check, LEAST <= solver->newton_tolerance && solver->newton_tolerance <= 1e-3, "newton_tolerance",
         solver->newton_tolerance, "in [1e-15, 1e-3]", "1e-7 changes no digit that matters");
    real(check, 0 <= solver->rho_inf && solver->rho_inf <= 1, "rho_inf", solver->rho_inf, "in [0, 1]",
         "0.6 damps what the mesh cannot resolve");
}

static void model_checked(const Model *model, const Check *check) {
    static const char *const names[] = {"force_tolerance"};
    choice(check, "rung", model->rung, 5, "0 auto, 1 torsional, 2 spatial, 3 planar, 4 rigid");
    all_finite(check, names, &model->force_tolerance, 1);
    real(check, 0 <= model->force_tolerance && model->force_tolerance <= 1, "force_tolerance", model->force_tolerance,
         "in [0, 1]", "0 allows only rungs that leave nothing out");
}

void scene_checked(const Scene *scene, char *message) {
    static const char *const groups[] = {"rope", "layout", "left.swivel", "right.swivel", "mesh", "solver", "model"};
    Check check[7];
    for (int i = 0; i < 7; i++) check[i].group = groups[i], check[i].message = message;
    message[0] = '\0';
    rope_checked(&scene->rope, &check[0]);
    layout_checked(&scene->layout, &check[1]);
    swivel_checked(&scene->swivels[LEFT], &check[2]);
    swivel_checked(&scene->swivels[RIGHT], &check[3]);
    mesh_checked(&scene->mesh, &check[4]);
    solver_checked(&scene->solver, &check[5]);
    model_checked(&scene->model, &check[6]);
}
