/* Service: the force accumulator of the nodes. Bodies that feel nothing but gravity do without it. */

#include "body/body_impl.h"

const plii_feature_class* const plii_surface_force_needs[] = {&plii_forces_class, &plii_normals_class,
                                                              &plii_areas_class, NULL};

const plii_feature_class plii_forces_class = {
    .name = "forces",
    .is_made_by_calls = true,
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(pli_body, forces), PLII_PER_NODE, .is_in_body = true, .is_kept = true, PLII_SAVED_AS("3f")})};
