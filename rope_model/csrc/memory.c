/* The memory of a simulator: all that it needs for its number of elements, taken at once. */

#include <stdint.h>

#include "formulas.h"
#include "messages.h"
#include "simulator.h"

enum { ALIGNMENT = 64 };

/* memory that is given away in pieces; without a block they are only counted */
typedef struct {
    char *block;
    size_t used;
} Room;

static void *piece(Room *room, size_t bytes) {
    char *at = room->block != NULL ? room->block + room->used : NULL;
    room->used += (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return at;
}

static double *numbers(Room *room, size_t number) {
    return piece(room, sizeof(double) * number);
}

/* all arrays of the rope; gives what is used but for its touches with itself: of these it seldom needs many, and memory
   that nothing is written to costs nothing */
static size_t lay_out(Simulator *rope, Room *room) {
    const Scene *scene = &rope->scene;
    const int rubs = wire_stiffness(&scene->rope) > 0, presses = scene->shaft.contact.rope_stiffness > 0;
    const size_t n = (size_t)rope->elements, size = (n + 1) * DOF;
    State **const states[] = {&rope->state, &rope->next, &rope->spare};
    double **const arrays[] = {&rope->trial.q,      &rope->trial.v,        &rope->trial.a, &rope->trial.b,
                               &rope->trial.a_rate, &rope->trial.reaction, &rope->x};
    rope->state_bytes = sizeof(State) + sizeof(double) * (FIELDS * size + 2 * n + 1 + (rubs ? WIRE_Z * n : 0));
    for (int k = 0; k < 3; k++) *states[k] = piece(room, rope->state_bytes);
    double *const in_a_row = numbers(room, 7 * size);
    for (size_t k = 0; in_a_row != NULL && k < 7; k++) *arrays[k] = in_a_row + k * size;
    rope->strains = piece(room, sizeof *rope->strains * n);
    rope->frames = piece(room, chain_frames_bytes(rope->elements));
    rope->work = piece(room, chain_work_bytes(rope->elements));
    if (most_curvature(&scene->rope) > 0) rope->curved = numbers(room, CURVED * n);
    if (rubs) rope->wires = numbers(room, WIRE_HISTORY * n);
    if (rubs) rope->latest = numbers(room, WIRE_LATEST * (n + MOST_LANES - 1));
    rope->around = piece(room, sizeof *rope->around);
    rope->own = piece(room, sizeof *rope->own);
    const ClearanceCache seen = {.q = numbers(room, size), .lengths = numbers(room, n)};
    const Surroundings around = {.scene = scene, .seen = seen, .near = piece(room, sizeof *around.near * n)};
    SelfContactState own = {.scene = scene, .presses = presses};
    own.seen = (ClearanceCache){.q = numbers(room, size), .lengths = numbers(room, n)};
    own.scratch = numbers(room, CG_ARRAYS * size);
    own.boxes = piece(room, sizeof *own.boxes * n);
    own.ways = numbers(room, n);
    own.distances = numbers(room, n);
    own.where = numbers(room, n);
    own.others = piece(room, sizeof *own.others * n);
    const size_t used = room->used;
    /* even of strands that lie in each other */
    if (presses) {
        const size_t places = (size_t)most_places(scene->rope.length, rope->elements, scene->rope.diameter);
        own.touches = piece(room, sizeof *own.touches * MOST_STRANDS * places);
    }
    if (room->block != NULL) *rope->around = around, *rope->own = own;
    return used;
}

Simulator *with_memory(const Scene *scene, int elements, const Memory *memory, char *message) {
    Simulator counted = {.scene = *scene, .elements = elements};
    Room room = {NULL, 0};
    const size_t cleared = lay_out(&counted, &room), bytes = sizeof counted + ALIGNMENT + room.used;
    Simulator *rope = memory->take(1, bytes);
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
    room.block = (char *)(rope + 1) + (ALIGNMENT - (uintptr_t)(rope + 1) % ALIGNMENT);
    room.used = 0;
    lay_out(rope, &room);
    return rope;
}

void rope_destroy(Simulator *rope) {
    if (rope != NULL) rope->memory.give_back(rope);
}
