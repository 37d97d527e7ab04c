/* Samples of a trip as hoist_demo.cosimulation.host winds them, bit for bit: with the scheme GaussSeidel(1), the
   SpeedController and head ropes that hold on the sheave.  The formulas of drive and control law are generated; these
   functions and the rope's come as pointers.  compiled_trip.py fills the structures, and writes numbers.h. */

#define _POSIX_C_SOURCE 199309L /* clock_gettime */

#include <math.h>
#include <stdbool.h>
#include <string.h>
#include <time.h>

#include "numbers.h"

typedef void (*Function)(void);

/* a function of the rope that gets or sets values, a row of them at a time */
typedef struct {
    int standard, text;
    Function function;
    void *rope;
    const void *numbers; /* of the values */
    size_t count, length, bytes;
    char *values;
} Access;

/* of the interface at one communication point */
typedef struct {
    double t, force[2], mean[2], acceleration[2];
} Sample;

typedef struct {
    Function drive; /* the kernel advance, */
    double *z, *y;  /* what it is given and finds */
    double *given;  /* to the law */

    Access step, motions, valid, forces, sides, guard; /* of the rope; without a function what it has not got */
    const Access *recorded;
    Function warning;
    char *told, *text;
    void (*heard)(void);
    int records, warnings, watched;

    int per_sample, per_step;
    double start, H, period, radius, start_height, ropes, slack_tension;
    const double (*reference)[4]; /* of all commands of the trip */

    Sample *samples; /* the last ones, oldest first */
    double *row;     /* of the record, where the first sample goes */
    size_t columns;
    double step_next, torque, integral, residual, exchanges, drive_time, rope_time;
    int kept, steps, evaluations, status;
} Trip;

static double now(void) {
#ifdef _WIN32
    return clock() / (double)CLOCKS_PER_SEC; /* wall time there */
#else
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
#endif
}

int law(const double **, double **, long long *, double *, int); /* generated, as the drive's kernel */

static void evaluate(int (*kernel)(const double **, double **, long long *, double *, int), const double *given,
                     double *found) {
    const double *arg[SZ_ARG];
    double *res[SZ_RES], w[SZ_W];
    long long iw[SZ_IW];
    arg[0] = given;
    res[0] = found;
    kernel(arg, res, iw, w, 0);
}

static int call(Trip *m, const Access *a, size_t row) {
    char *values = a->values + row * a->bytes;
    const char *text = "";
    void *target = a->text ? (void *)&text : values;
    m->status = 0;
    if (a->standard == FMI2)
        m->status = ((int (*)(void *, const void *, size_t, void *))a->function)(a->rope, a->numbers, a->count, target);
    else if (a->standard == FMI3)
        m->status = ((int (*)(void *, const void *, size_t, void *, size_t))a->function)(a->rope, a->numbers, a->count,
                                                                                         target, a->length);
    else if (a->text)
        text = ((const char *(*)(void *))a->function)(a->rope);
    else
        ((void (*)(void *, size_t, const void *, void *))a->function)(a->rope, a->count, a->numbers, target);
    if (a->text) strncpy(values, text, a->bytes);
    return m->status <= WARNING;
}

/* whether the value of one access, of whatever type, is anything but 0 */
static bool holds(const Access *a) {
    for (size_t i = 0; i < a->bytes; i++)
        if (a->values[i]) return true;
    return false;
}

/* warnings about a valid state are heard when they are new */
static void listen(Trip *m) {
    for (int i = 0; i < m->warnings; i++) {
        if (m->told[i]) continue;
        ((void (*)(void *, int, char *))m->warning)(m->step.rope, i, m->text);
        if (!m->text[0]) continue;
        m->told[i] = 1;
        m->heard();
    }
}

static int step_rope(Trip *m, double t, double h) {
    const double *shown = m->y + AT_SHOWN, *force = (const double *)m->forces.values;
    double *motions = (double *)m->motions.values;
    for (size_t i = 0; i < sizeof ENDS_SHOWN / sizeof *ENDS_SHOWN; i++)
        if (ENDS_SHOWN[i] >= 0) motions[i] = shown[ENDS_SHOWN[i]];
    if (m->step.standard == NATIVE) {
        if (!((int (*)(void *, double, const double *, double))m->step.function)(m->step.rope, t + h, motions, t + h))
            return STEP;
        listen(m);
    } else {
        bool event, ended = false, early;
        double last;
        if (!call(m, &m->motions, 0)) return MOTIONS;
        m->status = m->step.standard == FMI2
                        ? ((int (*)(void *, double, double, int))m->step.function)(m->step.rope, t, h, 0)
                        : ((int (*)(void *, double, double, bool, bool *, bool *, bool *, double *))m->step.function)(
                              m->step.rope, t, h, 0, &event, &ended, &early, &last);
        if (ended && m->status <= WARNING) m->status = DISCARD;
        if (m->status > WARNING) return STEP;
        if (m->valid.function && !(call(m, &m->valid, 0) && holds(&m->valid))) return VALID;
    }
    if (!call(m, &m->forces, 0)) return FORCES;
    return isfinite(force[0] + force[1] + force[2] + force[3]) ? WELL : FORCES;
}

static double change(double error) {
    return isfinite(error) ? fmax(SHRINKS, SAFETY * pow(fmax(error, 1e-20), -1.0 / ORDER)) : SHRINKS;
}

/* HoistPlant.advance, and in it Integrator.integrate */
static bool step_drive(Trip *m, double s, double end) {
    double *z = m->z, *y = m->y;
    double size = (m->step_next != 0.0 ? m->step_next : m->H) / m->H, growth = GROWS;
    while (size * m->H > SHORTEST) {
        const double calls = fmax(1.0, ceil((end - s) / (CHUNK * size) - 1e-9)), used = (end - s) / (CHUNK * calls);
        z[AT_S] = s;
        z[AT_H] = used;
        evaluate((int (*)(const double **, double **, long long *, double *, int))m->drive, z, y);
        m->evaluations++;
        size = fmin(used * change(y[AT_ERROR]), size * growth);
        if (!(y[AT_ERROR] <= 1.0)) {
            growth = 1.0;
            continue;
        }
        memcpy(z, y, REACHED * sizeof(double));
        s += CHUNK * used;
        if (calls == 1.0) {
            const double wound = m->radius * y[PHI];
            m->step_next = size * m->H;
            return fmin(z[AT_L0] - wound, z[AT_L0 + 1] + wound) > LEAST_ROPE;
        }
    }
    return false;
}

static double work(const Trip *m) {
    const double *works = m->y + AT_WORKS;
    return (works[LEFT_WORK] + works[RIGHT_WORK]) / m->ropes;
}

/* the command of the law that holds from now on; tells whether it is limited */
static double command(Trip *m, const double reference[4]) {
    const double *shown = m->y + AT_SHOWN;
    double found[3];
    memcpy(m->given, reference, 3 * sizeof(double));
    m->given[TRAVEL] = shown[Y_LEFT] - m->start_height;
    m->given[SPEED] = m->radius * shown[RATE];
    m->given[INTEGRAL] = m->integral;
    evaluate(law, m->given, found);
    m->torque = found[0];
    m->integral = found[2];
    return found[1];
}

/* both partners over one step from t, as GaussSeidel(1) and Pair.exchanged */
static int exchange(Trip *m, double t, const double (*reference)[4]) {
    const double H = m->H, begun = now(), work_before = work(m), integral = m->integral, torque = m->torque,
                 size = m->step_next;
    double *path = m->z + AT_PATH, *y = m->y, way[2], before[SIZE], left;
    const Sample *last = m->samples + m->kept - 1;
    const double *force = (const double *)m->forces.values;
    Sample sample;
    int failed = WELL;
    for (int i = 0; i < 2; i++) {
        path[FORCE + i] = last->force[i];
        path[INPUTS + FORCE + i] =
            m->kept > 1 ? (last->force[i] - last[-1].force[i]) / -((last[-1].t - last->t) / H) : 0.0;
    }
    memcpy(before, y, sizeof before);
    for (int k = 0; k < m->per_step && !failed; k++) {
        if (k) command(m, reference[k]);
        path[TORQUE] = m->torque;
        if (!step_drive(m, k / (double)m->per_step, (k + 1) / (double)m->per_step)) failed = DRIVE;
    }
    left = now();
    m->drive_time += left - begun;
    if (failed) {
        memcpy(y, before, sizeof before);
        m->integral = integral;
        m->torque = torque;
        m->step_next = size;
        return DRIVE;
    }
    failed = step_rope(m, t, H);
    m->rope_time += now() - left;
    if (failed) return failed;
    sample.t = t + H;
    for (int i = 0; i < 2; i++) {
        sample.force[i] = force[i];
        sample.mean[i] = force[2 + i];
        sample.acceleration[i] = y[AT_SHOWN + A_LEFT + i];
        way[i] = y[AT_SHOWN + Y_LEFT + i] - before[AT_SHOWN + Y_LEFT + i];
    }
    m->residual += work(m) - work_before - (sample.mean[0] * way[0] + sample.mean[1] * way[1]);
    m->exchanges++;
    if (m->kept == KEPT)
        memmove(m->samples, m->samples + 1, (KEPT - 1) * sizeof sample);
    else
        m->kept++;
    m->samples[m->kept - 1] = sample;
    return WELL;
}

/* what the rope shows now goes into a row of the record; whether nobody need look at it */
static bool record(Trip *m, size_t row) {
    const double *shown = m->y + AT_SHOWN, begun = now();
    bool well = true;
    for (int i = 0; i < m->records && well; i++) well = call(m, m->recorded + i, row);
    well = well && (!m->watched || !m->guard.function || (call(m, &m->guard, 0) && !holds(&m->guard)));
    m->rope_time += now() - begun;
    return well && !(m->watched && fmin(shown[PULL_LEFT], shown[PULL_LEFT + 1]) < m->slack_tension);
}

/* Samples from the first on until before the last, each with the steps to the next one.  Returns how the last one
   ended: before a sample at which Host must LOOK itself, before a step in which the DRIVE fails, or in one of the rope.
 */
int trip_samples(Trip *m, int *sample, int last) {
    double *path = m->z + AT_PATH, *y = m->y;
    memcpy(m->z, y, REACHED * sizeof(double));
    for (size_t n = 0; *sample < last; n++, ++*sample) {
        const double (*reference)[4] = m->reference + *sample * m->per_step;
        double *row = m->row + n * m->columns;
        if (!record(m, n)) return LOOK;
        row[0] = m->start + *sample * m->period;
        memcpy(row + 1, reference, 4 * sizeof(double));
        row[6] = command(m, reference[0]);
        row[5] = m->torque;
        row[7] = row[8] = 0.0; /* the head ropes hold */
        row[9] = m->residual;
        row[10] = m->exchanges;
        memcpy(row + 11, y + AT_SHOWN, OUTPUTS * sizeof(double));
        memcpy(row + 11 + OUTPUTS, y + AT_WORKS, WORKS * sizeof(double));
        if (m->sides.function) {
            if (!call(m, &m->sides, 0)) return LOOK;
            memcpy(path + SIDES, m->sides.values, m->sides.bytes);
            for (int i = SIDES; i < INPUTS; i++)
                if (isnan(path[i])) path[i] = 0.0;
        }
        for (int i = 0; i < m->per_sample; i++, m->steps++) {
            const int failed = exchange(m, m->start + m->steps * m->H, reference);
            if (failed) return failed;
        }
    }
    return WELL;
}
