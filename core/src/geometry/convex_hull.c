/* Quickhull: Barber, Dobkin, Huhdanpaa, "The quickhull algorithm for convex hulls", 1996. All decisions about what is
   in front of a face are exact, so that the surface is closed and convex at every moment, whatever the points; only
   the choice of the next point and the tolerance are rounded. */

#include "geometry/convex_hull.h"

#include "geometry/closest_point.h"
#include "geometry/orient3d.h"
#include "math/dvec3.h"
#include "math/range.h"

typedef struct hull_face {
    int corners[3];
    int neighbours[3]; /* face across the edge from corner i to corner i + 1 */
    int outside;       /* first of the points in front of this face, or -1; each waits at one face only */
    int next_free;     /* in the list of free slots */
    int visited_by;    /* last point that was inserted when the face was looked at */
    bool is_alive, is_visible;
} hull_face;

/* An edge of the rim between what the new point sees and the rest. */
typedef struct hull_rim {
    int from, to;
    int beyond; /* the face on the far side */
} hull_rim;

typedef struct hull_work {
    pli_context* context;
    int point_count;
    const pli_vec3* points;
    double tolerance;  /* m, what may be left out */
    double flatness;   /* m, thinner than this is flat */
    bool* late;        /* [point_count] points that are tried after all others only */
    bool is_late;      /* the time for them has come */
    int* next_outside; /* [point_count] */
    int* face_from;    /* [point_count] new face whose rim edge starts at the point */
    hull_face* faces;
    int face_count, face_capacity, free_face;
    int* queue; /* faces with points in front, and some that had some */
    int queue_count, queue_capacity;
    int* visible;
    int visible_count, visible_capacity;
    hull_rim* rim;
    int rim_count, rim_capacity;
} hull_work;

static plii_dvec3 hull_sub(pli_vec3 a, pli_vec3 b) {
    return plii_dvec3_sub(plii_dvec3_from(a), plii_dvec3_from(b));
}
static pli_vec3 hull_corner(const hull_work* work, const hull_face* face, int corner) {
    return work->points[face->corners[corner]];
}
static bool hull_sees(const hull_work* work, int point, const hull_face* face) {
    return plii_orient3d(hull_corner(work, face, 0), hull_corner(work, face, 1), hull_corner(work, face, 2),
                         work->points[point]) > 0;
}
static plii_dvec3 hull_normal(const hull_work* work, const hull_face* face) {
    const pli_vec3 origin = hull_corner(work, face, 0);
    return plii_dvec3_cross(hull_sub(hull_corner(work, face, 1), origin), hull_sub(hull_corner(work, face, 2), origin));
}

// --------------------------------------------------------------------------------------------- distance to the hull

/* Squared distance of a point from the triangle of three others, but for the rounding of the nearest point. */
static double hull_triangle_distance(const hull_work* work, int point, const int corners[3]) {
    plii_closest_feature closest;
    const pli_vec3 p = work->points[point];
    const plii_dvec3 offset =
        hull_sub(p, plii_closest_point_on_triangle(p, work->points[corners[0]], work->points[corners[1]],
                                                   work->points[corners[2]], &closest));
    return plii_dvec3_dot(offset, offset);
}

/* Whether some triangle is within the tolerance, walking over the surface towards the point. */
static bool hull_is_near(const hull_work* work, int point, int face) {
    double distance = hull_triangle_distance(work, point, work->faces[face].corners);
    for (;;) {
        if (distance <= work->tolerance * work->tolerance) { return true; }
        int best = -1;
        for (int i = 0; i < 3; ++i) {
            const int neighbour = work->faces[face].neighbours[i];
            const double other = hull_triangle_distance(work, point, work->faces[neighbour].corners);
            if (other < distance) {
                distance = other;
                best = neighbour;
            }
        }
        if (best < 0) { return false; }
        face = best;
    }
}

// --------------------------------------------------------------------------------------------------------- building

/* For a start or one more point: it adds at most as many faces as there are, and each may be queued and looked at. */
static bool hull_reserve(hull_work* work) {
    const int count = work->face_count < 4 ? 4 : 2 * work->face_count;
    return PLII_RESERVE(work->context, &work->faces, &work->face_capacity, count) &&
           PLII_RESERVE(work->context, &work->queue, &work->queue_capacity, work->queue_count + count) &&
           PLII_RESERVE(work->context, &work->visible, &work->visible_capacity, count) &&
           PLII_RESERVE(work->context, &work->rim, &work->rim_capacity, count);
}

static int hull_add_face(hull_work* work, int a, int b, int c) {
    const int face = work->free_face >= 0 ? work->free_face : work->face_count++;
    if (face == work->free_face) { work->free_face = work->faces[face].next_free; }
    work->faces[face] = (hull_face){.corners = {a, b, c}, .outside = -1, .visited_by = -1, .is_alive = true};
    return face;
}

static void hull_enqueue(hull_work* work, int face) {
    if (work->faces[face].outside >= 0) { work->queue[work->queue_count++] = face; }
}

/* Lets a point wait at the face that it is farthest in front of; a point in front of none is inside and done with. */
static void hull_assign(hull_work* work, int point, const int* candidates, int count) {
    int best = -1;
    double best_height = -HUGE_VAL;
    for (int i = 0; i < count; ++i) {
        const hull_face* face = &work->faces[candidates[i]];
        if (!hull_sees(work, point, face)) { continue; }
        const plii_dvec3 normal = hull_normal(work, face);
        const double height = plii_dvec3_dot(normal, hull_sub(work->points[point], hull_corner(work, face, 0))) /
                              plii_dvec3_length(normal);
        if (best < 0 || height > best_height) {
            best = candidates[i];
            best_height = height;
        }
    }
    if (best < 0) { return; }
    work->next_outside[point] = work->faces[best].outside;
    work->faces[best].outside = point;
}

static bool hull_must_wait(const hull_work* work, int point) {
    return work->late[point] && !work->is_late;
}

/* The farthest point in front of a face beyond the tolerance whose turn it is, or -1; others whose turn it is go. */
static int hull_find_farthest(hull_work* work, int face_index) {
    hull_face* face = &work->faces[face_index];
    const plii_dvec3 normal = hull_normal(work, face);
    const double length = plii_dvec3_length(normal);
    int kept = -1, best = -1;
    double best_height = -HUGE_VAL;
    for (int point = face->outside, next; point >= 0; point = next) {
        next = work->next_outside[point];
        const double height = plii_dvec3_dot(normal, hull_sub(work->points[point], hull_corner(work, face, 0)));
        const bool must_wait = hull_must_wait(work, point);
        if (!must_wait && height <= work->tolerance * length && hull_is_near(work, point, face_index)) { continue; }
        work->next_outside[point] = kept;
        kept = point;
        if (!must_wait && (best < 0 || height > best_height)) {
            best = point;
            best_height = height;
        }
    }
    face->outside = kept;
    return best;
}

/* Collects the faces that a point sees, starting from one of them, and the rim around them. */
static void hull_look(hull_work* work, int point, int start) {
    work->visible_count = 0;
    work->rim_count = 0;
    work->faces[start].visited_by = point;
    work->faces[start].is_visible = true;
    work->visible[work->visible_count++] = start;
    for (int i = 0; i < work->visible_count; ++i) {
        const hull_face* face = &work->faces[work->visible[i]];
        for (int k = 0; k < 3; ++k) {
            const int neighbour = face->neighbours[k];
            hull_face* other = &work->faces[neighbour];
            if (other->visited_by != point) {
                other->visited_by = point;
                other->is_visible = hull_sees(work, point, other);
                if (other->is_visible) { work->visible[work->visible_count++] = neighbour; }
            }
            if (!other->is_visible) {
                work->rim[work->rim_count++] = (hull_rim){face->corners[k], face->corners[(k + 1) % 3], neighbour};
            }
        }
    }
}

/* Replaces what the point sees by the cone from the rim to the point. */
static void hull_insert(hull_work* work, int point, int start) {
    hull_look(work, point, start);
    const int rim_count = work->rim_count;
    int* cone = work->visible + work->visible_count;
    for (int i = 0; i < rim_count; ++i) {
        const hull_rim* rim = &work->rim[i];
        cone[i] = hull_add_face(work, rim->from, rim->to, point);
        work->faces[cone[i]].neighbours[0] = rim->beyond;
        hull_face* beyond = &work->faces[rim->beyond];
        for (int k = 0; k < 3; ++k) {
            if (beyond->corners[k] == rim->to) { beyond->neighbours[k] = cone[i]; }
        }
        work->face_from[rim->from] = cone[i];
    }
    for (int i = 0; i < rim_count; ++i) {
        const int next = work->face_from[work->rim[i].to];
        work->faces[cone[i]].neighbours[1] = next;
        work->faces[next].neighbours[2] = cone[i];
    }
    for (int i = 0; i < work->visible_count; ++i) {
        for (int waiting = work->faces[work->visible[i]].outside, next; waiting >= 0; waiting = next) {
            next = work->next_outside[waiting];
            hull_assign(work, waiting, cone, rim_count);
        }
    }
    for (int i = 0; i < work->visible_count; ++i) {
        hull_face* face = &work->faces[work->visible[i]];
        face->is_alive = false;
        face->outside = -1;
        face->next_free = work->free_face;
        work->free_face = work->visible[i];
    }
    for (int i = 0; i < rim_count; ++i) {
        hull_enqueue(work, cone[i]);
    }
}

/* Four points that span a volume: two far apart, one far from their line, one far from the plane of the three. */
static bool hull_find_start(const hull_work* work, int corners[4]) {
    plii_dvec3 axis = {0, 0, 0}, normal = {0, 0, 0};
    pli_vec3 origin = work->points[0];
    for (int found = 0; found < 4; ++found) {
        double most = found == 3 ? work->flatness * plii_dvec3_length(normal) : 0.0;
        corners[found] = -1;
        for (int i = 0; i < work->point_count; ++i) {
            if (hull_must_wait(work, i)) { continue; }
            const plii_dvec3 arm = hull_sub(work->points[i], origin), across = plii_dvec3_cross(axis, arm);
            const double measure = found < 2    ? plii_dvec3_dot(arm, arm)
                                   : found == 2 ? plii_dvec3_dot(across, across)
                                                : fabs(plii_dvec3_dot(normal, arm));
            if (measure > most) {
                most = measure;
                corners[found] = i;
            }
        }
        if (corners[found] < 0) { return false; }
        const pli_vec3 corner = work->points[corners[found]];
        if (found == 0) { origin = corner; }
        if (found == 1) { axis = hull_sub(corner, origin); }
        if (found == 2) { normal = plii_dvec3_cross(axis, hull_sub(corner, origin)); }
    }
    const int side =
        plii_orient3d(origin, work->points[corners[1]], work->points[corners[2]], work->points[corners[3]]);
    if (side > 0) { PLII_SWAP(int, corners[1], corners[2]); } /* the base is to be seen from outside */
    return side != 0;
}

static void hull_start(hull_work* work, const int corners[4]) {
    static const int sides[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    static const int neighbours[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
    static const int all[4] = {0, 1, 2, 3};
    for (int i = 0; i < 4; ++i) {
        const int face = hull_add_face(work, corners[sides[i][0]], corners[sides[i][1]], corners[sides[i][2]]);
        memcpy(work->faces[face].neighbours, neighbours[i], sizeof neighbours[i]);
    }
    for (int i = 0; i < work->point_count; ++i) {
        hull_assign(work, i, all, 4);
    }
}

static bool hull_empty_queue(hull_work* work) {
    while (work->queue_count > 0 && hull_reserve(work)) {
        const int face = work->queue[--work->queue_count];
        const int point = work->faces[face].outside >= 0 ? hull_find_farthest(work, face) : -1;
        if (point >= 0) { hull_insert(work, point, face); }
    }
    return work->queue_count == 0;
}

/* PLI_ERROR_INVALID_MESH when the points that need not wait are flat. */
static pli_status hull_build(hull_work* work) {
    int corners[4];
    work->free_face = -1;
    work->face_count = work->queue_count = 0;
    work->is_late = false;
    if (!hull_find_start(work, corners)) { return PLI_ERROR_INVALID_MESH; }
    if (!hull_reserve(work)) { return PLI_ERROR_OUT_OF_MEMORY; }
    hull_start(work, corners);
    for (int pass = 0; pass < 2; ++pass) {
        work->is_late = pass > 0;
        for (int i = 0; i < work->face_count; ++i) {
            hull_enqueue(work, i);
        }
        if (!hull_empty_queue(work)) { return PLI_ERROR_OUT_OF_MEMORY; }
    }
    return PLI_OK;
}

// ----------------------------------------------------------------------------------------------------------- result

/* Whether a corner of the surface lies within the tolerance of the triangles between its neighbours. Such corners were
   inserted before what makes them superfluous, or stand out by a rounding error. */
static bool hull_is_superfluous(hull_work* work, int corner, int start) {
    enum { ALL_FANS = 16 };
    int* ring = work->visible; /* has room for as many as there are faces */
    int count = 0, face = start;
    do { /* from face to face around the corner */
        const hull_face* present = &work->faces[face];
        int k = 0;
        while (present->corners[k] != corner) {
            ++k;
        }
        ring[count++] = present->corners[(k + 1) % 3];
        face = present->neighbours[k];
    } while (face != start);
    const double limit = work->tolerance * work->tolerance;
    for (int first = 0; first < (count <= ALL_FANS ? count : 1); ++first) {
        for (int i = 1; i + 1 < count; ++i) {
            const int triangle[3] = {ring[first], ring[(first + i) % count], ring[(first + i + 1) % count]};
            if (hull_triangle_distance(work, corner, triangle) <= limit) { return true; }
        }
    }
    return false;
}

/* Lets all points wait but the corners that are needed; false when all corners are. */
static bool hull_mark_late(hull_work* work) {
    bool has_late_corner = false;
    memset(work->late, true, (size_t)work->point_count * sizeof *work->late);
    for (int i = 0; i < work->face_count; ++i) {
        for (int k = 0; work->faces[i].is_alive && k < 3; ++k) {
            work->face_from[work->faces[i].corners[k]] = i;
        }
    }
    for (int i = 0; i < work->face_count; ++i) {
        for (int k = 0; work->faces[i].is_alive && k < 3; ++k) {
            const int corner = work->faces[i].corners[k];
            if (work->face_from[corner] != i) { continue; } /* once per corner */
            work->late[corner] = hull_is_superfluous(work, corner, i);
            has_late_corner = has_late_corner || work->late[corner];
        }
    }
    return has_late_corner;
}

static pli_status hull_write(const hull_work* work, plii_convex_hull* hull) {
    int count = 0;
    for (int i = 0; i < work->face_count; ++i) {
        count += work->faces[i].is_alive;
    }
    if (!PLII_ALLOCATE(work->context, &hull->triangles, count)) { return PLI_ERROR_OUT_OF_MEMORY; }
    hull->triangle_count = 0;
    for (PLII_EACH(const hull_face, face, work->faces, work->face_count)) {
        if (face->is_alive) { memcpy(hull->triangles[hull->triangle_count++], face->corners, sizeof face->corners); }
    }
    return PLI_OK;
}

/* Twice, then with the needed corners first, so that the others only return where they are really missing. */
static pli_status hull_run(hull_work* work, plii_convex_hull* hull) {
    plii_scratch scratch = {.context = work->context};
    work->late = PLII_TAKE(&scratch, bool, work->point_count);
    work->next_outside = PLII_TAKE(&scratch, int, work->point_count);
    work->face_from = PLII_TAKE(&scratch, int, work->point_count);
    pli_status status = scratch.is_short ? PLI_ERROR_OUT_OF_MEMORY : hull_build(work);
    if (status == PLI_OK && hull_mark_late(work)) {
        status = hull_build(work);
        if (status == PLI_ERROR_INVALID_MESH) { /* too few are needed: all stay */
            memset(work->late, 0, (size_t)work->point_count * sizeof *work->late);
            status = hull_build(work);
        }
    }
    if (status == PLI_OK) { status = hull_write(work, hull); }
    plii_scratch_free(&scratch);
    PLII_RELEASE(work->context, work->faces, work->face_capacity);
    PLII_RELEASE(work->context, work->queue, work->queue_capacity);
    PLII_RELEASE(work->context, work->visible, work->visible_capacity);
    PLII_RELEASE(work->context, work->rim, work->rim_capacity);
    return status;
}

/* A few roundings of the largest coordinate. */
static double hull_rounding(int point_count, const pli_vec3* points) {
    float largest = 0.0f;
    for (int i = 0; i < point_count; ++i) {
        largest = plii_max(largest, plii_max(fabsf(points[i].x), plii_max(fabsf(points[i].y), fabsf(points[i].z))));
    }
    return 4.0 * (double)FLT_EPSILON * (double)largest;
}

pli_status plii_convex_hull_create(pli_context* context, int point_count, const pli_vec3* points, float tolerance,
                                   const char* function, plii_convex_hull* hull) {
    PLII_TRY(plii_check_int(context, point_count, 4, INT_MAX / 8, "the number of points of a hull", function));
    const double rounding = hull_rounding(point_count, points);
    hull_work work = {.context = context, .point_count = point_count, .points = points, .flatness = rounding};
    work.tolerance = (double)tolerance > rounding ? (double)tolerance : rounding;
    const pli_status status = hull_run(&work, hull);
    PLII_FAIL_IF(status == PLI_ERROR_INVALID_MESH, context, status, function, "the %d points lie in a plane",
                 point_count);
    PLII_FAIL_IF(status != PLI_OK, context, status, function, "no memory for the hull of %d points", point_count);
    return PLI_OK;
}

int plii_convex_hull_corners(const plii_convex_hull* hull, int point_count, int* corners) {
    int count = 0;
    for (int i = 0; i < point_count; ++i) {
        corners[i] = PLI_NULL_INDEX;
    }
    for (int i = 0; i < hull->triangle_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            corners[hull->triangles[i][k]] = 0;
        }
    }
    for (int i = 0; i < point_count; ++i) {
        if (corners[i] != PLI_NULL_INDEX) { corners[i] = count++; }
    }
    return count;
}

void plii_convex_hull_destroy(pli_context* context, plii_convex_hull* hull) {
    PLII_RELEASE(context, hull->triangles, hull->triangle_count);
    *hull = (plii_convex_hull){0};
}
