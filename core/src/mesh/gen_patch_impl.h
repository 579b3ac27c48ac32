#ifndef PLII_GEN_PATCH_IMPL_H
#define PLII_GEN_PATCH_IMPL_H

/* What the two kinds of patch have in common. */

#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

/* A mesh with the nodes of the patch, pinned as asked, and room for its links and faces. `allowed_pins` are the bits
   that the generator `function` knows. */
pli_status plii_patch_begin(pli_context* context, const pli_patch_def* def, int allowed_pins, const char* function,
                            pli_mesh** mesh);

static inline int plii_patch_node(const pli_patch_def* def, int x, int y) {
    return y * def->columns + x;
}

#endif
