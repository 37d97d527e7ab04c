/* The memory of a simulator: all that it needs for its number of elements, taken at once. */

#include <stdint.h>

#include "formulas.h"
#include "messages.h"
#include "simulator.h"

enum { ALIGNMENT = 64 };

static size_t align(size_t bytes) {
    return (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

Simulator *with_memory(const Scene *scene, int elements, const Memory *memory, char *message) {
    const int rubs = wire_stiffness(&scene->rope) > 0;
    const size_t nodes = (size_t)elements + 1, size = nodes * DOF;
    const size_t wires = rubs ? (size_t)elements : 0;
    const size_t state_bytes =
        sizeof(State) + sizeof(double) * (FIELDS * size + (size_t)elements + nodes + WIRE_Z * wires);
    const size_t curved_bytes = scene->rope.initial_curvature > 0 ? align(sizeof(double) * CURVED * (nodes - 1)) : 0;
    const size_t wire_bytes =
        rubs ? align(sizeof(double) * WIRE_HISTORY * wires) + align(sizeof(double) * WIRE_LATEST * (wires + 3)) : 0;
    const size_t bytes = 3 * align(state_bytes) + align(sizeof(double) * 7 * size) +
                         align(sizeof(double) * STRAINS * (size_t)elements) + align(chain_frames_bytes(elements)) +
                         align(chain_work_bytes(elements)) + curved_bytes + wire_bytes + align(sizeof(Surroundings)) +
                         align(sizeof(double) * (size + (size_t)elements) + sizeof(unsigned) * (size_t)elements);
    const size_t own_bytes = own_contact_bytes(scene, elements);
    Simulator *rope = memory->take(1, sizeof *rope);
    if (rope != NULL) {
        memset(rope, 0, sizeof *rope);
        rope->block = memory->take(1, bytes + own_bytes + ALIGNMENT);
    }
    if (rope == NULL || rope->block == NULL) {
        if (rope != NULL) memory->give_back(rope);
        say_no_memory(message, elements, 1e-6 * (double)(bytes + own_bytes));
        return NULL;
    }
    /* of its touches with itself a rope seldom needs many: memory that nothing is written to costs nothing */
    memset(rope->block, 0, bytes + ALIGNMENT);
    rope->memory = *memory;
    rope->scene = *scene;
    rope->elements = elements;
    rope->chains = fastest_chains();
    rope->state_bytes = state_bytes;
    char *at = (char *)rope->block + (ALIGNMENT - (uintptr_t)rope->block % ALIGNMENT);
    rope->state = (State *)at;
    rope->next = (State *)(at += align(state_bytes));
    rope->spare = (State *)(at += align(state_bytes));
    at += align(state_bytes);
    double **const arrays[7] = {&rope->trial.q,      &rope->trial.v,        &rope->trial.a, &rope->trial.b,
                                &rope->trial.a_rate, &rope->trial.reaction, &rope->x};
    for (size_t k = 0; k < 7; k++) *arrays[k] = (double *)at + k * size;
    rope->trial.elements = elements;
    rope->trial.nodes = (int)nodes;
    at += align(sizeof(double) * 7 * size);
    rope->strains = (double (*)[STRAINS])(void *)at;
    at += align(sizeof(double) * STRAINS * (size_t)elements);
    rope->frames = (double *)(void *)at;
    rope->work = at += align(chain_frames_bytes(elements));
    at += align(chain_work_bytes(elements));
    if (curved_bytes > 0) rope->curved = (double *)(void *)at;
    at += curved_bytes;
    if (rubs) rope->wires = (double *)(void *)at;
    if (rubs) rope->latest = (double *)(void *)(at + align(sizeof(double) * WIRE_HISTORY * wires));
    rope->around = (Surroundings *)(void *)(at += wire_bytes);
    rope->around->seen.q = (double *)(void *)(at + align(sizeof(Surroundings)));
    rope->around->seen.lengths = rope->around->seen.q + size;
    rope->around->near = (unsigned *)(void *)(rope->around->seen.lengths + elements);
    at += align(sizeof(Surroundings)) +
          align(sizeof(double) * (size + (size_t)elements) + sizeof(unsigned) * (size_t)elements);
    rope->own = own_contact(&rope->scene, elements, at);
    return rope;
}

void rope_destroy(Simulator *rope) {
    if (rope == NULL) return;
    const Memory memory = rope->memory;
    memory.give_back(rope->block);
    memory.give_back(rope);
}
