/* Quickhull: Barber, Dobkin, Huhdanpaa, "The quickhull algorithm for convex hulls", 1996. All decisions about what is
   in front of a face are exact, so that the surface is closed and convex at every moment, whatever the points; only
   the choice of the next point and the tolerance are rounded. */

#include "geometry/convex_hull.h"

#include "geometry/orient3d.h"
#include "math/dvec3.h"
#include "math/vec.h"

#include <limits.h>

typedef struct hull_face {
    int corners[3];
    int neighbours[3]; /* face across the edge from corner i to corner i + 1 */
    int outside;       /* first of the points in front of this face, or -1; each waits at one face only */
    int next_free;     /* in the list of free slots */
    int visited_by;    /* last point that was inserted when the face was looked at */
    bool is_alive, is_visible, is_queued;
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
    double tolerance; /* m, what may be left out */
    double flatness;  /* m, thinner than this is flat */
    const bool* late; /* [point_count] or NULL: points that are tried after all others only */
    bool is_late;     /* the time for them has come */
    hull_face* faces;
    int face_count, face_capacity, free_face;
    int* next_outside; /* [point_count] */
    int* face_from;    /* [point_count] new face whose rim edge starts at the point */
    int* queue;        /* faces with points in front */
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

/* Squared distance of q (relative to a corner at the origin) from the segment to `edge`. */
static double hull_segment_distance(plii_dvec3 q, plii_dvec3 edge) {
    const double along = plii_dvec3_dot(q, edge), length = plii_dvec3_dot(edge, edge);
    const double t = length > 0.0 && along > 0.0 ? (along < length ? along / length : 1.0) : 0.0;
    const plii_dvec3 offset = plii_dvec3_add_scaled(q, edge, -t);
    return plii_dvec3_dot(offset, offset);
}

/* Squared distance of p from the triangle of three points. */
static double hull_triangle_distance(const hull_work* work, int point, const int corners[3]) {
    const pli_vec3 p = work->points[point], a = work->points[corners[0]];
    const plii_dvec3 normal =
        plii_dvec3_cross(hull_sub(work->points[corners[1]], a), hull_sub(work->points[corners[2]], a));
    double nearest = HUGE_VAL;
    bool is_above = true;
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 from = work->points[corners[i]];
        const plii_dvec3 edge = hull_sub(work->points[corners[(i + 1) % 3]], from), q = hull_sub(p, from);
        is_above = is_above && plii_dvec3_dot(plii_dvec3_cross(normal, edge), q) >= 0.0;
        nearest = fmin(nearest, hull_segment_distance(q, edge));
    }
    const double area = plii_dvec3_dot(normal, normal);
    if (is_above && area > 0.0) {
        const double height = plii_dvec3_dot(normal, hull_sub(p, a));
        return height * height / area;
    }
    return nearest;
}

/* Whether some triangle is within the tolerance, walking over the surface towards the point. Never says yes wrongly. */
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

static int hull_add_face(hull_work* work, int a, int b, int c) {
    int face = work->free_face;
    if (face >= 0) {
        work->free_face = work->faces[face].next_free;
    } else {
        if (work->face_count == INT_MAX ||
            !PLII_RESERVE(work->context, &work->faces, &work->face_capacity, work->face_count + 1)) {
            return -1;
        }
        face = work->face_count++;
    }
    work->faces[face] = (hull_face){.corners = {a, b, c}, .outside = -1, .visited_by = -1, .is_alive = true};
    return face;
}

static bool hull_enqueue(hull_work* work, int face) {
    if (work->faces[face].is_queued || work->faces[face].outside < 0) { return true; }
    if (work->queue_count == INT_MAX ||
        !PLII_RESERVE(work->context, &work->queue, &work->queue_capacity, work->queue_count + 1)) {
        return false;
    }
    work->queue[work->queue_count++] = face;
    work->faces[face].is_queued = true;
    return true;
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
    return work->late != NULL && work->late[point] && !work->is_late;
}

/* Takes the farthest point in front of a face out of its list, or returns -1 when there is none whose turn it is and
   that is beyond the tolerance. */
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
    for (int* link = &face->outside; *link >= 0; link = &work->next_outside[*link]) {
        if (*link == best) {
            *link = work->next_outside[best];
            break;
        }
    }
    return best;
}

/* Collects the faces that a point sees, starting from one of them, and the rim around them. */
static bool hull_look(hull_work* work, int point, int start) {
    work->visible_count = 0;
    work->rim_count = 0;
    if (!PLII_RESERVE(work->context, &work->visible, &work->visible_capacity, work->face_count) ||
        !PLII_RESERVE(work->context, &work->rim, &work->rim_capacity, work->face_count)) {
        return false;
    }
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
    return true;
}

/* Replaces what the point sees by the cone from the rim to the point. */
static bool hull_insert(hull_work* work, int point, int start) {
    if (!hull_look(work, point, start)) { return false; }
    const int rim_count = work->rim_count;
    if (!PLII_RESERVE(work->context, &work->visible, &work->visible_capacity, work->visible_count + rim_count)) {
        return false;
    }
    int* cone = work->visible + work->visible_count;
    for (int i = 0; i < rim_count; ++i) {
        const hull_rim* rim = &work->rim[i];
        cone[i] = hull_add_face(work, rim->from, rim->to, point);
        if (cone[i] < 0) { return false; }
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
        if (!face->is_queued) { /* else when it leaves the queue, which names it still */
            face->next_free = work->free_face;
            work->free_face = work->visible[i];
        }
    }
    for (int i = 0; i < rim_count; ++i) {
        if (!hull_enqueue(work, cone[i])) { return false; }
    }
    return true;
}

static float hull_coordinate(const hull_work* work, int point, int axis) {
    const pli_vec3 p = work->points[point];
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/* Four points that span a volume: two far apart, one far from their line, one far from the plane of the three. */
static bool hull_find_start(const hull_work* work, int corners[4]) {
    int low[3] = {-1, -1, -1}, high[3] = {-1, -1, -1};
    for (int i = 0; i < work->point_count; ++i) {
        if (hull_must_wait(work, i)) { continue; }
        const float p[3] = {work->points[i].x, work->points[i].y, work->points[i].z};
        for (int axis = 0; axis < 3; ++axis) {
            if (low[axis] < 0 || p[axis] < hull_coordinate(work, low[axis], axis)) { low[axis] = i; }
            if (high[axis] < 0 || p[axis] > hull_coordinate(work, high[axis], axis)) { high[axis] = i; }
        }
    }
    double farthest = 0.0;
    for (int axis = 0; axis < 3 && low[axis] >= 0; ++axis) {
        const plii_dvec3 span = hull_sub(work->points[high[axis]], work->points[low[axis]]);
        if (plii_dvec3_dot(span, span) > farthest) {
            farthest = plii_dvec3_dot(span, span);
            corners[0] = low[axis];
            corners[1] = high[axis];
        }
    }
    if (!(farthest > 0.0)) { return false; }
    const pli_vec3 origin = work->points[corners[0]];
    const plii_dvec3 axis = hull_sub(work->points[corners[1]], origin);
    plii_dvec3 normal = {0, 0, 0};
    corners[2] = corners[3] = -1;
    for (int i = 0; i < work->point_count; ++i) {
        const plii_dvec3 candidate = plii_dvec3_cross(axis, hull_sub(work->points[i], origin));
        if (!hull_must_wait(work, i) && plii_dvec3_dot(candidate, candidate) > plii_dvec3_dot(normal, normal)) {
            normal = candidate;
            corners[2] = i;
        }
    }
    double highest = work->flatness * plii_dvec3_length(normal);
    for (int i = 0; i < work->point_count; ++i) {
        const double height = plii_dvec3_dot(normal, hull_sub(work->points[i], origin));
        if (!hull_must_wait(work, i) && fabs(height) > highest) {
            highest = fabs(height);
            corners[3] = i;
        }
    }
    if (corners[2] < 0 || corners[3] < 0) { return false; }
    const int side =
        plii_orient3d(origin, work->points[corners[1]], work->points[corners[2]], work->points[corners[3]]);
    if (side > 0) { /* the base is to be seen from outside */
        const int swapped = corners[1];
        corners[1] = corners[2];
        corners[2] = swapped;
    }
    return side != 0;
}

static bool hull_start(hull_work* work, const int corners[4]) {
    static const int sides[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    static const int neighbours[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
    static const int all[4] = {0, 1, 2, 3};
    for (int i = 0; i < 4; ++i) {
        const int face = hull_add_face(work, corners[sides[i][0]], corners[sides[i][1]], corners[sides[i][2]]);
        if (face < 0) { return false; }
        for (int k = 0; k < 3; ++k) {
            work->faces[face].neighbours[k] = neighbours[i][k];
        }
    }
    for (int i = 0; i < work->point_count; ++i) {
        hull_assign(work, i, all, 4);
    }
    for (int i = 0; i < 4; ++i) {
        if (!hull_enqueue(work, i)) { return false; }
    }
    return true;
}

static bool hull_empty_queue(hull_work* work) {
    while (work->queue_count > 0) {
        const int face = work->queue[--work->queue_count];
        work->faces[face].is_queued = false;
        if (!work->faces[face].is_alive) {
            work->faces[face].next_free = work->free_face;
            work->free_face = face;
            continue;
        }
        const int point = hull_find_farthest(work, face);
        if (point >= 0 && !hull_insert(work, point, face)) { return false; }
    }
    return true;
}

static bool hull_run(hull_work* work) {
    if (!hull_empty_queue(work)) { return false; }
    if (work->late == NULL) { return true; }
    work->is_late = true;
    for (int i = 0; i < work->face_count; ++i) {
        if (work->faces[i].is_alive && !hull_enqueue(work, i)) { return false; }
    }
    return hull_empty_queue(work);
}

// ----------------------------------------------------------------------------------------------------------- result

static void hull_work_destroy(hull_work* work) {
    PLII_RELEASE(work->context, work->faces, work->face_capacity);
    PLII_RELEASE(work->context, work->next_outside, work->point_count);
    PLII_RELEASE(work->context, work->face_from, work->point_count);
    PLII_RELEASE(work->context, work->queue, work->queue_capacity);
    PLII_RELEASE(work->context, work->visible, work->visible_capacity);
    PLII_RELEASE(work->context, work->rim, work->rim_capacity);
}

/* PLI_ERROR_INVALID_MESH when the points are flat. The work is to be destroyed in any case. */
static pli_status hull_build(hull_work* work) {
    work->free_face = -1;
    if (!PLII_ALLOCATE(work->context, &work->next_outside, work->point_count) ||
        !PLII_ALLOCATE(work->context, &work->face_from, work->point_count)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    int corners[4];
    if (!hull_find_start(work, corners)) { return PLI_ERROR_INVALID_MESH; }
    return hull_start(work, corners) && hull_run(work) ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

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

/* Marks all points but the corners that are needed; false when all corners are. */
static bool hull_mark_late(hull_work* work, bool* late) {
    bool has_late_corner = false;
    for (int i = 0; i < work->point_count; ++i) {
        late[i] = true;
    }
    for (int i = 0; i < work->face_count; ++i) {
        for (int k = 0; work->faces[i].is_alive && k < 3; ++k) {
            work->face_from[work->faces[i].corners[k]] = i;
        }
    }
    for (int i = 0; i < work->face_count; ++i) {
        for (int k = 0; work->faces[i].is_alive && k < 3; ++k) {
            const int corner = work->faces[i].corners[k];
            if (work->face_from[corner] != i) { continue; } /* once per corner */
            late[corner] = hull_is_superfluous(work, corner, i);
            has_late_corner = has_late_corner || late[corner];
        }
    }
    return has_late_corner;
}

static bool hull_write(const hull_work* work, plii_convex_hull* hull) {
    int count = 0;
    for (int i = 0; i < work->face_count; ++i) {
        count += work->faces[i].is_alive;
    }
    int(*triangles)[3] = plii_allocate(work->context, (size_t)count * sizeof *triangles);
    if (triangles == NULL) { return false; }
    hull->triangle_count = 0;
    hull->triangles = triangles;
    for (int i = 0; i < work->face_count; ++i) {
        if (!work->faces[i].is_alive) { continue; }
        for (int k = 0; k < 3; ++k) {
            triangles[hull->triangle_count][k] = work->faces[i].corners[k];
        }
        ++hull->triangle_count;
    }
    return true;
}

/* Once more with the needed corners first, so that the others only return where they are really missing. */
static pli_status hull_refine(hull_work* full, plii_convex_hull* hull) {
    const size_t late_size = (size_t)full->point_count * sizeof(bool);
    if (!PLII_RESERVE(full->context, &full->visible, &full->visible_capacity, full->face_count)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    bool* late = plii_allocate(full->context, late_size);
    if (late == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    const hull_work* result = full;
    hull_work work = {.context = full->context,
                      .point_count = full->point_count,
                      .points = full->points,
                      .tolerance = full->tolerance,
                      .flatness = full->flatness,
                      .late = late};
    pli_status status = PLI_OK;
    if (hull_mark_late(full, late)) {
        status = hull_build(&work);
        if (status == PLI_OK) { result = &work; }
        if (status == PLI_ERROR_INVALID_MESH) { status = PLI_OK; } /* too few are needed: all stay */
    }
    if (status == PLI_OK && !hull_write(result, hull)) { status = PLI_ERROR_OUT_OF_MEMORY; }
    hull_work_destroy(&work);
    plii_release(full->context, late, late_size);
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
    if (point_count < 4) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%d points, a hull needs 4 or more", point_count);
    }
    if (point_count > INT_MAX / 8) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%d points are too many for a hull", point_count);
    }
    const double rounding = hull_rounding(point_count, points);
    hull_work work = {.context = context, .point_count = point_count, .points = points, .flatness = rounding};
    work.tolerance = (double)tolerance > rounding ? (double)tolerance : rounding;
    pli_status status = hull_build(&work);
    if (status == PLI_OK) { status = hull_refine(&work, hull); }
    hull_work_destroy(&work);
    if (status == PLI_ERROR_INVALID_MESH) {
        return plii_fail(context, status, function, "the %d points lie in a plane", point_count);
    }
    if (status != PLI_OK) {
        return plii_fail(context, status, function, "no memory for the hull of %d points", point_count);
    }
    return PLI_OK;
}

void plii_convex_hull_destroy(pli_context* context, plii_convex_hull* hull) {
    PLII_RELEASE(context, hull->triangles, hull->triangle_count);
    *hull = (plii_convex_hull){0};
}
