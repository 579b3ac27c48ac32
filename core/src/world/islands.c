#include "world/world_impl.h"

#include "base/union_find.h"
#include "body/pipeline.h"

void plii_islands_start(pli_world* world) {
    if (!world->has_islands) { return; }
    for (int i = 0; i < world->body_count; ++i) {
        world->bodies[i]->island = world->bodies[i]->island_next = NULL;
    }
    world->has_islands = false;
}

/* As many sweeps and substeps of one length. */
static bool islands_are_in_step(const pli_body* body, const pli_body* other) {
    const plii_solver_class* solver = body->solver_class;
    if (other->solver_class != solver || other->step.dt != body->step.dt) { return false; }
    const plii_solver_pace a = solver->pace(body), b = solver->pace(other);
    return a.substeps == b.substeps && a.sweeps == b.sweeps;
}

void plii_world_join_bodies(pli_world* world, pli_body* body, pli_body* other) {
    if (!islands_are_in_step(body, other)) { return; }
    const bool was_locked = plii_context_lock(world->context); /* pairs may meet on several threads */
    if (!world->has_islands) {
        plii_union_start(world->body_count, world->islands);
        world->has_islands = true;
    }
    plii_union_join(world->islands, body->world_index, other->world_index);
    plii_context_unlock(world->context, was_locked);
}

/* From the last body, so that lists come in the order of bodies. The root is the first one. */
void plii_islands_find(pli_world* world) {
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

static inline void islands_run(pli_body* first, void (*run)(pli_body* body)) {
    for (pli_body* body = first; body != NULL; body = body->island_next) {
        plii_world_begin_body(body);
        run(body);
    }
}

static void islands_settle(pli_body* body) {
    plii_run_stage(body, PLII_STAGE_SETTLE);
}

static void islands_solve(pli_body* first) {
    const plii_solver_class* solver = first->solver_class;
    const plii_solver_pace pace = solver->pace(first);
    islands_run(first, solver->begin);
    for (int substep = 0; substep < pace.substeps; ++substep) {
        for (int sweep = 0; sweep < pace.sweeps; ++sweep) {
            islands_run(first, solver->sweep);
            islands_run(first, solver->couple);
        }
        islands_run(first, islands_settle);
    }
    islands_run(first, solver->end);
    for (pli_body* body = first; body != NULL; body = body->island_next) {
        body->is_solved = true;
    }
}

void plii_islands_solve(pli_body* const* bodies, int count) {
    for (int i = 0; i < count; ++i) {
        pli_body* body = bodies[i];
        const bool is_led = body->island != NULL && body->island != body;
        if (!plii_body_is_idle(body) && !is_led) { islands_solve(body); }
    }
}
