/* A body's life and state: cooking a mesh, access to nodes, measures. Features live in their own files. */

#include "body/pipeline.h"
#include "math/bounds.h"
#include "math/dvec3.h"
#include "mesh/mesh_impl.h"

#include <stdio.h>

// --------------------------------------------------------------------------------------------------- checks

pli_status plii_check_body_change(const pli_body* body, const char* function) {
    PLII_TRY(plii_check_body(body, function));
    return plii_check_world_change(body->world, function);
}
pli_status plii_check_body_idle(const pli_body* body, const char* function) {
    PLII_TRY(plii_check_body(body, function));
    return plii_check_world_idle(body->world, function);
}
pli_status plii_check_node(const pli_body* body, int node, const char* function) {
    PLII_TRY(plii_check_body(body, function));
    return plii_check_index(body->context, node, body->node_count, "node", "body", function);
}
pli_status plii_check_faces(const pli_body* body, const char* need, const char* function) {
    if (body->topology->face_count > 0) { return PLI_OK; }
    return plii_fail(body->context, PLI_ERROR_INVALID_MESH, function, "%s, the body has none", need);
}

static const plii_field solver_fields[] = {
    PLII_FIELD(pli_solver_settings, velocity_iterations, 0, INT_MAX),
    PLII_FIELD(pli_solver_settings, position_iterations, 0, INT_MAX),
    PLII_FIELD(pli_solver_settings, drift_iterations, 0, INT_MAX),
    PLII_FIELD(pli_solver_settings, drift_correction, -PLI_MAX_FACTOR, PLI_MAX_FACTOR),
    PLII_FIELD(pli_solver_settings, velocity_damping, 0, 1),
    PLII_FIELD(pli_solver_settings, time_scale, PLI_MIN_TIME_SCALE, PLI_MAX_TIME_SCALE),
};

// ----------------------------------------------------------------------------------------------------- life

PLII_DEFINE_DEFAULT(pli_body_def, .collision_margin = PLI_MARGIN_OF_MESH,
                    .solver = {.position_iterations = 8, .drift_correction = 1.0f, .time_scale = 1.0f})

static bool body_needs_link_tags(const pli_mesh* mesh) {
    for (int i = 0; i < mesh->link_count; ++i) {
        if (mesh->links[i].material != 0 || mesh->links[i].is_bending) { return true; }
    }
    return false;
}

bool plii_body_allocate_arrays(pli_body* body, bool has_tags) {
    const size_t block_size = plii_body_node_block_size(body);
    if (!plii_allocate_array(body->context, (void**)&body->positions, block_size)) { return false; }
    if (body->positions != NULL) {
        const size_t stride = block_size / 3 / sizeof(pli_vec4);
        body->previous = body->positions + stride;
        body->velocities = body->previous + stride;
    }
    return PLII_ALLOCATE(body->context, &body->links, body->link_count) &&
           PLII_ALLOCATE(body->context, &body->link_tags, has_tags ? body->link_count : 0);
}

void plii_body_release_arrays(pli_body* body) {
    plii_release(body->context, body->positions, plii_body_node_block_size(body));
    PLII_RELEASE(body->context, body->links, body->link_count);
    PLII_RELEASE(body->context, body->link_tags, body->link_count);
    plii_topology_release(body->context, body->topology);
}

static void body_release(pli_body* body) {
    plii_feature_disable_all(body);
    plii_body_release_arrays(body);
    PLII_RELEASE(body->context, body->materials, body->material_count);
    PLII_RELEASE(body->context, body->ignored_rigids, body->ignored_rigid_capacity);
    plii_handle_release(body->context, body, PLII_HANDLE_BODY, sizeof *body);
}

static double mesh_distance(const pli_mesh* mesh, int a, int b) {
    return (double)pli_vec3_length(pli_vec3_sub(mesh->positions[a], mesh->positions[b]));
}

/* See PLI_MARGIN_OF_MESH. */
static float body_margin_of_mesh(const pli_world* world, const pli_mesh* mesh) {
    const float most = 0.25f;
    double sum = 0;
    int count = 0;
    for (int i = 0; i < mesh->link_count; ++i) {
        if (mesh->links[i].is_bending) { continue; }
        sum += mesh_distance(mesh, mesh->links[i].nodes[0], mesh->links[i].nodes[1]);
        ++count;
    }
    for (int i = 0; i < mesh->face_count && mesh->link_count == 0; ++i) {
        const int* nodes = mesh->faces[i].nodes;
        sum += mesh_distance(mesh, nodes[0], nodes[1]) + mesh_distance(mesh, nodes[1], nodes[2]) +
               mesh_distance(mesh, nodes[2], nodes[0]);
        count += 3;
    }
    return count > 0 && !world->def.reference_mode ? fminf((float)(0.5 * sum / count), most) : most;
}

/* False when out of memory. */
static bool body_cook(pli_body* body, const pli_mesh* mesh, const pli_body_def* def) {
    body->user_data = def->user_data;
    body->solver = def->solver;
    body->collision_margin =
        def->collision_margin != PLI_MARGIN_OF_MESH ? def->collision_margin : body_margin_of_mesh(body->world, mesh);
    memcpy(body->materials, mesh->materials, (size_t)body->material_count * sizeof *body->materials);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 p = mesh->positions[i];
        body->positions[i] = (pli_vec4){p.x, p.y, p.z, mesh->inverse_masses[i]};
        plii_set_xyz(&body->previous[i], p);
    }
    for (int i = 0; i < body->link_count; ++i) {
        const pli_link* link = &mesh->links[i];
        const float rest_length = (float)mesh_distance(mesh, link->nodes[0], link->nodes[1]);
        body->links[i] = (plii_link){{link->nodes[0], link->nodes[1]}, rest_length * rest_length};
        if (body->link_tags != NULL) {
            body->link_tags[i] = (plii_link_tag)(link->material | (link->is_bending ? PLII_LINK_TAG_BENDING : 0));
        }
    }
    plii_body_update_bounds(body);
    return plii_feature_enable(body, &plii_links_class, NULL) == PLI_OK;
}

pli_body* plii_body_make(pli_world* world, int node_count, int link_count, int material_count, bool has_tags,
                         plii_topology* topology, const pli_mesh* mesh, const pli_body_def* def) {
    pli_body* made = plii_handle_create(world->context, PLII_HANDLE_BODY, sizeof *made);
    if (made == NULL) {
        plii_topology_release(world->context, topology);
        return NULL;
    }
    made->world = world;
    made->context = world->context;
    made->solver_class = &plii_position_solver;
    made->sweep_links = plii_links_sweep;
    made->interval.steps = 1;
    plii_body_was_put(made);
    made->node_count = node_count;
    made->link_count = link_count;
    made->material_count = material_count;
    made->topology = topology;
    if (topology != NULL && plii_body_allocate_arrays(made, has_tags) &&
        PLII_ALLOCATE(world->context, &made->materials, material_count) &&
        (mesh == NULL || body_cook(made, mesh, def)) && plii_world_add_body(world, made) == PLI_OK) {
        return made;
    }
    body_release(made);
    return NULL;
}

pli_status pli_body_create(pli_world* world, const pli_mesh* mesh, const pli_body_def* def, pli_body** body) {
    PLII_TRY(plii_check_world_idle(world, __func__));
    pli_context* context = world->context;
    if (body == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "body is null"); }
    PLII_TRY(plii_check_handle(mesh, PLII_HANDLE_MESH, context, NULL, __func__));
    const pli_body_def used = def != NULL ? *def : pli_body_def_default();
    PLII_TRY(PLII_CHECK_MADE(context, pli_body_def, &used, __func__));
    PLII_TRY(PLII_CHECK_FIELDS(context, &used.solver, solver_fields, __func__));
    if (used.collision_margin != PLI_MARGIN_OF_MESH) {
        PLII_TRY(plii_check_margin(context, used.collision_margin, __func__));
    }
    if (mesh->node_count == 0) { return PLII_FAIL(context, PLI_ERROR_INVALID_MESH, "the mesh has no nodes"); }
    PLII_FAIL_IF(mesh->material_count > PLII_MAX_MATERIALS, context, PLI_ERROR_INVALID_MESH, __func__,
                 "the mesh has %d materials, at most %d are possible", mesh->material_count, PLII_MAX_MATERIALS);

    /* Bodies share the faces of their mesh, which the mesh keeps count of. */
    plii_topology* topology = plii_mesh_acquire_topology((pli_mesh*)(uintptr_t)mesh, context);
    pli_body* made = plii_body_make(world, mesh->node_count, mesh->link_count, mesh->material_count,
                                    body_needs_link_tags(mesh), topology, mesh, &used);
    PLII_FAIL_IF(made == NULL, context, PLI_ERROR_OUT_OF_MEMORY, __func__, "no memory for %d nodes and %d links",
                 mesh->node_count, mesh->link_count);
    *body = made;
    return PLI_OK;
}

void pli_body_destroy(pli_body* body) {
    if (body == NULL || plii_check_body_idle(body, __func__) != PLI_OK) { return; }
    plii_world_remove_body(body->world, body);
    body_release(body);
}

// ------------------------------------------------------------------------------------------------- settings

PLII_DEFINE_GET(pli_world*, pli_body_get_world, body, body->world, NULL)
PLII_DEFINE_GET(void*, pli_body_get_user_data, body, body->user_data, NULL)
pli_status pli_body_set_user_data(pli_body* body, void* user_data) {
    PLII_TRY(plii_check_body(body, __func__));
    body->user_data = user_data;
    return PLI_OK;
}

PLII_DEFINE_GET(pli_solver_settings, pli_body_get_solver_settings, body, body->solver, (pli_solver_settings){0})
pli_status pli_body_set_solver_settings(pli_body* body, const pli_solver_settings* settings) {
    PLII_TRY(plii_check_body_change(body, __func__));
    if (settings == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "settings is null"); }
    PLII_TRY(PLII_CHECK_FIELDS(body->context, settings, solver_fields, __func__));
    body->solver = *settings;
    return plii_body_changed(body, PLI_OK);
}

PLII_DEFINE_GET(float, pli_body_get_collision_margin, body, body->collision_margin, 0.0f)
pli_status pli_body_set_collision_margin(pli_body* body, float margin) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_margin(body->context, margin, __func__));
    const float grown = margin - body->collision_margin;
    body->collision_margin = margin;
    if (body->world->is_stepping) { /* bounds that hold the way of the step stay so */
        body->bounds = plii_bounds_grow(body->bounds, grown);
    } else {
        plii_body_update_bounds(body);
    }
    return plii_body_changed(body, PLI_OK);
}

void plii_body_refresh_in_step(pli_body* body) {
    if (plii_solver_update_bounds(body) && plii_solver_check_velocities(body)) {
        plii_run_stage(body, PLII_STAGE_REFRESH);
    }
}
void plii_body_refresh(pli_body* body) {
    plii_walk walk;
    plii_walk_begin(&walk, body->context, PLII_WALK_STEP);
    plii_body_refresh_in_step(body);
    plii_walk_end(&walk);
}

pli_bounds plii_body_face_box(int face, const void* user) {
    const pli_body* body = user;
    return plii_bounds_of_face(body->positions, body->topology->faces[face]);
}

// ---------------------------------------------------------------------------------------------------- state

pli_body_view pli_body_get_view(const pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return (pli_body_view){0}; }
    const plii_topology* topology = body->topology;
    return (pli_body_view){.node_count = body->node_count,
                           .link_count = body->link_count,
                           .face_count = topology->face_count,
                           .tetra_count = topology->tetra_count,
                           .positions = body->positions,
                           .previous = body->previous,
                           .velocities = body->velocities,
                           .normals = body->normals,
                           .link_nodes = body->link_count > 0 ? body->links[0].nodes : NULL,
                           .link_node_stride = (int)(sizeof(plii_link) / sizeof(int)),
                           .face_nodes = topology->face_count > 0 ? topology->faces[0] : NULL,
                           .tetra_nodes = topology->tetra_count > 0 ? topology->tetras[0] : NULL};
}

/* Vector by vector, as they are stored: the whole has to wait for its parts right after a prediction. */
pli_bounds pli_body_get_bounds(const pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return (pli_bounds){{0, 0, 0}, {0, 0, 0}}; }
    return (pli_bounds){body->bounds.min, body->bounds.max};
}

static pli_status body_check_link(const pli_body* body, int link, const char* function) {
    PLII_TRY(plii_check_body(body, function));
    return plii_check_index(body->context, link, body->link_count, "link", "body", function);
}
float pli_body_get_rest_length(const pli_body* body, int link) {
    return body_check_link(body, link, __func__) == PLI_OK ? sqrtf(body->links[link].rest_length_squared) : 0.0f;
}

pli_status plii_body_check_between(const pli_body* body, const char* what, int index, float value, float low,
                                   float high, const char* function) {
    if (value >= low && value <= high) { return PLI_OK; }
    char name[40];
    snprintf(name, sizeof name, "%s %d", what, index);
    return plii_check_between(body->context, value, low, high, name, function);
}
/* Of a node, which has to be one. */
static pli_status body_check_vec3(const pli_body* body, const char* what, int node, pli_vec3 value, float limit,
                                  const char* function) {
    PLII_TRY(plii_check_node(body, node, function));
    if (plii_vec3_is_within(value, limit)) { return PLI_OK; }
    char name[40];
    snprintf(name, sizeof name, "%s of node %d", what, node);
    return plii_check_vec3_within(body->context, value, limit, name, function);
}

pli_status pli_body_set_rest_length(pli_body* body, int link, float rest_length) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(body_check_link(body, link, __func__));
    PLII_TRY(
        plii_body_check_between(body, "rest length of link", link, rest_length, 0.0f, PLI_MAX_COORDINATE, __func__));
    body->links[link].rest_length_squared = rest_length * rest_length;
    body->link_revision += 1;
    body->length_revision += 1;
    return plii_body_changed(body, PLI_OK);
}

static pli_status body_check_motion(const pli_body* body, int node, pli_vec3 x, pli_vec3 v, const char* verb,
                                    const char* function) {
    if (plii_is_point(x) && plii_vec3_is_within(v, PLI_MAX_SPEED)) { return PLI_OK; }
    const bool is_finite = plii_vec3_is_finite(x) && plii_vec3_is_finite(v);
    return plii_fail(body->context, is_finite ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_NOT_FINITE, function,
                     "node %d %s at (%g, %g, %g) with (%g, %g, %g) m/s, the limits are %g m and %g m/s", node, verb,
                     (double)x.x, (double)x.y, (double)x.z, (double)v.x, (double)v.y, (double)v.z,
                     (double)PLI_MAX_COORDINATE, (double)PLI_MAX_SPEED);
}

pli_status pli_body_set_state(pli_body* body, const pli_vec3* positions, const pli_vec3* velocities) {
    const pli_vec3 at_rest = {0, 0, 0};
    PLII_TRY(plii_check_body_idle(body, __func__));
    if (positions == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "positions is null"); }
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 velocity = velocities != NULL ? velocities[i] : at_rest;
        PLII_TRY(body_check_motion(body, i, positions[i], velocity, "is", __func__));
    }
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i], positions[i]);
        plii_set_xyz(&body->previous[i], positions[i]);
        plii_set_xyz(&body->velocities[i], velocities != NULL ? velocities[i] : at_rest);
    }
    plii_body_refresh(body);
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_set_node_position(pli_body* body, int node, pli_vec3 position) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(body_check_vec3(body, "position", node, position, PLI_MAX_COORDINATE, __func__));
    plii_set_xyz(&body->positions[node], position);
    plii_set_xyz(&body->previous[node], position);
    plii_body_update_bounds(body);
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_set_node_velocity(pli_body* body, int node, pli_vec3 velocity) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(body_check_vec3(body, "velocity", node, velocity, PLI_MAX_SPEED, __func__));
    plii_set_xyz(&body->velocities[node], velocity);
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_set_node_mass(pli_body* body, int node, float mass) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_node(body, node, __func__));
    if (mass != 0.0f) {
        PLII_TRY(plii_body_check_between(body, "mass of node", node, mass, PLI_MIN_MASS, PLI_MAX_MASS, __func__));
    }
    body->positions[node].w = mass > 0.0f ? 1.0f / mass : 0.0f;
    body->link_revision += 1;
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_transform(pli_body* body, pli_transform transform) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_FAIL_IF(!plii_transform_is_finite(transform), body->context, PLI_ERROR_NOT_FINITE, __func__,
                 "the transform is not finite");
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 position = pli_transform_point(transform, plii_xyz(body->positions[i]));
        const pli_vec3 previous = pli_transform_point(transform, plii_xyz(body->previous[i]));
        const pli_vec3 velocity = pli_mat3_mul_vec3(transform.rotation, plii_xyz(body->velocities[i]));
        PLII_TRY(body_check_motion(body, i, position, velocity, "would be", __func__));
        PLII_TRY(body_check_motion(body, i, previous, velocity, "would start the step", __func__));
    }
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i], pli_transform_point(transform, plii_xyz(body->positions[i])));
        plii_set_xyz(&body->previous[i], pli_transform_point(transform, plii_xyz(body->previous[i])));
        plii_set_xyz(&body->velocities[i], pli_mat3_mul_vec3(transform.rotation, plii_xyz(body->velocities[i])));
    }
    plii_body_was_put(body);
    plii_body_refresh(body);
    return plii_body_changed(body, PLI_OK);
}

/* Of what a node that is not pinned has by now, with what was added before. */
static pli_status body_check_sum(const pli_body* body, const char* what, int node, pli_vec3 sum, float limit,
                                 const char* function) {
    if (!(body->positions[node].w > 0.0f) || plii_vec3_is_within(sum, limit)) { return PLI_OK; }
    return plii_fail(body->context, PLI_ERROR_INVALID_VALUE, function,
                     "the %s node %d would be (%g, %g, %g), the limit is %g", what, node, (double)sum.x, (double)sum.y,
                     (double)sum.z, (double)limit);
}

/* The same to each of some nodes. */
static pli_status body_add_forces(pli_body* body, int begin, int end, pli_vec3 force, const char* function) {
    for (int i = begin; i < end && body->forces != NULL; ++i) {
        const pli_vec3 sum = pli_vec3_add(body->forces[i], force);
        PLII_TRY(body_check_sum(body, "forces on", i, sum, PLI_MAX_FORCE, function));
    }
    PLII_TRY(plii_feature_enable(body, &plii_forces_class, NULL));
    for (int i = begin; i < end; ++i) {
        if (body->positions[i].w > 0.0f) { body->forces[i] = pli_vec3_add(body->forces[i], force); }
    }
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_add_node_force(pli_body* body, int node, pli_vec3 force) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(body_check_vec3(body, "force", node, force, PLI_MAX_FORCE, __func__));
    return body_add_forces(body, node, node + 1, force, __func__);
}

pli_status pli_body_add_force(pli_body* body, pli_vec3 force) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_vec3_within(body->context, force, PLI_MAX_FORCE, "force", __func__));
    return body_add_forces(body, 0, body->node_count, force, __func__);
}

pli_status pli_body_add_velocity(pli_body* body, pli_vec3 velocity) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_vec3_within(body->context, velocity, PLI_MAX_SPEED, "velocity", __func__));
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 sum = pli_vec3_add(plii_xyz(body->velocities[i]), velocity);
        PLII_TRY(body_check_sum(body, "velocity of", i, sum, PLI_MAX_SPEED, __func__));
    }
    for (int i = 0; i < body->node_count; ++i) {
        if (body->positions[i].w > 0.0f) { plii_add_xyz(&body->velocities[i], velocity); }
    }
    return plii_body_changed(body, PLI_OK);
}

PLII_DEFINE_GET(bool, pli_body_is_frozen, body, body->is_frozen, false)
pli_status pli_body_set_frozen(pli_body* body, bool frozen) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    body->is_frozen = frozen;
    return plii_body_changed(body, PLI_OK);
}

// ------------------------------------------------------------------------------------------- ignored rigid bodies

static int body_find_ignored_rigid(const pli_body* body, const pli_rigid* rigid) {
    for (int i = 0; i < body->ignored_rigid_count; ++i) {
        if (body->ignored_rigids[i] == rigid) { return i; }
    }
    return PLI_NULL_INDEX;
}

bool plii_body_ignores_rigid(const pli_body* body, const pli_rigid* rigid) {
    return body_find_ignored_rigid(body, rigid) != PLI_NULL_INDEX;
}
void plii_body_stop_ignoring(pli_body* body, const pli_rigid* rigid) {
    const int index = body_find_ignored_rigid(body, rigid);
    if (index != PLI_NULL_INDEX) { body->ignored_rigids[index] = body->ignored_rigids[--body->ignored_rigid_count]; }
}
bool pli_body_ignores_rigid(const pli_body* body, const pli_rigid* rigid) {
    if (plii_check_body(body, __func__) != PLI_OK) { return false; }
    if (plii_check_handle(rigid, PLII_HANDLE_RIGID, body->context, NULL, __func__) != PLI_OK) { return false; }
    return plii_body_ignores_rigid(body, rigid);
}

pli_status pli_body_ignore_rigid(pli_body* body, pli_rigid* rigid, bool ignore) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_handle(rigid, PLII_HANDLE_RIGID, body->context, NULL, __func__));
    PLII_FAIL_IF(rigid->world != body->world, body->context, PLI_ERROR_INVALID_VALUE, __func__,
                 "the rigid body is in another world");
    if (!ignore) { plii_body_stop_ignoring(body, rigid); }
    if (!ignore || plii_body_ignores_rigid(body, rigid)) { return plii_body_changed(body, PLI_OK); }
    const int count = body->ignored_rigid_count;
    PLII_FAIL_IF(!PLII_RESERVE(body->context, &body->ignored_rigids, &body->ignored_rigid_capacity, count + 1),
                 body->context, PLI_ERROR_OUT_OF_MEMORY, __func__, "no memory for another ignored rigid body");
    body->ignored_rigids[body->ignored_rigid_count++] = rigid;
    return plii_body_changed(body, PLI_OK);
}

// ------------------------------------------------------------------------------------------------- measures

/* FNV-1a over 32-bit words. */
static uint64_t body_hash_words(uint64_t hash, const pli_vec4* records, int count) {
    for (int i = 0; i < count; ++i) {
        uint32_t words[3];
        memcpy(words, &records[i], sizeof words);
        for (int k = 0; k < 3; ++k) {
            hash = (hash ^ words[k]) * 0x100000001b3u;
        }
    }
    return hash;
}

uint64_t pli_body_state_hash(const pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    const uint64_t hash = body_hash_words(0xcbf29ce484222325u, body->positions, body->node_count);
    return body_hash_words(hash, body->velocities, body->node_count);
}

typedef struct body_sums {
    double mass, energy;
    plii_dvec3 momentum;
} body_sums;

/* Of the nodes that are not pinned. */
static body_sums body_sum_up(const pli_body* body) {
    body_sums sums = {0};
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; }
        const double mass = 1.0 / (double)body->positions[i].w;
        const pli_vec3 velocity = plii_xyz(body->velocities[i]);
        sums.mass += mass;
        sums.energy += 0.5 * (double)pli_vec3_length_squared(velocity) / (double)body->positions[i].w;
        sums.momentum = plii_dvec3_add_scaled(sums.momentum, plii_dvec3_from(velocity), mass);
    }
    return sums;
}

PLII_DEFINE_GET(float, pli_body_total_mass, body, (float)body_sum_up(body).mass, 0.0f)
PLII_DEFINE_GET(float, pli_body_kinetic_energy, body, (float)body_sum_up(body).energy, 0.0f)
PLII_DEFINE_GET(pli_vec3, pli_body_momentum, body, plii_dvec3_to_float(body_sum_up(body).momentum),
                pli_vec3_make(0, 0, 0))

float plii_body_stretch(const pli_body* body, int link) {
    const plii_link* at = &body->links[link];
    if (!(at->rest_length_squared > 0.0f)) { return 0.0f; }
    const pli_vec3 delta =
        pli_vec3_sub(plii_xyz(body->positions[at->nodes[1]]), plii_xyz(body->positions[at->nodes[0]]));
    return sqrtf(pli_vec3_length_squared(delta) / at->rest_length_squared) - 1.0f;
}

float pli_body_max_stretch(const pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0.0f; }
    float max_stretch = 0.0f;
    for (int i = 0; i < body->link_count; ++i) {
        max_stretch = plii_max(max_stretch, fabsf(plii_body_stretch(body, i)));
    }
    return max_stretch;
}

PLII_DEFINE_GET(float, pli_body_volume, body, plii_body_volume(body), 0.0f)

size_t pli_body_bytes(const pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    const plii_topology* topology = body->topology;
    const size_t node_bytes = 3 * sizeof(pli_vec4);
    const size_t link_bytes = sizeof(plii_link) + (body->link_tags != NULL ? sizeof(plii_link_tag) : 0);
    const size_t face_bytes =
        sizeof *topology->faces + (topology->face_materials != NULL ? sizeof *topology->face_materials : 0);
    return sizeof *body + (size_t)body->node_count * node_bytes + (size_t)body->link_count * link_bytes +
           (size_t)topology->face_count * face_bytes + (size_t)topology->tetra_count * sizeof *topology->tetras +
           (size_t)body->material_count * sizeof *body->materials +
           (size_t)body->ignored_rigid_capacity * sizeof *body->ignored_rigids + plii_feature_bytes(body);
}
