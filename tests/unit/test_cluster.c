/* Clusters: generation, frames, matching, degenerate clusters, pinned nodes, changes of topology, what they cost, bad
   input. */

#include "test_cluster_world.h"

#include <stdlib.h>

static const float dt = 1.0f / 60.0f;

static void check_error(pli_status status, pli_status expected, const char* part) {
    assert_int_equal(status, expected);
    if (strstr(pli_last_error(context), part) == NULL) {
        fail_msg("the message \"%s\" does not say \"%s\"", pli_last_error(context), part);
    }
}

static double determinant(pli_mat3 m) {
    return (double)pli_vec3_dot(m.rows[0], pli_vec3_cross(m.rows[1], m.rows[2]));
}

static void generate(pli_body* body, int count) {
    assert_int_equal(pli_body_generate_clusters(body, count, 8192, NULL), PLI_OK);
}

// -------------------------------------------------------------------------------------------------------- generation

static void test_every_node_is_in_a_cluster(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 2, 1), pli_vec3_make(0, 0, 0), 0.1f);
    int made = 0;
    assert_int_equal(pli_body_generate_clusters(body, 8, 8192, &made), PLI_OK);
    assert_int_equal(made, 9);
    int count_of[SAMPLE_SPHERE_NODES] = {0};
    int most = 0;
    for (int i = 1; i < made; ++i) {
        const pli_cluster_view view = cluster_of(body, i);
        for (int k = 0; k < view.node_count; ++k) {
            count_of[view.nodes[k * view.node_stride]] += 1;
        }
    }
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        assert_true(count_of[i] >= 1);
        if (count_of[i] > most) { most = count_of[i]; }
    }
    /* Neighbours share a ring of nodes. */
    assert_true(most >= 2);
    const pli_cluster_view whole = cluster_of(body, 0);
    assert_int_equal(whole.node_count, SAMPLE_SPHERE_NODES);
    check_near(1.0f / whole.inverse_mass, SAMPLE_SPHERE_NODES, 1e-3);
    pli_cluster_settings settings;
    assert_int_equal(pli_body_get_cluster_settings(body, 0, &settings), PLI_OK);
    assert_false(settings.collides);
}

/* The same groups, however small the body is. */
static void test_size_does_not_matter(void** unused) {
    (void)unused;
    const float scales[] = {0.25f, 0.25f / 256};
    pli_body* bodies[2];
    for (int k = 0; k < 2; ++k) {
        const float a = scales[k];
        pli_patch_def sheet = pli_patch_def_default();
        sheet.corner_00 = pli_vec3_make(-a, 0, -a);
        sheet.corner_10 = pli_vec3_make(a, 0, -a);
        sheet.corner_01 = pli_vec3_make(-a, 0, a);
        sheet.corner_11 = pli_vec3_make(a, 0, a);
        sheet.columns = 31;
        sheet.rows = 23;
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create_patch(context, &sheet, &mesh), PLI_OK);
        bodies[k] = make_body(mesh, 0.05f * a);
        generate(bodies[k], 8);
        assert_int_equal(pli_body_cluster_count(bodies[k]), 9);
    }
    for (int i = 0; i < 9; ++i) {
        const pli_cluster_view large = cluster_of(bodies[0], i), small = cluster_of(bodies[1], i);
        assert_int_equal(small.node_count, large.node_count);
        for (int k = 0; k < large.node_count; ++k) {
            assert_int_equal(small.nodes[k * small.node_stride], large.nodes[k * large.node_stride]);
        }
    }
}

/* A snapshot does not fit other clusters, of as many groups as before. */
static void test_snapshots_know_their_clusters(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    generate(body, 5);
    size_t size = pli_world_snapshot_size(world);
    unsigned char* snapshot = malloc(size);
    assert_non_null(snapshot);
    assert_int_equal(pli_world_save(world, snapshot, size, &size), PLI_OK);
    assert_int_equal(pli_world_restore(world, snapshot, size), PLI_OK);
    generate(body, 5);
    check_error(pli_world_restore(world, snapshot, size), PLI_ERROR_INVALID_VALUE, "clusters have come or gone");
    free(snapshot);
}

static void test_clusters_are_replaced_and_removed(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    const size_t bytes = pli_body_bytes(body);
    assert_int_equal(pli_body_cluster_count(body), 0);
    generate(body, 5);
    assert_int_equal(pli_body_cluster_count(body), 6);
    generate(body, 1);
    assert_int_equal(pli_body_cluster_count(body), 1);
    int made = 0;
    assert_int_equal(pli_body_generate_clusters_from_elements(body, &made), PLI_OK);
    assert_int_equal(made, pli_body_get_view(body).face_count);
    const int nodes[] = {3, 5, 8};
    int cluster = 0;
    assert_int_equal(pli_body_add_cluster(body, nodes, 3, &cluster), PLI_OK);
    assert_int_equal(cluster, made);
    const pli_cluster_view view = cluster_of(body, cluster);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(view.nodes[i * view.node_stride], nodes[i]);
    }
    assert_int_equal(pli_body_remove_clusters(body), PLI_OK);
    assert_int_equal(pli_body_cluster_count(body), 0);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    generate(body, 3);
    assert_int_equal(pli_body_disable_clusters(body), PLI_OK);
    assert_int_equal(pli_body_cluster_count(body), 0);
    check_at_most(pli_body_bytes(body), bytes + 4096);
}

/* Changed settings leave the clusters and their rest shape alone. */
static void test_enabling_again_keeps_clusters(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    generate(body, 1);
    pli_vec3 positions[SAMPLE_SPHERE_NODES];
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        positions[i] = pli_vec3_mul(position_of(body, i), pli_vec3_make(1.5f, 1, 1));
    }
    assert_int_equal(pli_body_set_state(body, positions, NULL), PLI_OK);
    match_clusters(body, 1);
    pli_clusters_def def = pli_clusters_def_default();
    def.iterations = 9;
    assert_int_equal(pli_body_enable_clusters(body, &def), PLI_OK);
    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    check_near(position_of(body, 0).y, 1, 1e-6);
    const int side = sample_sphere_node(3, 0);
    check_near(position_of(body, side).x, positions[side].x / 1.5f, 1e-5);
    assert_int_equal(pli_world_solve(world), PLI_OK);
}

// ------------------------------------------------------------------------------------------------ frames and matching

static void test_frame_follows_a_rigid_motion(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 2, 1.5f), pli_vec3_make(3, 1, 0), 0.1f);
    generate(body, 1);
    const pli_transform motion =
        pli_transform_make(pli_quat_from_yaw_pitch_roll(2.5f, 0.7f, -1.9f), pli_vec3_make(1, 2, 3));
    assert_int_equal(pli_body_transform(body, motion), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const pli_cluster_view view = cluster_of(body, 0);
    const pli_vec3 centre = pli_transform_point(motion, pli_vec3_make(3, 1, 0));
    check_at_most(pli_vec3_length(pli_vec3_sub(view.frame.origin, centre)), 2e-6);
    for (int i = 0; i < 3; ++i) {
        check_at_most(pli_vec3_length(pli_vec3_sub(view.frame.rotation.rows[i], motion.rotation.rows[i])), 2e-6);
    }
}

/* The clusters of a body that is turned inside out have rotations, and matching turns it back. */
/* Before the first step, too, when they have just been made or reset. */
static void test_a_frame_is_where_the_nodes_are(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    const pli_transform up = {pli_mat3_identity(), pli_vec3_make(0, 3, 0)};
    generate(body, 1);
    const float first = cluster_of(body, 0).frame.origin.y;
    for (int i = 1; i <= 3; ++i) {
        assert_int_equal(pli_body_transform(body, up), PLI_OK);
        check_near(cluster_of(body, 0).frame.origin.y, first + 3 * (float)i, 1e-5);
        if (i == 1) { assert_int_equal(pli_body_reset_clusters(body), PLI_OK); }
        if (i == 2) { assert_int_equal(pli_body_add_velocity(body, pli_vec3_make(0, 1, 0)), PLI_OK); }
    }
    check_near(cluster_of(body, 0).linear_velocity.y, 1, 1e-5);
}

static void test_inverted_body_recovers(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 2, 1.5f), pli_vec3_make(0, 0, 0), 0.1f);
    generate(body, 1);
    match_clusters(body, 0.2f);
    pli_vec3 positions[SAMPLE_SPHERE_NODES];
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        positions[i] = pli_vec3_mul(position_of(body, i), pli_vec3_make(-1, 1, 1));
    }
    assert_int_equal(pli_body_set_state(body, positions, NULL), PLI_OK);
    const float volume = pli_body_volume(body);
    assert_true(volume < 0.0f);
    for (int i = 0; i < 200; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        const pli_cluster_view view = cluster_of(body, 0);
        check_near(determinant(view.frame.rotation), 1, 1e-5);
    }
    check_near(pli_body_volume(body), -volume, 1e-2 * fabs((double)volume));
}

/* matching = 1 puts the nodes on the rest shape at once. */
static void test_matching_is_the_share_of_the_way(void** unused) {
    (void)unused;
    const float shares[] = {0.0f, 0.25f, 1.0f};
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 points[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
        pli_body* body = make_points(points, 6, 0.1f);
        const int nodes[] = {0, 1, 2, 3, 4, 5};
        assert_int_equal(pli_body_add_cluster(body, nodes, 6, NULL), PLI_OK);
        match_clusters(body, shares[k]);
        assert_int_equal(pli_body_set_node_position(body, 4, pli_vec3_make(0, 0, 1.1f)), PLI_OK);
        assert_int_equal(pli_body_set_node_position(body, 5, pli_vec3_make(0, 0, -1.1f)), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        check_near(position_of(body, 4).z, 1.1f - shares[k] * 0.1f, 1e-6);
        check_near(position_of(body, 5).z, -1.1f + shares[k] * 0.1f, 1e-6);
        pli_body_destroy(body);
    }
}

/* Masses that do not add up exactly, far from the origin: what the centre at rest is off pulls in every step. */
static void test_matching_moves_no_body_at_rest(void** unused) {
    (void)unused;
    const float places[] = {0, 100, 1000};
    for (int k = 0; k < 6; ++k) {
        pli_mesh* mesh = NULL;
        assert_int_equal(sample_create_ellipsoid(context, pli_vec3_make(0.5f, 0.5f, 0.5f), &mesh), PLI_OK);
        assert_int_equal(pli_mesh_translate(mesh, pli_vec3_make(places[k % 3], 0, 0)), PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 0.7f), PLI_OK);
        pli_body* body = make_body(mesh, 0.1f);
        generate(body, 1);
        match_clusters(body, 0.5f);
        if (k >= 3) { assert_int_equal(pli_body_set_node_mass(body, 0, 0.1f), PLI_OK); }
        for (int step = 0; step < 600; ++step) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        const float speed = pli_vec3_length(pli_body_momentum(body)) / pli_body_total_mass(body);
        print_message("%g m from the origin: %.1e m/s after 10 s\n", (double)places[k % 3], (double)speed);
        assert_true(speed < 1e-4f); /* 2.2 m/s a kilometre away with a centre reckoned from the origin */
        pli_body_destroy(body);
    }
}

/* All nodes take the velocity of the whole, where theirs is larger. */
static void test_node_damping_takes_out_deformation(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    generate(body, 1);
    pli_cluster_settings settings;
    assert_int_equal(pli_body_get_cluster_settings(body, 0, &settings), PLI_OK);
    settings.node_damping = 1;
    assert_int_equal(pli_body_set_cluster_settings(body, 0, &settings), PLI_OK);
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        const float outward = i % 2 == 0 ? 1.0f : -1.0f;
        assert_int_equal(pli_body_set_node_velocity(body, i, pli_vec3_scale(position_of(body, i), outward)), PLI_OK);
    }
    const float before = pli_body_kinetic_energy(body);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    check_at_most(pli_body_kinetic_energy(body), 1e-2 * (double)before);
}

static void test_linear_damping_is_seen_by_the_cluster(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    generate(body, 1);
    pli_cluster_settings settings;
    assert_int_equal(pli_body_get_cluster_settings(body, 0, &settings), PLI_OK);
    settings.linear_damping = 0.25f;
    settings.angular_damping = 0.5f;
    assert_int_equal(pli_body_set_cluster_settings(body, 0, &settings), PLI_OK);
    for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
        const pli_vec3 spin = pli_vec3_cross(pli_vec3_make(0, 2, 0), position_of(body, i));
        assert_int_equal(pli_body_set_node_velocity(body, i, pli_vec3_add(spin, pli_vec3_make(4, 0, 0))), PLI_OK);
    }
    assert_int_equal(pli_world_predict(world, 1e-4f), PLI_OK);
    const pli_cluster_view view = cluster_of(body, 0);
    check_near(view.linear_velocity.x, 3, 1e-4);
    check_near(view.angular_velocity.y, 1, 1e-4);
    assert_int_equal(pli_world_solve(world), PLI_OK);
}

// ------------------------------------------------------------------------------------------------ degenerate clusters

static void check_degenerate(const pli_vec3* points, int count, const char* what) {
    pli_body* body = make_points(points, count, 0.1f);
    int nodes[8];
    for (int i = 0; i < count; ++i) {
        nodes[i] = i;
    }
    assert_int_equal(pli_body_add_cluster(body, nodes, count, NULL), PLI_OK);
    const pli_cluster_settings settings = {0.3f, 0.2f, 0.1f, 0.1f, true, 100.0f, 1.0f};
    assert_int_equal(pli_body_set_cluster_settings(body, 0, &settings), PLI_OK);
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
    pli_rigid* floor =
        make_rigid(PLI_RIGID_STATIC, 1, 1, pli_vec3_make(0, -1, 0), make_box_shape(pli_vec3_make(9, 1, 9)));
    pli_rigid* weight = make_rigid(PLI_RIGID_DYNAMIC, 2, 1, pli_vec3_make(0.1f, 2.5f, 0),
                                   make_box_shape(pli_vec3_make(0.5f, 0.5f, 0.5f)));
    pli_linear_joint_def joint = pli_linear_joint_def_default();
    joint.other.rigid = weight;
    joint.position = pli_vec3_make(0.5f, 1, 0.2f);
    assert_int_equal(pli_body_add_linear_joint(body, &joint, NULL), PLI_OK);
    pli_angular_joint_def hinge = pli_angular_joint_def_default();
    hinge.axis = pli_vec3_make(1, 2, 0);
    hinge.other.rigid = weight;
    assert_int_equal(pli_body_add_angular_joint(body, &hinge, NULL), PLI_OK);
    const pli_vec3 gravity = pli_vec3_make(0, -10, 0);
    assert_int_equal(pli_world_set_gravity(world, gravity), PLI_OK);
    for (int i = 0; i < 300; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_rigid_integrate(weight, pli_vec3_make(0, 0, 0), dt), PLI_OK);
        if (!is_finite_body(body)) { fail_msg("%s: step %d is not finite", what, i); }
        check_near(determinant(cluster_of(body, 0).frame.rotation), 1, 1e-4);
        const pli_rigid_state state = pli_rigid_get_state(weight);
        assert_true(isfinite(pli_vec3_length(state.linear_velocity) + pli_vec3_length(state.angular_velocity)));
        if (!(pli_vec3_length(position_of(body, 0)) < 50)) { fail_msg("%s: flies off in step %d", what, i); }
    }
    pli_rigid_destroy(weight);
    pli_rigid_destroy(floor);
    pli_body_destroy(body);
}

static void test_degenerate_clusters_stay_finite(void** unused) {
    (void)unused;
    const pli_vec3 points[] = {{0, 1, 0}, {1, 1, 0.5f}, {2, 1, 1}, {3, 1, 1.5f}, {1, 2, 0}};
    check_degenerate(points, 1, "one node");
    check_degenerate(points, 2, "two nodes");
    check_degenerate(points, 4, "a line");
    const pli_vec3 same[] = {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}};
    check_degenerate(same, 3, "coincident nodes");
    const pli_vec3 flat[] = {{0, 1, 0}, {1, 1, 0}, {0, 1, 1}, {1, 1, 1}};
    check_degenerate(flat, 4, "a plane");
    const pli_vec3 tiny[] = {{0, 1, 0}, {1e-6f, 1, 0}, {0, 1.000001f, 0}, {0, 1, 1e-6f}};
    check_degenerate(tiny, 4, "a tiny body");
}

// ------------------------------------------------------------------------------------------------------- pinned nodes

static void test_pinned_nodes_never_move(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(context, 7, 2, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_11, &mesh), PLI_OK);
    pli_body* body = make_body(mesh, 0.1f);
    generate(body, 4);
    match_clusters(body, 0.3f);
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
    pli_rigid* weight = make_rigid(PLI_RIGID_DYNAMIC, 50, 10, pli_vec3_make(0.2f, 3, 0.1f),
                                   make_box_shape(pli_vec3_make(0.5f, 0.5f, 0.5f)));
    for (int i = 1; i < pli_body_cluster_count(body); ++i) {
        pli_linear_joint_def joint = pli_linear_joint_def_default();
        joint.cluster = i;
        joint.other.rigid = weight;
        joint.position = cluster_of(body, i).frame.origin;
        assert_int_equal(pli_body_add_linear_joint(body, &joint, NULL), PLI_OK);
    }
    const pli_vec3 gravity = pli_vec3_make(0, -10, 0);
    assert_int_equal(pli_world_set_gravity(world, gravity), PLI_OK);
    const pli_vec3 first = position_of(body, 0), last = position_of(body, 48);
    for (int i = 0; i < 300; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_rigid_integrate(weight, gravity, dt), PLI_OK);
        assert_true(is_finite_body(body));
        check_near(pli_vec3_length(pli_vec3_sub(position_of(body, 0), first)), 0, 0);
        check_near(pli_vec3_length(pli_vec3_sub(position_of(body, 48), last)), 0, 0);
    }
    /* They hold: the weight hangs. */
    print_message("           the weight hangs at %.2f m\n", (double)pli_rigid_get_state(weight).pose.origin.y);
    assert_true(pli_rigid_get_state(weight).pose.origin.y > -4.0f);
}

// ----------------------------------------------------------------------------------------------- changes of topology

static float below(pli_vec3 x, void* user) {
    (void)user;
    return x.x - 0.1f;
}

/* Refined and cut through: what is on the border joins the clusters, and frames and joints stay where they were. */
static void test_clusters_follow_a_cut(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(context, 9, 0, 0, &mesh), PLI_OK);
    pli_body* body = make_body(mesh, 0.1f);
    generate(body, 4);
    assert_int_equal(pli_body_transform(body, pli_transform_make(pli_quat_from_yaw_pitch_roll(0.4f, 0.3f, 0.2f),
                                                                 pli_vec3_make(0.1f, 0.2f, 0.3f))),
                     PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    pli_linear_joint_def joint = pli_linear_joint_def_default();
    joint.cluster = 1;
    joint.position = pli_vec3_add(cluster_of(body, 1).frame.origin, pli_vec3_make(0.2f, 0.1f, 0));
    joint.softness.split = 0;
    assert_int_equal(pli_body_add_linear_joint(body, &joint, NULL), PLI_OK);
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    contacts.with_self = true;
    assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const int old_count = pli_body_get_view(body).node_count;
    const int count = pli_body_cluster_count(body);
    assert_in_range(count, 3, 5);
    pli_cluster_view before[5];
    for (int i = 0; i < count; ++i) {
        before[i] = cluster_of(body, i);
    }
    pli_refine_def def = pli_refine_def_default();
    def.surface = below;
    def.cut = true;
    assert_int_equal(pli_body_refine(body, &def), PLI_OK);
    const int node_count = pli_body_get_view(body).node_count;
    assert_true(node_count > old_count + 10);
    assert_int_equal(pli_body_cluster_count(body), count);
    int members = 0;
    for (int i = 0; i < count; ++i) {
        const pli_cluster_view view = cluster_of(body, i);
        assert_true(view.node_count >= before[i].node_count);
        double own = 0;
        for (int k = 0; k < view.node_count; ++k) {
            const int node = view.nodes[k * view.node_stride];
            assert_in_range(node, 0, node_count - 1);
            own += 1.0 / (double)pli_body_get_view(body).positions[node].w;
        }
        check_near(1.0 / (double)view.inverse_mass, own, 1e-4);
        if (i > 0) { members += view.node_count - before[i].node_count; }
        /* The rest shape is the same, so the frame still turns with it. */
        for (int r = 0; r < 3; ++r) {
            check_at_most(pli_vec3_length(pli_vec3_sub(view.frame.rotation.rows[r], before[i].frame.rotation.rows[r])),
                          2e-5);
        }
    }
    assert_int_equal(cluster_of(body, 0).node_count, node_count);
    assert_true(members > 0);
    /* A joint with an error would move the body. */
    const pli_vec3 node = position_of(body, 0);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    check_at_most(pli_vec3_length(pli_vec3_sub(position_of(body, 0), node)), 1e-4);
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_true(is_finite_body(body));
}

// ---------------------------------------------------------------------------------------------------- memory, errors

static void test_steady_steps_allocate_nothing(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    generate(body, 8);
    match_clusters(body, 0.1f);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const uint64_t count = pli_context_allocation_count(context);
    for (int i = 0; i < 20; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_int_equal(pli_context_allocation_count(context), count);
}

static pli_status make_clusters(pli_context* c, void* user) {
    (void)user;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    pli_status status = pli_world_create(c, NULL, &w);
    if (status == PLI_OK) { status = sample_create_ellipsoid(c, pli_vec3_make(1, 1, 1), &mesh); }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &body); }
    const int nodes[] = {1, 2, 3};
    if (status == PLI_OK) {
        status = pli_body_generate_clusters(body, 6, 100, NULL);
        assert_int_equal(pli_body_cluster_count(body), status == PLI_OK ? 7 : 0);
    }
    if (status == PLI_OK) {
        status = pli_body_add_cluster(body, nodes, 3, NULL);
        assert_int_equal(pli_body_cluster_count(body), status == PLI_OK ? 8 : 7);
    }
    if (status == PLI_OK) {
        status = pli_body_generate_clusters_from_elements(body, NULL);
        if (status != PLI_OK) { assert_int_equal(pli_body_cluster_count(body), 8); }
    }
    if (status == PLI_OK) { status = pli_world_step(w, dt); }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_out_of_memory_leaves_clusters_as_they_were(void** unused) {
    (void)unused;
    const int failures = check_survives_failing_allocator(make_clusters, NULL);
    print_message("           %d failures\n", failures);
    assert_true(failures > 20);
}

static void test_bad_input(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(1, 1, 1), pli_vec3_make(0, 0, 0), 0.1f);
    const pli_vec3 point = {0, 0, 0};
    pli_body* points = make_points(&point, 1, 0.1f);
    pli_clusters_def def = {0};
    check_error(pli_body_enable_clusters(body, &def), PLI_ERROR_INVALID_DEF, "pli_clusters_def_default");
    def = pli_clusters_def_default();
    def.iterations = 0;
    check_error(pli_body_enable_clusters(body, &def), PLI_ERROR_INVALID_VALUE, "iterations is 0");
    check_error(pli_body_remove_clusters(body), PLI_ERROR_WRONG_STATE, "not enabled");
    check_error(pli_body_reset_clusters(body), PLI_ERROR_WRONG_STATE, "not enabled");
    check_error(pli_body_generate_clusters(body, 0, 10, NULL), PLI_ERROR_INVALID_VALUE, "0 clusters");
    check_error(pli_body_generate_clusters(body, 3, 0, NULL), PLI_ERROR_INVALID_VALUE, "0 iterations");
    check_error(pli_body_generate_clusters_from_elements(points, NULL), PLI_ERROR_INVALID_MESH, "neither");
    assert_int_equal(pli_body_cluster_count(body), 0);

    const int twice[] = {4, 7, 4}, outside[] = {0, 86};
    check_error(pli_body_add_cluster(body, twice, 3, NULL), PLI_ERROR_INVALID_VALUE, "node 4 is named twice");
    check_error(pli_body_add_cluster(body, outside, 2, NULL), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 86");
    check_error(pli_body_add_cluster(body, twice, 0, NULL), PLI_ERROR_INVALID_VALUE, "0 nodes");
    check_error(pli_body_add_cluster(body, twice, 87, NULL), PLI_ERROR_INVALID_VALUE, "87 nodes");
    check_error(pli_body_add_cluster(body, NULL, 3, NULL), PLI_ERROR_NULL_ARGUMENT, "nodes is null");
    assert_int_equal(pli_body_add_cluster(NULL, twice, 1, NULL), PLI_ERROR_NULL_ARGUMENT);

    generate(body, 2);
    pli_cluster_view view;
    pli_cluster_settings settings;
    check_error(pli_body_get_cluster(body, 3, &view), PLI_ERROR_INDEX_OUT_OF_RANGE, "cluster 3 is out of range");
    check_error(pli_body_get_cluster(body, -1, &view), PLI_ERROR_INDEX_OUT_OF_RANGE, "cluster -1 is out of range");
    check_error(pli_body_get_cluster(body, 0, NULL), PLI_ERROR_NULL_ARGUMENT, "view is null");
    check_error(pli_body_get_cluster_settings(body, 0, NULL), PLI_ERROR_NULL_ARGUMENT, "settings is null");
    check_error(pli_body_set_cluster_settings(body, 0, NULL), PLI_ERROR_NULL_ARGUMENT, "settings is null");
    assert_int_equal(pli_body_get_cluster_settings(body, 0, &settings), PLI_OK);
    const pli_cluster_settings good = settings;
    settings.matching = NAN;
    check_error(pli_body_set_cluster_settings(body, 0, &settings), PLI_ERROR_NOT_FINITE, "matching is nan");
    settings = good;
    settings.node_damping = 1.5f;
    check_error(pli_body_set_cluster_settings(body, 0, &settings), PLI_ERROR_INVALID_VALUE, "1.5");
    settings = good;
    settings.max_self_impulse = -1;
    check_error(pli_body_set_cluster_settings(body, 0, &settings), PLI_ERROR_INVALID_VALUE, "max_self_impulse is -1");
    assert_int_equal(pli_body_get_cluster_settings(body, 0, &settings), PLI_OK);
    assert_memory_equal(&settings, &good, sizeof good);

    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    check_error(pli_body_generate_clusters(body, 3, 10, NULL), PLI_ERROR_WRONG_STATE, "between predict and solve");
    check_error(pli_body_generate_clusters_from_elements(body, NULL), PLI_ERROR_WRONG_STATE, "between");
    check_error(pli_body_add_cluster(body, twice, 2, NULL), PLI_ERROR_WRONG_STATE, "between predict and solve");
    check_error(pli_body_remove_clusters(body), PLI_ERROR_WRONG_STATE, "between predict and solve");
    check_error(pli_body_reset_clusters(body), PLI_ERROR_WRONG_STATE, "between predict and solve");
    check_error(pli_body_enable_clusters(body, NULL), PLI_ERROR_WRONG_STATE, "between predict and solve");
    check_error(pli_body_disable_clusters(body), PLI_ERROR_WRONG_STATE, "between predict and solve");
    assert_int_equal(pli_body_cluster_count(body), 3);
    assert_int_equal(pli_world_solve(world), PLI_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_every_node_is_in_a_cluster, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_size_does_not_matter, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_snapshots_know_their_clusters, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_clusters_are_replaced_and_removed, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_enabling_again_keeps_clusters, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_frame_follows_a_rigid_motion, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_frame_is_where_the_nodes_are, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_inverted_body_recovers, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_matching_is_the_share_of_the_way, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_matching_moves_no_body_at_rest, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_node_damping_takes_out_deformation, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_linear_damping_is_seen_by_the_cluster, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_degenerate_clusters_stay_finite, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_pinned_nodes_never_move, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_clusters_follow_a_cut, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_steady_steps_allocate_nothing, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_out_of_memory_leaves_clusters_as_they_were, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_bad_input, setup_weightless_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
