/* Features of bodies in files. The one file that names them all. */

#include "file/file_impl.h"

#include "body/pipeline.h"
#include "body/substep.h"

#include <stdio.h>
#include <string.h>

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

static bool file_is_kept(const char* fields, plii_snapshot_share share) {
    return fields != NULL && share != PLII_LEFT;
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
        int* capacity = file_member(state, array->capacity);
        if (!plii_reserve(body->context, block, capacity, count, array->element_size)) {
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

/* One that follows the body. */
static void file_array(plii_file* file, pli_body* body, const plii_feature_array* array, void* state) {
    void* block = plii_feature_array_address(body, array, state);
    bool is_there = block != NULL;
    if (array->is_optional) { plii_file_fields(file, "B", &is_there); }
    if (file->status != PLI_OK) { return; }
    if (file->mode == PLII_FILE_READ && is_there && block == NULL) {
        if (!plii_feature_array_add(body, array, state)) {
            plii_file_refuse(file, "an array cannot be made");
            return;
        }
        block = plii_feature_array_address(body, array, state);
    }
    if (!is_there || !file_is_kept(array->fields, array->snapshot)) { return; }
    const size_t count = plii_feature_array_bytes(body, array, state) / array->element_size;
    plii_file_elements(file, array->fields, block, count, array->element_size);
}

/* Of lists with a common count. */
static bool file_lists_have_room(const plii_feature_class* klass, void* state) {
    for (const plii_feature_array* array = klass->arrays; array != NULL && array->element_size > 0; ++array) {
        if (array->length != PLII_LIST || array->count == 0) { continue; }
        if (file_get_int(state, array->count) > file_get_int(state, array->capacity)) { return false; }
    }
    return true;
}

static void file_feature_state(plii_file* file, pli_body* body, const plii_feature* feature) {
    const plii_feature_class* klass = feature->klass;
    void* state = feature->state;
    plii_file_begin_part(file, klass->name);
    for (const plii_state_part* part = klass->state_parts; part != NULL && part->size > 0; ++part) {
        if (file_is_kept(part->fields, part->snapshot)) {
            plii_file_fields(file, part->fields, file_member(state, part->offset));
        }
    }
    file_check_settings(file, &klass->settings, state);
    for (const plii_feature_array* array = klass->arrays; array != NULL && array->element_size > 0; ++array) {
        if (file->status != PLI_OK) { break; }
        if (array->length >= PLII_LIST) {
            if (file_is_kept(array->fields, array->snapshot)) { file_list(file, body, array, state); }
        } else if (!array->is_scratch) {
            file_array(file, body, array, state);
        }
    }
    if (file->mode == PLII_FILE_READ && file->status == PLI_OK && !file_lists_have_room(klass, state)) {
        plii_file_refuse(file, "two lists have different lengths");
    }
}

void plii_file_features(plii_file* file, pli_body* body) {
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
        const plii_feature_array* array = feature->klass->arrays;
        for (; array != NULL && array->element_size > 0; ++array) {
            if (array->length != PLII_LIST || array->count == 0) { continue; }
            memset(file_member(feature->state, array->count), 0, sizeof(int));
        }
    }
    body->sweeping_features = 0; /* features count down as they end */
}

void plii_file_settle_features(plii_file* file, pli_body* body) {
    for (int i = 0; i < body->pipeline.feature_count && file->status == PLI_OK; ++i) {
        const plii_feature* feature = &body->pipeline.features[i];
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
