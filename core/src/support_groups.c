/* Packed coordinates, and groups by splitting at the median along the longest side until the groups are small. */

#include "support_groups.h"

static const plii_support_kernel* support_kernel(const pli_context* context) {
#if PLIANT_SIMD_X86
    if (context->simd == PLI_SIMD_AVX2) { return &plii_support_kernel_avx2; }
#else
    (void)context;
#endif
    return &plii_support_kernel_base;
}

static float support_coordinate(pli_vec4 x, int axis) {
    return axis == 0 ? x.x : axis == 1 ? x.y : x.z;
}

static pli_bounds support_bounds(const pli_vec4* positions, const int* nodes, int count) {
    pli_vec3 min = plii_xyz(positions[nodes[0]]), max = min;
    for (int i = 1; i < count; ++i) {
        min = plii_vec3_min(min, plii_xyz(positions[nodes[i]]));
        max = plii_vec3_max(max, plii_xyz(positions[nodes[i]]));
    }
    return (pli_bounds){min, max};
}

/* Brings the `rank` smallest along an axis to the front (quickselect; ties by index keep it deterministic). */
static void support_select(const pli_vec4* positions, int* nodes, int count, int rank, int axis) {
    int low = 0, high = count - 1;
    while (low < high) {
        const float pivot = support_coordinate(positions[nodes[low + (high - low) / 2]], axis);
        int i = low, k = high;
        while (i <= k) {
            while (support_coordinate(positions[nodes[i]], axis) < pivot) {
                ++i;
            }
            while (support_coordinate(positions[nodes[k]], axis) > pivot) {
                --k;
            }
            if (i <= k) {
                const int swapped = nodes[i];
                nodes[i++] = nodes[k];
                nodes[k--] = swapped;
            }
        }
        if (rank <= k) {
            high = k;
        } else if (rank >= i) {
            low = i;
        } else {
            return;
        }
    }
}

static void support_split(const pli_vec4* positions, plii_support_groups* groups, int begin, int count, int largest) {
    if (count <= largest) {
        groups->begin[groups->count++] = begin;
        return;
    }
    const pli_bounds bounds = support_bounds(positions, groups->nodes + begin, count);
    const pli_vec3 size = pli_vec3_sub(bounds.max, bounds.min);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int half = count / 2;
    support_select(positions, groups->nodes + begin, count, half, axis);
    support_split(positions, groups, begin, half, largest);
    support_split(positions, groups, begin + half, count - half, largest);
}

bool plii_support_groups_create(pli_context* context, const pli_vec4* positions, const int* nodes, int node_stride,
                                int node_count, plii_support_groups* groups) {
    *groups = (plii_support_groups){0};
    if (node_count < PLII_SUPPORT_PACKED_MIN) { return true; }
    groups->node_count = node_count;
    groups->kernel = support_kernel(context);
    const size_t count = (size_t)node_count;
    const bool is_whole = node_count < PLII_SUPPORT_GROUPS_MIN;
    groups->nodes = plii_allocate(context, count * sizeof *groups->nodes);
    bool has_memory = groups->nodes != NULL;
    if (is_whole) {
        groups->packed = plii_allocate(context, plii_support_block_count(groups) * sizeof *groups->packed);
        has_memory = has_memory && groups->packed != NULL;
    } else {
        groups->begin = plii_allocate(context, (count + 1) * sizeof *groups->begin);
        groups->bounds = plii_allocate(context, count * sizeof *groups->bounds);
        has_memory = has_memory && groups->begin != NULL && groups->bounds != NULL;
    }
    if (!has_memory) {
        plii_support_groups_release(context, groups);
        return false;
    }
    for (int i = 0; i < node_count; ++i) {
        groups->nodes[i] = nodes[i * node_stride];
    }
    if (is_whole) { return true; }
    const int largest = (int)sqrtf((float)node_count);
    support_split(positions, groups, 0, node_count, largest);
    groups->begin[groups->count] = node_count;
    return true;
}

static void support_pack(const pli_vec4* positions, plii_support_groups* groups) {
    const int block_count = (int)plii_support_block_count(groups);
    for (int b = 0; b < block_count; ++b) {
        plii_support_block* block = &groups->packed[b];
        for (int lane = 0; lane < PLII_SUPPORT_LANES; ++lane) {
            const int i = b * PLII_SUPPORT_LANES + lane;
            const pli_vec4 x = positions[groups->nodes[i < groups->node_count ? i : 0]];
            block->x[lane] = x.x;
            block->y[lane] = x.y;
            block->z[lane] = x.z;
        }
    }
}

void plii_support_groups_update(const pli_vec4* positions, plii_support_groups* groups) {
    if (groups->packed != NULL) { support_pack(positions, groups); }
    for (int i = 0; i < groups->count; ++i) {
        const int begin = groups->begin[i];
        groups->bounds[i] = support_bounds(positions, groups->nodes + begin, groups->begin[i + 1] - begin);
    }
    groups->is_current = true;
}

static int support_query_groups(const pli_vec4* positions, const plii_support_groups* groups, pli_vec3 direction) {
    float best = -INFINITY;
    int farthest = groups->nodes[0];
    for (int i = 0; i < groups->count; ++i) {
        const pli_bounds b = groups->bounds[i];
        const float reach = direction.x * (direction.x > 0.0f ? b.max.x : b.min.x) +
                            direction.y * (direction.y > 0.0f ? b.max.y : b.min.y) +
                            direction.z * (direction.z > 0.0f ? b.max.z : b.min.z);
        if (!(reach > best)) { continue; }
        for (int k = groups->begin[i]; k < groups->begin[i + 1]; ++k) {
            const float along = pli_vec3_dot(plii_xyz(positions[groups->nodes[k]]), direction);
            if (along > best) {
                best = along;
                farthest = groups->nodes[k];
            }
        }
    }
    return farthest;
}

int plii_support_groups_query(const pli_vec4* positions, const plii_support_groups* groups, pli_vec3 direction) {
    return groups->packed != NULL ? groups->nodes[groups->kernel->farthest(groups, direction)]
                                  : support_query_groups(positions, groups, direction);
}

float plii_support_groups_reach(const plii_support_groups* groups, pli_vec3 direction) {
    return groups->kernel->reach(groups, direction);
}

bool plii_support_groups_has_near(const plii_support_groups* groups, pli_vec3 hub, pli_vec3 point, float distance,
                                  pli_vec3* gap) {
    *gap = pli_vec3_make(0, 0, 0);
    if (groups->packed == NULL) { return false; }
    return groups->kernel->find_way(groups, hub, point, gap) < distance * distance;
}

int plii_support_groups_find_below(const plii_support_groups* groups, pli_vec3 foot, pli_vec3 normal, float limit,
                                   pli_vec3* points, float* heights) {
    return groups->kernel->find_below(groups, foot, normal, limit, points, heights);
}

void plii_support_groups_release(pli_context* context, plii_support_groups* groups) {
    const size_t count = (size_t)groups->node_count;
    plii_release(context, groups->nodes, count * sizeof *groups->nodes);
    plii_release(context, groups->packed, plii_support_block_count(groups) * sizeof *groups->packed);
    plii_release(context, groups->begin, (count + 1) * sizeof *groups->begin);
    plii_release(context, groups->bounds, count * sizeof *groups->bounds);
    *groups = (plii_support_groups){0};
}

size_t plii_support_groups_bytes(const plii_support_groups* groups) {
    const size_t count = (size_t)groups->node_count;
    size_t bytes = count * sizeof *groups->nodes;
    if (groups->packed != NULL) { bytes += plii_support_block_count(groups) * sizeof *groups->packed; }
    if (groups->begin != NULL) { bytes += count * sizeof *groups->bounds + (count + 1) * sizeof *groups->begin; }
    return bytes;
}
