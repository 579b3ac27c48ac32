#ifndef TESTS_UNIT_ALL_CALLS_H
#define TESTS_UNIT_ALL_CALLS_H

/* Every public function that takes a handle, once for each handle that it takes, with arguments that would do. The test
   calls_are_listed compares the list with the headers. */

#include <pliant/bullet_reference.h>
#include <pliant/pliant.h>

#include <math.h>

typedef struct call_handles {
    pli_context* context;
    pli_world* world;
    pli_body *body, *other; /* with a cluster each */
    pli_rigid* rigid;
    pli_mesh* mesh;
    pli_shape* shape;
    /* Of the body, as they are. */
    const pli_vec3* positions;
    const pli_bounds* boxes;
    pli_solver_settings solver;
    pli_cluster_settings cluster_settings;
    pli_rigid_state rigid_state;
} call_handles;

typedef enum call_kind { CALL_CONTEXT, CALL_WORLD, CALL_BODY, CALL_OTHER, CALL_RIGID, CALL_MESH, CALL_SHAPE } call_kind;

typedef enum call_effect {
    CALL_READS,
    CALL_CHANGES,     /* not in callbacks */
    CALL_CHANGES_IDLE /* nor between predict and solve */
} call_effect;

typedef struct call_result {
    bool has_status, has_value, is_neutral;
    pli_status status;
} call_result;

typedef struct call_row {
    const char* name;
    call_kind kind; /* of the handle that the row is about */
    call_effect effect;
    call_result (*run)(const call_handles* h);
} call_row;

#define CALL_STATUS(call) ((call_result){.has_status = true, .status = (call)})
#define CALL_VALUE(is_neutral_value) ((call_result){.has_value = true, .is_neutral = (is_neutral_value)})
#define CALL_VOID(call) ((call), (call_result){.status = PLI_OK})
#define CALL_DEF(prefix) ((const prefix##_def[]){prefix##_def_default()})

static const pli_vec3 call_point = {1, 1, 1};
static const int call_nodes[1] = {0};
static const pli_drag_id call_drag = {1, 1};
static const pli_vec3 call_points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const int call_indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

/* The node is not pinned, which is not what a handle or a state is refused for. */
static inline pli_status call_move_node(const call_handles* h) {
    const pli_status status = pli_body_move_node(h->body, 0, call_point);
    return status == PLI_ERROR_INVALID_VALUE ? PLI_OK : status;
}

/* No vertices, so that every body has them. */
static inline pli_status call_write_vertices(const call_handles* h) {
    pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
    char none[24];
    buffer.vertices = none;
    buffer.normal_offset = -1;
    return pli_body_write_vertices(h->body, &buffer, 1);
}

/* Bytes that do not make a snapshot: what a handle or a state is refused for comes before that. */
static inline pli_status call_without_snapshot(pli_status status) {
    return status == PLI_ERROR_FILE_FORMAT || status == PLI_ERROR_INVALID_VALUE ? PLI_OK : status;
}
static inline pli_status call_world_save(const call_handles* h) {
    char none[1];
    return call_without_snapshot(pli_world_save(h->world, none, 0, NULL));
}
static inline pli_status call_world_restore(const call_handles* h) {
    return call_without_snapshot(pli_world_restore(h->world, "", 0));
}
static inline pli_status call_body_save(const call_handles* h) {
    char none[1];
    return call_without_snapshot(pli_body_save(h->body, none, 0, NULL));
}
static inline pli_status call_body_restore(const call_handles* h) {
    return call_without_snapshot(pli_body_restore(h->body, "", 0));
}

static inline pli_status call_file_write(const call_handles* h) {
    char none[1];
    return call_without_snapshot(pli_world_file_write(h->world, NULL, none, 0, NULL));
}
static inline pli_status call_file_restore(const call_handles* h) {
    return call_without_snapshot(pli_world_file_restore(h->world, NULL, "", 0));
}
static inline pli_status call_file_create(const call_handles* h) {
    pli_world* made = NULL;
    return call_without_snapshot(pli_world_file_create(h->context, NULL, "", 0, &made));
}

static inline pli_status call_add_anchor(const call_handles* h) {
    pli_anchor_def def = pli_anchor_def_default();
    def.rigid = h->rigid;
    return pli_body_add_anchor(h->body, &def, NULL);
}

static inline pli_status call_enable_targets(const call_handles* h) {
    static const pli_target target = {.max_distance = 1};
    pli_targets_def def = pli_targets_def_default();
    def.targets = &target;
    def.count = 1;
    return pli_body_enable_targets(h->body, &def);
}

typedef pli_status call_targets(pli_body*, const pli_vec3*, const pli_vec3*, int);
static inline pli_status call_move_targets(const call_handles* h, call_targets* call) {
    const pli_status status = call(h->body, &call_point, NULL, 1);
    return status == PLI_ERROR_INVALID_VALUE ? PLI_OK : status; /* there may be none */
}

/* `other`: what is at the other end, else the world. */
static inline pli_status call_add_linear_joint(const call_handles* h, call_kind other) {
    pli_linear_joint_def def = pli_linear_joint_def_default();
    if (other == CALL_RIGID) { def.other.rigid = h->rigid; }
    if (other == CALL_OTHER) { def.other.body = h->other; }
    return pli_body_add_linear_joint(h->body, &def, NULL);
}

static inline pli_status call_add_angular_joint(const call_handles* h, call_kind other) {
    pli_angular_joint_def def = pli_angular_joint_def_default();
    def.axis = call_point;
    if (other == CALL_RIGID) { def.other.rigid = h->rigid; }
    if (other == CALL_OTHER) { def.other.body = h->other; }
    return pli_body_add_angular_joint(h->body, &def, NULL);
}

static inline pli_status call_create_rigid(const call_handles* h) {
    pli_rigid_def def = pli_rigid_def_default();
    pli_rigid* rigid = NULL;
    def.shape_count = 1;
    def.shapes = &h->shape;
    return pli_rigid_create(h->world, &def, &rigid);
}

static inline float call_surface(pli_vec3 point, void* user) {
    (void)user;
    return point.x;
}

static inline pli_status call_refine(const call_handles* h) {
    pli_refine_def def = pli_refine_def_default();
    def.surface = call_surface;
    return pli_body_refine(h->body, &def);
}

/* X(function, handle, effect, result) */
#define CALL_LIST(X)                                                                                                   \
    X(pli_world_snapshot_size, WORLD, READS, CALL_VALUE(pli_world_snapshot_size(h->world) == 0))                       \
    X(pli_world_save, WORLD, CHANGES_IDLE, CALL_STATUS(call_world_save(h)))                                            \
    X(pli_world_restore, WORLD, CHANGES_IDLE, CALL_STATUS(call_world_restore(h)))                                      \
    X(pli_world_file_size, WORLD, READS, CALL_VALUE(pli_world_file_size(h->world) == 0))                               \
    X(pli_world_file_write, WORLD, CHANGES_IDLE, CALL_STATUS(call_file_write(h)))                                      \
    X(pli_world_file_restore, WORLD, CHANGES_IDLE, CALL_STATUS(call_file_restore(h)))                                  \
    X(pli_world_file_create, CONTEXT, CHANGES, CALL_STATUS(call_file_create(h)))                                       \
    X(pli_body_snapshot_size, BODY, READS, CALL_VALUE(pli_body_snapshot_size(h->body) == 0))                           \
    X(pli_body_save, BODY, CHANGES_IDLE, CALL_STATUS(call_body_save(h)))                                               \
    X(pli_body_restore, BODY, CHANGES_IDLE, CALL_STATUS(call_body_restore(h)))                                         \
    X(pli_body_add_anchor, BODY, CHANGES, CALL_STATUS(call_add_anchor(h)))                                             \
    X(pli_body_add_anchor, RIGID, CHANGES, CALL_STATUS(call_add_anchor(h)))                                            \
    X(pli_body_remove_anchor, BODY, CHANGES, CALL_STATUS(pli_body_remove_anchor(h->body, ((pli_anchor_id){1, 1}))))    \
    X(pli_body_attach_nodes, BODY, CHANGES, CALL_STATUS(pli_body_attach_nodes(h->body, call_nodes, 1, h->rigid)))      \
    X(pli_body_attach_nodes, RIGID, CHANGES, CALL_STATUS(pli_body_attach_nodes(h->body, call_nodes, 1, h->rigid)))     \
    X(pli_body_detach_nodes, BODY, CHANGES, CALL_STATUS(pli_body_detach_nodes(h->body, call_nodes, 1)))                \
    X(pli_body_anchor_count, BODY, READS, CALL_VALUE(pli_body_anchor_count(h->body) == 0))                             \
    X(pli_body_set_anchor_hardness, BODY, CHANGES, CALL_STATUS(pli_body_set_anchor_hardness(h->body, 0.5f)))           \
    X(pli_context_destroy, CONTEXT, CHANGES, CALL_STATUS(pli_context_destroy(h->context)))                             \
    X(pli_context_fail, CONTEXT, READS, CALL_STATUS(pli_context_fail(h->context, PLI_OK, "call", "text")))             \
    X(pli_context_allocated_bytes, CONTEXT, READS, CALL_VALUE(pli_context_allocated_bytes(h->context) == 0))           \
    X(pli_context_allocation_count, CONTEXT, READS, CALL_VALUE(pli_context_allocation_count(h->context) == 0))         \
    X(pli_body_create, WORLD, CHANGES_IDLE,                                                                            \
      CALL_STATUS(pli_body_create(h->world, h->mesh, CALL_DEF(pli_body), (pli_body*[]){NULL})))                        \
    X(pli_body_create, MESH, CHANGES_IDLE,                                                                             \
      CALL_STATUS(pli_body_create(h->world, h->mesh, CALL_DEF(pli_body), (pli_body*[]){NULL})))                        \
    X(pli_body_destroy, BODY, CHANGES_IDLE, CALL_VOID(pli_body_destroy(h->body)))                                      \
    X(pli_body_get_world, BODY, READS, CALL_VALUE(pli_body_get_world(h->body) == NULL))                                \
    X(pli_body_get_user_data, BODY, READS, CALL_VALUE(pli_body_get_user_data(h->body) == NULL))                        \
    X(pli_body_set_user_data, BODY, READS, CALL_STATUS(pli_body_set_user_data(h->body, NULL)))                         \
    X(pli_body_get_solver_settings, BODY, READS, CALL_VALUE(pli_body_get_solver_settings(h->body).time_scale == 0.0f)) \
    X(pli_body_set_solver_settings, BODY, CHANGES, CALL_STATUS(pli_body_set_solver_settings(h->body, &h->solver)))     \
    X(pli_body_get_collision_margin, BODY, READS, CALL_VALUE(pli_body_get_collision_margin(h->body) == 0.0f))          \
    X(pli_body_set_collision_margin, BODY, CHANGES, CALL_STATUS(pli_body_set_collision_margin(h->body, 0.5f)))         \
    X(pli_body_get_view, BODY, READS, CALL_VALUE(pli_body_get_view(h->body).positions == NULL))                        \
    X(pli_body_get_bounds, BODY, READS, CALL_VALUE(pli_body_get_bounds(h->body).max.x == 0.0f))                        \
    X(pli_body_get_rest_length, BODY, READS, CALL_VALUE(pli_body_get_rest_length(h->body, 0) == 0.0f))                 \
    X(pli_body_set_rest_length, BODY, CHANGES, CALL_STATUS(pli_body_set_rest_length(h->body, 0, 0.5f)))                \
    X(pli_body_set_state, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_set_state(h->body, h->positions, NULL)))            \
    X(pli_body_set_node_position, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_set_node_position(h->body, 0, call_point))) \
    X(pli_body_set_node_velocity, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_set_node_velocity(h->body, 0, call_point))) \
    X(pli_body_move_node, BODY, CHANGES_IDLE, CALL_STATUS(call_move_node(h)))                                          \
    X(pli_body_set_node_mass, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_set_node_mass(h->body, 0, 0.5f)))               \
    X(pli_body_total_mass, BODY, READS, CALL_VALUE(pli_body_total_mass(h->body) == 0.0f))                              \
    X(pli_body_transform, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_transform(h->body, pli_transform_identity())))      \
    X(pli_body_add_node_force, BODY, CHANGES, CALL_STATUS(pli_body_add_node_force(h->body, 0, call_point)))            \
    X(pli_body_add_force, BODY, CHANGES, CALL_STATUS(pli_body_add_force(h->body, call_point)))                         \
    X(pli_body_add_velocity, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_add_velocity(h->body, call_point)))              \
    X(pli_body_enable_restitution, BODY, CHANGES, CALL_STATUS(pli_body_enable_restitution(h->body, 0.5f)))             \
    X(pli_body_disable_restitution, BODY, CHANGES, CALL_STATUS(pli_body_disable_restitution(h->body)))                 \
    X(pli_body_enable_step_smoothing, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_step_smoothing(h->body)))        \
    X(pli_body_disable_step_smoothing, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_step_smoothing(h->body)))      \
    X(pli_body_enable_normals, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_normals(h->body)))                      \
    X(pli_body_disable_normals, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_normals(h->body)))                    \
    X(pli_body_get_face_normals, BODY, READS, CALL_VALUE(pli_body_get_face_normals(h->body) == NULL))                  \
    X(pli_body_write_vertices, BODY, READS, CALL_STATUS(call_write_vertices(h)))                                       \
    X(pli_body_enable_topology_changes, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_topology_changes(h->body)))    \
    X(pli_body_disable_topology_changes, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_topology_changes(h->body)))  \
    X(pli_body_get_topology_changes, BODY, READS, CALL_VALUE(pli_body_get_topology_changes(h->body).face_count == 0))  \
    X(pli_body_enable_velocity_links, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_velocity_links(h->body)))        \
    X(pli_body_disable_velocity_links, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_velocity_links(h->body)))      \
    X(pli_body_enable_colored_links, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_colored_links(h->body)))          \
    X(pli_body_disable_colored_links, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_colored_links(h->body)))        \
    X(pli_body_is_frozen, BODY, READS, CALL_VALUE(!pli_body_is_frozen(h->body)))                                       \
    X(pli_body_get_update_interval, BODY, READS, CALL_VALUE(pli_body_get_update_interval(h->body) == 1))               \
    X(pli_body_is_asleep, BODY, READS, CALL_VALUE(!pli_body_is_asleep(h->body)))                                       \
    X(pli_body_is_resting, BODY, READS, CALL_VALUE(!pli_body_is_resting(h->body)))                                     \
    X(pli_body_get_held_rigids, BODY, READS, CALL_VALUE(pli_body_get_held_rigids(h->body, 0, NULL) == 0))              \
    X(pli_body_set_asleep, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_set_asleep(h->body, true)))                        \
    X(pli_body_enable_sleep, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_sleep(h->body, CALL_DEF(pli_sleep))))     \
    X(pli_body_disable_sleep, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_sleep(h->body)))                        \
    X(pli_body_set_frozen, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_set_frozen(h->body, true)))                        \
    X(pli_body_set_update_interval, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_set_update_interval(h->body, 2)))         \
    X(pli_body_ignore_rigid, BODY, CHANGES, CALL_STATUS(pli_body_ignore_rigid(h->body, h->rigid, true)))               \
    X(pli_body_ignore_rigid, RIGID, CHANGES, CALL_STATUS(pli_body_ignore_rigid(h->body, h->rigid, true)))              \
    X(pli_body_ignores_rigid, BODY, READS, CALL_VALUE(!pli_body_ignores_rigid(h->body, h->rigid)))                     \
    X(pli_body_ignores_rigid, RIGID, READS, CALL_VALUE(!pli_body_ignores_rigid(h->body, h->rigid)))                    \
    X(pli_body_state_hash, BODY, READS, CALL_VALUE(pli_body_state_hash(h->body) == 0))                                 \
    X(pli_body_kinetic_energy, BODY, READS, CALL_VALUE(pli_body_kinetic_energy(h->body) == 0.0f))                      \
    X(pli_body_max_stretch, BODY, READS, CALL_VALUE(pli_body_max_stretch(h->body) == 0.0f))                            \
    X(pli_body_momentum, BODY, READS, CALL_VALUE(pli_body_momentum(h->body).x == 0.0f))                                \
    X(pli_body_volume, BODY, READS, CALL_VALUE(pli_body_volume(h->body) == 0.0f))                                      \
    X(pli_body_bytes, BODY, READS, CALL_VALUE(pli_body_bytes(h->body) == 0))                                           \
    X(pli_body_get_features, BODY, READS, CALL_VALUE(pli_body_get_features(h->body, 0, NULL) == 0))                    \
    X(pli_body_enable_clusters, BODY, CHANGES_IDLE,                                                                    \
      CALL_STATUS(pli_body_enable_clusters(h->body, CALL_DEF(pli_clusters))))                                          \
    X(pli_body_disable_clusters, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_clusters(h->body)))                  \
    X(pli_body_generate_clusters, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_generate_clusters(h->body, 1, 1, NULL)))    \
    X(pli_body_generate_clusters_from_elements, BODY, CHANGES_IDLE,                                                    \
      CALL_STATUS(pli_body_generate_clusters_from_elements(h->body, NULL)))                                            \
    X(pli_body_add_cluster, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_add_cluster(h->body, call_indices, 1, NULL)))     \
    X(pli_body_remove_clusters, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_remove_clusters(h->body)))                    \
    X(pli_body_cluster_count, BODY, READS, CALL_VALUE(pli_body_cluster_count(h->body) == 0))                           \
    X(pli_body_get_cluster_settings, BODY, READS,                                                                      \
      CALL_STATUS(pli_body_get_cluster_settings(h->body, 0, (pli_cluster_settings[]){{0}})))                           \
    X(pli_body_set_cluster_settings, BODY, CHANGES,                                                                    \
      CALL_STATUS(pli_body_set_cluster_settings(h->body, 0, &h->cluster_settings)))                                    \
    X(pli_body_get_cluster, BODY, READS, CALL_STATUS(pli_body_get_cluster(h->body, 0, (pli_cluster_view[]){{0}})))     \
    X(pli_body_reset_clusters, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_reset_clusters(h->body)))                      \
    X(pli_body_enable_cluster_contacts, BODY, CHANGES_IDLE,                                                            \
      CALL_STATUS(pli_body_enable_cluster_contacts(h->body, CALL_DEF(pli_cluster_contacts))))                          \
    X(pli_body_disable_cluster_contacts, BODY, CHANGES, CALL_STATUS(pli_body_disable_cluster_contacts(h->body)))       \
    X(pli_body_get_cluster_contacts, BODY, READS, CALL_VALUE(pli_body_get_cluster_contacts(h->body, 0, NULL) == 0))    \
    X(pli_body_reorder_cluster_contacts, BODY, CHANGES,                                                                \
      CALL_STATUS(pli_body_reorder_cluster_contacts(h->body, call_indices, 1)))                                        \
    X(pli_body_enable_rigid_contacts, BODY, CHANGES,                                                                   \
      CALL_STATUS(pli_body_enable_rigid_contacts(h->body, CALL_DEF(pli_rigid_contacts))))                              \
    X(pli_body_disable_rigid_contacts, BODY, CHANGES, CALL_STATUS(pli_body_disable_rigid_contacts(h->body)))           \
    X(pli_body_get_rigid_contacts, BODY, READS, CALL_VALUE(pli_body_get_rigid_contacts(h->body, 0, NULL) == 0))        \
    X(pli_body_reorder_rigid_contacts, BODY, CHANGES,                                                                  \
      CALL_STATUS(pli_body_reorder_rigid_contacts(h->body, call_indices, 1)))                                          \
    X(pli_body_enable_rigid_face_contacts, BODY, CHANGES,                                                              \
      CALL_STATUS(pli_body_enable_rigid_face_contacts(h->body, CALL_DEF(pli_rigid_face_contacts))))                    \
    X(pli_body_disable_rigid_face_contacts, BODY, CHANGES, CALL_STATUS(pli_body_disable_rigid_face_contacts(h->body))) \
    X(pli_body_get_rigid_face_contacts, BODY, READS,                                                                   \
      CALL_VALUE(pli_body_get_rigid_face_contacts(h->body, 0, NULL) == 0))                                             \
    X(pli_body_enable_soft_contacts, BODY, CHANGES,                                                                    \
      CALL_STATUS(pli_body_enable_soft_contacts(h->body, CALL_DEF(pli_soft_contacts))))                                \
    X(pli_body_disable_soft_contacts, BODY, CHANGES, CALL_STATUS(pli_body_disable_soft_contacts(h->body)))             \
    X(pli_body_get_soft_contacts, BODY, READS, CALL_VALUE(pli_body_get_soft_contacts(h->body, 0, NULL) == 0))          \
    X(pli_body_reorder_soft_contacts, BODY, CHANGES,                                                                   \
      CALL_STATUS(pli_body_reorder_soft_contacts(h->body, call_indices, 1)))                                           \
    X(pli_body_enable_contact_events, BODY, CHANGES_IDLE,                                                              \
      CALL_STATUS(pli_body_enable_contact_events(h->body, CALL_DEF(pli_contact_events))))                              \
    X(pli_body_disable_contact_events, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_contact_events(h->body)))      \
    X(pli_body_get_contact_events, BODY, READS,                                                                        \
      CALL_VALUE(pli_body_get_contact_events(h->body, PLI_CONTACT_BEGIN, NULL) == NULL))                               \
    X(pli_body_enable_bullet_node_boxes, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_bullet_node_boxes(h->body)))  \
    X(pli_body_disable_bullet_node_boxes, BODY, CHANGES_IDLE,                                                          \
      CALL_STATUS(pli_body_disable_bullet_node_boxes(h->body)))                                                        \
    X(pli_body_set_bullet_boxes, BODY, CHANGES, CALL_STATUS(pli_body_set_bullet_boxes(h->body, h->boxes, h->boxes)))   \
    X(pli_body_refine, BODY, CHANGES_IDLE, CALL_STATUS(call_refine(h)))                                                \
    X(pli_body_cut_link, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_cut_link(h->body, 0, 1, 0.5f)))                      \
    X(pli_body_tear, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_tear(h->body, 0.5f, 1, NULL)))                           \
    X(pli_body_cut_swept, BODY, CHANGES_IDLE,                                                                          \
      CALL_STATUS(pli_body_cut_swept(h->body, call_point, call_point, call_point, call_point, NULL)))                  \
    X(pli_body_count_parts, BODY, READS, CALL_STATUS(pli_body_count_parts(h->body, (int[]){0})))                       \
    X(pli_body_enable_aero, BODY, CHANGES, CALL_STATUS(pli_body_enable_aero(h->body, CALL_DEF(pli_aero))))             \
    X(pli_body_set_wind, BODY, CHANGES, CALL_STATUS(pli_body_set_wind(h->body, call_point)))                           \
    X(pli_body_disable_aero, BODY, CHANGES, CALL_STATUS(pli_body_disable_aero(h->body)))                               \
    X(pli_body_enable_pressure, BODY, CHANGES, CALL_STATUS(pli_body_enable_pressure(h->body, 0.5f)))                   \
    X(pli_body_disable_pressure, BODY, CHANGES, CALL_STATUS(pli_body_disable_pressure(h->body)))                       \
    X(pli_body_enable_volume_conservation, BODY, CHANGES,                                                              \
      CALL_STATUS(pli_body_enable_volume_conservation(h->body, 0.5f)))                                                 \
    X(pli_body_disable_volume_conservation, BODY, CHANGES, CALL_STATUS(pli_body_disable_volume_conservation(h->body))) \
    X(pli_mesh_create_rope, CONTEXT, CHANGES,                                                                          \
      CALL_STATUS(pli_mesh_create_rope(h->context, call_point, call_point, 1, 0, (pli_mesh*[]){NULL})))                \
    X(pli_mesh_create_patch, CONTEXT, CHANGES,                                                                         \
      CALL_STATUS(pli_mesh_create_patch(h->context, CALL_DEF(pli_patch), (pli_mesh*[]){NULL})))                        \
    X(pli_mesh_create_patch_uv, CONTEXT, CHANGES,                                                                      \
      CALL_STATUS(pli_mesh_create_patch_uv(h->context, CALL_DEF(pli_patch), NULL, (pli_mesh*[]){NULL})))               \
    X(pli_mesh_create_ellipsoid, CONTEXT, CHANGES,                                                                     \
      CALL_STATUS(pli_mesh_create_ellipsoid(h->context, call_point, call_point, 4, (pli_mesh*[]){NULL})))              \
    X(pli_mesh_create_convex_hull, CONTEXT, CHANGES,                                                                   \
      CALL_STATUS(pli_mesh_create_convex_hull(h->context, 4, call_points, 0.5f, (pli_mesh*[]){NULL})))                 \
    X(pli_mesh_create_from_triangles, CONTEXT, CHANGES,                                                                \
      CALL_STATUS(                                                                                                     \
          pli_mesh_create_from_triangles(h->context, 4, call_points, 4, call_indices, true, (pli_mesh*[]){NULL})))     \
    X(pli_mesh_create_from_vertices, CONTEXT, CHANGES,                                                                 \
      CALL_STATUS(pli_mesh_create_from_vertices(h->context, 4, call_points, 4, call_indices, (int[4]){0},              \
                                                (pli_mesh*[]){NULL})))                                                 \
    X(pli_mesh_create_from_tetras, CONTEXT, CHANGES,                                                                   \
      CALL_STATUS(pli_mesh_create_from_tetras(h->context, 4, call_points, 1, call_indices, (pli_mesh*[]){NULL})))      \
    X(pli_body_enable_implicit, BODY, CHANGES_IDLE,                                                                    \
      CALL_STATUS(pli_body_enable_implicit(h->body, CALL_DEF(pli_implicit))))                                          \
    X(pli_body_disable_implicit, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_implicit(h->body)))                  \
    X(pli_body_get_implicit_report, BODY, READS, CALL_VALUE(pli_body_get_implicit_report(h->body).iterations == 0))    \
    X(pli_triangles_read_obj, CONTEXT, CHANGES,                                                                        \
      CALL_STATUS(pli_triangles_read_obj(h->context, "none", (pli_triangles[]){{0}})))                                 \
    X(pli_triangles_destroy, CONTEXT, CHANGES,                                                                         \
      CALL_VOID(pli_triangles_destroy((pli_triangles[]){{.context = h->context}})))                                    \
    X(pli_mesh_read_obj, CONTEXT, CHANGES, CALL_STATUS(pli_mesh_read_obj(h->context, "none", (pli_mesh*[]){NULL})))    \
    X(pli_mesh_read_tetgen, CONTEXT, CHANGES,                                                                          \
      CALL_STATUS(pli_mesh_read_tetgen(h->context, "none", (pli_mesh*[]){NULL})))                                      \
    X(pli_body_add_linear_joint, BODY, CHANGES_IDLE, CALL_STATUS(call_add_linear_joint(h, CALL_BODY)))                 \
    X(pli_body_add_linear_joint, OTHER, CHANGES_IDLE, CALL_STATUS(call_add_linear_joint(h, CALL_OTHER)))               \
    X(pli_body_add_linear_joint, RIGID, CHANGES_IDLE, CALL_STATUS(call_add_linear_joint(h, CALL_RIGID)))               \
    X(pli_body_add_angular_joint, BODY, CHANGES_IDLE, CALL_STATUS(call_add_angular_joint(h, CALL_BODY)))               \
    X(pli_body_add_angular_joint, OTHER, CHANGES_IDLE, CALL_STATUS(call_add_angular_joint(h, CALL_OTHER)))             \
    X(pli_body_add_angular_joint, RIGID, CHANGES_IDLE, CALL_STATUS(call_add_angular_joint(h, CALL_RIGID)))             \
    X(pli_body_remove_joint, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_remove_joint(h->body, ((pli_joint_id){1, 1}))))  \
    X(pli_body_joint_count, BODY, READS, CALL_VALUE(pli_body_joint_count(h->body) == 0))                               \
    X(pli_mesh_create, CONTEXT, CHANGES, CALL_STATUS(pli_mesh_create(h->context, (pli_mesh*[]){NULL})))                \
    X(pli_mesh_clone, MESH, CHANGES, CALL_STATUS(pli_mesh_clone(h->mesh, (pli_mesh*[]){NULL})))                        \
    X(pli_mesh_destroy, MESH, CHANGES, CALL_VOID(pli_mesh_destroy(h->mesh)))                                           \
    X(pli_mesh_get_view, MESH, READS, CALL_VALUE(pli_mesh_get_view(h->mesh).materials == NULL))                        \
    X(pli_mesh_append_node, MESH, CHANGES, CALL_STATUS(pli_mesh_append_node(h->mesh, call_point, 0.5f, NULL)))         \
    X(pli_mesh_append_link, MESH, CHANGES, CALL_STATUS(pli_mesh_append_link(h->mesh, 0, 1, 0, NULL)))                  \
    X(pli_mesh_append_face, MESH, CHANGES, CALL_STATUS(pli_mesh_append_face(h->mesh, 0, 1, 2, 0, NULL)))               \
    X(pli_mesh_append_tetra, MESH, CHANGES, CALL_STATUS(pli_mesh_append_tetra(h->mesh, 0, 1, 2, 3, 0, NULL)))          \
    X(pli_mesh_append_material, MESH, CHANGES,                                                                         \
      CALL_STATUS(pli_mesh_append_material(h->mesh, (const pli_material[]){{.linear_stiffness = 1}}, NULL)))           \
    X(pli_mesh_set_material, MESH, CHANGES,                                                                            \
      CALL_STATUS(pli_mesh_set_material(h->mesh, 0, (const pli_material[]){{.linear_stiffness = 1}})))                 \
    X(pli_mesh_set_node_position, MESH, CHANGES, CALL_STATUS(pli_mesh_set_node_position(h->mesh, 0, call_point)))      \
    X(pli_mesh_append_bending_links, MESH, CHANGES, CALL_STATUS(pli_mesh_append_bending_links(h->mesh, 2, 0, NULL)))   \
    X(pli_mesh_shuffle_links, MESH, CHANGES, CALL_STATUS(pli_mesh_shuffle_links(h->mesh)))                             \
    X(pli_mesh_interleave_links, MESH, CHANGES, CALL_STATUS(pli_mesh_interleave_links(h->mesh)))                       \
    X(pli_mesh_set_node_mass, MESH, CHANGES, CALL_STATUS(pli_mesh_set_node_mass(h->mesh, 0, 0.5f)))                    \
    X(pli_mesh_total_mass, MESH, READS, CALL_VALUE(pli_mesh_total_mass(h->mesh) == 0.0f))                              \
    X(pli_mesh_set_total_mass, MESH, CHANGES, CALL_STATUS(pli_mesh_set_total_mass(h->mesh, 0.5f)))                     \
    X(pli_mesh_set_total_mass_from_faces, MESH, CHANGES,                                                               \
      CALL_STATUS(pli_mesh_set_total_mass_from_faces(h->mesh, 0.5f)))                                                  \
    X(pli_mesh_set_total_mass_from_tetras, MESH, CHANGES,                                                              \
      CALL_STATUS(pli_mesh_set_total_mass_from_tetras(h->mesh, 0.5f)))                                                 \
    X(pli_mesh_set_density_from_faces, MESH, CHANGES, CALL_STATUS(pli_mesh_set_density_from_faces(h->mesh, 0.5f)))     \
    X(pli_mesh_set_density_from_tetras, MESH, CHANGES, CALL_STATUS(pli_mesh_set_density_from_tetras(h->mesh, 0.5f)))   \
    X(pli_mesh_transform, MESH, CHANGES, CALL_STATUS(pli_mesh_transform(h->mesh, pli_transform_identity())))           \
    X(pli_mesh_translate, MESH, CHANGES, CALL_STATUS(pli_mesh_translate(h->mesh, call_point)))                         \
    X(pli_mesh_rotate, MESH, CHANGES, CALL_STATUS(pli_mesh_rotate(h->mesh, ((pli_quat){0, 0, 0, 1}))))                 \
    X(pli_mesh_scale, MESH, CHANGES, CALL_STATUS(pli_mesh_scale(h->mesh, call_point)))                                 \
    X(pli_mesh_volume, MESH, READS, CALL_VALUE(pli_mesh_volume(h->mesh) == 0.0f))                                      \
    X(pli_mesh_bounds, MESH, READS, CALL_VALUE(pli_mesh_bounds(h->mesh).max.x == 0.0f))                                \
    X(pli_body_enable_pose_matching, BODY, CHANGES, CALL_STATUS(pli_body_enable_pose_matching(h->body, 0.5f)))         \
    X(pli_body_disable_pose_matching, BODY, CHANGES, CALL_STATUS(pli_body_disable_pose_matching(h->body)))             \
    X(pli_body_get_pose, BODY, READS,                                                                                  \
      CALL_STATUS(pli_body_get_pose(h->body, (pli_transform[]){pli_transform_identity()})))                            \
    X(pli_body_cast_ray, BODY, READS,                                                                                  \
      CALL_STATUS(pli_body_cast_ray(h->body, CALL_DEF(pli_ray), (pli_ray_hit[]){{0}})))                                \
    X(pli_rigid_create, WORLD, CHANGES, CALL_STATUS(call_create_rigid(h)))                                             \
    X(pli_rigid_create, SHAPE, CHANGES, CALL_STATUS(call_create_rigid(h)))                                             \
    X(pli_rigid_destroy, RIGID, CHANGES_IDLE, CALL_VOID(pli_rigid_destroy(h->rigid)))                                  \
    X(pli_rigid_set_state, RIGID, CHANGES, CALL_STATUS(pli_rigid_set_state(h->rigid, &h->rigid_state)))                \
    X(pli_rigid_move, RIGID, CHANGES, CALL_STATUS(pli_rigid_move(h->rigid, pli_transform_identity(), 0.5f)))           \
    X(pli_rigid_get_state, RIGID, READS, CALL_VALUE(pli_rigid_get_state(h->rigid).inverse_mass == 0.0f))               \
    X(pli_rigid_set_friction, RIGID, CHANGES, CALL_STATUS(pli_rigid_set_friction(h->rigid, 0.5f)))                     \
    X(pli_rigid_set_restitution, RIGID, CHANGES, CALL_STATUS(pli_rigid_set_restitution(h->rigid, 0.5f)))               \
    X(pli_rigid_set_factors, RIGID, CHANGES, CALL_STATUS(pli_rigid_set_factors(h->rigid, call_point, call_point)))     \
    X(pli_rigid_set_present, RIGID, CHANGES, CALL_STATUS(pli_rigid_set_present(h->rigid, false)))                      \
    X(pli_rigid_is_present, RIGID, READS, CALL_VALUE(!pli_rigid_is_present(h->rigid)))                                 \
    X(pli_rigid_set_kind, RIGID, CHANGES,                                                                              \
      CALL_STATUS(pli_rigid_set_kind(h->rigid, PLI_RIGID_STATIC, &h->rigid_state)))                                    \
    X(pli_rigid_set_shapes, RIGID, CHANGES, CALL_STATUS(pli_rigid_set_shapes(h->rigid, 1, &h->shape, NULL)))           \
    X(pli_rigid_set_shapes, SHAPE, CHANGES, CALL_STATUS(pli_rigid_set_shapes(h->rigid, 1, &h->shape, NULL)))           \
    X(pli_rigid_set_sensor, RIGID, CHANGES, CALL_STATUS(pli_rigid_set_sensor(h->rigid, true)))                         \
    X(pli_rigid_is_sensor, RIGID, READS, CALL_VALUE(!pli_rigid_is_sensor(h->rigid)))                                   \
    X(pli_rigid_is_asleep, RIGID, READS, CALL_VALUE(!pli_rigid_is_asleep(h->rigid)))                                   \
    X(pli_rigid_get_kind, RIGID, READS, CALL_VALUE(pli_rigid_get_kind(h->rigid) == PLI_RIGID_STATIC))                  \
    X(pli_rigid_get_user_data, RIGID, READS, CALL_VALUE(pli_rigid_get_user_data(h->rigid) == NULL))                    \
    X(pli_rigid_was_touched, RIGID, READS, CALL_VALUE(!pli_rigid_was_touched(h->rigid)))                               \
    X(pli_rigid_get_shift, RIGID, READS, CALL_VALUE(!pli_rigid_get_shift(h->rigid, NULL, NULL)))                       \
    X(pli_rigid_integrate, RIGID, CHANGES, CALL_STATUS(pli_rigid_integrate(h->rigid, call_point, 0.5f)))               \
    X(pli_body_enable_self_collision, BODY, CHANGES_IDLE,                                                              \
      CALL_STATUS(pli_body_enable_self_collision(h->body, CALL_DEF(pli_self_collision))))                              \
    X(pli_body_disable_self_collision, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_self_collision(h->body)))      \
    X(pli_body_get_self_collision_report, BODY, READS,                                                                 \
      CALL_VALUE(pli_body_get_self_collision_report(h->body).pairs == 0))                                              \
    X(pli_body_enable_self_grids, BODY, CHANGES_IDLE,                                                                  \
      CALL_STATUS(pli_body_enable_self_grids(h->body, CALL_DEF(pli_self_grids))))                                      \
    X(pli_body_disable_self_grids, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_self_grids(h->body)))              \
    X(pli_body_get_self_grids_report, BODY, READS, CALL_VALUE(pli_body_get_self_grids_report(h->body).pairs == 0))     \
    X(pli_body_enable_self_faces, BODY, CHANGES_IDLE,                                                                  \
      CALL_STATUS(pli_body_enable_self_faces(h->body, CALL_DEF(pli_self_faces))))                                      \
    X(pli_body_disable_self_faces, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_self_faces(h->body)))              \
    X(pli_body_get_self_faces_report, BODY, READS, CALL_VALUE(pli_body_get_self_faces_report(h->body).pairs == 0))     \
    X(pli_body_count_crossings, BODY, READS, CALL_STATUS(pli_body_count_crossings(h->body, (int[]){0})))               \
    X(pli_shape_create, CONTEXT, CHANGES,                                                                              \
      CALL_STATUS(pli_shape_create(h->context, CALL_DEF(pli_shape), (pli_shape*[]){NULL})))                            \
    X(pli_shape_retain, SHAPE, CHANGES, CALL_VOID(pli_shape_retain(h->shape)))                                         \
    X(pli_shape_release, SHAPE, CHANGES, CALL_VOID(pli_shape_release(h->shape)))                                       \
    X(pli_shape_create_plane, CONTEXT, CHANGES,                                                                        \
      CALL_STATUS(pli_shape_create_plane(h->context, call_point, 0.5f, (pli_shape*[]){NULL})))                         \
    X(pli_shape_create_sphere, CONTEXT, CHANGES,                                                                       \
      CALL_STATUS(pli_shape_create_sphere(h->context, 0.5f, (pli_shape*[]){NULL})))                                    \
    X(pli_shape_create_box, CONTEXT, CHANGES,                                                                          \
      CALL_STATUS(pli_shape_create_box(h->context, call_point, (pli_shape*[]){NULL})))                                 \
    X(pli_shape_create_capsule, CONTEXT, CHANGES,                                                                      \
      CALL_STATUS(pli_shape_create_capsule(h->context, call_point, 0.5f, (pli_shape*[]){NULL})))                       \
    X(pli_shape_create_cylinder, CONTEXT, CHANGES,                                                                     \
      CALL_STATUS(pli_shape_create_cylinder(h->context, call_point, 0.5f, (pli_shape*[]){NULL})))                      \
    X(pli_shape_create_convex_hull, CONTEXT, CHANGES,                                                                  \
      CALL_STATUS(pli_shape_create_convex_hull(h->context, 4, call_points, 0.5f, (pli_shape*[]){NULL})))               \
    X(pli_shape_create_triangle_mesh, CONTEXT, CHANGES,                                                                \
      CALL_STATUS(                                                                                                     \
          pli_shape_create_triangle_mesh(h->context, 4, call_points, 4, call_indices, 0.5f, (pli_shape*[]){NULL})))    \
    X(pli_shape_create_sampled_mesh, CONTEXT, CHANGES,                                                                 \
      CALL_STATUS(pli_shape_create_sampled_mesh(h->context, 4, call_points, 4, call_indices,                           \
                                                CALL_DEF(pli_sampled_mesh), (pli_shape*[]){NULL})))                    \
    X(pli_shape_create_lattice, CONTEXT, CHANGES,                                                                      \
      CALL_STATUS(pli_shape_create_lattice(h->context, h->shape, 0.5f, (pli_shape*[]){NULL})))                         \
    X(pli_shape_create_lattice, SHAPE, CHANGES,                                                                        \
      CALL_STATUS(pli_shape_create_lattice(h->context, h->shape, 0.5f, (pli_shape*[]){NULL})))                         \
    X(pli_shape_distance, SHAPE, READS, CALL_VALUE(isinf(pli_shape_distance(h->shape, call_point, NULL))))             \
    X(pli_shape_bounds, SHAPE, READS, CALL_VALUE(pli_shape_bounds(h->shape).max.x == 0.0f))                            \
    X(pli_body_begin_drag, BODY, CHANGES_IDLE,                                                                         \
      CALL_STATUS(pli_body_begin_drag(h->body, CALL_DEF(pli_drag), (pli_drag_id[]){{0}})))                             \
    X(pli_body_move_drag, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_move_drag(h->body, call_drag, call_point)))         \
    X(pli_body_end_drag, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_end_drag(h->body, call_drag)))                       \
    X(pli_body_get_drag, BODY, READS, CALL_STATUS(pli_body_get_drag(h->body, call_drag, NULL, NULL)))                  \
    X(pli_body_enable_targets, BODY, CHANGES_IDLE, CALL_STATUS(call_enable_targets(h)))                                \
    X(pli_body_disable_targets, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_targets(h->body)))                    \
    X(pli_body_move_targets, BODY, CHANGES_IDLE, CALL_STATUS(call_move_targets(h, pli_body_move_targets)))             \
    X(pli_body_teleport_targets, BODY, CHANGES_IDLE, CALL_STATUS(call_move_targets(h, pli_body_teleport_targets)))     \
    X(pli_body_enable_tethers, BODY, CHANGES_IDLE,                                                                     \
      CALL_STATUS(pli_body_enable_tethers(h->body, CALL_DEF(pli_tethers))))                                            \
    X(pli_body_disable_tethers, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_tethers(h->body)))                    \
    X(pli_body_get_tether, BODY, READS, CALL_VALUE(pli_body_get_tether(h->body, 0).origin == PLI_NULL_INDEX))          \
    X(pli_world_create, CONTEXT, CHANGES,                                                                              \
      CALL_STATUS(pli_world_create(h->context, CALL_DEF(pli_world), (pli_world*[]){NULL})))                            \
    X(pli_world_destroy, WORLD, CHANGES, CALL_VOID(pli_world_destroy(h->world)))                                       \
    X(pli_world_get_context, WORLD, READS, CALL_VALUE(pli_world_get_context(h->world) == NULL))                        \
    X(pli_world_get_gravity, WORLD, READS, CALL_VALUE(pli_world_get_gravity(h->world).y == 0.0f))                      \
    X(pli_world_set_gravity, WORLD, CHANGES, CALL_STATUS(pli_world_set_gravity(h->world, call_point)))                 \
    X(pli_world_get_user_data, WORLD, READS, CALL_VALUE(pli_world_get_user_data(h->world) == NULL))                    \
    X(pli_world_step, WORLD, CHANGES, CALL_STATUS(pli_world_step(h->world, 0.5f)))                                     \
    X(pli_world_predict, WORLD, CHANGES, CALL_STATUS(pli_world_predict(h->world, 0.5f)))                               \
    X(pli_world_collide_rigids, WORLD, CHANGES,                                                                        \
      CALL_STATUS(pli_world_collide_rigids(h->world, (const pli_rigid_pair[]){{h->body, h->rigid}}, 1)))               \
    X(pli_world_collide_rigid, WORLD, CHANGES, CALL_STATUS(pli_world_collide_rigid(h->world, h->body, h->rigid)))      \
    X(pli_world_collide_rigid, BODY, CHANGES, CALL_STATUS(pli_world_collide_rigid(h->world, h->body, h->rigid)))       \
    X(pli_world_collide_rigid, RIGID, CHANGES, CALL_STATUS(pli_world_collide_rigid(h->world, h->body, h->rigid)))      \
    X(pli_world_collide_body_pairs, WORLD, CHANGES,                                                                    \
      CALL_STATUS(pli_world_collide_body_pairs(h->world, (const pli_body_pair[]){{h->body, h->other}}, 1)))            \
    X(pli_world_collide_bodies, WORLD, CHANGES, CALL_STATUS(pli_world_collide_bodies(h->world, h->body, h->other)))    \
    X(pli_world_collide_bodies, BODY, CHANGES, CALL_STATUS(pli_world_collide_bodies(h->world, h->body, h->other)))     \
    X(pli_world_collide_bodies, OTHER, CHANGES, CALL_STATUS(pli_world_collide_bodies(h->world, h->body, h->other)))    \
    X(pli_world_solve, WORLD, CHANGES, CALL_STATUS(pli_world_solve(h->world)))                                         \
    X(pli_body_collides_with_bodies, BODY, READS, CALL_VALUE(!pli_body_collides_with_bodies(h->body)))                 \
    X(pli_world_is_stepping, WORLD, READS, CALL_VALUE(!pli_world_is_stepping(h->world)))                               \
    X(pli_world_body_count, WORLD, READS, CALL_VALUE(pli_world_body_count(h->world) == 0))                             \
    X(pli_world_get_body, WORLD, READS, CALL_VALUE(pli_world_get_body(h->world, 0) == NULL))                           \
    X(pli_world_rigid_count, WORLD, READS, CALL_VALUE(pli_world_rigid_count(h->world) == 0))                           \
    X(pli_world_get_rigid, WORLD, READS, CALL_VALUE(pli_world_get_rigid(h->world, 0) == NULL))                         \
    X(pli_world_get_events, WORLD, READS, CALL_VALUE(pli_world_get_events(h->world, NULL) == NULL))                    \
    X(pli_world_set_profile, WORLD, CHANGES_IDLE, CALL_STATUS(pli_world_set_profile(h->world, NULL, NULL)))            \
    X(pli_body_enable_xpbd, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_xpbd(h->body, CALL_DEF(pli_xpbd))))        \
    X(pli_body_disable_xpbd, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_xpbd(h->body)))                          \
    X(pli_body_enable_xpbd_links, BODY, CHANGES_IDLE,                                                                  \
      CALL_STATUS(pli_body_enable_xpbd_links(h->body, CALL_DEF(pli_xpbd_links))))                                      \
    X(pli_body_disable_xpbd_links, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_xpbd_links(h->body)))              \
    X(pli_body_enable_xpbd_bending, BODY, CHANGES_IDLE,                                                                \
      CALL_STATUS(pli_body_enable_xpbd_bending(h->body, CALL_DEF(pli_xpbd_bending))))                                  \
    X(pli_body_disable_xpbd_bending, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_xpbd_bending(h->body)))          \
    X(pli_body_enable_xpbd_tetras, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_enable_xpbd_tetras(h->body, 0.5f)))        \
    X(pli_body_disable_xpbd_tetras, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_xpbd_tetras(h->body)))            \
    X(pli_body_enable_xpbd_volume, BODY, CHANGES_IDLE,                                                                 \
      CALL_STATUS(pli_body_enable_xpbd_volume(h->body, CALL_DEF(pli_xpbd_volume))))                                    \
    X(pli_body_disable_xpbd_volume, BODY, CHANGES_IDLE, CALL_STATUS(pli_body_disable_xpbd_volume(h->body)))

#define CALL_FUNCTION(name, kind, effect, result)                                                                      \
    static call_result call_##name##_##kind(const call_handles* h) {                                                   \
        return result;                                                                                                 \
    }
CALL_LIST(CALL_FUNCTION)
#undef CALL_FUNCTION

static const call_row call_rows[] = {
#define CALL_ROW(name, kind, effect, result) {#name, CALL_##kind, CALL_##effect, call_##name##_##kind},
    CALL_LIST(CALL_ROW)
#undef CALL_ROW
};
enum { CALL_COUNT = sizeof call_rows / sizeof call_rows[0] };

#endif
