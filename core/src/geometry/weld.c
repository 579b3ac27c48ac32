#include "geometry/weld.h"

#include "math/vec.h"

#include <stdlib.h>

typedef struct weld_point {
    pli_vec3 position;
    int index;
} weld_point;

static int weld_compare(const void* left, const void* right) {
    const weld_point *a = left, *b = right;
    const int order = plii_vec3_compare(a->position, b->position);
    return order != 0 ? order : (a->index > b->index) - (a->index < b->index);
}

int plii_weld_points(pli_context* context, int count, const pli_vec3* points, int* places) {
    weld_point* sorted = NULL;
    if (!PLII_ALLOCATE(context, &sorted, count)) { return PLI_NULL_INDEX; }
    for (int i = 0; i < count; ++i) {
        sorted[i] = (weld_point){points[i], i};
    }
    qsort(sorted, (size_t)count, sizeof *sorted, weld_compare);
    for (int i = 0; i < count; ++i) {
        const bool is_first = i == 0 || plii_vec3_compare(sorted[i].position, sorted[i - 1].position) != 0;
        places[sorted[i].index] = is_first ? sorted[i].index : places[sorted[i - 1].index];
    }
    PLII_RELEASE(context, sorted, count);
    int place_count = 0;
    for (int i = 0; i < count; ++i) {
        places[i] = places[i] == i ? place_count++ : places[places[i]];
    }
    return place_count;
}
