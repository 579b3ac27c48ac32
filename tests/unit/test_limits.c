/* The limits of limits.h: just beyond them a call is refused and says so, on them it is accepted and steps lead to
   states that are finite. */

#include "level_sheet.h"
#include "test_world.h"

#include <float.h>

static float beyond(float limit) {
    return nextafterf(limit, INFINITY);
}
static float below(float limit) {
    return nextafterf(limit, 0.0f);
}

static void check_out_of_limits(pli_status status, const char* words) {
    if (status == PLI_ERROR_INVALID_VALUE && strstr(pli_last_error(context), words) != NULL) { return; }
    fail_msg("status %d, \"%s\" does not say \"%s\"", (int)status, pli_last_error(context), words);
}
#define CHECK_OK(expression) assert_int_equal(expression, PLI_OK)

static pli_mesh* make_sheet(float size) {
    pli_patch_def def = level_sheet(size, 0, 4);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &def, &mesh));
    return mesh;
}

static pli_body* make_body(pli_mesh* mesh) {
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, NULL, &body));
    pli_mesh_destroy(mesh);
    return body;
}

static void check_finite(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i], v = view.velocities[i];
        assert_true(isfinite(x.x) && isfinite(x.y) && isfinite(x.z) && isfinite(x.w));
        assert_true(isfinite(v.x) && isfinite(v.y) && isfinite(v.z));
    }
}
static void check_rigid_finite(const pli_rigid* rigid) {
    const pli_rigid_state state = pli_rigid_get_state(rigid);
    assert_true(isfinite(pli_vec3_length(state.linear_velocity)) && isfinite(pli_vec3_length(state.angular_velocity)));
    assert_true(isfinite(pli_vec3_length(state.pose.origin)));
}

static void step(int count, float dt) {
    for (int i = 0; i < count; ++i) {
        CHECK_OK(pli_world_step(world, dt));
    }
}

// ------------------------------------------------------------------------------------------------------- meshes

static void test_generators_refuse_points_out_of_the_world(void** unused) {
    (void)unused;
    static const float sizes[] = {PLI_MAX_COORDINATE, 1e7f, 1e20f, 3e38f};
    static const int corners[4] = {0, 1, 2, 3}, triangle[3] = {0, 1, 2};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s) {
        const float size = s == 0 ? beyond(sizes[s]) : sizes[s];
        const pli_vec3 from = pli_vec3_make(-size, -size, -size), to = pli_vec3_make(size, size, size);
        const pli_vec3 points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -size}};
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = from;
        patch.corner_11 = to;
        pli_mesh* mesh = NULL;
        check_out_of_limits(pli_mesh_create_patch(context, &patch, &mesh), "corner_00 is (-");
        check_out_of_limits(pli_mesh_create_patch_uv(context, &patch, NULL, &mesh), "the limit is 1e+06");
        check_out_of_limits(pli_mesh_create_rope(context, from, to, 3, 0, &mesh), "point 0");
        check_out_of_limits(pli_mesh_create_ellipsoid(context, to, pli_vec3_make(1, 1, 1), 20, &mesh),
                            "the center is (");
        check_out_of_limits(pli_mesh_create_ellipsoid(context, points[0], to, 20, &mesh), "radii is (");
        check_out_of_limits(pli_mesh_create_convex_hull(context, 4, points, 0, &mesh), "point 3");
        check_out_of_limits(pli_mesh_create_from_tetras(context, 4, points, 1, corners, &mesh), "point 3");
        check_out_of_limits(pli_mesh_create_from_triangles(context, 4, points, 1, triangle, false, &mesh), "point 3");
        assert_null(mesh);
    }
    const pli_vec3 edge = pli_vec3_make(PLI_MAX_COORDINATE, 0, 0);
    pli_mesh* mesh = NULL;
    check_out_of_limits(pli_mesh_create_ellipsoid(context, edge, pli_vec3_make(1, 1, 1), 20, &mesh),
                        "coordinates go to");
}

/* Rounding takes what lies between corners over the limit. */
static void test_meshes_on_the_border_step(void** unused) {
    (void)unused;
    const float c = PLI_MAX_COORDINATE;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)));
    for (int k = 0; k < 40; ++k) {
        const float low = -c * (float)k / 39.0f;
        const pli_vec3 from = pli_vec3_make(low, -c, c), to = pli_vec3_make(c, c, -c);
        pli_mesh* mesh = NULL;
        CHECK_OK(pli_mesh_create_rope(context, from, to, 7 + k, 0, &mesh));
        pli_body* body = make_body(mesh);
        step(2, 1.0f / 60.0f);
        assert_false(pli_body_is_frozen(body));
        check_finite(body);
        pli_body_destroy(body);
    }
    pli_body* sheet = make_body(make_sheet(c));
    CHECK_OK(pli_body_set_collision_margin(sheet, c));
    const pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    CHECK_OK(pli_body_enable_soft_contacts(sheet, &contacts));
    pli_body* other = make_body(make_sheet(0.5f * c));
    CHECK_OK(pli_body_enable_soft_contacts(other, &contacts));
    step(3, 1.0f / 60.0f);
    check_finite(sheet);
    check_finite(other);
}

static void test_meshes_are_not_moved_out_of_the_world(void** unused) {
    (void)unused;
    pli_mesh* mesh = make_sheet(1);
    pli_transform far = pli_transform_identity();
    far.origin.y = beyond(PLI_MAX_COORDINATE);
    for (int k = 0; k < 2; ++k) {
        check_out_of_limits(pli_mesh_translate(mesh, pli_vec3_make(3e38f, 0, 0)), "node 0 would be at (3e+38");
        check_out_of_limits(pli_mesh_scale(mesh, pli_vec3_make(3e38f, 1, 1)), "node 0 would be at (-3e+38, 0, -1)");
        check_out_of_limits(pli_mesh_transform(mesh, far), "coordinates go to 1e+06");
    }
    check_out_of_limits(pli_mesh_set_node_position(mesh, 2, far.origin), "the position is (0, 1e+06, 0), the limit");
    check_out_of_limits(pli_mesh_append_node(mesh, far.origin, 1, NULL), "the position is");
    CHECK_OK(pli_mesh_scale(mesh, pli_vec3_make(PLI_MAX_COORDINATE, 1, 1)));
    CHECK_OK(pli_mesh_translate(mesh, pli_vec3_make(0, PLI_MAX_COORDINATE, 0)));
    check_out_of_limits(pli_mesh_translate(mesh, pli_vec3_make(0, 1, 0)), "would be at");
    pli_mesh_destroy(mesh);
}

static void test_masses_keep_to_their_limits(void** unused) {
    (void)unused;
    static const float bad[] = {3e38f, 1e30f, 1e-36f, 1e-37f, 1e-12f};
    pli_mesh* mesh = make_sheet(1);
    pli_body* body = NULL;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        check_out_of_limits(pli_mesh_set_total_mass(mesh, bad[i]), "masses go from 1e-09 to 1e+12");
        check_out_of_limits(pli_mesh_set_total_mass_from_faces(mesh, bad[i]), "masses go from");
        check_out_of_limits(pli_mesh_set_node_mass(mesh, 3, bad[i]), "the limits are 1e-09 and 1e+12");
        check_out_of_limits(pli_mesh_append_node(mesh, pli_vec3_make(0, 0, 0), bad[i], NULL), "the mass is");
    }
    check_out_of_limits(pli_mesh_set_total_mass(mesh, 1e-45f), "the mass is 1.4013e-45");
    check_out_of_limits(pli_mesh_set_node_mass(mesh, 3, below(PLI_MIN_MASS)), "the mass is 1e-09");
    CHECK_OK(pli_body_create(world, mesh, NULL, &body));
    check_out_of_limits(pli_body_set_node_mass(body, 3, beyond(PLI_MAX_MASS)), "mass of node 3 is 1e+12");
    check_out_of_limits(pli_body_set_node_mass(body, 3, 1e-45f), "mass of node 3 is 1.4013e-45");
    /* The lightest and the heaviest side by side. */
    for (int i = 0; i < 16; ++i) {
        CHECK_OK(pli_body_set_node_mass(body, i, i % 2 == 0 ? PLI_MIN_MASS : PLI_MAX_MASS));
    }
    step(3, 1.0f / 60.0f);
    assert_false(pli_body_is_frozen(body));
    check_finite(body);
    for (int k = 0; k < 2; ++k) {
        CHECK_OK(pli_mesh_set_total_mass(mesh, 16.0f * (k == 0 ? PLI_MIN_MASS : PLI_MAX_MASS)));
        CHECK_OK(pli_body_create(world, mesh, NULL, &body));
        step(2, 1.0f / 60.0f);
        assert_false(pli_body_is_frozen(body));
    }
    pli_mesh_destroy(mesh);

    pli_vec3 points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int corners[4] = {0, 1, 2, 3};
    CHECK_OK(pli_mesh_create_from_tetras(context, 4, points, 1, corners, &mesh));
    check_out_of_limits(pli_mesh_set_density_from_tetras(mesh, 3e38f), "masses go from");
    check_out_of_limits(pli_mesh_set_density_from_tetras(mesh, 1e-30f), "masses go from");
    pli_mesh_destroy(mesh);
}

// ------------------------------------------------------------------------------------------------------- states

static void test_states_keep_to_their_limits(void** unused) {
    (void)unused;
    pli_body* body = make_body(make_sheet(1));
    const uint64_t before = pli_body_state_hash(body);
    const float c = beyond(PLI_MAX_COORDINATE), v = beyond(PLI_MAX_SPEED);
    pli_vec3 places[16], speeds[16];
    for (int i = 0; i < 16; ++i) {
        places[i] = speeds[i] = pli_vec3_make(0, 0, 0);
    }
    places[5].y = c;
    check_out_of_limits(pli_body_set_state(body, places, speeds), "node 5 is at (0, 1e+06, 0)");
    places[5].y = 0;
    speeds[7].z = -v;
    check_out_of_limits(pli_body_set_state(body, places, speeds), "node 7");
    check_out_of_limits(pli_body_set_node_position(body, 1, pli_vec3_make(c, 0, 0)),
                        "position of node 1 is (1e+06, 0, 0), the limit");
    check_out_of_limits(pli_body_set_node_velocity(body, 1, pli_vec3_make(v, 0, 0)), "velocity of node 1 is");
    check_out_of_limits(pli_body_add_velocity(body, pli_vec3_make(3e38f, 0, 0)), "velocity is");
    check_out_of_limits(pli_body_add_node_force(body, 1, pli_vec3_make(3e38f, 0, 0)), "force of node 1 is");
    check_out_of_limits(pli_body_set_rest_length(body, 0, c), "rest length of link 0 is");
    check_out_of_limits(pli_body_set_collision_margin(body, c), "the collision margin is");
    pli_transform far = pli_transform_identity();
    far.origin.x = 3e38f;
    check_out_of_limits(pli_body_transform(body, far), "node 0 would be at (3e+38");
    check_out_of_limits(pli_body_transform(body, far), "node 0 would be at (3e+38");
    assert_true(pli_body_state_hash(body) == before);

    CHECK_OK(pli_body_add_velocity(body, pli_vec3_make(PLI_MAX_SPEED, 0, 0)));
    check_out_of_limits(pli_body_add_velocity(body, pli_vec3_make(PLI_MAX_SPEED, 0, 0)),
                        "the velocity of node 0 would be");
    CHECK_OK(pli_body_add_velocity(body, pli_vec3_make(-PLI_MAX_SPEED, 0, 0)));
    CHECK_OK(pli_body_add_force(body, pli_vec3_make(0, PLI_MAX_FORCE, 0)));
    check_out_of_limits(pli_body_add_force(body, pli_vec3_make(0, PLI_MAX_FORCE, 0)), "the forces on node 0 would be");
    step(1, 1.0f / 60.0f); /* as far as max_force_displacement lets them */
    assert_false(pli_body_is_frozen(body));
    check_finite(body);
}

static void test_steps_keep_to_their_limits(void** unused) {
    (void)unused;
    pli_body* body = make_body(make_sheet(1));
    check_out_of_limits(pli_world_step(world, beyond(PLI_MAX_TIME_STEP)), "dt is 1000, the limits are 1e-06 and 1000");
    check_out_of_limits(pli_world_step(world, 1e38f), "dt is 1e+38");
    check_out_of_limits(pli_world_step(world, 1e-38f), "dt is 1e-38");
    assert_false(pli_world_is_stepping(world));
    check_out_of_limits(pli_world_set_gravity(world, pli_vec3_make(0, 1e38f, 0)), "gravity is (0, 1e+38, 0)");
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.time_scale = 1e30f;
    check_out_of_limits(pli_body_set_solver_settings(body, &settings), "time_scale is 1e+30");
    settings.time_scale = 1;
    settings.drift_correction = -1e38f;
    check_out_of_limits(pli_body_set_solver_settings(body, &settings), "drift_correction is -1e+38");
    pli_world_def def = pli_world_def_default();
    pli_world* made = NULL;
    def.max_force_displacement = 1e30f;
    check_out_of_limits(pli_world_create(context, &def, &made), "max_force_displacement is 1e+30");
    def = pli_world_def_default();
    def.gravity.z = -beyond(PLI_MAX_ACCELERATION);
    check_out_of_limits(pli_world_create(context, &def, &made), "gravity is");

    step(3, PLI_MIN_TIME_STEP);
    assert_false(pli_body_is_frozen(body));
    check_finite(body);
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, -PLI_MAX_ACCELERATION, 0)));
    step(2, PLI_MAX_TIME_STEP);
    assert_true(pli_body_is_frozen(body)); /* 1e12 m down */
    check_finite(body);
    int count = 0;
    pli_world_get_events(world, &count);
    assert_int_equal(count, 0); /* of the step before */
}

/* A node that jumps through the world in a microsecond has a speed that no state may have. */
static void test_velocities_are_held_against_the_limit_too(void** unused) {
    (void)unused;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)));
    for (int solver = 0; solver < 3; ++solver) {
        pli_mesh* mesh = NULL;
        CHECK_OK(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(4e5f, 0, 0), 0, 0, &mesh));
        pli_body* body = make_body(mesh);
        if (solver == 1) {
            pli_xpbd_def def = pli_xpbd_def_default();
            def.substeps = 1;
            CHECK_OK(pli_body_enable_xpbd(body, &def));
            const pli_xpbd_links_def links = pli_xpbd_links_def_default();
            CHECK_OK(pli_body_enable_xpbd_links(body, &links));
        } else if (solver == 2) {
            pli_implicit_def def = pli_implicit_def_default();
            def.stiffness = PLI_MAX_COEFFICIENT;
            CHECK_OK(pli_body_enable_implicit(body, &def));
        }
        CHECK_OK(pli_body_set_node_position(body, 1, pli_vec3_make(5e5f, 0, 0)));
        CHECK_OK(pli_world_step(world, PLI_MIN_TIME_STEP));
        int count = 0;
        const pli_event* events = pli_world_get_events(world, &count);
        assert_int_equal(count, 1);
        assert_int_equal(events[0].kind, PLI_EVENT_BODY_FROZEN);
        assert_ptr_equal(events[0].body, body);
        assert_in_range(events[0].node, 0, 1);
        assert_true(pli_body_get_view(body).velocities[1].x == 0.0f);
        check_finite(body);
        pli_body_destroy(body);
    }
}

// ------------------------------------------------------------------------------------------------------- rigid bodies

static pli_rigid_def dynamic_def(void) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.inverse_mass = 1;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] =
            pli_vec3_make(i == 0 ? 2.5f : 0, i == 1 ? 2.5f : 0, i == 2 ? 2.5f : 0);
    }
    return def;
}

static void test_rigid_states_keep_to_their_limits(void** unused) {
    (void)unused;
    pli_rigid_def good = dynamic_def(), def = good;
    pli_rigid* rigid = NULL;
    def.state.pose.origin.y = beyond(PLI_MAX_COORDINATE);
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "pose.origin is (0, 1e+06, 0), the limit is 1e+06");
    def = good;
    def.state.pose.rotation.rows[1].z = 3e38f;
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "pose.rotation.rows[1] is (0, 1, 3e+38)");
    /* Larger, sheared, mirrored, with two rows alike. */
    static const pli_mat3 not_rotations[] = {{{{1.02f, 0, 0}, {0, 1.02f, 0}, {0, 0, 1.02f}}},
                                             {{{1, 0, 0}, {0.02f, 1, 0}, {0, 0, 1}}},
                                             {{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}},
                                             {{{1, 0, 0}, {1, 0, 0}, {0, 0, 1}}}};
    for (size_t i = 0; i < sizeof not_rotations / sizeof *not_rotations; ++i) {
        def = good;
        def.state.pose.rotation = not_rotations[i];
        check_out_of_limits(pli_rigid_create(world, &def, &rigid), "pose.rotation is scaled, sheared or mirrored");
    }
    def = good;
    def.state.pose.rotation.rows[0].x = 1.005f;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    def.state.pose.rotation.rows[0].x = 0;
    check_out_of_limits(pli_rigid_set_state(rigid, &def.state), "pose.rotation is scaled, sheared or mirrored");
    assert_float_equal(pli_rigid_get_state(rigid).pose.rotation.rows[0].x, 1.005f, 0);
    pli_rigid_destroy(rigid);
    rigid = NULL;
    def = good;
    def.state.linear_velocity.x = -3e38f;
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "linear_velocity is");
    def = good;
    def.state.angular_velocity.x = beyond(PLI_MAX_ANGULAR_SPEED);
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "angular_velocity is");
    def = good;
    def.state.inverse_mass = 1e30f;
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "inverse_mass is 1e+30, the limits are");
    def.state.inverse_mass = 1e-30f;
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "inverse_mass is 1e-30");
    def = good;
    def.state.inverse_inertia_world.rows[2].z = 3e38f;
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "inverse_inertia_world.rows[2]");
    def = good;
    def.friction = 3e38f;
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "friction is 3e+38");
    def = good;
    def.angular_factor.z = 1e30f;
    check_out_of_limits(pli_rigid_create(world, &def, &rigid), "angular_factor is");
    assert_null(rigid);
    CHECK_OK(pli_rigid_create(world, &good, &rigid));
    pli_rigid_state state = pli_rigid_get_state(rigid);
    state.linear_velocity = pli_vec3_make(PLI_MAX_SPEED, 0, 0);
    state.angular_velocity = pli_vec3_make(0, PLI_MAX_ANGULAR_SPEED, 0);
    CHECK_OK(pli_rigid_set_state(rigid, &state));
    check_out_of_limits(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), 1), "pose.origin is (1e+09");
    check_out_of_limits(pli_rigid_integrate(rigid, pli_vec3_make(0, 3e38f, 0), 1), "gravity is");
    check_out_of_limits(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), 1e30f), "dt is");
    CHECK_OK(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), 1e-4f));
    check_rigid_finite(rigid);
}

static float ask_for_much(float present, void* user) {
    (void)present;
    return *(const float*)user;
}

/* A sheet in one cluster, hinged to a box; another box below it only touches it. */
static void test_joint_speeds_leave_rigid_bodies_in_the_world(void** unused) {
    (void)unused;
    static const float speeds[] = {1e6f, 1e8f, 1e12f, 1e30f, 3e38f};
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.4f, 0.4f, 0.4f), &shape));
    unsigned events_seen = 0;
    for (size_t s = 0; s < sizeof speeds / sizeof *speeds; ++s) {
        float speed = speeds[s];
        pli_rigid_def def = dynamic_def();
        def.shape_count = 1;
        def.shapes = &shape;
        def.state.pose.origin.y = 1;
        pli_rigid *joined = NULL, *touching = NULL;
        CHECK_OK(pli_rigid_create(world, &def, &joined));
        def.state.pose.origin.y = -0.45f;
        CHECK_OK(pli_rigid_create(world, &def, &touching));
        pli_body* body = make_body(make_sheet(1));
        pli_solver_settings settings = pli_body_get_solver_settings(body);
        settings.position_iterations = 1; /* more share it out below the limits */
        CHECK_OK(pli_body_set_solver_settings(body, &settings));
        CHECK_OK(pli_body_generate_clusters(body, 1, 1, NULL));
        const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        CHECK_OK(pli_body_enable_rigid_contacts(body, &contacts));
        const pli_cluster_contacts_def of_clusters = pli_cluster_contacts_def_default();
        CHECK_OK(pli_body_enable_cluster_contacts(body, &of_clusters));
        pli_angular_joint_def joint = pli_angular_joint_def_default();
        joint.axis = pli_vec3_make(0.6f, 0.8f, 0);
        joint.other.rigid = joined;
        joint.controller = (pli_joint_controller){NULL, ask_for_much, &speed};
        CHECK_OK(pli_body_add_angular_joint(body, &joint, NULL));
        for (int i = 0; i < 10; ++i) {
            CHECK_OK(pli_world_step(world, 1.0f / 60.0f));
            int count = 0;
            pli_world_get_events(world, &count);
            events_seen += (unsigned)count;
            check_finite(body);
            for (int r = 0; r < 2; ++r) {
                const pli_rigid_state state = pli_rigid_get_state(r == 0 ? joined : touching);
                check_at_most(pli_vec3_length(state.angular_velocity), 1.8 * (double)PLI_MAX_ANGULAR_SPEED);
                check_at_most(pli_vec3_length(state.linear_velocity), 1.8 * (double)PLI_MAX_SPEED);
            }
            if (pli_rigid_integrate(joined, pli_vec3_make(0, 0, 0), 1.0f / 60.0f) != PLI_OK ||
                pli_rigid_integrate(touching, pli_vec3_make(0, 0, 0), 1.0f / 60.0f) != PLI_OK) {
                break;
            }
        }
        pli_body_destroy(body);
        pli_rigid_destroy(joined);
        pli_rigid_destroy(touching);
    }
    assert_true(events_seen > 0);
    pli_shape_release(shape);
}

// ------------------------------------------------------------------------------------------------------- features

static void test_features_keep_to_their_limits(void** unused) {
    (void)unused;
    const float much = 3e38f;
    pli_body* body = make_body(make_sheet(1));
    pli_rigid* wall = NULL;
    const pli_rigid_def wall_def = pli_rigid_def_default();
    CHECK_OK(pli_rigid_create(world, &wall_def, &wall));

    pli_aero_def aero = pli_aero_def_default();
    aero.drag = much;
    check_out_of_limits(pli_body_enable_aero(body, &aero), "drag is 3e+38");
    aero = pli_aero_def_default();
    aero.wind.x = much;
    check_out_of_limits(pli_body_enable_aero(body, &aero), "wind is");
    check_out_of_limits(pli_body_enable_pressure(body, -much), "coefficient is -3e+38");
    check_out_of_limits(pli_body_enable_volume_conservation(body, much), "coefficient is");
    pli_anchor_def anchor = pli_anchor_def_default();
    const pli_vec3 pivot = {much, 0, 0};
    anchor.rigid = wall;
    anchor.influence = much;
    check_out_of_limits(pli_body_add_anchor(body, &anchor, NULL), "influence is");
    anchor.influence = 1;
    anchor.local_pivot = &pivot;
    check_out_of_limits(pli_body_add_anchor(body, &anchor, NULL), "local_pivot is");
    pli_rigid_contacts_def nodes = pli_rigid_contacts_def_default();
    nodes.friction = much;
    check_out_of_limits(pli_body_enable_rigid_contacts(body, &nodes), "friction is");
    pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
    faces.friction = much;
    check_out_of_limits(pli_body_enable_rigid_face_contacts(body, &faces), "friction is");
    pli_soft_contacts_def soft = pli_soft_contacts_def_default();
    soft.recovery_speed = much;
    check_out_of_limits(pli_body_enable_soft_contacts(body, &soft), "recovery_speed is");
    pli_cluster_contacts_def clusters = pli_cluster_contacts_def_default();
    clusters.friction = much;
    check_out_of_limits(pli_body_enable_cluster_contacts(body, &clusters), "friction is");
    pli_self_collision_def self = pli_self_collision_def_default();
    self.thickness = much;
    check_out_of_limits(pli_body_enable_self_collision(body, &self), "thickness is");
    pli_tethers_def tethers = pli_tethers_def_default();
    tethers.slack = much;
    check_out_of_limits(pli_body_enable_tethers(body, &tethers), "slack is");
    pli_implicit_def implicit = pli_implicit_def_default();
    implicit.stiffness = much;
    check_out_of_limits(pli_body_enable_implicit(body, &implicit), "stiffness is");
    const pli_xpbd_def xpbd = pli_xpbd_def_default();
    CHECK_OK(pli_body_enable_xpbd(body, &xpbd));
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.damping = much;
    check_out_of_limits(pli_body_enable_xpbd_links(body, &links), "damping is");
    pli_xpbd_volume_def volume = pli_xpbd_volume_def_default();
    volume.pressure_ratio = much;
    check_out_of_limits(pli_body_enable_xpbd_volume(body, &volume), "pressure_ratio is");
    CHECK_OK(pli_body_disable_xpbd(body));

    pli_ray_def ray = pli_ray_def_default();
    pli_ray_hit hit;
    ray.to.x = beyond(PLI_MAX_COORDINATE);
    check_out_of_limits(pli_body_cast_ray(body, &ray, &hit), "end 1 is");
    const pli_vec3 far = {0, much, 0}, here = {0, 0, 0};
    check_out_of_limits(pli_body_cut_swept(body, here, here, here, far, NULL), "end 3 is (0, 3e+38, 0)");
    assert_int_equal(pli_body_get_features(body, 0, NULL), 1); /* links */
}

static void test_shapes_keep_to_their_limits(void** unused) {
    (void)unused;
    const float c = beyond(PLI_MAX_COORDINATE);
    const pli_vec3 long_side = {c, 1, 1}, points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, c}};
    static const int triangles[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const pli_sampled_mesh_def sampled = pli_sampled_mesh_def_default();
    pli_shape* shape = NULL;
    check_out_of_limits(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), c, &shape), "offset is");
    check_out_of_limits(pli_shape_create_sphere(context, c, &shape), "radius is");
    check_out_of_limits(pli_shape_create_box(context, long_side, &shape), "half_extents is");
    check_out_of_limits(pli_shape_create_capsule(context, long_side, 1, &shape), "half_segment is");
    check_out_of_limits(pli_shape_create_cylinder(context, long_side, 1, &shape), "half_axis is");
    check_out_of_limits(pli_shape_create_convex_hull(context, 4, points, 0, &shape), "point 3");
    check_out_of_limits(pli_shape_create_triangle_mesh(context, 4, points, 4, triangles, 0.1f, &shape), "point 3");
    check_out_of_limits(pli_shape_create_sampled_mesh(context, 4, points, 4, triangles, &sampled, &shape), "point 3");
    assert_null(shape);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_generators_refuse_points_out_of_the_world, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_meshes_on_the_border_step, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_meshes_are_not_moved_out_of_the_world, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_masses_keep_to_their_limits, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_states_keep_to_their_limits, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_steps_keep_to_their_limits, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_velocities_are_held_against_the_limit_too, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_rigid_states_keep_to_their_limits, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_joint_speeds_leave_rigid_bodies_in_the_world, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_features_keep_to_their_limits, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_shapes_keep_to_their_limits, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
