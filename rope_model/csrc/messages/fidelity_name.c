/* Words of the fidelities. */

#include "fidelity_name.h"

#include "rope.h"

const char *fidelity_name(int fidelity) {
    static const char *const names[] = FIDELITY_WORDS;
    return names[fidelity];
}
