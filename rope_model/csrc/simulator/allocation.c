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

/* Numbers of nodal arrays and of elements that the arrays below are made for. */
typedef struct {
    size_t elements;
    size_t fields; /* nodes x DOF */
    bool rubs;     /* true if there is friction between wires */
} Extent;

static void lay_out_states(Simulator *sim, const Extent *extent, Arena *arena) {
    const size_t n = extent->elements;
    const size_t history = extent->rubs ? WIRE_Z * n : 0;
    State **const states[] = {&sim->state, &sim->next, &sim->spare, &sim->start};
    sim->state_bytes = sizeof(State) + sizeof(double) * (FIELDS * extent->fields + n + (n + 1) + history);
    for (size_t k = 0; k < sizeof states / sizeof *states; k++) *states[k] = reserve(arena, sim->state_bytes);
    sim->replay.steps = reserve(arena, sizeof *sim->replay.steps * MAX_TAKEN);
}

static Workspace lay_out_workspace(int elements, const Extent *extent, Arena *arena) {
    Workspace work = {.trial = {.elements = elements, .nodes = elements + 1}};
    double **const arrays[] = {&work.trial.q,      &work.trial.v,        &work.trial.a, &work.trial.b,
                               &work.trial.a_rate, &work.trial.reaction, &work.x};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) *arrays[k] = numbers(arena, extent->fields);
    work.strains = reserve(arena, sizeof *work.strains * extent->elements);
    work.gained = reserve(arena, sizeof *work.gained * extent->elements);
    work.chain = reserve(arena, chain_work_bytes(elements));
    if (extent->rubs)
        work.wire_tangents = numbers(arena, WIRE_ELEMENT_TANGENT_SIZE * (extent->elements + MAX_LANES - 1));
    return work;
}

static Reference lay_out_reference(const Rope *rope, int elements, const Extent *extent, Arena *arena) {
    Reference reference = {.frames = reserve(arena, chain_frames_bytes(elements))};
    if (max_curvature(rope) > 0) reference.curved = numbers(arena, CURVED_SIZE * extent->elements);
    if (extent->rubs) reference.wires = numbers(arena, WIRE_ELEMENT_HISTORY_SIZE * extent->elements);
    return reference;
}

static ClearanceCache lay_out_cache(const Extent *extent, Arena *arena) {
    ClearanceCache cache = {.q = numbers(arena, extent->fields)};
    cache.lengths = numbers(arena, extent->elements);
    return cache;
}

static Obstacles lay_out_obstacles(const Scene *scene, const Extent *extent, Arena *arena) {
    Obstacles obstacles = {.scene = scene, .cache = lay_out_cache(extent, arena)};
    obstacles.near = reserve(arena, sizeof *obstacles.near * extent->elements);
    return obstacles;
}

/* Lay out contact of the rope with itself, without its contacts. */
static SelfContactState lay_out_self_contact(const Scene *scene, const Extent *extent, Arena *arena) {
    SelfContactState self_contact = {.scene = scene, .presses = scene->shaft.contact.rope_stiffness > 0};
    SelfContactWork *work = &self_contact.work;
    self_contact.cache = lay_out_cache(extent, arena);
    work->cg = numbers(arena, CG_ARRAYS * extent->fields);
    work->boxes = reserve(arena, sizeof *work->boxes * extent->elements);
    work->neighbours = reserve(arena, sizeof *work->neighbours * extent->elements);
    return self_contact;
}

/* Return room for the contacts of the rope with itself, also of strands that lie in each other. */
static SelfContact *lay_out_contacts(const Scene *scene, int elements, Arena *arena) {
    const size_t places = (size_t)rope_contact_max_points(scene->rope.length, elements, scene->rope.diameter);
    return reserve(arena, sizeof(SelfContact) * ROPE_CONTACT_MAX_STRANDS * places);
}

/* Lay out all arrays; return the bytes to clear: most self-contacts behind them are never written and cost no memory.
 */
static size_t lay_out(Simulator *sim, Arena *arena) {
    const Scene *scene = &sim->scene;
    const size_t elements = (size_t)sim->elements;
    const Extent extent = {
        .elements = elements, .fields = (elements + 1) * DOF, .rubs = wire_stiffness(&scene->rope) > 0};
    lay_out_states(sim, &extent, arena);
    sim->work = lay_out_workspace(sim->elements, &extent, arena);
    sim->reference = lay_out_reference(&scene->rope, sim->elements, &extent, arena);
    sim->obstacles = reserve(arena, sizeof *sim->obstacles);
    sim->self_contact = reserve(arena, sizeof *sim->self_contact);
    const Obstacles obstacles = lay_out_obstacles(scene, &extent, arena);
    SelfContactState self_contact = lay_out_self_contact(scene, &extent, arena);
    const size_t cleared = arena->used;
    if (self_contact.presses) self_contact.contacts = lay_out_contacts(scene, sim->elements, arena);
    if (arena->block == NULL) return cleared;
    *sim->obstacles = obstacles;
    *sim->self_contact = self_contact;
    return cleared;
}

Simulator *allocate_simulator(const Scene *scene, int elements, const Memory *memory, char *message) {
    Simulator counted = {.scene = *scene, .elements = elements};
    Arena arena = {.block = NULL};
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
    sim->chains = fastest_chains();
    arena.block = (char *)(sim + 1) + (ALIGNMENT - (uintptr_t)(sim + 1) % ALIGNMENT);
    arena.used = 0;
    lay_out(sim, &arena);
    return sim;
}

void rope_destroy(Simulator *sim) {
    if (sim != NULL) sim->memory.deallocate(sim);
}
