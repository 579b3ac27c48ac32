/* Anchors in substeps, C = node - point of the rigid body as one constraint of three rows. */

#include "contact/anchor_impl.h"
#include "math/range.h"

static void anchor_substeps_begin(pli_body* body, void* data) {
    plii_anchors* anchors = data;
    for (PLII_EACH(plii_anchor, anchor, anchors->items, anchors->item_count)) {
        pli_rigid* rigid = anchor->rigid;
        anchor->is_idle = rigid->is_absent;
        if (anchor->is_idle) { continue; }
        anchor->substeps.goal = anchor->start;
        const pli_vec3 offset = pli_mat3_mul_vec3(rigid->path.begin.rotation, anchor->pivot);
        anchor->substeps.pivot = (plii_substep_rigid_pivot){{rigid, offset}, offset};
        if (rigid->kind != PLI_RIGID_DYNAMIC) {
            const pli_vec3 end = pli_transform_point(plii_anchor_end_pose(body, anchor), anchor->pivot);
            anchor->substeps.goal_motion = pli_vec3_sub(end, anchor->start);
        }
        plii_substep_follow_rigid(body, rigid);
        plii_rigid_touch(rigid);
    }
}

static float anchor_alpha(const plii_anchor* anchor, const plii_substep* substep) {
    return anchor->compliance * substep->inverse_dt * substep->inverse_dt;
}

static void anchor_substep_restart(pli_body* body, void* data, const plii_substep* substep) {
    const plii_anchors* anchors = data;
    for (PLII_EACH(plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (anchor->is_idle) { continue; }
        const pli_rigid* rigid = anchor->rigid;
        if (rigid->kind == PLI_RIGID_DYNAMIC) { plii_substep_rigid_pivot_turn(&anchor->substeps.pivot); }
        const plii_substep_rigid_point* point = &anchor->substeps.pivot.point;
        anchor->substeps.multiplier = pli_vec3_make(0, 0, 0);
        anchor->substeps.inverse =
            plii_effective_mass(1.0f, substep->displacements[anchor->node].w + anchor_alpha(anchor, substep),
                                rigid->state.inverse_mass, rigid->state.inverse_inertia_world, point->offset);
    }
}

/* At the end of the substep. */
static pli_vec3 anchor_goal(const pli_body* body, const plii_anchor* anchor, const plii_substep* substep) {
    if (anchor->rigid->kind != PLI_RIGID_DYNAMIC) {
        const float time = (float)(substep->index + 1) * substep->dt * body->step.inverse_dt;
        return pli_vec3_add(anchor->substeps.goal, pli_vec3_scale(anchor->substeps.goal_motion, time));
    }
    const plii_substep_rigid_pivot* pivot = &anchor->substeps.pivot;
    return pli_vec3_add(pli_vec3_add(anchor->substeps.goal, plii_substep_rigid_pivot_moved(pivot)),
                        plii_substep_rigid_point_motion(&pivot->point, substep));
}

static void anchor_substep_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const plii_anchors* anchors = data;
    for (PLII_EACH(plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (anchor->is_idle) { continue; }
        const plii_substep_rigid_point* point = &anchor->substeps.pivot.point;
        const pli_vec3 goal = anchor_goal(body, anchor, substep);
        const pli_vec3 error = pli_vec3_add(pli_vec3_sub(plii_substep_position(body, substep, anchor->node), goal),
                                            pli_vec3_scale(anchor->substeps.multiplier, anchor_alpha(anchor, substep)));
        const pli_vec3 change = pli_vec3_neg(pli_mat3_mul_vec3(anchor->substeps.inverse, error));
        if (!plii_vec3_is_finite(change)) { continue; } /* neither side can move */
        anchor->substeps.multiplier = pli_vec3_add(anchor->substeps.multiplier, change);
        plii_substep_move(substep, anchor->node, change, 1.0f);
        plii_substep_rigid_point_push(point, pli_vec3_neg(change), substep);
    }
}

static bool anchor_substeps_are_idle(const void* data) {
    const plii_anchors* anchors = data;
    for (int i = 0; i < anchors->item_count; ++i) {
        if (!anchors->items[i].is_idle) { return false; }
    }
    return true;
}

enum { ANCHOR_SUBSTEP_ORDER = 50 }; /* they take their nodes along after links and tethers */

const plii_substep_class plii_anchor_substepped = {
    .order = ANCHOR_SUBSTEP_ORDER,
    .begin = anchor_substeps_begin,
    .restart = anchor_substep_restart,
    .sweep = anchor_substep_sweep,
    .is_idle = anchor_substeps_are_idle,
};
