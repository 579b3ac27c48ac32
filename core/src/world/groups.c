#include "world/world_impl.h"

#include "base/csr.h"
#include "base/union_find.h"
#include "body/pipeline.h"

/* Nodes of a part that is worth a thread: a microsecond or two to hand it over, against some 5 ns per node of a
   prediction and 100 of a solve. A body costs a prediction or a contact as much as some nodes; forces, and the implicit
   solver, which solves there, take longer per node. Memory of a body that another thread has changed comes back to the
   one that reads it in most of a microsecond: for less work a body stays where it is. */
enum { GROUPS_PREDICT_NODES = 2048, GROUPS_SOLVE_NODES = 256 };
enum { GROUPS_BODY_NODES = 16, GROUPS_FORCES_TIMES = 8, GROUPS_IMPLICIT_TIMES = 32 };
enum { GROUPS_MOVED_SOLVE_NODES = 8, GROUPS_MOVED_PREDICT_NODES = 160 };

bool plii_groups_reserve(pli_world* world, int body_count) {
    if (world->context->def.parallel_for == NULL) { return true; }
    return PLII_RESERVE(world->context, &world->group_roots, &world->group_root_capacity, body_count) &&
           PLII_RESERVE(world->context, &world->group_begin, &world->group_begin_capacity, body_count + 1) &&
           PLII_RESERVE(world->context, &world->group_bodies, &world->group_body_capacity, body_count);
}

/* What a thread more is worth to the prediction. Where solves are parted, bodies go to other threads anyway. */
static int64_t groups_prediction(const pli_body* body) {
    if (plii_body_is_idle(body)) { return 0; }
    const int times = body->solver_class->solves_constraints          ? GROUPS_IMPLICIT_TIMES
                      : !plii_stage_is_empty(body, PLII_STAGE_FORCES) ? GROUPS_FORCES_TIMES
                                                                      : 1;
    const int64_t nodes = GROUPS_BODY_NODES + (int64_t)body->node_count * times;
    const int moved = body->world->are_groups_parted ? 0 : GROUPS_MOVED_PREDICT_NODES;
    return nodes > moved ? nodes - moved : 0;
}

/* The same to the solve. */
static int64_t groups_solution(const pli_body* body) {
    const int nodes = body->node_count;
    return nodes > GROUPS_MOVED_SOLVE_NODES && !plii_body_is_idle(body) ? nodes - GROUPS_MOVED_SOLVE_NODES : 0;
}

/* Whether anything in the step is worth a second thread. */
static bool groups_are_worth_it(const pli_world* world) {
    int64_t nodes = 0, prediction = 0;
    for (int i = 0; i < world->body_count; ++i) {
        nodes += groups_solution(world->bodies[i]);
        prediction += groups_prediction(world->bodies[i]);
        if (nodes >= 2 * GROUPS_SOLVE_NODES || prediction >= 2 * GROUPS_PREDICT_NODES) { return true; }
    }
    return false;
}

void plii_groups_start(pli_world* world) {
    /* A profile function is told of one thing after the other. Distances of reference mode fill caches. */
    world->has_groups = world->context->def.parallel_for != NULL && world->body_count > 1 && world->profile == NULL &&
                        !world->def.reference_mode && groups_are_worth_it(world);
    if (!world->has_groups) { return; }
    plii_union_start(world->body_count, world->group_roots);
    for (int i = 0; i < world->rigid_count; ++i) {
        world->rigids[i]->first_body = PLI_NULL_INDEX;
    }
}

void plii_groups_join_rigid(pli_world* world, const pli_body* body, pli_rigid* rigid) {
    if (!world->has_groups || rigid->kind == PLI_RIGID_STATIC) { return; }
    if (rigid->first_body == PLI_NULL_INDEX) {
        rigid->first_body = body->world_index;
    } else {
        plii_union_join(world->group_roots, rigid->first_body, body->world_index);
    }
}

void plii_groups_join_bodies(pli_world* world, const pli_body* body, const pli_body* other) {
    if (!world->has_groups) { return; }
    plii_union_join(world->group_roots, body->world_index, other->world_index);
}

/* Beyond the pairs that have met: by anchors and joints. */
static void groups_join_held(pli_body* other, pli_rigid* rigid, void* user) {
    const pli_body* body = user;
    if (rigid != NULL) { plii_groups_join_rigid(body->world, body, rigid); }
}

/* Groups in the order of their first bodies, and bodies in their order. A root is the first body of its group. */
static void groups_list(pli_world* world) {
    int* begin = world->group_begin;
    int* roots = world->group_roots;
    plii_union_flatten(world->body_count, roots);
    int count = 0;
    for (int i = 0; i < world->body_count; ++i) {
        if (roots[i] == i) {
            begin[count] = 0;
            roots[i] = -1 - count++; /* the number of the group; those after it look there */
        } else {
            roots[i] = roots[roots[i]];
        }
        ++begin[-1 - roots[i]];
    }
    world->group_count = count;
    plii_csr_sum(count, begin);
    for (int i = world->body_count - 1; i >= 0; --i) {
        world->group_bodies[--begin[-1 - roots[i]]] = world->bodies[i];
    }
}

static int64_t groups_nodes(pli_body* const* bodies, int count) {
    int64_t nodes = 0;
    for (int i = 0; i < count; ++i) {
        nodes += groups_solution(bodies[i]);
    }
    return nodes;
}

bool plii_groups_find(pli_world* world) {
    world->are_groups_parted = false;
    if (!world->has_groups) { return false; }
    if (groups_nodes(world->bodies, world->body_count) < 2 * (int64_t)GROUPS_SOLVE_NODES) { return false; }
    for (PLII_EACH_BODY(body, world)) {
        if (!plii_body_is_idle(body)) { plii_features_visit_joined(body, groups_join_held, body); }
    }
    groups_list(world);
    return world->group_count > 1;
}

/* How many of `count` items with so many nodes make a part that has `worth` nodes; all, where that is not two parts. */
static int groups_part(int count, int64_t nodes, int worth) {
    const int64_t part = nodes >= 2 * (int64_t)worth ? ((int64_t)worth * count + nodes - 1) / nodes : count;
    return part < count ? (int)part : count;
}

typedef struct groups_task {
    pli_world* world;
    void (*run_group)(pli_body* const* bodies, int count);
    void (*run_body)(pli_body* body);
    int alone; /* was done before */
} groups_task;

static void groups_range(int begin, int end, void* data) {
    const groups_task* task = data;
    pli_world* world = task->world;
    for (int i = begin; i < end; ++i) {
        if (i == task->alone) { continue; }
        if (task->run_body != NULL) {
            if (!plii_body_is_idle(world->bodies[i])) { task->run_body(world->bodies[i]); }
            continue;
        }
        const int first = world->group_begin[i];
        task->run_group(&world->group_bodies[first], world->group_begin[i + 1] - first);
    }
}

/* An item of more than half of all nodes runs before the others, and parts its ranges. False: too few, nothing done. */
static bool groups_run(groups_task* task, int count, int64_t least, int worth) {
    const pli_world* world = task->world;
    int64_t nodes = 0, largest = -1;
    int largest_item = PLI_NULL_INDEX, busy = 0;
    for (int i = 0; i < count; ++i) {
        const int first = world->group_begin[i];
        const int64_t size = task->run_body != NULL
                                 ? groups_prediction(world->bodies[i])
                                 : groups_nodes(&world->group_bodies[first], world->group_begin[i + 1] - first);
        nodes += size;
        busy += size > 0 ? 1 : 0;
        if (size > largest) {
            largest = size;
            largest_item = i;
        }
    }
    if (nodes < least) { return false; }
    task->alone = PLI_NULL_INDEX;
    if (2 * largest > nodes) {
        groups_range(largest_item, largest_item + 1, task);
        task->alone = largest_item;
        nodes -= largest;
        busy -= 1;
    }
    plii_parallel_for(world->context, groups_range, task, count, busy > 1 ? groups_part(count, nodes, worth) : count);
    return true;
}

void plii_groups_run(pli_world* world, void (*run)(pli_body* const* bodies, int count)) {
    groups_task task = {.world = world, .run_group = run};
    (void)groups_run(&task, world->group_count, 0, GROUPS_SOLVE_NODES);
    world->are_groups_parted = task.alone == PLI_NULL_INDEX;
}
bool plii_groups_run_bodies(pli_world* world, void (*run)(pli_body* body)) {
    groups_task task = {.world = world, .run_body = run};
    return groups_run(&task, world->body_count, 2 * (int64_t)GROUPS_PREDICT_NODES, GROUPS_PREDICT_NODES);
}

int plii_groups_grain(const pli_world* world, int count, int64_t nodes) {
    const int64_t each = world->are_groups_parted ? GROUPS_BODY_NODES : -GROUPS_MOVED_PREDICT_NODES;
    return groups_part(count, nodes > 0 ? nodes + each * count : 0, GROUPS_PREDICT_NODES);
}
