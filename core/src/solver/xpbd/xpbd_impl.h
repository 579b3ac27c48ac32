#pragma once

/* What the kinds of constraints know of the XPBD solver: where nodes are, and how to take part in its sweeps. */

#include "body/pipeline.h"
#include "body/substep.h"
#include "pliant/xpbd.h"

/* plii_feature_enable_with for a kind, which takes part in sweeps then; fails unless the body is stepped by XPBD. */
pli_status plii_xpbd_enable_kind(pli_body* body, const plii_feature_class* klass, const void* given, size_t size,
                                 const char* function, void** state);

/* Change of the multiplier of a constraint (Macklin and others 2016, equations 18 and 26).
   c: its value; weight: sum of w |gradient|^2; c_motion: change of c by the motion in this substep. 0 where the
   constraint has nothing to act on. */
static inline float plii_xpbd_multiplier(float c, float weight, float compliance, float damping, float multiplier,
                                         float c_motion, const plii_substep* substep) {
    const float alpha = compliance * substep->inverse_dt * substep->inverse_dt;
    const float gamma = compliance * damping * substep->inverse_dt;
    const float change = (-c - alpha * multiplier - gamma * c_motion) / ((1.0f + gamma) * weight + alpha);
    return weight > 0.0f && plii_is_finite(change) ? change : 0.0f;
}
