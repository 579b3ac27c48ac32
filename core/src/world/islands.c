#include "world/world_impl.h"

#include "base/union_find.h"

void plii_islands_start(pli_world* world) {
    if (!world->has_islands) { return; }
    for (int i = 0; i < world->body_count; ++i) {
        world->bodies[i]->island = world->bodies[i]->island_next = NULL;
    }
    world->has_islands = false;
}

void plii_world_join_bodies(pli_world* world, pli_body* body, pli_body* other) {
    /* They need as many sweeps and substeps of one length. */
    const plii_solver_class* solver = body->solver_class;
    if (other->solver_class != solver || other->step.dt != body->step.dt) { return; }
    const plii_solver_pace a = solver->pace(body), b = solver->pace(other);
    if (a.substeps != b.substeps || a.sweeps != b.sweeps) { return; }
    const bool was_locked = plii_context_lock(world->context); /* pairs may meet on several threads */
    if (!world->has_islands) {
        plii_union_start(world->body_count, world->islands);
        world->has_islands = true;
    }
    plii_union_join(world->islands, body->world_index, other->world_index);
    plii_context_unlock(world->context, was_locked);
}

static void islands_meet(pli_body* other, pli_rigid* rigid, void* user) {
    pli_body* body = user;
    if (rigid == NULL || rigid->kind != PLI_RIGID_DYNAMIC) { return; }
    if (rigid->first_island_body == PLI_NULL_INDEX) {
        rigid->first_island_body = body->world_index;
    } else {
        plii_world_join_bodies(body->world, body->world->bodies[rigid->first_island_body], body);
    }
}

/* Bodies with substeps that hold the same rigid body do so side by side. One after the other, each would stop it anew
   on the way that it went before the one before stopped it, and together they would throw it back. */
static void islands_join_by_rigids(pli_world* world) {
    int count = 0;
    for (int i = 0; i < world->body_count && count < 2; ++i) {
        count += world->bodies[i]->solver_class->has_substeps;
    }
    bool has_dynamic = false;
    for (int i = 0; i < world->rigid_count && count == 2; ++i) {
        has_dynamic = has_dynamic || world->rigids[i]->kind == PLI_RIGID_DYNAMIC;
        world->rigids[i]->first_island_body = PLI_NULL_INDEX;
    }
    if (!has_dynamic) { return; }
    for (PLII_EACH_BODY(body, world)) {
        if (plii_body_is_idle(body) || !body->solver_class->has_substeps) { continue; }
        for (PLII_EACH_FEATURE(feature, body)) {
            const plii_feature_class* klass = feature->klass;
            if (klass->visit_met != NULL) { klass->visit_met(feature->state, islands_meet, body); }
            if (klass->visit_joined != NULL) { klass->visit_joined(feature->state, islands_meet, body); }
        }
    }
}

/* From the last body, so that lists come in the order of bodies. The root is the first one. */
void plii_islands_find(pli_world* world) {
    islands_join_by_rigids(world);
    if (!world->has_islands) { return; }
    plii_union_flatten(world->body_count, world->islands);
    for (int i = world->body_count - 1; i >= 0; --i) {
        pli_body *body = world->bodies[i], *root = world->bodies[world->islands[i]];
        if (body == root) { continue; }
        body->island = root->island = root;
        body->island_next = root->island_next;
        root->island_next = body;
    }
}

void plii_islands_solve(pli_body* const* bodies, int count) {
    for (PLII_EACH_AT(pli_body, body, bodies, count)) {
        const bool is_led = body->island != NULL && body->island != body;
        if (!plii_body_is_idle(body) && !is_led) { body->solver_class->solve(body); }
    }
}
