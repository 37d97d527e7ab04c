/* Steps of other methods under the product's name; step.inc is the product's step.c.

   Runge-Kutta, diagonally implicit, the last stage at the step's end, with the unknown q of a stage:
       Q = q0 + h g V, V = v0 + h g A      q0 = q + h sum a_j V_j, v0 = v + h sum a_j A_j over the stages before
   Backward difference: v = (q - q_n - d (q_n - q_{n-1})) / (h g), a the same of v; b and a_rate hold
   (q_n - q_{n-1}) / h and (v_n - v_{n-1}) / h. */

#define trial_step product_trial_step
#include "step.inc"
#undef trial_step

#include <stdlib.h>

#include "study.h"

enum { ALPHA, STAGES, BACKWARD };
enum { MOST_STAGES = 8 };

static struct {
    int kind, stages;
    double rows[MOST_STAGES][MOST_STAGES];
} method;

/* v of the step's start and of each stage, and then a */
static double *memory;
static size_t memory_size;

void study_select(int kind, int stages, const double *rows) {
    method.kind = kind;
    method.stages = stages;
    memcpy(method.rows, rows, sizeof method.rows);
}

/* one stage that ends at t; q0 and v0 lie in the trial's q and v, and in its a what Newton's method begins from */
static Progress stage(Simulator *rope, State *state, const System *s, double t, double hg, double *balance) {
    const Arrays *now = &rope->trial;
    const size_t size = (size_t)now->nodes * DOF;
    for (size_t i = 0; i < size; i++) {
        now->v[i] += hg * now->a[i];
        now->q[i] += hg * now->v[i];
    }
    prescribe(rope, state, s, t, 3, (double *[]){now->q, now->v, now->a});
    return chain_of(rope, state)
        ->solve(s, rope->work, now->q, now->v, now->a, now->reaction, (double[]){1, 1 / hg, 1 / (hg * hg)},
                rope->scene.solver.newton_tolerance, balance);
}

static Progress all_stages(Simulator *rope, State *state, const System *s, double h, double *balance) {
    const Arrays old = state_arrays(state), *now = &rope->trial;
    const size_t size = (size_t)old.nodes * DOF;
    Progress progress = {TOO_MANY, 0, 0, INFINITY, INFINITY, 0};
    double known = rate_known(h, state->h) ? 1 : 0, place = 0;
    int total = 0;
    if (memory_size < 2 * MOST_STAGES * size) {
        memory_size = 2 * MOST_STAGES * size;
        memory = realloc(memory, sizeof(double) * memory_size);
    }
    double *const v = memory, *const a = memory + MOST_STAGES * size;
    memcpy(v, old.v, sizeof(double) * size);
    memcpy(a, old.a, sizeof(double) * size);
    for (int number = 0; number < method.stages; number++) {
        const double *weights = method.rows[number], before = place;
        place = 0;
        for (int j = 0; j <= number + 1; j++) place += weights[j];
        for (size_t i = 0; i < size; i++) {
            const double *v_i = v + i, *a_i = a + i;
            /* the acceleration goes on as in the step before, then as from the step's start to the stage before */
            const double rate = before > 0 ? (now->a[i] - old.a[i]) / before : known * h * old.a_rate[i];
            now->a[i] = old.a[i] + place * rate;
            now->q[i] = old.q[i];
            now->v[i] = old.v[i];
            for (int j = 0; j <= number; j++) {
                now->q[i] += h * weights[j] * v_i[(size_t)j * size];
                now->v[i] += h * weights[j] * a_i[(size_t)j * size];
            }
        }
        progress = stage(rope, state, s, state->t + place * h, h * weights[number + 1], balance);
        total += progress.iterations;
        if (progress.status != CONVERGED) break;
        memcpy(v + (size_t)(number + 1) * size, now->v, sizeof(double) * size);
        memcpy(a + (size_t)(number + 1) * size, now->a, sizeof(double) * size);
    }
    for (size_t i = 0; i < size; i++) {
        now->b[i] = now->a[i];
        now->a_rate[i] = (now->a[i] - old.a[i]) / h;
    }
    progress.iterations = total;
    return progress;
}

static Progress backward(Simulator *rope, State *state, const System *s, double h, double *balance) {
    const Arrays old = state_arrays(state), *now = &rope->trial;
    const size_t size = (size_t)old.nodes * DOF;
    const double w = state->h > 0 ? h / state->h : 0, hg = h * (1 + w) / (1 + 2 * w);
    const double d = w * w / (1 + 2 * w) * state->h; /* of the last differences over their step */
    for (size_t i = 0; i < size; i++) {
        now->q[i] = old.q[i] + d * old.b[i];
        now->v[i] = old.v[i] + d * old.a_rate[i];
        now->a[i] = old.a[i];
    }
    const Progress progress = stage(rope, state, s, state->t + h, hg, balance);
    for (size_t i = 0; i < size; i++) {
        now->b[i] = (now->q[i] - old.q[i]) / h;
        now->a_rate[i] = (now->v[i] - old.v[i]) / h;
    }
    return progress;
}

/* no local error is told: the step control takes all that Newton's method reaches */
Trial trial_step(Simulator *rope, State *state, double h) {
    if (method.kind == ALPHA) return product_trial_step(rope, state, h);
    const System s = system_of(rope, state);
    const Arrays old = state_arrays(state);
    const size_t size = (size_t)old.nodes * DOF;
    Trial trial = {.t = state->t + h, .h = h};
    double sum = 0;
    memcpy(rope->trial.reaction, old.reaction, sizeof(double) * size);
    trial.newton = (method.kind == STAGES ? all_stages : backward)(rope, state, &s, h, trial.balance);
    for (size_t i = 0; i < size; i++) sum += fabs(rope->trial.reaction[i]);
    if (trial.newton.status == CONVERGED && !isfinite(sum)) trial.newton.status = NOT_FINITE;
    trial.reached = trial.newton.status == CONVERGED;
    return trial;
}
