#ifndef TESTS_UNIT_TEST_CLUSTER_WORLD_H
#define TESTS_UNIT_TEST_CLUSTER_WORLD_H

/* A world, soft bodies with clusters and rigid bodies, and sums over them; for the tests of clusters, joints and
   cluster contacts. */

#include "failing_allocator.h"
#include "sample_mesh.h"
#include "test_world.h"

#include <string.h>

/* Takes the mesh. */
static inline pli_body* make_body(pli_mesh* mesh, float margin) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = 2;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static inline pli_body* make_ball(pli_vec3 radii, pli_vec3 centre, float margin) {
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_ellipsoid(context, radii, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_translate(mesh, centre), PLI_OK);
    return make_body(mesh, margin);
}

/* Nodes of 1 kg without links. */
static inline pli_body* make_points(const pli_vec3* points, int count, float margin) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i < count; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, points[i], 1.0f, NULL), PLI_OK);
    }
    return make_body(mesh, margin);
}

/* Keeps the shape of all clusters. */
static inline void match_clusters(pli_body* body, float matching) {
    for (int i = 0; i < pli_body_cluster_count(body); ++i) {
        pli_cluster_settings settings;
        assert_int_equal(pli_body_get_cluster_settings(body, i, &settings), PLI_OK);
        settings.matching = matching;
        assert_int_equal(pli_body_set_cluster_settings(body, i, &settings), PLI_OK);
    }
}

static inline pli_cluster_view cluster_of(const pli_body* body, int cluster) {
    pli_cluster_view view;
    assert_int_equal(pli_body_get_cluster(body, cluster, &view), PLI_OK);
    return view;
}

/* Takes the shape, which may be NULL. */
static inline pli_rigid* make_rigid(pli_rigid_kind kind, float mass, float inertia, pli_vec3 origin, pli_shape* shape) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.state.pose = pli_transform_make(pli_quat_identity(), origin);
    def.state.inverse_mass = 1.0f / mass;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], 1.0f / inertia);
    }
    def.shape_count = shape != NULL ? 1 : 0;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    pli_shape_release(shape);
    return rigid;
}

static inline pli_shape* make_box_shape(pli_vec3 half_extents) {
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_box(context, half_extents, &shape), PLI_OK);
    return shape;
}

static inline pli_vec3 position_of(const pli_body* body, int node) {
    const pli_vec4 p = pli_body_get_view(body).positions[node];
    return pli_vec3_make(p.x, p.y, p.z);
}

static inline bool is_finite_body(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        if (!isfinite(view.positions[i].x + view.positions[i].y + view.positions[i].z)) { return false; }
        if (!isfinite(view.velocities[i].x + view.velocities[i].y + view.velocities[i].z)) { return false; }
    }
    return !pli_body_is_frozen(body);
}

/* Linear momentum, and angular momentum about the origin. */
typedef struct momenta {
    double linear[3], angular[3];
} momenta;

static inline void momenta_add(momenta* sum, pli_vec3 x, pli_vec3 momentum) {
    const double p[3] = {(double)momentum.x, (double)momentum.y, (double)momentum.z};
    const double r[3] = {(double)x.x, (double)x.y, (double)x.z};
    for (int i = 0; i < 3; ++i) {
        const int k = (i + 1) % 3, l = (i + 2) % 3;
        sum->linear[i] += p[i];
        sum->angular[i] += r[k] * p[l] - r[l] * p[k];
    }
}

static inline void momenta_add_body(momenta* sum, const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i], v = view.velocities[i];
        if (!(x.w > 0.0f)) { continue; }
        momenta_add(sum, pli_vec3_make(x.x, x.y, x.z), pli_vec3_scale(pli_vec3_make(v.x, v.y, v.z), 1.0f / x.w));
    }
}

/* A rigid body of make_rigid. */
static inline void momenta_add_rigid(momenta* sum, const pli_rigid* rigid) {
    const pli_rigid_state state = pli_rigid_get_state(rigid);
    momenta_add(sum, state.pose.origin, pli_vec3_scale(state.linear_velocity, 1.0f / state.inverse_mass));
    const float inertia = 1.0f / state.inverse_inertia_world.rows[0].x;
    sum->angular[0] += (double)(inertia * state.angular_velocity.x);
    sum->angular[1] += (double)(inertia * state.angular_velocity.y);
    sum->angular[2] += (double)(inertia * state.angular_velocity.z);
}

static inline double largest_difference(const double* a, const double* b) {
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        largest = fmax(largest, fabs(a[i] - b[i]));
    }
    return largest;
}

#endif
