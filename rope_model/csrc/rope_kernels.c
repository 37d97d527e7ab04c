/* Choice between the forms of the chains, and their memory. */

#include <stddef.h>

#include "chain.h"
#include "formulas.h"
#include "lanes.h"
#include "processor.h"
#include "rope.h"

/* The torsional chain is the largest: a tangent has `most` entries, and a step as many for either end. */
size_t chain_work_bytes(int elements) {
    const size_t n = (size_t)elements, most = DOF * (2 * DOF + 1);
    return sizeof(double) * ((n + MAX_LANES) * most + (n + 1) * 2 * DOF) + sizeof(Vec2) * most * ((n + 1) / SWEEPS + 1);
}

size_t chain_frames_bytes(int elements) {
    return sizeof(double) * ELEMENT_FRAME_SIZE * ((size_t)elements + MAX_LANES - 1);
}

extern const Chain chains_plain[3];
extern const Chain chains_wide[3];
extern const Chain chains_widest[3];

const Chain *fastest_chains(void) {
#if HAS_WIDE_FORMS
    const int lanes = processor_lanes();
    if (lanes > 2) return lanes == 8 ? chains_widest : chains_wide;
#endif
    return chains_plain;
}
