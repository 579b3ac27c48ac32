/* Bodies in files, but for their features. */

#include "file/file_impl.h"

#include "body/pipeline.h"
#include "mesh/mesh_impl.h"

static const plii_state_part file_body_parts[] = {
    PLII_STATE_OF(pli_body, is_frozen, PLII_SAVED, "B"),
    PLII_STATE_OF(pli_body, bounds, PLII_SAVED, "6f"),
    PLII_STATE_SPAN(pli_body, collision_margin, step, PLII_SAVED, "f3i5f"),
    PLII_STATE_SPAN(pli_body, link_revision, length_revision, PLII_SAVED, "2u"),
    {0},
};

/* What features change as they are enabled. */
static const plii_state_part file_body_last_parts[] = {
    PLII_STATE_OF(pli_body, is_asleep, PLII_SAVED, "B"),
    PLII_STATE_SPAN(pli_body, is_resting, was_asleep, PLII_SAVED, "3B"),
    PLII_STATE_OF(pli_body, records_contacts, PLII_SAVED, "B"),
    PLII_STATE_OF(pli_body, sleep_group, PLII_SAVED, "u"),
    PLII_STATE_OF(pli_body, interval, PLII_SAVED, "2i2f2B"),
    PLII_STATE_SPAN(pli_body, joint_iterations, sweeping_features, PLII_SAVED, "2i"),
    {0},
};

/* What it is made of. */
typedef struct file_body_sizes {
    int nodes, links, materials, faces, tetras;
    bool has_tags, has_face_materials;
} file_body_sizes;

static file_body_sizes file_body_read_sizes(plii_file* file, const pli_body* body) {
    static const plii_topology no_topology;
    static const pli_body no_body;
    const plii_topology* topology = body != NULL ? body->topology : &no_topology;
    if (body == NULL) { body = &no_body; }
    file_body_sizes sizes = {.has_tags = body->link_tags != NULL,
                             .has_face_materials = topology->face_materials != NULL};
    sizes.nodes = plii_file_count(file, body->node_count, 48);
    sizes.links = plii_file_count(file, body->link_count, 12);
    sizes.materials = plii_file_count(file, body->material_count, 4);
    sizes.faces = plii_file_count(file, topology->face_count, 12);
    sizes.tetras = plii_file_count(file, topology->tetra_count, 16);
    plii_file_fields(file, "B", &sizes.has_tags);
    plii_file_fields(file, "B", &sizes.has_face_materials);
    if (file->mode == PLII_FILE_READ && (sizes.nodes == 0 || sizes.materials > PLII_MAX_MATERIALS)) {
        plii_file_refuse(file, "it has no nodes, or too many materials");
    }
    return sizes;
}

static pli_body* file_make_body(plii_file* file, pli_world* world, const file_body_sizes* sizes) {
    plii_topology* topology =
        plii_topology_create(file->context, sizes->faces, sizes->tetras, sizes->has_face_materials);
    pli_body* body = topology == NULL ? NULL
                                      : plii_body_create_bare(world, sizes->nodes, sizes->links, sizes->materials,
                                                              sizes->has_tags, topology);
    if (body == NULL) {
        PLII_FILE_FAIL(file, PLI_ERROR_OUT_OF_MEMORY, "no memory for a body of %d nodes and %d links", sizes->nodes,
                       sizes->links);
    }
    return body;
}

static bool file_have_materials(const pli_body* body, const uint16_t* materials, int count, int mask) {
    for (int i = 0; i < count && materials != NULL; ++i) {
        if ((materials[i] & mask) >= body->material_count) { return false; }
    }
    return true;
}

static void file_body_mesh(plii_file* file, pli_body* body) {
    const size_t nodes = (size_t)body->node_count;
    plii_topology* topology = body->topology;
    const size_t tags = body->link_tags != NULL ? (size_t)body->link_count : 0,
                 face_materials = topology->face_materials != NULL ? (size_t)topology->face_count : 0;
    plii_file_elements(file, "4f", body->positions, nodes, sizeof *body->positions);
    plii_file_elements(file, "4f", body->previous, nodes, sizeof *body->previous);
    plii_file_elements(file, "4f", body->velocities, nodes, sizeof *body->velocities);
    plii_file_elements(file, "2nf", body->links, (size_t)body->link_count, sizeof *body->links);
    plii_file_elements(file, "h", body->link_tags, tags, sizeof *body->link_tags);
    plii_file_elements(file, "f", body->materials, (size_t)body->material_count, sizeof *body->materials);
    plii_file_elements(file, "3n", topology->faces, (size_t)topology->face_count, sizeof *topology->faces);
    plii_file_elements(file, "h", topology->face_materials, face_materials, sizeof *topology->face_materials);
    plii_file_elements(file, "4n", topology->tetras, (size_t)topology->tetra_count, sizeof *topology->tetras);
}

static void file_check_body(plii_file* file, const pli_body* body) {
    const plii_topology* topology = body->topology;
    const int all = PLII_MAX_MATERIALS - 1;
    const bool has_materials = file_have_materials(body, body->link_tags, body->link_count, all) &&
                               file_have_materials(body, topology->face_materials, topology->face_count, 0xffff) &&
                               (body->material_count > 0 || body->link_count == 0);
    if (!has_materials) { plii_file_refuse(file, "a material is out of range"); }
    for (PLII_EACH(const plii_link, link, body->links, body->link_count)) {
        if (link->nodes[0] == link->nodes[1]) { plii_file_refuse(file, "a link joins a node to itself"); }
    }
    bool is_within = plii_body_find_lost_node(body) == PLI_NULL_INDEX;
    for (int i = 0; i < body->node_count; ++i) {
        const float w = body->positions[i].w; /* may be above 1 / PLI_MIN_MASS: cuts halve masses */
        is_within = is_within && plii_is_point(plii_xyz(body->previous[i])) && w >= 0.0f && w <= FLT_MAX;
    }
    if (!is_within) { plii_file_refuse(file, "a node is too far out, too fast, or has no mass"); }
    for (int i = 0; i < body->material_count && file->status == PLI_OK; ++i) {
        if (plii_check_material(file->context, &body->materials[i], file->function) != PLI_OK) {
            plii_file_refuse(file, "the stiffness of a material is out of range");
        }
    }
}

pli_body* plii_file_body(plii_file* file, pli_world* world, pli_body* body) {
    const file_body_sizes sizes = file_body_read_sizes(file, body);
    if (file->status != PLI_OK) { return body; }
    if (file->mode == PLII_FILE_READ) { body = file_make_body(file, world, &sizes); }
    if (body == NULL) { return NULL; }
    file->body = body;
    plii_file_parts(file, file_body_parts, body);
    file_body_mesh(file, body);
    if (file->mode != PLII_FILE_READ || file->status != PLI_OK) { return body; }
    file_check_body(file, body);
    const pli_solver_settings solver = body->solver;
    if (file->status == PLI_OK &&
        (pli_body_set_solver_settings(body, &solver) != PLI_OK ||
         plii_check_margin(file->context, body->collision_margin, file->function) != PLI_OK)) {
        plii_file_refuse(file, "a setting of the solver or the collision margin is out of range");
    }
    return body;
}

void plii_file_body_end(plii_file* file, pli_body* body) {
    plii_file_parts(file, file_body_last_parts, body);
    const bool is_counted = body->sweeping_features >= 0 && body->sweeping_features <= body->pipeline.feature_count;
    const bool has_events = plii_feature_state(body, &plii_contact_events_class) != NULL;
    if (!plii_update_interval_is_valid(&body->interval) || body->joint_iterations < 0 || !is_counted ||
        body->records_contacts != has_events) {
        plii_file_refuse(file, "a setting is out of range");
    }
    /* One that had some before may still be ahead of the world, and wait. */
    const bool has_intervals = body->interval.steps > 1 || body->interval.step > 0.0f;
    if (has_intervals) { plii_world_use_update_intervals(body->world); }
}

void plii_file_ignored_rigids(plii_file* file, pli_body* body) {
    const int count = plii_file_count(file, body->ignored_rigid_count, 4);
    if (file->mode == PLII_FILE_READ && file->status == PLI_OK) {
        if (!PLII_RESERVE(file->context, &body->ignored_rigids, &body->ignored_rigid_capacity, count)) {
            PLII_FILE_FAIL(file, PLI_ERROR_OUT_OF_MEMORY, "no memory for rigid bodies that body %d ignores",
                           file->body_index);
            return;
        }
        body->ignored_rigid_count = count;
    }
    if (count > 0) {
        plii_file_elements(file, "S", body->ignored_rigids, (size_t)count, sizeof(*body->ignored_rigids));
    }
}
