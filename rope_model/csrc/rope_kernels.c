/* The chains in the form that every processor runs, and the choice between the forms. */

#define FORM(name) name##_plain
#include "rope_kernels_form.inc"

#include "processor.h"

/* no fidelity needs more than the torsional: tangents, steps, correction and residual */
size_t chain_work_bytes(int elements) {
    const size_t n = (size_t)elements;
    return sizeof(torsional_Step) * ((n + 1) / PAIR + 1) +
           sizeof(double) * ((n + MOST_LANES) * 105 + (n + 1) * 2 * DOF);
}

size_t chain_frames_bytes(int elements) {
    return sizeof(double) * FRAME * ((size_t)elements + MOST_LANES - 1);
}

#if HAS_WIDE_FORMS
extern const Chain chains_wide[3], chains_widest[3];

const Chain *fastest_chains(void) {
    const int lanes = processor_lanes();
    return lanes == 8 ? chains_widest : lanes == 4 ? chains_wide : chains_plain;
}
#else
const Chain *fastest_chains(void) {
    return chains_plain;
}
#endif
