/* What there is: making, finding and destroying it. */

#include "calls.h"

#include <stdlib.h>
#include <string.h>

#define PICK(c, array, member, count)                                                                                  \
    do {                                                                                                               \
        const int first = bytes_below(&(c)->bytes, count);                                                             \
        for (int i = 0; i < (count); ++i) {                                                                            \
            if ((c)->array[(first + i) % (count)].member != NULL) { return &(c)->array[(first + i) % (count)]; }       \
        }                                                                                                              \
    } while (0)

// ------------------------------------------------------------------------------------------------- contexts

/* What one block may take: requests that are absurd fail as they would for want of memory. */
enum { MOST_BYTES = 12 << 20 };

static void* allocate(size_t size, size_t alignment, void* user) {
    calls_context* home = user;
    if (home->fail_in > 0 && --home->fail_in == 0) {
        ++home->calls->report->failed_allocations;
        if (--home->fail_count > 0) { home->fail_in = 1; }
        return NULL;
    }
    if (size > MOST_BYTES) { return NULL; }
    void* block = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (block != NULL) { home->alive += size; }
    return block;
}

static void release(void* block, size_t size, void* user) {
    calls_context* home = user;
    home->alive -= size;
    free(block);
}

static void log_line(pli_log_level level, const char* message, void* user) {
    calls_context* home = user;
    home->errors += level == PLI_LOG_ERROR;
    if (message[0] == '\0') { calls_finding(home->calls, "an empty line in the log"); }
}

/* In pieces, the last one first: results must not depend on it. */
static void parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
    (void)user;
    const int piece = grain > 0 ? grain : 1;
    for (int end = count; end > 0;) {
        const int begin = (end - 1) / piece * piece;
        range(begin, end, task);
        end = begin;
    }
}

static bool open_context(calls* c, calls_context* home) {
    home->calls = c;
    pli_context_def def = pli_context_def_default();
    def.allocator = (pli_allocator){allocate, release, home};
    def.log = log_line;
    def.log_user = home;
    const int choice = bytes_next(&c->bytes);
    if (choice % 2 == 1) { def.parallel_for = parallel_for; }
    def.simd = (pli_simd)(choice / 2 % 6);
    pli_status status = pli_context_create(&def, &home->context);
    if (status != PLI_OK) { /* this processor has not got that */
        def.simd = PLI_SIMD_BEST;
        status = pli_context_create(&def, &home->context);
    }
    return status == PLI_OK;
}

calls_context* calls_any_context(calls* c) {
    PICK(c, contexts, context, CALLS_CONTEXTS);
    return NULL;
}

void calls_fail_allocations(calls* c) {
    calls_context* home = calls_any_context(c);
    const int in = 1 + bytes_next(&c->bytes);
    const int count = bytes_flag(&c->bytes) ? 1 : 1000;
    if ((c->kinds & RANDOM_CALLS_ALLOCATIONS) == 0) { return; }
    home->fail_in = home->fail_in > 0 && count == 1 ? 0 : in;
    home->fail_count = count;
}

// --------------------------------------------------------------------------------------------------- worlds

bool calls_may_mix(const calls* c, const calls_context* home, const calls_world* world) {
    return home == world->home || (c->kinds & RANDOM_CALLS_MIXTURES) != 0;
}

bool calls_is_stepping(const calls_world* world) {
    return pli_world_is_stepping(world->world);
}

/* The handles of what goes with a world. */
static void forget_world(calls* c, calls_world* world) {
    for (int i = 0; i < CALLS_BODIES; ++i) {
        if (c->bodies[i].world == world) { c->bodies[i] = (calls_body){0}; }
    }
    for (int i = 0; i < CALLS_RIGIDS; ++i) {
        if (c->rigids[i].world == world) { c->rigids[i] = (calls_rigid){0}; }
    }
}

static void destroy_world(calls* c, calls_world* world) {
    pli_world* gone = world->world;
    if (gone == NULL) { return; }
    calls_context* home = world->home;
    forget_world(c, world);
    *world = (calls_world){0};
    VOID_CALL(c, home, pli_world_destroy(gone));
}

void calls_make_world(calls* c) {
    calls_world* world = &c->worlds[bytes_below(&c->bytes, CALLS_WORLDS)];
    calls_context* home = calls_any_context(c);
    destroy_world(c, world);
    pli_world_def def = pli_world_def_default();
    if (bytes_seldom(&c->bytes, 128)) {
        def.gravity = bytes_vec3(&c->bytes, -20.0f, 20.0f);
        def.air_density = bytes_float(&c->bytes, 0.0f, 2.0f);
        def.max_force_displacement = bytes_float(&c->bytes, 0.1f, 1000.0f);
        def.preallocates = bytes_flag(&c->bytes);
    }
    def.user_data = c;
    pli_world* made = NULL;
    if (CALL(c, home, pli_world_create(home->context, &def, &made)) == PLI_OK) {
        *world = (calls_world){made, home};
        c->digest = calls_digest(c);
    }
}

calls_world* calls_any_world(calls* c) {
    PICK(c, worlds, world, CALLS_WORLDS);
    calls_make_world(c);
    PICK(c, worlds, world, CALLS_WORLDS);
    return NULL;
}

// --------------------------------------------------------------------------------------- meshes and shapes

static void destroy_mesh(calls* c, calls_mesh* place) {
    const calls_mesh gone = *place;
    if (gone.mesh == NULL) { return; }
    *place = (calls_mesh){0};
    VOID_CALL(c, gone.home, pli_mesh_destroy(gone.mesh));
}

static void destroy_shape(calls* c, calls_shape* place) {
    const calls_shape gone = *place;
    if (gone.shape == NULL) { return; }
    *place = (calls_shape){0};
    VOID_CALL(c, gone.home, pli_shape_release(gone.shape));
}

calls_mesh* calls_mesh_place(calls* c) {
    calls_mesh* place = &c->meshes[bytes_below(&c->bytes, CALLS_MESHES)];
    destroy_mesh(c, place);
    return place;
}

calls_shape* calls_shape_place(calls* c) {
    calls_shape* place = &c->shapes[bytes_below(&c->bytes, CALLS_SHAPES)];
    destroy_shape(c, place);
    return place;
}

calls_mesh* calls_any_mesh(calls* c) {
    PICK(c, meshes, mesh, CALLS_MESHES);
    calls_make_mesh(c);
    PICK(c, meshes, mesh, CALLS_MESHES);
    return NULL;
}

calls_shape* calls_any_shape(calls* c) {
    PICK(c, shapes, shape, CALLS_SHAPES);
    calls_make_shape(c);
    PICK(c, shapes, shape, CALLS_SHAPES);
    return NULL;
}

// ---------------------------------------------------------------------------------------------- soft bodies

static void destroy_body(calls* c, calls_body* place) {
    const calls_body gone = *place;
    if (gone.body == NULL || calls_is_stepping(gone.world)) { return; }
    *place = (calls_body){0};
    VOID_CALL(c, gone.world->home, pli_body_destroy(gone.body));
}

void calls_make_body(calls* c) {
    calls_world* world = calls_any_world(c);
    const calls_mesh* mesh = calls_any_mesh(c);
    calls_body* place = &c->bodies[bytes_below(&c->bytes, CALLS_BODIES)];
    if (world == NULL || mesh == NULL || !calls_may_mix(c, mesh->home, world)) { return; }
    destroy_body(c, place);
    if (place->body != NULL) { return; }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.05f;
    def.user_data = c;
    if (bytes_seldom(&c->bytes, 100)) {
        def.collision_margin = bytes_float(&c->bytes, 0.0f, 0.5f);
        def.solver.position_iterations = bytes_small(&c->bytes, 0, 4);
        def.solver.velocity_iterations = bytes_small(&c->bytes, 0, 2);
        def.solver.drift_iterations = bytes_small(&c->bytes, 0, 2);
        def.solver.velocity_damping = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.solver.drift_correction = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.solver.time_scale = bytes_float(&c->bytes, 0.5f, 2.0f);
    }
    pli_body* made = NULL;
    if (CALL(c, world->home, pli_body_create(world->world, mesh->mesh, &def, &made)) == PLI_OK) {
        *place = (calls_body){made, world};
        c->digest = calls_digest(c);
        ++c->report->bodies;
    }
}

calls_body* calls_any_body(calls* c) {
    PICK(c, bodies, body, CALLS_BODIES);
    calls_make_body(c);
    PICK(c, bodies, body, CALLS_BODIES);
    return NULL;
}

// --------------------------------------------------------------------------------------------- rigid bodies

static void destroy_rigid(calls* c, calls_rigid* place) {
    const calls_rigid gone = *place;
    if (gone.rigid == NULL || calls_is_stepping(gone.world)) { return; }
    *place = (calls_rigid){0};
    VOID_CALL(c, gone.world->home, pli_rigid_destroy(gone.rigid));
}

void calls_make_rigid(calls* c) {
    calls_world* world = calls_any_world(c);
    calls_rigid* place = &c->rigids[bytes_below(&c->bytes, CALLS_RIGIDS)];
    if (world == NULL) { return; }
    destroy_rigid(c, place);
    if (place->rigid != NULL) { return; }
    pli_rigid_def def = pli_rigid_def_default();
    pli_shape* shapes[2] = {NULL, NULL};
    pli_transform poses[2];
    def.shape_count = bytes_small(&c->bytes, 1, 2);
    for (int i = 0; i < 2 && i < def.shape_count; ++i) {
        const calls_shape* shape = calls_any_shape(c);
        if (shape == NULL || !calls_may_mix(c, shape->home, world)) { return; }
        shapes[i] = shape->shape;
        poses[i] = bytes_transform(&c->bytes, 0.5f);
    }
    def.shapes = shapes;
    def.shape_poses = bytes_flag(&c->bytes) ? poses : NULL;
    def.kind = (pli_rigid_kind)bytes_small(&c->bytes, 0, 2);
    def.state.pose = bytes_transform(&c->bytes, 1.0f);
    def.state.linear_velocity = bytes_vec3(&c->bytes, -3.0f, 3.0f);
    def.state.inverse_mass = bytes_float(&c->bytes, 0.1f, 2.0f);
    const float inertia = bytes_float(&c->bytes, 0.1f, 5.0f);
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], inertia);
    }
    if (bytes_seldom(&c->bytes, 64)) {
        def.friction = bytes_float(&c->bytes, 0.0f, 1.0f);
        def.linear_factor = bytes_vec3(&c->bytes, 0.0f, 1.0f);
        def.angular_factor = bytes_vec3(&c->bytes, 0.0f, 1.0f);
    }
    def.user_data = c;
    pli_rigid* made = NULL;
    if (CALL(c, world->home, pli_rigid_create(world->world, &def, &made)) == PLI_OK) {
        *place = (calls_rigid){made, world};
        c->digest = calls_digest(c);
        ++c->report->rigids;
    }
}

calls_rigid* calls_any_rigid(calls* c) {
    PICK(c, rigids, rigid, CALLS_RIGIDS);
    calls_make_rigid(c);
    PICK(c, rigids, rigid, CALLS_RIGIDS);
    return NULL;
}

// ------------------------------------------------------------------------------------------ life and death

void calls_destroy_something(calls* c) {
    const int which = bytes_next(&c->bytes), kind = bytes_below(&c->bytes, 8);
    if (kind == 0) { destroy_world(c, &c->worlds[which % CALLS_WORLDS]); }
    if (kind == 1 || kind == 2) { destroy_body(c, &c->bodies[which % CALLS_BODIES]); }
    if (kind == 3 || kind == 4) { destroy_rigid(c, &c->rigids[which % CALLS_RIGIDS]); }
    if (kind == 5 || kind == 6) { destroy_shape(c, &c->shapes[which % CALLS_SHAPES]); }
    if (kind == 7) { destroy_mesh(c, &c->meshes[which % CALLS_MESHES]); }
}

bool calls_open(calls* c) {
    bool is_open = true;
    for (int i = 0; i < CALLS_CONTEXTS; ++i) {
        is_open = is_open && open_context(c, &c->contexts[i]);
    }
    c->digest = calls_digest(c);
    return is_open;
}

static void close_context(calls* c, calls_context* home) {
    if (home->context == NULL) { return; }
    const size_t left = pli_context_allocated_bytes(home->context);
    if (left != 0) { calls_finding(c, "%d bytes left in a context", (int)left); }
    pli_context_destroy(home->context);
    home->context = NULL;
    if (home->alive != 0 && left == 0) { calls_finding(c, "%d bytes left in an allocator", (int)home->alive); }
}

void calls_close(calls* c) {
    const int order = bytes_next(&c->bytes);
    for (int part = 0; part < 3; ++part) {
        const int kind = (part + order) % 3;
        for (int i = 0; i < CALLS_MESHES && kind == 0; ++i) {
            destroy_mesh(c, &c->meshes[(i + order) % CALLS_MESHES]);
        }
        for (int i = 0; i < CALLS_SHAPES && kind == 1; ++i) {
            destroy_shape(c, &c->shapes[(i + order) % CALLS_SHAPES]);
        }
        for (int i = 0; i < CALLS_BODIES && kind == 2 && order % 2 == 1; ++i) {
            destroy_body(c, &c->bodies[(i + order) % CALLS_BODIES]);
        }
        for (int i = 0; i < CALLS_RIGIDS && kind == 2 && order % 4 >= 2; ++i) {
            destroy_rigid(c, &c->rigids[(i + order) % CALLS_RIGIDS]);
        }
        for (int i = 0; i < CALLS_WORLDS && kind == 2; ++i) {
            destroy_world(c, &c->worlds[(i + order) % CALLS_WORLDS]);
        }
    }
    for (int i = 0; i < CALLS_CONTEXTS; ++i) {
        close_context(c, &c->contexts[i]);
    }
    if (c->custom_shapes != 0) { calls_finding(c, "%d shapes of one's own were not destroyed", c->custom_shapes); }
}
