/* Generalised winding numbers (Jacobson, Kavan, Sorkine-Hornung, Robust inside-outside segmentation using generalized
   winding numbers, 2013), far triangles taken together as one dipole (Barill, Dickson, Schmidt, Levin, Jacobson, Fast
   winding numbers for soups and clouds, 2018). */

#include "geometry/winding_number.h"

#include "base/scratch.h"
#include "math/bounds.h"

/* A cluster is far when it is this many of its radii away: errors of some hundredths. */
#define WINDING_FAR 3.0f
#define WINDING_FULL 12.566370614f /* the solid angle of everything, 4 pi */

static void winding_finish(plii_winding_cluster* cluster, pli_bounds box) {
    cluster->centre = plii_vec3_divide(cluster->centre, cluster->area);
    const pli_vec3 low = pli_vec3_sub(cluster->centre, box.min), high = pli_vec3_sub(box.max, cluster->centre);
    cluster->reach_squared = WINDING_FAR * WINDING_FAR * pli_vec3_length_squared(plii_vec3_max(low, high));
}

static void winding_add_weighted(plii_winding_cluster* sum, pli_vec3 centre, pli_vec3 area_normal, float area) {
    sum->centre = pli_vec3_add(sum->centre, pli_vec3_scale(centre, area));
    sum->area_normal = pli_vec3_add(sum->area_normal, area_normal);
    sum->area += area;
}

bool plii_winding_build(plii_winding* winding, const plii_soup* soup) {
    const plii_bvh* tree = &soup->tree;
    winding->soup = soup;
    winding->level_count = plii_bvh_lay_out(tree->count, winding->begin);
    const int count = winding->begin[winding->level_count];
    plii_scratch scratch = {.context = soup->context};
    pli_bounds* boxes = PLII_TAKE(&scratch, pli_bounds, count);
    if (boxes == NULL || !PLII_ALLOCATE(soup->context, &winding->clusters, count)) {
        plii_scratch_free(&scratch);
        return false;
    }
    for (int i = 0; i < tree->count; ++i) {
        const pli_vec3* c = soup->triangles[tree->items[i]].corners;
        const pli_vec3 normal =
            pli_vec3_scale(pli_vec3_cross(pli_vec3_sub(c[1], c[0]), pli_vec3_sub(c[2], c[0])), 0.5f);
        const pli_vec3 centre = pli_vec3_scale(pli_vec3_add(c[0], pli_vec3_add(c[1], c[2])), 1.0f / 3.0f);
        winding_add_weighted(&winding->clusters[i], centre, normal, pli_vec3_length(normal));
        boxes[i] = plii_bounds_of_triangle(c[0], c[1], c[2]);
        winding_finish(&winding->clusters[i], boxes[i]);
    }
    for (int level = 1; level < winding->level_count; ++level) {
        const int below = winding->begin[level - 1], begin = winding->begin[level], end = winding->begin[level + 1];
        for (int i = below; i < begin; ++i) {
            const plii_winding_cluster* child = &winding->clusters[i];
            const int parent = begin + (i - below) / PLII_BVH_FAN;
            boxes[parent] = (i - below) % PLII_BVH_FAN == 0 ? boxes[i] : plii_bounds_join(boxes[parent], boxes[i]);
            winding_add_weighted(&winding->clusters[parent], child->centre, child->area_normal, child->area);
        }
        for (int i = begin; i < end; ++i) {
            winding_finish(&winding->clusters[i], boxes[i]);
        }
    }
    plii_scratch_free(&scratch);
    return true;
}

void plii_winding_free(plii_winding* winding) {
    if (winding->soup == NULL) { return; }
    PLII_RELEASE(winding->soup->context, winding->clusters, winding->begin[winding->level_count]);
}

/* Van Oosterom and Strackee, The solid angle of a plane triangle, 1983. */
static float winding_solid_angle(const pli_vec3* corners, pli_vec3 point) {
    const pli_vec3 a = pli_vec3_sub(corners[0], point), b = pli_vec3_sub(corners[1], point);
    const pli_vec3 c = pli_vec3_sub(corners[2], point);
    const float la = pli_vec3_length(a), lb = pli_vec3_length(b), lc = pli_vec3_length(c);
    const float volume = pli_vec3_dot(a, pli_vec3_cross(b, c));
    const float below = la * lb * lc + pli_vec3_dot(a, b) * lc + pli_vec3_dot(b, c) * la + pli_vec3_dot(c, a) * lb;
    return 2.0f * atan2f(volume, below);
}

float plii_winding_at(const plii_winding* winding, pli_vec3 point) {
    const plii_bvh* tree = &winding->soup->tree;
    struct {
        int level, index;
    } stack[PLII_BVH_STACK];
    int depth = 0;
    stack[depth].level = winding->level_count - 1;
    stack[depth++].index = 0;
    float angle = 0.0f;
    while (depth > 0) {
        --depth;
        const int level = stack[depth].level, index = stack[depth].index;
        const plii_winding_cluster* cluster = &winding->clusters[winding->begin[level] + index];
        const pli_vec3 offset = pli_vec3_sub(cluster->centre, point);
        const float squared = pli_vec3_length_squared(offset);
        if (squared > cluster->reach_squared) {
            angle += pli_vec3_dot(cluster->area_normal, offset) / (squared * sqrtf(squared));
            continue;
        }
        if (level == 0) {
            angle += winding_solid_angle(winding->soup->triangles[tree->items[index]].corners, point);
            continue;
        }
        const int first = index * PLII_BVH_FAN;
        const int width = winding->begin[level] - winding->begin[level - 1];
        for (int child = first; child < first + PLII_BVH_FAN && child < width; ++child) {
            stack[depth].level = level - 1;
            stack[depth++].index = child;
        }
    }
    return angle / WINDING_FULL;
}
