/* The chains in the form that every processor runs, and the choice between the forms. */

#define FORM(name) name##_plain
#include "rope_kernels_form.inc"

#include "processor.h"

/* no fidelity needs more than the torsional: steps, tangents, correction and residual, and what alignment takes */
size_t chain_work_bytes(int elements) {
    const size_t n = (size_t)elements;
    return sizeof(torsional_Step) * ((n + 1) / PAIR + 1) + sizeof(double) * (n + 1) * (105 + 2 * DOF);
}

/* the last group of elements may have lanes to spare */
size_t chain_frames_bytes(int elements) {
    return sizeof(double) * FRAME * ((size_t)elements + 3);
}

#if HAS_WIDE_FORM
extern const Chain chains_wide[3];

const Chain *fastest_chains(void) {
    return processor_has_avx2() ? chains_wide : chains_plain;
}
#else
const Chain *fastest_chains(void) {
    return chains_plain;
}
#endif
