/* Bodies in files, with their features. The one file that names all features. */

#include "file/file_impl.h"

#include "body/pipeline.h"
#include "body/substep.h"
#include "mesh/mesh_impl.h"

#include <stdio.h>

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
    PLII_STATE_SPAN(pli_body, overlap_steps, sleep_group, PLII_SAVED, "2u"),
    PLII_STATE_OF(pli_body, interval, PLII_SAVED, "2i2f2B"),
    PLII_STATE_SPAN(pli_body, joint_iterations, sweeping_features, PLII_SAVED, "2i"),
    {0},
};

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
    plii_file_fields(file, "2B", &sizes.has_tags);
    if (file->mode == PLII_FILE_READ && (sizes.nodes == 0 || sizes.materials > PLII_MAX_MATERIALS)) {
        plii_file_refuse(file, "it has no nodes, or too many materials");
    }
    return sizes;
}

static pli_body* file_make_body(plii_file* file, pli_world* world, const file_body_sizes* sizes) {
    plii_topology* topology =
        plii_topology_create(file->context, sizes->faces, sizes->tetras, sizes->has_face_materials);
    pli_body* body =
        plii_body_make(world, sizes->nodes, sizes->links, sizes->materials, sizes->has_tags, topology, NULL, NULL);
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

void plii_file_body(plii_file* file, pli_world* world, pli_body* body) {
    const file_body_sizes sizes = file_body_read_sizes(file, body);
    if (file->status != PLI_OK) { return; }
    if (file->mode == PLII_FILE_READ) { body = file_make_body(file, world, &sizes); }
    if (body == NULL) { return; }
    file->body = body;
    plii_file_parts(file, file_body_parts, body);
    file_body_mesh(file, body);
    if (file->mode != PLII_FILE_READ || file->status != PLI_OK) { return; }
    file_check_body(file, body);
    const pli_solver_settings solver = body->solver;
    if (file->status == PLI_OK &&
        (pli_body_set_solver_settings(body, &solver) != PLI_OK ||
         plii_check_margin(file->context, body->collision_margin, file->function) != PLI_OK)) {
        plii_file_refuse(file, "a setting of the solver or the collision margin is out of range");
    }
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

static void file_ignored_rigids(plii_file* file, pli_body* body) {
    const int count = plii_file_count(file, body->ignored_rigid_count, 4);
    if (file->mode == PLII_FILE_READ && file->status == PLI_OK) {
        if (!PLII_RESERVE(file->context, &body->ignored_rigids, &body->ignored_rigid_capacity, count)) {
            PLII_FILE_FAIL(file, PLI_ERROR_OUT_OF_MEMORY, "no memory for rigid bodies that body %d ignores",
                           file->body_index);
            return;
        }
        body->ignored_rigid_count = count;
    }
    plii_file_elements(file, "S", body->ignored_rigids, (size_t)count, sizeof(*body->ignored_rigids));
}

// ------------------------------------------------------------------------------------------------------- features

enum { FILE_NAME_SIZE = 32 };

#define FILE_FEATURE(name) &plii_##name##_class,
static const plii_feature_class* const file_classes[] = {PLII_ALL_FEATURES(FILE_FEATURE)};
enum { FILE_CLASSES = sizeof file_classes / sizeof *file_classes };

static bool file_may_enable(const pli_body* body, const plii_feature_class* klass) {
    if (plii_feature_is_enabled(body, klass)) { return false; }
    for (const plii_feature_class* const* need = klass->needs; need != NULL && *need != NULL; ++need) {
        if (!plii_feature_is_enabled(body, *need)) { return false; }
    }
    const bool is_solver = klass == &plii_xpbd_class || klass == &plii_implicit_class;
    const bool has_solver = body->solver_class != &plii_position_solver;
    if (is_solver && has_solver) { return false; }
    const bool is_of_xpbd = klass->substepped != NULL && klass->substepped->is_of_xpbd;
    if (is_of_xpbd && !plii_feature_is_enabled(body, &plii_xpbd_class)) { return false; }
    if (klass == &plii_xpbd_tetras_class && body->topology->tetra_count == 0) { return false; }
    const bool is_of_positions = klass == &plii_colored_links_class || klass == &plii_velocity_links_class;
    return !(is_of_positions && has_solver);
}

static void file_enable(plii_file* file, pli_body* body, const plii_feature_class* klass, bool by_user) {
    if (!file_may_enable(body, klass)) {
        plii_file_refuse(file, "the feature does not go with those before it");
        return;
    }
    file->status = plii_feature_append(body, klass, by_user);
    if (file->status == PLI_ERROR_OUT_OF_MEMORY) {
        PLII_FILE_FAIL(file, file->status, "no memory for %s of body %d", klass->name, file->body_index);
    }
}

/* Name and by_user of feature `index`. */
static void file_feature_name(plii_file* file, pli_body* body, int index) {
    const bool is_reading = file->mode == PLII_FILE_READ;
    char name[FILE_NAME_SIZE] = {0};
    bool by_user = false;
    if (!is_reading) {
        const plii_feature* feature = &body->pipeline.features[index];
        memcpy(name, feature->klass->name, strlen(feature->klass->name));
        by_user = feature->by_user;
    }
    for (int i = 0; i < FILE_NAME_SIZE; ++i) {
        plii_file_number(file, &name[i], 1);
    }
    plii_file_fields(file, "B", &by_user);
    if (!is_reading || file->status != PLI_OK) { return; }
    name[FILE_NAME_SIZE - 1] = 0;
    const plii_feature_class* klass = NULL;
    for (int i = 0; i < FILE_CLASSES && klass == NULL; ++i) {
        if (strcmp(file_classes[i]->name, name) == 0) { klass = file_classes[i]; }
    }
    if (klass == NULL) {
        plii_file_refuse(file, "there is a feature that this version does not know");
        return;
    }
    file->what = klass->name;
    file_enable(file, body, klass, by_user);
}

static void* file_member(void* state, size_t offset) {
    return (unsigned char*)state + offset;
}
static int file_get_int(void* state, size_t offset) {
    int value;
    memcpy(&value, file_member(state, offset), sizeof value);
    return value;
}

/* Of what was read, the numbers that calls would refuse. */
static void file_check_settings(plii_file* file, const plii_limits* settings, void* values) {
    for (int i = 0; i < settings->count && file->mode == PLII_FILE_READ && file->status == PLI_OK; ++i) {
        const plii_field* field = &settings->fields[i];
        if (plii_check_fields(file->context, file_member(values, settings->offset), 1, field, file->function) ==
            PLI_OK) {
            continue;
        }
        char problem[64];
        snprintf(problem, sizeof problem, "%s is out of range", field->name);
        plii_file_refuse(file, problem);
    }
}

/* How many elements a list has; without a count, all of its capacity. */
static void file_list(plii_file* file, pli_body* body, const plii_feature_array* array, void* state) {
    const size_t count_offset = array->count != 0 ? array->count : array->capacity;
    int count = plii_file_count(file, file_get_int(state, count_offset), plii_file_packed_size(array->fields));
    if (file->status != PLI_OK) { return; }
    if (file->mode == PLII_FILE_READ && array->count == 0 && count != file_get_int(state, array->capacity)) {
        plii_file_refuse(file, "a list has another length than the body needs");
        return;
    }
    if (file->mode == PLII_FILE_READ && array->count != 0) {
        void** block = file_member(state, array->member);
        if (!plii_reserve(body->context, block, file_member(state, array->capacity), count, array->element_size)) {
            PLII_FILE_FAIL(file, PLI_ERROR_OUT_OF_MEMORY, "no memory for %s of body %d", file->what, file->body_index);
            return;
        }
        memcpy(file_member(state, array->count), &count, sizeof count);
    }
    void* block = plii_feature_array_address(body, array, state);
    plii_file_elements(file, array->fields, block, (size_t)count, array->element_size);
    for (int i = 0; i < count && array->settings.count > 0; ++i) {
        file_check_settings(file, &array->settings, file_member(block, (size_t)i * array->element_size));
    }
}

/* Of lists with a common count. */
static bool file_lists_have_room(const plii_feature_class* klass, void* state) {
    for (PLII_EACH_ARRAY(array, klass)) {
        if (array->length != PLII_LIST || array->count == 0) { continue; }
        if (file_get_int(state, array->count) > file_get_int(state, array->capacity)) { return false; }
    }
    return true;
}

static void file_feature_state(plii_file* file, pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    void* state = feature->state;
    plii_file_begin_part(file, klass->name);
    plii_file_parts(file, klass->state_parts, state);
    file_check_settings(file, &klass->settings, state);
    for (PLII_EACH_ARRAY(array, klass)) {
        if (file->status != PLI_OK) { break; }
        if (!plii_file_is_kept(array->fields, array->snapshot)) { continue; }
        if (array->length == PLII_LIST) {
            file_list(file, body, array, state);
        } else { /* one that follows the body */
            const size_t count = plii_feature_array_bytes(body, array, state) / array->element_size;
            void* block = plii_feature_array_address(body, array, state);
            plii_file_elements(file, array->fields, block, count, array->element_size);
        }
    }
    if (file->mode == PLII_FILE_READ && file->status == PLI_OK && !file_lists_have_room(klass, state)) {
        plii_file_refuse(file, "two lists have different lengths");
    }
}

void plii_file_features(plii_file* file, pli_body* body) {
    file_ignored_rigids(file, body);
    const int count = plii_file_count(file, body->pipeline.feature_count, FILE_NAME_SIZE + 1);
    for (int i = 0; i < count && file->status == PLI_OK; ++i) {
        file->what = "features";
        file_feature_name(file, body, i);
    }
    for (int i = 0; i < body->pipeline.feature_count && file->status == PLI_OK; ++i) {
        if (file->mode == PLII_FILE_READ && body->pipeline.features[i].users == 0) {
            plii_file_refuse(file, "nobody needs a feature");
        }
        file_feature_state(file, body, &body->pipeline.features[i]);
    }
    file->what = NULL;
}

void plii_file_empty_features(pli_body* body) {
    for (PLII_EACH_FEATURE(feature, body)) {
        for (PLII_EACH_ARRAY(array, feature->klass)) {
            if (array->length != PLII_LIST || array->count == 0) { continue; }
            memset(file_member(feature->state, array->count), 0, sizeof(int));
        }
    }
    body->sweeping_features = 0; /* features count down as they end */
}

void plii_file_settle_features(plii_file* file, pli_body* body) {
    for (PLII_EACH_FEATURE(feature, body)) {
        file->what = feature->klass->name;
        if (feature->klass->is_sound != NULL && !feature->klass->is_sound(body, feature->state)) {
            plii_file_refuse(file, "its numbers do not go together");
            return;
        }
        if (feature->klass->on_restored != NULL) { feature->klass->on_restored(body, feature->state); }
    }
    file->what = NULL;
}

void plii_file_take_over(pli_body* body, const pli_body* before) {
    for (PLII_EACH_FEATURE(feature, body)) {
        if (feature->klass->on_restored != NULL) { feature->klass->on_restored(body, feature->state); }
        const void* state = plii_feature_state(before, feature->klass);
        if (feature->klass->keep_callbacks != NULL && state != NULL) {
            feature->klass->keep_callbacks(feature->state, state);
        }
    }
}
