/* Arrays of features by their table. */

#include "body/pipeline.h"

/* How many nodes, links and faces there are. */
typedef struct feature_counts {
    size_t of[PLII_LIST];
} feature_counts;

static feature_counts feature_counts_of(int nodes, int links, int faces) {
    return (feature_counts){
        {[PLII_PER_NODE] = (size_t)nodes, [PLII_PER_LINK] = (size_t)links, [PLII_PER_FACE] = (size_t)faces}};
}
static feature_counts feature_counts_now(const pli_body* body) {
    return feature_counts_of(body->node_count, body->link_count, body->topology->face_count);
}
static feature_counts feature_counts_before(const plii_topology_change* change) {
    return feature_counts_of(change->old_node_count, change->old_link_count, change->old_face_count);
}

/* Pointers are objects of several types, so they are copied. */
void* plii_feature_array_address(const pli_body* body, const plii_feature_array* array, const void* state) {
    void* block;
    memcpy(&block, (array->is_in_body ? (const char*)body : (const char*)state) + array->member, sizeof block);
    return block;
}
static void feature_array_set(pli_body* body, const plii_feature_array* array, void* state, void* block) {
    memcpy((array->is_in_body ? (char*)body : (char*)state) + array->member, &block, sizeof block);
}

/* Bytes by the size of a body; 0 for lists. */
static size_t feature_array_size(const plii_feature_array* array, const feature_counts* counts) {
    if (array->length == PLII_LIST) { return 0; }
    const size_t times = array->times > 0 ? (size_t)array->times : 1, per = array->per > 0 ? (size_t)array->per : 1;
    return (counts->of[array->length] * times / per + (size_t)array->more) * array->element_size;
}

size_t plii_feature_array_bytes(const pli_body* body, const plii_feature_array* array, const void* state) {
    const feature_counts counts = feature_counts_now(body);
    if (plii_feature_array_address(body, array, state) == NULL) { return 0; }
    if (array->length != PLII_LIST) { return feature_array_size(array, &counts); }
    const int* capacity = (const int*)((const char*)state + array->capacity);
    return (size_t)*capacity * array->element_size;
}

bool plii_feature_arrays_allocate(pli_body* body, const plii_feature_class* klass, void* state) {
    const feature_counts counts = feature_counts_now(body);
    for (PLII_EACH_ARRAY(array, klass)) {
        const size_t size = feature_array_size(array, &counts);
        if (size == 0) { continue; }
        void* block = plii_allocate(body->context, size);
        feature_array_set(body, array, state, block);
        if (block == NULL) {
            plii_feature_arrays_release(body, klass, state, false);
            return false;
        }
    }
    return true;
}

void plii_feature_arrays_release(pli_body* body, const plii_feature_class* klass, void* state, bool only_scratch) {
    for (PLII_EACH_ARRAY(array, klass)) {
        if (only_scratch && !array->is_scratch) { continue; }
        for (int k = 0; k == 0 || k < array->copies; ++k) {
            void* at = k > 0 ? (char*)state + (size_t)k * array->stride : state;
            plii_release(body->context, plii_feature_array_address(body, array, at),
                         plii_feature_array_bytes(body, array, at));
            feature_array_set(body, array, at, NULL);
        }
    }
}

size_t plii_feature_arrays_bytes(const pli_body* body, const plii_feature_class* klass, const void* state) {
    size_t bytes = 0;
    for (PLII_EACH_ARRAY(array, klass)) {
        for (int k = 0; k == 0 || k < array->copies; ++k) {
            const void* at = k > 0 ? (const char*)state + (size_t)k * array->stride : state;
            bytes += plii_feature_array_bytes(body, array, at);
        }
    }
    return bytes;
}

bool plii_feature_arrays_need_commit(const plii_feature_class* klass) {
    for (PLII_EACH_ARRAY(array, klass)) {
        if (array->length == PLII_LIST && !array->is_kept) { return true; }
    }
    return false;
}

int plii_feature_arrays_sizes(const plii_feature_class* klass, const plii_topology_change* change, size_t* sizes) {
    const feature_counts counts = feature_counts_of(change->node_count, change->link_count, change->face_count);
    int count = 0;
    for (PLII_EACH_ARRAY(array, klass)) {
        sizes[count++] = feature_array_size(array, &counts);
    }
    return count;
}

void plii_feature_arrays_exchange(pli_body* body, const plii_feature_class* klass, void* state,
                                  const plii_topology_change* change, void** blocks) {
    const feature_counts before = feature_counts_before(change);
    for (PLII_EACH_ARRAY(array, klass)) {
        void** block = &blocks[array - klass->arrays];
        if (array->length == PLII_LIST) { continue; }
        void* old = plii_feature_array_address(body, array, state);
        if (array->is_kept && old != NULL) { memcpy(*block, old, feature_array_size(array, &before)); }
        feature_array_set(body, array, state, *block);
        *block = old;
    }
}

void plii_feature_arrays_drop(pli_body* body, const plii_feature_class* klass, void* state,
                              const plii_topology_change* change, void** blocks) {
    const feature_counts before = feature_counts_before(change);
    for (PLII_EACH_ARRAY(array, klass)) {
        plii_release(body->context, blocks[array - klass->arrays], feature_array_size(array, &before));
    }
    plii_feature_arrays_release(body, klass, state, true);
}
