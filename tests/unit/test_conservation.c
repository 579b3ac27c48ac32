/* What a free body keeps: linear momentum, angular momentum, and an energy that does not grow; for features whose
   forces are inside of it, at the origin and far from it, with equal and unequal masses. */

#include "sample_mesh.h"
#include "test_world.h"

#define CHECK_OK(expression) assert_int_equal(expression, PLI_OK)

static const double dt = 1.0 / 60.0;

/* Angular momentum and energy are those about the centre of mass. */
typedef struct motion {
    double mass, centre[3], momentum[3], spin[3], energy;
} motion;

static motion motion_of(const pli_body* body) {
    motion sum = {0};
    const pli_body_view view = pli_body_get_view(body);
    const pli_vec4 first = view.positions[0];
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i], v = view.velocities[i];
        const double mass = 1.0 / (double)x.w, speed[3] = {(double)v.x, (double)v.y, (double)v.z};
        const double arm[3] = {(double)x.x - (double)first.x, (double)x.y - (double)first.y,
                               (double)x.z - (double)first.z};
        sum.mass += mass;
        for (int k = 0; k < 3; ++k) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            sum.centre[k] += mass * arm[k];
            sum.momentum[k] += mass * speed[k];
            sum.spin[k] += mass * (arm[l] * speed[m] - arm[m] * speed[l]);
            sum.energy += 0.5 * mass * speed[k] * speed[k];
        }
    }
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3, m = (k + 2) % 3;
        sum.spin[k] -= (sum.centre[l] * sum.momentum[m] - sum.centre[m] * sum.momentum[l]) / sum.mass;
        sum.energy -= 0.5 * sum.momentum[k] * sum.momentum[k] / sum.mass;
    }
    return sum;
}

static double length_of(const double* a) {
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}
static double distance_of(const double* a, const double* b) {
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return length_of(d);
}

/* A ball of 1 m and 10 kg; masses from 1 to 1000 where they are unequal. */
static pli_body* make_ball(pli_vec3 centre, bool has_equal_masses) {
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    CHECK_OK(sample_create_ellipsoid(context, pli_vec3_make(1, 1, 1), &mesh));
    for (int i = 0; i < SAMPLE_SPHERE_NODES && !has_equal_masses; ++i) {
        CHECK_OK(pli_mesh_set_node_mass(mesh, i, powf(1000.0f, (float)(i * 37 % 83) / 82.0f)));
    }
    CHECK_OK(pli_mesh_set_total_mass(mesh, 10));
    CHECK_OK(pli_mesh_translate(mesh, centre));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    return body;
}

/* A common velocity, a rotation about the centre, and waves that deform. */
static void set_motion(pli_body* body, pli_vec3 centre, pli_vec3 common, pli_vec3 turn, float wave) {
    pli_vec3 positions[SAMPLE_SPHERE_NODES], velocities[SAMPLE_SPHERE_NODES];
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        positions[i] = pli_vec3_make(view.positions[i].x, view.positions[i].y, view.positions[i].z);
        const pli_vec3 arm = pli_vec3_sub(positions[i], centre);
        velocities[i] = pli_vec3_add(common, pli_vec3_cross(turn, arm));
        velocities[i] = pli_vec3_add(velocities[i], pli_vec3_scale(pli_vec3_make(arm.y, arm.z * arm.z, -arm.x), wave));
    }
    CHECK_OK(pli_body_set_state(body, positions, velocities));
}

// ------------------------------------------------------------------------------------------------------- clusters

/* Clusters that share nodes pull at each other, not at the body. */
static void test_matching_of_clusters_keeps_momentum(void** unused) {
    (void)unused;
    for (int trial = 0; trial < 4; ++trial) {
        const pli_vec3 centre = trial < 2 ? pli_vec3_make(0, 0, 0) : pli_vec3_make(70, -40, 25);
        pli_body* body = make_ball(centre, trial % 2 == 0);
        CHECK_OK(pli_body_enable_xpbd(body, NULL));
        CHECK_OK(pli_body_generate_clusters(body, 6, 100, NULL));
        for (int i = 0; i < pli_body_cluster_count(body); ++i) {
            pli_cluster_settings settings;
            CHECK_OK(pli_body_get_cluster_settings(body, i, &settings));
            settings.matching = 0.3f;
            CHECK_OK(pli_body_set_cluster_settings(body, i, &settings));
        }
        set_motion(body, centre, pli_vec3_make(0, 0, 0), pli_vec3_make(0.6f, 1.2f, -0.4f), 1.0f);
        const motion start = motion_of(body);
        double worst = 0.0;
        for (int i = 0; i < 120; ++i) {
            CHECK_OK(pli_world_step(world, (float)dt));
            worst = fmax(worst, distance_of(motion_of(body).momentum, start.momentum) / start.mass);
        }
        print_message("matching of clusters: %.2g m/s\n", worst);
        check_at_most(worst, trial < 2 ? 1e-4 : 3e-3);
        pli_body_destroy(body);
    }
}

static void enable_cluster_contacts(pli_body* body, bool with_self) {
    pli_cluster_contacts_def def = pli_cluster_contacts_def_default();
    def.with_self = with_self;
    CHECK_OK(pli_body_enable_cluster_contacts(body, &def));
}

/* Clusters that share nodes: each ball, of 10 kg at 2 m/s, has 11 of them. */
static void test_contacts_of_clusters_keep_momentum(void** unused) {
    (void)unused;
    for (int trial = 0; trial < 6; ++trial) {
        const pli_vec3 centre = pli_vec3_make(-1.2f, 0.3f, 0), other = pli_vec3_make(1.2f, -0.3f, 0.2f);
        pli_body* balls[2] = {make_ball(centre, trial % 2 == 0), make_ball(other, trial % 2 == 0)};
        for (int k = 0; k < 2; ++k) {
            if (trial / 2 == 1) { CHECK_OK(pli_body_enable_implicit(balls[k], NULL)); }
            if (trial / 2 == 2) {
                CHECK_OK(pli_body_enable_xpbd(balls[k], NULL));
                CHECK_OK(pli_body_enable_xpbd_links(balls[k], NULL));
            }
            CHECK_OK(pli_body_generate_clusters(balls[k], 11, 1000, NULL));
            enable_cluster_contacts(balls[k], false);
            CHECK_OK(pli_body_add_velocity(balls[k], pli_vec3_make(k == 0 ? 2.0f : -2.0f, 0, 0)));
        }
        double worst = 0.0, energy = 0.0;
        int contacts = 0;
        for (int i = 0; i < 120; ++i) {
            CHECK_OK(pli_world_step(world, (float)dt));
            const pli_vec3 sum = pli_vec3_add(pli_body_momentum(balls[0]), pli_body_momentum(balls[1]));
            worst = fmax(worst, (double)pli_vec3_length(sum));
            energy = (double)(pli_body_kinetic_energy(balls[0]) + pli_body_kinetic_energy(balls[1]));
            contacts += pli_body_get_cluster_contacts(balls[0], 0, NULL);
            contacts += pli_body_get_cluster_contacts(balls[1], 0, NULL);
        }
        print_message("contacts of clusters: of 20 kg m/s, %.2g; of 40 J, %.2g left, %d contacts\n", worst, energy,
                      contacts);
        assert_true(contacts > 20);
        check_at_most(worst, 5e-4);
        check_at_most(energy, 40.0);
        pli_body_destroy(balls[0]);
        pli_body_destroy(balls[1]);
    }
}

/* Of one body: two slabs of loose nodes, of 16 and 32 kg, with two clusters each that share a third of their nodes. */
static void test_contacts_within_a_body_keep_momentum(void** unused) {
    (void)unused;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    CHECK_OK(pli_mesh_create(context, &mesh));
    for (int i = 0; i < 96; ++i) {
        const float x = 0.3f * (float)(i % 4), y = 0.3f * (float)(i / 4 % 6), z = 0.3f * (float)(i / 24 % 2);
        const int slab = i / 48;
        const pli_vec3 at = pli_vec3_make(x + (slab == 0 ? -0.5f : 0.7f), y + 0.4f * (float)slab, z);
        CHECK_OK(pli_mesh_append_node(mesh, at, (float)(slab + 1) / 3.0f, NULL));
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.05f;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    pli_vec3 positions[96], velocities[96];
    for (int k = 0; k < 4; ++k) {
        int nodes[32], count = 0; /* rows 0 to 3, or 2 to 5 */
        for (int i = 0; i < 48; ++i) {
            const int row = i / 4 % 6 - 2 * (k % 2);
            if (row >= 0 && row < 4) { nodes[count++] = 48 * (k / 2) + i; }
        }
        pli_cluster_settings settings;
        CHECK_OK(pli_body_add_cluster(body, nodes, count, NULL));
        CHECK_OK(pli_body_get_cluster_settings(body, k, &settings));
        settings.matching = 0.5f;
        CHECK_OK(pli_body_set_cluster_settings(body, k, &settings));
    }
    enable_cluster_contacts(body, true);
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < 96; ++i) {
        positions[i] = pli_vec3_make(view.positions[i].x, view.positions[i].y, view.positions[i].z);
        velocities[i] = pli_vec3_make(i < 48 ? 2.0f : -1.0f, 0, 0);
    }
    CHECK_OK(pli_body_set_state(body, positions, velocities));
    const motion start = motion_of(body);
    double moved = 0.0, turned = 0.0;
    int contacts = 0;
    for (int i = 0; i < 120; ++i) {
        CHECK_OK(pli_world_step(world, (float)dt));
        const motion now = motion_of(body);
        moved = fmax(moved, distance_of(now.momentum, start.momentum));
        turned = fmax(turned, distance_of(now.spin, start.spin));
        contacts += pli_body_get_cluster_contacts(body, 0, NULL);
    }
    print_message("within a body: of 32 kg m/s, %.2g; of %.3g kg m^2/s, %.2g; %.3g of %.3g J left, %d contacts\n",
                  moved, length_of(start.spin), turned, motion_of(body).energy, start.energy, contacts);
    assert_true(contacts > 0);
    check_at_most(moved, 4e-3);
    check_at_most(turned, 0.5);
}

/* A joint between a ball and a rigid body of 2 kg that turn about each other, where links are solved on velocities. */
static void test_joint_holds_a_body_with_velocity_links(void** unused) {
    (void)unused;
    pli_body* body = make_ball(pli_vec3_make(0, 0, 0), true);
    pli_solver_settings solver = pli_body_get_solver_settings(body);
    solver.velocity_iterations = 4;
    CHECK_OK(pli_body_set_solver_settings(body, &solver));
    CHECK_OK(pli_body_enable_velocity_links(body));
    CHECK_OK(pli_body_generate_clusters(body, 1, 100, NULL));
    pli_rigid_def def = pli_rigid_def_default();
    pli_rigid* rigid = NULL;
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.pose.origin = pli_vec3_make(2, 0, 0);
    def.state.inverse_mass = 0.5f;
    for (int k = 0; k < 3; ++k) {
        def.state.inverse_inertia_world.rows[k] = pli_vec3_scale(pli_mat3_identity().rows[k], 2.5f);
    }
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_linear_joint_def joint = pli_linear_joint_def_default();
    joint.other.rigid = rigid;
    joint.position = pli_vec3_make(1.5f, 0, 0);
    CHECK_OK(pli_body_add_linear_joint(body, &joint, NULL));
    set_motion(body, pli_vec3_make(0, 0, 0), pli_vec3_make(0, 1, 0), pli_vec3_make(0, 0, 0.5f), 0);
    const double start[3] = {0, 10, 0};
    double worst = 0.0, farthest = 0.0;
    for (int i = 0; i < 120; ++i) {
        CHECK_OK(pli_world_step(world, (float)dt));
        CHECK_OK(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), (float)dt));
        const pli_rigid_state state = pli_rigid_get_state(rigid);
        const pli_vec3 v = state.linear_velocity, middle = middle_of(body);
        motion now = motion_of(body);
        now.momentum[0] += 2.0 * (double)v.x;
        now.momentum[1] += 2.0 * (double)v.y;
        now.momentum[2] += 2.0 * (double)v.z;
        worst = fmax(worst, distance_of(now.momentum, start));
        farthest = fmax(farthest, (double)pli_vec3_length(pli_vec3_sub(state.pose.origin, middle)));
    }
    print_message("joint: momentum changes by %.2g of 10 kg m/s, %.3f m apart\n", worst, farthest);
    check_at_most(worst, 2e-4);
    check_at_most(farthest, 2.05);
}

// ------------------------------------------------------------------------------------------------- self-collision

/* The speed limit of nodes, 0.12 m/s without substeps, is one of what deforms a free body. Here it flies, turns and
   deforms faster, under each solver. */
static void test_speed_limit_of_self_collision_keeps_momentum(void** unused) {
    (void)unused;
    for (int trial = 0; trial < 6; ++trial) {
        const pli_vec3 centre = pli_vec3_make(0, 0, 0);
        pli_body* body = make_ball(centre, trial % 2 == 0);
        if (trial / 2 == 1) { CHECK_OK(pli_body_enable_implicit(body, NULL)); }
        if (trial / 2 == 2) {
            CHECK_OK(pli_body_enable_xpbd(body, NULL));
            CHECK_OK(pli_body_enable_xpbd_links(body, NULL));
        }
        CHECK_OK(pli_body_enable_self_collision(body, NULL));
        set_motion(body, centre, pli_vec3_make(0.5f, 0, 0), pli_vec3_make(0.6f, 1.2f, -0.4f), 2.0f);
        CHECK_OK(pli_world_step(world, (float)dt));
        const motion start = motion_of(body);
        for (int i = 0; i < 9; ++i) {
            CHECK_OK(pli_world_step(world, (float)dt));
        }
        const motion end = motion_of(body);
        const double moved = distance_of(end.momentum, start.momentum) / start.mass;
        const double turned = distance_of(end.spin, start.spin) / length_of(start.spin);
        print_message("self-collision, %s: %.2g m/s, %.2g of the angular momentum, %d nodes limited\n",
                      trial / 2 == 0   ? "positions"
                      : trial / 2 == 1 ? "implicit"
                                       : "XPBD",
                      moved, turned, pli_body_get_self_collision_report(body).limited_nodes);
        check_at_most(moved, 8e-6);
        check_at_most(turned, 0.03);
        pli_body_destroy(body);
    }
}

// ----------------------------------------------------------------------------------------------------- XPBD links

/* Largest energy in 8 s over that of a kick of 0.1 m/s in random directions, rigid links. */
static double growth_of_kick(pli_mesh* mesh, int substeps) {
    pli_body* body = NULL;
    CHECK_OK(pli_mesh_set_total_mass(mesh, 10));
    CHECK_OK(pli_body_create(world, mesh, NULL, &body));
    pli_mesh_destroy(mesh);
    pli_xpbd_def xpbd = pli_xpbd_def_default();
    xpbd.substeps = substeps;
    CHECK_OK(pli_body_enable_xpbd(body, &xpbd));
    CHECK_OK(pli_body_enable_xpbd_links(body, NULL));
    unsigned state = 1;
    for (int i = 0; i < pli_body_get_view(body).node_count; ++i) {
        float v[3];
        for (int k = 0; k < 3; ++k) {
            state = state * 1664525u + 1013904223u;
            v[k] = 0.2f * ((float)(state >> 8) / 16777216.0f - 0.5f);
        }
        CHECK_OK(pli_body_set_node_velocity(body, i, pli_vec3_make(v[0], v[1], v[2])));
    }
    const double start = motion_of(body).energy;
    double most = 0.0;
    for (int i = 0; i < 480; ++i) {
        CHECK_OK(pli_world_step(world, (float)dt));
        most = fmax(most, motion_of(body).energy / start);
    }
    pli_body_destroy(body);
    return most;
}

static void test_links_between_unequal_masses_get_no_energy(void** unused) {
    (void)unused;
    for (int substeps = 10; substeps <= 40; substeps *= 2) {
        pli_mesh* mesh = NULL;
        CHECK_OK(sample_create_sheet(context, 13, 0, 0, &mesh));
        for (int i = 0; i < 169; ++i) {
            CHECK_OK(pli_mesh_set_node_mass(mesh, i, powf(1000.0f, (float)(i * 37 % 167) / 166.0f)));
        }
        const double most = growth_of_kick(mesh, substeps);
        print_message("masses of 1 to 1000, %d substeps: %.2g of the energy\n", substeps, most);
        check_at_most(most, 0.7);
    }
}

/* A ball that some links hold in shape from inside. */
static void test_links_of_a_braced_surface_get_no_energy(void** unused) {
    (void)unused;
    enum { NODES = 120 };
    for (int substeps = 10; substeps <= 40; substeps *= 2) {
        for (int braces = 28; braces <= 42; braces += 14) { /* of 354 edges */
            pli_mesh* mesh = NULL;
            CHECK_OK(pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1), NODES, &mesh));
            unsigned state = 1;
            for (int i = 0; i < braces; ++i) {
                state = state * 1664525u + 1013904223u;
                const int node = (int)(state >> 8) % NODES, shift = NODES / 2 + (int)(state >> 16) % 9;
                CHECK_OK(pli_mesh_append_link(mesh, node, (node + shift) % NODES, 0, NULL));
            }
            const double most = growth_of_kick(mesh, substeps);
            print_message("%d braces, %d substeps: %.2g of the energy\n", braces, substeps, most);
            check_at_most(most, 0.15);
        }
    }
}

// ---------------------------------------------------------------------------------------------------- XPBD volume

/* Rigid links do not allow ten percent more volume, nor what a gas wants; a ball that rests stays so, and one that
   turns goes on as it did. With unequal masses too. */
static void test_volume_that_links_do_not_allow_turns_nothing(void** unused) {
    (void)unused;
    for (int trial = 0; trial < 12; ++trial) {
        const bool has_gas = trial % 4 >= 2, turns = trial % 2 == 1;
        const pli_vec3 centre = trial < 8 ? pli_vec3_make(0, 0, 0) : pli_vec3_make(70, -40, 25);
        pli_body* body = make_ball(centre, trial / 4 != 1);
        pli_xpbd_volume_def volume = pli_xpbd_volume_def_default();
        volume.pressure_ratio = has_gas ? 1.0f : 1.1f;
        volume.compliance = has_gas ? 1e-4f : 0.0f;
        CHECK_OK(pli_body_enable_xpbd(body, NULL));
        CHECK_OK(pli_body_enable_xpbd_links(body, NULL));
        CHECK_OK(pli_body_enable_xpbd_volume(body, &volume));
        if (has_gas) { CHECK_OK(pli_body_enable_pressure(body, 2000)); }
        const float turn = turns ? 1.0f : 0.0f;
        set_motion(body, centre, pli_vec3_make(0, 0, 0), pli_vec3_make(0.6f * turn, 1.2f * turn, -0.4f * turn), 0);
        const motion start = motion_of(body);
        double worst = 0.0;
        for (int i = 0; i < 480; ++i) {
            CHECK_OK(pli_world_step(world, (float)dt));
            worst = fmax(worst, distance_of(motion_of(body).spin, start.spin));
        }
        const double more = motion_of(body).energy - start.energy;
        print_message("%s%s, %s masses: turned by %.2g kg m^2/s, %.2g J more\n", has_gas ? "gas" : "ratio of 1.1",
                      turns ? " in a ball that turns" : "", trial / 4 == 1 ? "unequal" : "equal", worst, more);
        check_at_most(worst, 3e-3);
        check_at_most(more, trial / 4 == 1 ? 0.2 : 1e-4); // nodes of 1 g swing
        pli_body_destroy(body);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_matching_of_clusters_keeps_momentum, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_contacts_of_clusters_keep_momentum, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_contacts_within_a_body_keep_momentum, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_joint_holds_a_body_with_velocity_links, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_speed_limit_of_self_collision_keeps_momentum, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_links_between_unequal_masses_get_no_energy, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_links_of_a_braced_surface_get_no_energy, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_volume_that_links_do_not_allow_turns_nothing, setup_weightless_world,
                                        teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
