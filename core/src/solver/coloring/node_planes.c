/* Records of nodes to planes of components and back, eight at a time. */

#include "math/lanes.h"

#include "solver/coloring/node_planes.h"

static void planes_take_one(const plii_planes* planes, const pli_vec4* records, int node) {
    const ptrdiff_t place = plii_planes_place(planes, node);
    planes->x[place] = records[node].x;
    planes->y[place] = records[node].y;
    planes->z[place] = records[node].z;
    if (planes->w != NULL) { planes->w[place] = records[node].w; }
}
static void planes_give_one(const plii_planes* planes, pli_vec4* records, int node) {
    const ptrdiff_t place = plii_planes_place(planes, node);
    const float w = planes->w != NULL ? planes->w[place] : 0.0f;
    records[node] = (pli_vec4){planes->x[place], planes->y[place], planes->z[place], w};
}

/* Every second of eight nodes. */
PLII_SIMD_INLINE void planes_take_four(const plii_planes* planes, const pli_vec4* records, int node) {
    const ptrdiff_t place = plii_planes_place(planes, node);
    plii_float4 four[PLII_LANES] = {plii_float4_from(&records[node]), plii_float4_from(&records[node + 2]),
                                    plii_float4_from(&records[node + 4]), plii_float4_from(&records[node + 6])};
    plii_float4_turn(four);
    plii_float4_store(planes->x + place, four[0]);
    plii_float4_store(planes->y + place, four[1]);
    plii_float4_store(planes->z + place, four[2]);
    if (planes->w != NULL) { plii_float4_store(planes->w + place, four[3]); }
}
PLII_SIMD_INLINE void planes_give_four(const plii_planes* planes, pli_vec4* records, int node) {
    const ptrdiff_t place = plii_planes_place(planes, node);
    plii_float4 four[PLII_LANES] = {plii_float4_load(planes->x + place), plii_float4_load(planes->y + place),
                                    plii_float4_load(planes->z + place),
                                    planes->w != NULL ? plii_float4_load(planes->w + place) : plii_float4_all(0.0f)};
    plii_float4_turn(four);
    for (int k = 0; k < PLII_LANES; ++k) {
        plii_float4_to(&records[node + 2 * k], four[k]);
    }
}

void plii_planes_take(const plii_planes* planes, const pli_vec4* records, int begin, int end) {
    const plii_planes copy = *planes; /* no store can change it */
    int i = begin;
    for (; i + 2 * PLII_LANES <= end; i += 2 * PLII_LANES) {
        planes_take_four(&copy, records, i);
        planes_take_four(&copy, records, i + 1);
    }
    for (; i < end; ++i) {
        planes_take_one(&copy, records, i);
    }
}

void plii_planes_give(const plii_planes* planes, pli_vec4* records, int begin, int end) {
    const plii_planes copy = *planes;
    int i = begin;
    for (; i + 2 * PLII_LANES <= end; i += 2 * PLII_LANES) {
        planes_give_four(&copy, records, i);
        planes_give_four(&copy, records, i + 1);
    }
    for (; i < end; ++i) {
        planes_give_one(&copy, records, i);
    }
}
