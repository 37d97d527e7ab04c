/* Words of the fidelities. */
#ifndef FIDELITY_NAME_H
#define FIDELITY_NAME_H

/* Return "torsional", "spatial", "planar" or "rigid". */
const char *fidelity_name(int fidelity);

#endif
