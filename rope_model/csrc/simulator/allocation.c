/* Memory of a simulator: one block for all arrays. */

#include "allocation.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "chain.h"
#include "communication_step.h"
#include "formulas.h"
#include "messages.h"
#include "obstacles.h"
#include "rope.h"
#include "self_contact.h"
#include "simulator.h"
#include "state_structures.h"

enum { ALIGNMENT = 64 };

/* Block that is laid out in pieces; NULL to count their bytes only. */
typedef struct {
    char *block;
    size_t used;
} Arena;

static void *reserve(Arena *arena, size_t bytes) {
    char *start = arena->block != NULL ? arena->block + arena->used : NULL;
    arena->used += (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return start;
}

static double *numbers(Arena *arena, size_t count) {
    return reserve(arena, sizeof(double) * count);
}

/* Lay out all arrays; return the bytes to clear: most self-contacts behind them are never written and cost no memory.
 */
static size_t lay_out(Simulator *sim, Arena *arena) {
    const Scene *scene = &sim->scene;
    const bool rubs = wire_stiffness(&scene->rope) > 0;
    const bool presses = scene->shaft.contact.rope_stiffness > 0;
    const size_t n = (size_t)sim->elements;
    const size_t size = (n + 1) * DOF;
    State **const states[] = {&sim->state, &sim->next, &sim->spare, &sim->start};
    double **const arrays[] = {&sim->work.trial.q, &sim->work.trial.v,      &sim->work.trial.a,
                               &sim->work.trial.b, &sim->work.trial.a_rate, &sim->work.trial.reaction,
                               &sim->work.x};
    sim->state_bytes = sizeof(State) + sizeof(double) * (FIELDS * size + 2 * n + 1 + (rubs ? WIRE_Z * n : 0));
    for (int k = 0; k < 4; k++) *states[k] = reserve(arena, sim->state_bytes);
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) *arrays[k] = numbers(arena, size);
    sim->replay.steps = reserve(arena, sizeof *sim->replay.steps * MAX_TAKEN);
    sim->work.strains = reserve(arena, sizeof *sim->work.strains * n);
    sim->work.gained = reserve(arena, sizeof *sim->work.gained * n);
    sim->reference.frames = reserve(arena, chain_frames_bytes(sim->elements));
    sim->work.chain = reserve(arena, chain_work_bytes(sim->elements));
    if (max_curvature(&scene->rope) > 0) sim->reference.curved = numbers(arena, CURVED_SIZE * n);
    if (rubs) sim->reference.wires = numbers(arena, WIRE_ELEMENT_HISTORY_SIZE * n);
    if (rubs) sim->work.wire_tangents = numbers(arena, WIRE_ELEMENT_TANGENT_SIZE * (n + MAX_LANES - 1));
    sim->obstacles = reserve(arena, sizeof *sim->obstacles);
    sim->self_contact = reserve(arena, sizeof *sim->self_contact);
    const ClearanceCache cache = {.q = numbers(arena, size), .lengths = numbers(arena, n)};
    const Obstacles obstacles = {.scene = scene, .cache = cache, .near = reserve(arena, sizeof *obstacles.near * n)};
    SelfContactState self_contact = {.scene = scene, .presses = presses};
    self_contact.cache = (ClearanceCache){.q = numbers(arena, size), .lengths = numbers(arena, n)};
    self_contact.work.cg = numbers(arena, CG_ARRAYS * size);
    self_contact.work.boxes = reserve(arena, sizeof *self_contact.work.boxes * n);
    self_contact.work.neighbours = reserve(arena, sizeof *self_contact.work.neighbours * n);
    const size_t used = arena->used;
    if (presses) { /* room for strands that lie in each other */
        const size_t places = (size_t)rope_contact_max_points(scene->rope.length, sim->elements, scene->rope.diameter);
        self_contact.contacts = reserve(arena, sizeof *self_contact.contacts * ROPE_CONTACT_MAX_STRANDS * places);
    }
    if (arena->block == NULL) return used;
    *sim->obstacles = obstacles;
    *sim->self_contact = self_contact;
    return used;
}

Simulator *allocate_simulator(const Scene *scene, int elements, const Memory *memory, char *message) {
    Simulator counted = {.scene = *scene, .elements = elements};
    Arena arena = {NULL, 0};
    const size_t cleared = lay_out(&counted, &arena);
    const size_t bytes = sizeof counted + ALIGNMENT + arena.used;
    Simulator *sim = memory->allocate(1, bytes);
    if (sim == NULL) {
        say_no_memory(message, elements, 1e-6 * (double)bytes);
        return NULL;
    }
    memset(sim, 0, sizeof *sim + ALIGNMENT + cleared);
    sim->memory = *memory;
    sim->scene = *scene;
    sim->elements = elements;
    sim->work.trial.elements = elements;
    sim->work.trial.nodes = elements + 1;
    sim->chains = fastest_chains();
    arena.block = (char *)(sim + 1) + (ALIGNMENT - (uintptr_t)(sim + 1) % ALIGNMENT);
    arena.used = 0;
    lay_out(sim, &arena);
    return sim;
}

void rope_destroy(Simulator *sim) {
    if (sim != NULL) sim->memory.deallocate(sim);
}
