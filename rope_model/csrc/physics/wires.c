/* Hysteresis of rubbing wires along a rope: physics.wire_friction at the Gauss points of its elements.

   z of each point is state: (elements, 9), empty without friction, which is off in the rigid rope and while a
   rope is hung up, so that it begins with z = 0.

   A transformation carries z as the mean over the length of rope that belongs to a point, its weight in the
   element: the integral of z stays, and that of z^2 can only fall. Points with an unchanged length of rope keep z
   to the bit. */

#include "wires.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "formulas.h"
#include "rope.h"
#include "state_structures.h"
#include "transfer.h"

/* numbers of an element's history behind those of its points */
enum { SLIP_CURVATURE, STIFFNESS };
enum { COMPONENTS = 3 }; /* of z */

static const double CELLS[] = WIRE_CELLS; /* bounds of the points' cells, element coordinates */

/* Section of an element at a point.  Sections do not turn without torsion, even if the ends have theta. */
static void read_section(const State *state, const NodalArrays *nodal, const double *q, int element, int point,
                         double section[WIRE_FRICTION_POINT_STATE_SIZE]) {
    static const double places[] = WIRE_PLACES;
    wire_friction_section_at(places[point], nodal->lengths[element], q + (ptrdiff_t)element * DOF, section);
    if (state->fidelity != TORSIONAL) section[ANGLE] = 0;
}

void wires_history(const Rope *rope, State *state, const double *q, double (*strains)[STRAINS], double *wires) {
    const NodalArrays nodal = state_arrays(state);
    const double stiffness = wire_stiffness(rope);
    for (int e = 0; e < nodal.elements; e++) {
        double *history = wires + (ptrdiff_t)e * WIRE_ELEMENT_HISTORY_SIZE;
        for (int k = 0; k < WIRE_POINTS; k++, history += WIRE_FRICTION_POINT_STATE_SIZE) {
            read_section(state, &nodal, q, e, k, history);
            memcpy(history + WIRE_FRICTION_POINT_STATE_SIZE - COMPONENTS,
                   nodal.z + (ptrdiff_t)e * WIRE_Z + COMPONENTS * k, COMPONENTS * sizeof *history);
        }
        history[SLIP_CURVATURE] =
            wire_friction_slip_curvature(rope, stiffness, strains[e][STRAIN_E], strains[e][STRAIN_TAU]);
        history[STIFFNESS] = stiffness;
    }
}

double update_hysteresis(const double *wires, State *state, const double *q) {
    static const double weights[] = WIRE_WEIGHTS;
    const NodalArrays nodal = state_arrays(state);
    double dissipated = 0;
    if (!state->rubs) return 0;
    for (int e = 0; e < nodal.elements; e++) {
        const double *before = wires + (ptrdiff_t)e * WIRE_ELEMENT_HISTORY_SIZE;
        const double *law = before + WIRE_POINTS * WIRE_FRICTION_POINT_STATE_SIZE;
        double now[WIRE_FRICTION_POINT_STATE_SIZE];
        for (int k = 0; k < WIRE_POINTS; k++, before += WIRE_FRICTION_POINT_STATE_SIZE) {
            read_section(state, &nodal, q, e, k, now);
            const BoucWenStep step = wire_friction_bouc_wen_step(before, now, law[SLIP_CURVATURE]);
            memcpy(nodal.z + (ptrdiff_t)e * WIRE_Z + COMPONENTS * k, step.z, sizeof step.z);
            dissipated += law[STIFFNESS] * nodal.lengths[e] * weights[k] * step.dissipated;
        }
    }
    return dissipated;
}

/* Mean of z over arc lengths between `from` and `to`; z is constant in the cell of a point. */
static void mean_between(const double *z, const double *s, int elements, double from, double to,
                         double mean[COMPONENTS]) {
    const double close = place_tolerance(s[elements]);
    memset(mean, 0, COMPONENTS * sizeof *mean);
    for (int e = 0; e < elements && s[e] < to; e++) {
        if (!(s[e + 1] > from)) continue;
        for (int k = 0; k < WIRE_POINTS; k++) {
            const double l = s[e + 1] - s[e];
            const double begin = s[e] + l * CELLS[k];
            const double end = s[e] + l * CELLS[k + 1];
            const double *point_z = z + (ptrdiff_t)e * WIRE_Z + COMPONENTS * k;
            const double fraction = (fmin(end, to) - fmax(begin, from)) / (to - from);
            if (fabs(begin - from) <= close && fabs(end - to) <= close) {
                memcpy(mean, point_z, COMPONENTS * sizeof *mean);
                return;
            }
            if (!(fraction > 0)) continue;
            for (int i = 0; i < COMPONENTS; i++) mean[i] += fraction * point_z[i];
        }
    }
}

void wires_carry(State *state, const double *old_s, double *before) {
    const NodalArrays nodal = state_arrays(state);
    if (!state->rubs) return;
    memcpy(before, nodal.z, sizeof(double) * WIRE_Z * (size_t)nodal.elements);
    for (int e = 0; e < nodal.elements; e++)
        for (int k = 0; k < WIRE_POINTS; k++)
            mean_between(before, old_s, nodal.elements, nodal.s[e] + nodal.lengths[e] * CELLS[k],
                         nodal.s[e] + nodal.lengths[e] * CELLS[k + 1],
                         nodal.z + (ptrdiff_t)e * WIRE_Z + COMPONENTS * k);
}

bool start_hysteresis(const double *wires, State *state) {
    const NodalArrays nodal = state_arrays(state);
    if (state->rubs || state->fidelity == RIGID || wires == NULL) return false;
    state->rubs = 1;
    memset(nodal.z, 0, sizeof(double) * WIRE_Z * (size_t)nodal.elements);
    return true;
}
