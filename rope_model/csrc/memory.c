/* Memory of a simulator: one block for all arrays. */

#include <stdint.h>

#include "formulas.h"
#include "messages.h"
#include "simulator.h"

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

static double *numbers(Arena *arena, size_t number) {
    return reserve(arena, sizeof(double) * number);
}

/* Lay out all arrays; return the bytes before self-contacts, most of which are never written and cost nothing. */
static size_t lay_out(Simulator *rope, Arena *arena) {
    const Scene *scene = &rope->scene;
    const int rubs = wire_stiffness(&scene->rope) > 0, presses = scene->shaft.contact.rope_stiffness > 0;
    const size_t n = (size_t)rope->elements, size = (n + 1) * DOF;
    State **const states[] = {&rope->state, &rope->next, &rope->spare};
    double **const arrays[] = {&rope->trial.q,      &rope->trial.v,        &rope->trial.a, &rope->trial.b,
                               &rope->trial.a_rate, &rope->trial.reaction, &rope->x};
    rope->state_bytes = sizeof(State) + sizeof(double) * (FIELDS * size + 2 * n + 1 + (rubs ? WIRE_Z * n : 0));
    for (int k = 0; k < 3; k++) *states[k] = reserve(arena, rope->state_bytes);
    double *const in_a_row = numbers(arena, 7 * size);
    for (size_t k = 0; in_a_row != NULL && k < 7; k++) *arrays[k] = in_a_row + k * size;
    rope->strains = reserve(arena, sizeof *rope->strains * n);
    rope->frames = reserve(arena, chain_frames_bytes(rope->elements));
    rope->work = reserve(arena, chain_work_bytes(rope->elements));
    if (max_curvature(&scene->rope) > 0) rope->curved = numbers(arena, CURVATURE_SIZE * n);
    if (rubs) rope->wires = numbers(arena, WIRE_HISTORY_SIZE * n);
    if (rubs) rope->latest = numbers(arena, WIRE_TANGENT_SIZE * (n + MAX_LANES - 1));
    rope->obstacles = reserve(arena, sizeof *rope->obstacles);
    rope->self_contact = reserve(arena, sizeof *rope->self_contact);
    const ClearanceCache cache = {.q = numbers(arena, size), .lengths = numbers(arena, n)};
    const Obstacles obstacles = {.scene = scene, .cache = cache, .near = reserve(arena, sizeof *obstacles.near * n)};
    SelfContactState self_contact = {.scene = scene, .presses = presses};
    self_contact.cache = (ClearanceCache){.q = numbers(arena, size), .lengths = numbers(arena, n)};
    self_contact.scratch = numbers(arena, CG_ARRAYS * size);
    self_contact.boxes = reserve(arena, sizeof *self_contact.boxes * n);
    self_contact.arc_gaps = numbers(arena, n);
    self_contact.distances = numbers(arena, n);
    self_contact.xi = numbers(arena, n);
    self_contact.others = reserve(arena, sizeof *self_contact.others * n);
    const size_t used = arena->used;
    if (presses) { /* room for strands that lie in each other */
        const size_t places = (size_t)max_points(scene->rope.length, rope->elements, scene->rope.diameter);
        self_contact.contacts = reserve(arena, sizeof *self_contact.contacts * MAX_STRANDS * places);
    }
    if (arena->block == NULL) return used;
    *rope->obstacles = obstacles;
    *rope->self_contact = self_contact;
    return used;
}

Simulator *allocate_simulator(const Scene *scene, int elements, const Memory *memory, char *message) {
    Simulator counted = {.scene = *scene, .elements = elements};
    Arena arena = {NULL, 0};
    const size_t cleared = lay_out(&counted, &arena), bytes = sizeof counted + ALIGNMENT + arena.used;
    Simulator *rope = memory->allocate(1, bytes);
    if (rope == NULL) {
        say_no_memory(message, elements, 1e-6 * (double)bytes);
        return NULL;
    }
    memset(rope, 0, sizeof *rope + ALIGNMENT + cleared);
    rope->memory = *memory;
    rope->scene = *scene;
    rope->elements = rope->trial.elements = elements;
    rope->trial.nodes = elements + 1;
    rope->chains = fastest_chains();
    arena.block = (char *)(rope + 1) + (ALIGNMENT - (uintptr_t)(rope + 1) % ALIGNMENT);
    arena.used = 0;
    lay_out(rope, &arena);
    return rope;
}

void rope_destroy(Simulator *rope) {
    if (rope != NULL) rope->memory.deallocate(rope);
}
