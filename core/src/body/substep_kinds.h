#pragma once

/* What takes part in the substeps of a body (substep.h). */

#include "body/substep.h"

enum { PLII_MAX_SUBSTEP_KINDS = 16 };

/* Features of the body that take part, by order; equals as they came. */
typedef struct plii_substep_kinds {
    int count;
    const plii_feature* at[PLII_MAX_SUBSTEP_KINDS];
    plii_substep_limits limits;
} plii_substep_kinds;

/* All but those that have nothing to do in this step. */
void plii_substep_kinds_begin(pli_body* body, plii_substep_kinds* kinds, bool in_iterations);
void plii_substep_kinds_restart(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep);
void plii_substep_kinds_sweep(pli_body* body, const plii_substep_kinds* kinds, const plii_substep* substep);

/* A feature: to contacts with rigid bodies the position-based step is one substep, and each iteration a sweep. They
   come last in it, and so have the last word. */
extern const plii_feature_class plii_iterated_sweeps_class;
