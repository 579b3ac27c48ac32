/* Records of nodes to planes of components and back, four at a time. */

#include "lanes.h"

#include "node_planes.h"

void plii_planes_take(const plii_planes* planes, const pli_vec4* records, int begin, int end) {
    int i = begin;
    for (; i + PLII_LANES <= end; i += PLII_LANES) {
        plii_float4 w;
        const plii_vec3x4 four = plii_vec3x4_from_records(records + i, &w);
        plii_float4_store(planes->x + i, four.x);
        plii_float4_store(planes->y + i, four.y);
        plii_float4_store(planes->z + i, four.z);
        if (planes->w != NULL) { plii_float4_store(planes->w + i, w); }
    }
    for (; i < end; ++i) {
        planes->x[i] = records[i].x;
        planes->y[i] = records[i].y;
        planes->z[i] = records[i].z;
        if (planes->w != NULL) { planes->w[i] = records[i].w; }
    }
}

void plii_planes_give(const plii_planes* planes, pli_vec4* records, int begin, int end) {
    int i = begin;
    for (; i + PLII_LANES <= end; i += PLII_LANES) {
        plii_float4 rows[PLII_LANES] = {plii_float4_load(planes->x + i), plii_float4_load(planes->y + i),
                                        plii_float4_load(planes->z + i),
                                        planes->w != NULL ? plii_float4_load(planes->w + i) : plii_float4_all(0.0f)};
        plii_float4_turn(rows);
        for (int k = 0; k < PLII_LANES; ++k) {
            plii_float4_to(&records[i + k], rows[k]);
        }
    }
    for (; i < end; ++i) {
        records[i] = (pli_vec4){planes->x[i], planes->y[i], planes->z[i], planes->w != NULL ? planes->w[i] : 0.0f};
    }
}
