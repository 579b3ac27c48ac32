/* The sweep over groups of contacts, for the instruction set that the build selects. With gap = dot(normal, node) +
   offset at the start of a substep and `along` the motion along the normal since then, against the surface, C =
   max(gap, 0) + along: what was apart may come together, what was inside goes no deeper. */

#include "contact/node_rigid_groups.h"
#include "math/simd_wide.h"

/* Components of vectors, one after the other. */
PLII_SIMD_INLINE plii_wide_vec3 groups_load(const float* components) {
    return (plii_wide_vec3){plii_float8_load(components), plii_float8_load(components + PLII_RIGID_GROUP_SIZE),
                            plii_float8_load(components + 2 * PLII_RIGID_GROUP_SIZE)};
}
PLII_SIMD_INLINE void groups_store(float* components, plii_wide_vec3 a) {
    plii_float8_store(components, a.x);
    plii_float8_store(components + PLII_RIGID_GROUP_SIZE, a.y);
    plii_float8_store(components + 2 * PLII_RIGID_GROUP_SIZE, a.z);
}

/* Stores come after all loads, as a node may be there more than once. */
PLII_SIMD_INLINE void groups_move(pli_vec4* records, const uint32_t* scaled_indices, plii_wide_vec3 by) {
    plii_float8 r[4] = {by.x, by.y, by.z, plii_float8_all(0.0f)};
    plii_float8_transpose4(r);
    PLII_UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        r[k] = plii_float8_add(plii_simd_load_two(records, scaled_indices + 2 * k), r[k]);
    }
    PLII_UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        plii_simd_store_two(records, scaled_indices + 2 * k, r[k]);
    }
}

PLII_SIMD_LARGE void groups_solve(const plii_rigid_groups_pass* pass, plii_rigid_group* group,
                                  const plii_rigid_surface* surface) {
    const plii_substep* substep = pass->substep;
    const bool is_first = substep->is_first_sweep;
    const plii_float8 zero = plii_float8_all(0.0f);
    const plii_wide_nodes start =
        plii_wide_gather(substep->start_displacements, group->scaled_indices, group->scaled_indices);
    const plii_wide_nodes now = plii_wide_gather(substep->displacements, group->scaled_indices, group->scaled_indices);
    const plii_float8 weight = now.w;
    const plii_wide_vec3 normal = groups_load(group->normal);
    if (is_first && substep->has_new_positions) {
        plii_float8 height = plii_float8_load(group->offset);
        if (!substep->is_absolute) {
            const plii_wide_nodes x = plii_wide_gather(pass->positions, group->scaled_indices, group->scaled_indices);
            height = plii_float8_add(plii_wide_vec3_dot(normal, x.at), height);
        }
        plii_float8_store(group->height, height);
    }
    plii_wide_vec3 from = start.at;
    plii_wide_vec3 motion = plii_wide_vec3_sub(now.at, from);
    if (surface != NULL) {
        const plii_wide_vec3 velocity = groups_load(surface->velocity);
        from = plii_wide_vec3_sub(from,
                                  plii_wide_vec3_scale(velocity, plii_float8_all((float)substep->index * substep->dt)));
        motion = plii_wide_vec3_sub(motion, plii_wide_vec3_scale(velocity, plii_float8_all(substep->dt)));
    }
    const plii_float8 gap = plii_float8_add(plii_wide_vec3_dot(normal, from), plii_float8_load(group->height));
    const plii_float8 along = plii_wide_vec3_dot(normal, motion);
    const plii_float8 c = plii_float8_add(plii_float8_max(gap, zero), along);
    const plii_float8 squeeze = plii_float8_load(group->squeeze);
    if (is_first && (plii_float8_less_bits(c, zero) | plii_float8_less_bits(gap, zero) |
                     plii_float8_less_bits(zero, squeeze)) == 0) {
        if (pass->leaves_sums) {
            plii_float8_store(group->pushed, zero);
            groups_store(group->rubbed, (plii_wide_vec3){zero, zero, zero});
        }
        return;
    }

    plii_float8 pushed_before = zero;
    plii_wide_vec3 rubbed_before = {zero, zero, zero};
    if (!is_first) {
        pushed_before = plii_float8_load(group->pushed);
        rubbed_before = groups_load(group->rubbed);
    }
    plii_float8 change = plii_float8_sub(zero, c);
    if (pass->alpha > 0.0f) {
        const plii_float8 alpha = plii_float8_all(pass->alpha);
        change =
            plii_float8_div(plii_float8_sub(plii_float8_mul(change, weight), plii_float8_mul(alpha, pushed_before)),
                            plii_float8_add(weight, alpha));
    }
    const plii_float8 pushed =
        plii_float8_where_greater(weight, zero, plii_float8_max(plii_float8_add(pushed_before, change), zero));

    const plii_wide_vec3 sliding = plii_wide_vec3_sub(motion, plii_wide_vec3_scale(normal, along));
    plii_wide_vec3 rubbed = plii_wide_vec3_sub(rubbed_before, sliding);
    const plii_float8 length = plii_float8_sqrt(plii_wide_vec3_dot(rubbed, rubbed));
    const plii_float8 pressed = plii_float8_add(pushed, plii_float8_mul(squeeze, plii_float8_all(pass->share)));
    const plii_float8 limit = plii_float8_mul(plii_float8_load(group->friction), pressed);
    rubbed = plii_wide_vec3_scale(
        rubbed, plii_float8_select_less(limit, length, plii_float8_div(limit, length), plii_float8_all(1.0f)));
    if (pass->leaves_sums) {
        plii_float8_store(group->pushed, pushed);
        groups_store(group->rubbed, rubbed);
    }

    plii_wide_vec3 moves = plii_wide_vec3_add(plii_wide_vec3_scale(normal, plii_float8_sub(pushed, pushed_before)),
                                              plii_wide_vec3_sub(rubbed, rubbed_before));
    /* A penetration from before goes without leaving speed, as if the node had started there. */
    if (is_first && plii_float8_less_bits(gap, zero) != 0) {
        const plii_float8 depth = plii_float8_max(plii_float8_sub(zero, gap), zero);
        const plii_float8 recovered = plii_float8_min(depth, plii_float8_all(pass->recovery));
        const plii_wide_vec3 shift = plii_wide_vec3_scale(normal, plii_float8_where_greater(weight, zero, recovered));
        groups_move(substep->start_displacements, group->scaled_indices, shift);
        moves = plii_wide_vec3_add(moves, shift);
    }
    groups_move(substep->displacements, group->scaled_indices, moves);
}

void PLII_KERNEL_NAME(plii_rigid_groups_sweep)(plii_rigid_groups* groups, const plii_rigid_groups_pass* pass) {
    for (PLII_EACH(plii_rigid_group, group, groups->groups, groups->count)) {
        const plii_rigid_surface* surface = group->surface != PLI_NULL_INDEX ? &groups->surfaces[group->surface] : NULL;
        groups_solve(pass, group, surface);
    }
}
