/* Place of each scalar of the interface in the rope; the table is generated from fmu_src.interface. */
#ifndef ROPE_TABLE_H
#define ROPE_TABLE_H

#include <stddef.h>

#include "rope.h"

enum Where {
    NOWHERE,
    SCENE_REAL,    /* offset: in struct Scene */
    SCENE_INTEGER, /* as SCENE_REAL */
    LEFT_MOTION,   /* offset: number of the value in END_MOTION_NAMES */
    RIGHT_MOTION,  /* as LEFT_MOTION */
    SIGNAL,        /* offset: number of the signal */
    FIDELITY_NAME,
    FIDELITY_REASON,
    WARNING
};

typedef struct {
    enum Where where;
    size_t offset;
    int derivative; /* index in the result of rope_load_derivative; -1 for none */
} Place;

extern const Place ROPE_PLACES[]; /* MODEL_SCALARS */

extern const size_t ROPE_MOTIONS[2][END_MOTIONS]; /* scalars of both ends' motions, in the order of EndMotion */

#endif
