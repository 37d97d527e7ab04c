/* Creation of a rope, its tunable parameters, and facts about it. */

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "allocation.h"
#include "fidelity_name.h"
#include "messages.h"
#include "parameter_table.h"
#include "partition.h"
#include "rope.h"
#include "rules.h"
#include "simulator.h"
#include "state_structures.h"

Simulator *rope_create(const Scene *scene, const Memory *memory, char *message) {
    message[0] = '\0';
    if (!check_scene(scene, message)) return NULL;
    const Mesh mesh = fit_mesh(scene);
    double divider_s[DIVIDERS];
    mesh_dividers(scene, 0, 0, divider_s);
    const int elements = partition_elements(&mesh, scene->rope.length, divider_s, message);
    if (elements == 0) {
        char why[MESSAGE];
        memcpy(why, message, sizeof why);
        if (scene->mesh.kind == AUTO_MESH) say_fit_fails(message, why);
        return NULL;
    }
    Simulator *sim = allocate_simulator(scene, elements, memory, message);
    if (sim == NULL) return NULL;
    sim->mesh = mesh;
    sim->obstacles->bodies = bodies_may_touch(&scene->shaft);
    return sim;
}

const char *rope_message(const Simulator *sim) {
    return sim->message;
}

int rope_is_initialized(const Simulator *sim) {
    return sim->initialized;
}

double rope_time(const Simulator *sim) {
    return sim->state->t;
}

int rope_elements(const Simulator *sim) {
    return sim->elements;
}

const char *rope_fidelity(const Simulator *sim) {
    return sim->initialized ? fidelity_name(sim->state->fidelity) : "";
}

const char *rope_fidelity_reason(const Simulator *sim) {
    return sim->initialized ? sim->state->fidelity_reason : "";
}

RopeStatus rope_retune(Simulator *sim, const Scene *scene) {
    if (!check_scene(scene, sim->message)) return ROPE_FAILED;
    sim->scene.solver = scene->solver;
    memcpy(sim->scene.swivels, scene->swivels, sizeof scene->swivels);
    sim->scene.shaft.air = scene->shaft.air;
    sim->computed_groups = 0;
    sim->replay.known = false;
    return ROPE_DONE;
}
