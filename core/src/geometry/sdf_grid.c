/* Signed distances on a grid from a triangle soup.

   Inside is where the winding number is above one half either way, so that holes, parts turned over, parts inside of
   others and parts that cross each other do no harm. Where the sign changes far from any triangle there is a hole: the
   solid gets a surface there, and the distances around are lowered to it. */

#include "geometry/triangle_soup.h"

#include "math/bounds.h"

// -------------------------------------------------------------------------------------------------- the winding number

/* How often the surface goes round a point: 1 inside of a closed surface that faces outward and 0 outside; with holes
   or doubled parts something in between that changes gradually. Jacobson and others, Robust inside-outside segmentation
   using generalized winding numbers, 2013; far triangles are taken together as one dipole: Barill and others, Fast
   winding numbers for soups and clouds, 2018. */

#define WINDING_FAR 3.0f           /* radii of a cluster, beyond which it is far: errors of some hundredths */
#define WINDING_FULL 12.566370614f /* the solid angle of everything, 4 pi */

/* What many triangles look like from afar. */
typedef struct winding_cluster {
    pli_vec3 centre;     /* weighted by area */
    float reach_squared; /* farther from the centre than this the cluster counts as one */
    pli_vec3 area_normal;
    float area;
} winding_cluster;

/* Samples, and what winding numbers are summed up from. */
typedef struct sampling_grid {
    const plii_soup* soup;
    winding_cluster* clusters; /* of the items of the soup's tree, of four of these each, and so on up to one */
    int level_count, begin[PLII_BVH_MAX_LEVELS + 1]; /* of each level in `clusters` */
    int counts[3];
    size_t strides[3], count;
    float* distances;
    bool* is_inside;
    float highest_winding; /* of all samples, absolute */
} sampling_grid;

static void winding_finish(winding_cluster* cluster, pli_bounds box) {
    cluster->centre = plii_vec3_divide(cluster->centre, cluster->area);
    const pli_vec3 low = pli_vec3_sub(cluster->centre, box.min), high = pli_vec3_sub(box.max, cluster->centre);
    cluster->reach_squared = WINDING_FAR * WINDING_FAR * pli_vec3_length_squared(plii_vec3_max(low, high));
}
static void winding_add_weighted(winding_cluster* sum, pli_vec3 centre, pli_vec3 area_normal, float area) {
    sum->centre = pli_vec3_add(sum->centre, pli_vec3_scale(centre, area));
    sum->area_normal = pli_vec3_add(sum->area_normal, area_normal);
    sum->area += area;
}

/* False when out of memory. */
static bool winding_build(sampling_grid* grid) {
    const plii_soup* soup = grid->soup;
    const plii_bvh* tree = &soup->tree;
    grid->level_count = plii_bvh_lay_out(tree->count, grid->begin);
    const int count = grid->begin[grid->level_count];
    plii_scratch scratch = {.context = soup->context};
    pli_bounds* boxes = PLII_TAKE(&scratch, pli_bounds, count);
    if (boxes == NULL || !PLII_ALLOCATE(soup->context, &grid->clusters, count)) {
        plii_scratch_free(&scratch);
        return false;
    }
    for (int i = 0; i < tree->count; ++i) {
        const pli_vec3* c = soup->triangles[tree->items[i]].corners;
        const pli_vec3 normal =
            pli_vec3_scale(pli_vec3_cross(pli_vec3_sub(c[1], c[0]), pli_vec3_sub(c[2], c[0])), 0.5f);
        const pli_vec3 centre = pli_vec3_scale(pli_vec3_add(c[0], pli_vec3_add(c[1], c[2])), 1.0f / 3.0f);
        winding_add_weighted(&grid->clusters[i], centre, normal, pli_vec3_length(normal));
        boxes[i] = plii_bounds_of_triangle(c[0], c[1], c[2]);
    }
    for (int level = 0; level < grid->level_count; ++level) {
        const int begin = grid->begin[level], end = grid->begin[level + 1];
        for (int i = begin; i < end; ++i) {
            winding_cluster* cluster = &grid->clusters[i];
            winding_finish(cluster, boxes[i]);
            if (end == count) { continue; } /* there are no parents */
            const int parent = end + (i - begin) / PLII_BVH_FAN;
            boxes[parent] = (i - begin) % PLII_BVH_FAN == 0 ? boxes[i] : plii_bounds_join(boxes[parent], boxes[i]);
            winding_add_weighted(&grid->clusters[parent], cluster->centre, cluster->area_normal, cluster->area);
        }
    }
    plii_scratch_free(&scratch);
    return true;
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

/* Adds that of a cluster at a point, its last ones first, in logarithmic time. */
static void winding_add_angle(const sampling_grid* grid, int level, int index, pli_vec3 point, float* angle) {
    const winding_cluster* cluster = &grid->clusters[grid->begin[level] + index];
    const pli_vec3 offset = pli_vec3_sub(cluster->centre, point);
    const float squared = pli_vec3_length_squared(offset);
    if (squared > cluster->reach_squared) {
        *angle += pli_vec3_dot(cluster->area_normal, offset) / (squared * sqrtf(squared));
    } else if (level == 0) {
        const int item = grid->soup->tree.items[index];
        *angle += winding_solid_angle(grid->soup->triangles[item].corners, point);
    } else {
        const int first = index * PLII_BVH_FAN, width = grid->begin[level] - grid->begin[level - 1];
        for (int child = (first + PLII_BVH_FAN < width ? first + PLII_BVH_FAN : width) - 1; child >= first; --child) {
            winding_add_angle(grid, level - 1, child, point, angle);
        }
    }
}
static float winding_at(const sampling_grid* grid, pli_vec3 point) {
    float angle = 0.0f;
    winding_add_angle(grid, grid->level_count - 1, 0, point, &angle);
    return angle / WINDING_FULL;
}

// --------------------------------------------------------------------------------------------------------- the samples

#define SAMPLING_BLOCK 4 /* samples along the edge of a block */
/* Cells: a block whose centre is farther from the surface lies on one side of it; its samples are within 2.6. */
#define SAMPLING_NEAR 4.1f
#define SAMPLING_CLEAR 0.25f /* winding numbers farther than this from one half hold for the whole of such a block */
#define SAMPLING_SIDE 0.05f  /* cells: so far from a triangle its two sides are looked at */
/* Where no sample has a winding number above this the triangles are a sheet rather than a solid. */
#define SAMPLING_ENCLOSED 0.75f
/* Neighbours of different sign whose distances sum up to more cells than this have no surface between them. Exact
   distances give 1 at most, and more where rounding took a sample on the surface to the other side. */
#define SAMPLING_HOLE 1.5f

static bool sampling_is_solid(float winding) {
    return fabsf(winding) > 0.5f;
}

/* Coordinates of a sample along the axes. */
static void sampling_locate(const sampling_grid* grid, size_t sample, int at[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        at[axis] = (int)(sample / grid->strides[axis] % (size_t)grid->counts[axis]);
    }
}

/* Whether both sides of a triangle are solid at one of its points. */
static bool sampling_is_inner(const sampling_grid* grid, pli_vec3 point, pli_vec3 side) {
    return sampling_is_solid(winding_at(grid, pli_vec3_add(point, side))) &&
           sampling_is_solid(winding_at(grid, pli_vec3_sub(point, side)));
}

/* Walls inside of the solid, where parts overlap, are not its surface. False when nothing else is there. */
static bool sampling_hide_inner_triangles(plii_soup* soup, const sampling_grid* grid) {
    bool has_surface = false;
    for (int i = 0; i < soup->count; ++i) {
        const pli_vec3* c = soup->triangles[i].corners;
        const pli_vec3 cross = pli_vec3_cross(pli_vec3_sub(c[1], c[0]), pli_vec3_sub(c[2], c[0]));
        const pli_vec3 side = pli_vec3_scale(cross, SAMPLING_SIDE / pli_vec3_length(cross));
        const pli_vec3 centre = pli_vec3_scale(pli_vec3_add(c[0], pli_vec3_add(c[1], c[2])), 1.0f / 3.0f);
        bool is_hidden = sampling_is_inner(grid, centre, side);
        for (int k = 0; k < 3 && is_hidden; ++k) {
            is_hidden = sampling_is_inner(grid, pli_vec3_lerp(centre, c[k], 0.95f), side);
        }
        soup->triangles[i].is_hidden = is_hidden;
        has_surface = has_surface || !is_hidden;
    }
    return has_surface;
}

static void sampling_fill_block(sampling_grid* grid, const int first[3]) {
    int end[3];
    for (int axis = 0; axis < 3; ++axis) {
        end[axis] =
            first[axis] + SAMPLING_BLOCK < grid->counts[axis] ? first[axis] + SAMPLING_BLOCK : grid->counts[axis];
    }
    const float half = 0.5f * (float)(SAMPLING_BLOCK - 1);
    const pli_vec3 centre = pli_vec3_make((float)first[0] + half, (float)first[1] + half, (float)first[2] + half);
    float centre_distance;
    int nearest = plii_soup_nearest(grid->soup, centre, PLI_NULL_INDEX, &centre_distance);
    const bool is_near = centre_distance <= SAMPLING_NEAR;
    float winding = is_near ? 0.5f : fabsf(winding_at(grid, centre));
    const bool is_clear = fabsf(winding - 0.5f) > SAMPLING_CLEAR;
    for (int k = first[2]; k < end[2]; ++k) {
        for (int j = first[1]; j < end[1]; ++j) {
            for (int i = first[0]; i < end[0]; ++i) {
                const size_t at = (size_t)i + grid->strides[1] * (size_t)j + grid->strides[2] * (size_t)k;
                const pli_vec3 p = pli_vec3_make((float)i, (float)j, (float)k);
                nearest = plii_soup_nearest(grid->soup, p, nearest, &grid->distances[at]);
                if (!is_clear) { winding = fabsf(winding_at(grid, p)); }
                grid->is_inside[at] = sampling_is_solid(winding);
                grid->highest_winding = plii_max(grid->highest_winding, winding);
            }
        }
    }
}

static void sampling_fill_blocks(sampling_grid* grid) {
    int first[3];
    for (first[2] = 0; first[2] < grid->counts[2]; first[2] += SAMPLING_BLOCK) {
        for (first[1] = 0; first[1] < grid->counts[1]; first[1] += SAMPLING_BLOCK) {
            for (first[0] = 0; first[0] < grid->counts[0]; first[0] += SAMPLING_BLOCK) {
                sampling_fill_block(grid, first);
            }
        }
    }
}

/* Both sides of a change of sign that no triangle explains. */
static bool sampling_find_holes(sampling_grid* grid) {
    bool has_holes = false;
    for (size_t i = 0; i < grid->count; ++i) {
        int at[3];
        sampling_locate(grid, i, at);
        for (int axis = 0; axis < 3; ++axis) {
            if (at[axis] + 1 == grid->counts[axis]) { continue; }
            const size_t next = i + grid->strides[axis];
            if (grid->is_inside[i] == grid->is_inside[next]) { continue; }
            if (grid->distances[i] + grid->distances[next] <= SAMPLING_HOLE) { continue; }
            grid->distances[i] = plii_min(grid->distances[i], 0.5f);
            grid->distances[next] = plii_min(grid->distances[next], 0.5f);
            has_holes = true;
        }
    }
    return has_holes;
}

/* No distance may exceed that of a neighbour by more than the way there: half of the 26 neighbours in the order of the
   samples, the others in the opposite order (Borgefors, Distance transformations in digital images, 1986). */
static void sampling_lower(sampling_grid* grid, bool is_backward) {
    const float lengths[4] = {0.0f, 1.0f, 1.41421356f, 1.73205081f};
    const int sign = is_backward ? -1 : 1;
    for (size_t i = 0; i < grid->count; ++i) {
        int at[3];
        const size_t sample = is_backward ? grid->count - 1 - i : i;
        sampling_locate(grid, sample, at);
        /* The 13 neighbours before this one are the first of the 27 samples around it. */
        for (int n = 0; n < 13; ++n) {
            const int d[3] = {sign * (n % 3 - 1), sign * (n / 3 % 3 - 1), sign * (n / 9 - 1)};
            ptrdiff_t step = 0;
            bool is_there = true;
            for (int axis = 0; axis < 3; ++axis) {
                step += d[axis] * (ptrdiff_t)grid->strides[axis];
                is_there = is_there && at[axis] + d[axis] >= 0 && at[axis] + d[axis] < grid->counts[axis];
            }
            if (!is_there) { continue; }
            const float length = lengths[d[0] * d[0] + d[1] * d[1] + d[2] * d[2]];
            const float across = grid->distances[(ptrdiff_t)sample + step] + length;
            grid->distances[sample] = plii_min(grid->distances[sample], across);
        }
    }
}

/* False when nothing is inside. */
static bool sampling_fill(sampling_grid* grid) {
    sampling_fill_blocks(grid);
    if (grid->highest_winding < SAMPLING_ENCLOSED) { return false; }
    if (sampling_find_holes(grid)) {
        sampling_lower(grid, false);
        sampling_lower(grid, true);
    }
    for (size_t i = 0; i < grid->count; ++i) {
        if (grid->is_inside[i]) { grid->distances[i] = -grid->distances[i]; }
    }
    return true;
}

pli_status plii_soup_sample(plii_soup* soup, const int counts[3], float* samples) {
    if (soup->count == 0) { return PLI_ERROR_INVALID_MESH; }
    sampling_grid grid = {.soup = soup, .distances = samples, .count = 1};
    for (int axis = 0; axis < 3; ++axis) {
        grid.counts[axis] = counts[axis];
        grid.strides[axis] = grid.count;
        grid.count *= (size_t)counts[axis];
    }
    pli_status status = PLI_ERROR_OUT_OF_MEMORY;
    if (PLII_ALLOCATE(soup->context, &grid.is_inside, grid.count) && winding_build(&grid)) {
        status = sampling_hide_inner_triangles(soup, &grid) && sampling_fill(&grid) ? PLI_OK : PLI_ERROR_INVALID_MESH;
    }
    PLII_RELEASE(soup->context, grid.clusters, grid.begin[grid.level_count]);
    PLII_RELEASE(soup->context, grid.is_inside, grid.count);
    return status;
}
