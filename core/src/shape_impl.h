#ifndef PLII_SHAPE_IMPL_H
#define PLII_SHAPE_IMPL_H

#include "context.h"
#include "pliant/shape.h"
#include "vec.h"

struct pli_shape {
    uint32_t magic;
    int reference_count;
    pli_context* context;
    pli_shape_def def; /* callbacks and their data */
};

#define PLII_SHAPE_MAGIC 0x70736870u

#endif
