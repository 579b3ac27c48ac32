/* The costs in memory that docs/costs.md gives. */

#include "check.h"

#include <pliant/pliant.h>

enum { SIZE = 128, NODES = SIZE * SIZE };

static pli_context* create_context(void) {
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    return context;
}

/* Structural and both shear links; `with_bending`: and links over one node in rows and columns, of another material. */
static pli_mesh* create_patch(pli_context* context, bool with_bending) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    const pli_material material = pli_mesh_get_view(mesh).materials[0];
    if (with_bending) { assert_int_equal(pli_mesh_append_material(mesh, &material, NULL), PLI_OK); }
    for (int i = 0; i < NODES; ++i) {
        const pli_vec3 position = pli_vec3_make(0.01f * (float)(i % SIZE), 0.0f, 0.01f * (float)(i / SIZE));
        assert_int_equal(pli_mesh_append_node(mesh, position, 1.0f, NULL), PLI_OK);
    }
    const int steps[][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}};
    for (int i = 0; i < NODES; ++i) {
        for (int k = 0; k < (with_bending ? 6 : 4); ++k) {
            const int x = i % SIZE + steps[k][0], y = i / SIZE + steps[k][1];
            if (x < 0 || x >= SIZE || y >= SIZE) { continue; }
            assert_int_equal(pli_mesh_append_link(mesh, i, y * SIZE + x, k < 4 ? 0 : 1, NULL), PLI_OK);
        }
        if (i % SIZE == SIZE - 1 || i / SIZE == SIZE - 1) { continue; }
        assert_int_equal(pli_mesh_append_face(mesh, i, i + SIZE, i + 1, 0, NULL), PLI_OK);
        assert_int_equal(pli_mesh_append_face(mesh, i + 1, i + SIZE, i + SIZE + 1, 0, NULL), PLI_OK);
    }
    return mesh;
}

typedef struct cost {
    int link_count, face_count;
    double bytes; /* of the body, with what it shares with its mesh, in use */
} cost;

typedef void enable_fn(pli_body* body);

static cost measure(bool with_bending, enable_fn* enable) {
    pli_context* context = create_context();
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_mesh* mesh = create_patch(context, with_bending);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    if (enable != NULL) { enable(body); }
    assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    const pli_body_view view = pli_body_get_view(body);
    const cost result = {view.link_count, view.face_count, (double)pli_context_allocated_bytes(context)};
    assert_true((double)pli_body_bytes(body) <= result.bytes);
    assert_true((double)pli_body_bytes(body) > result.bytes - 2000);
    pli_world_destroy(world);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
    return result;
}

/* What a body, its features and its world take whatever its size. */
static const double fixed_bytes = 7600;

static void check_bytes(cost measured, double least, double most) {
    assert_true(measured.bytes >= least);
    assert_true(measured.bytes <= most + fixed_bytes);
}

static double base_bytes(cost c, bool has_tags) {
    return 48.0 * NODES + 12.0 * c.face_count + (has_tags ? 14.0 : 12.0) * c.link_count;
}

static void use_colored_links(pli_body* body) {
    assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
}
static void use_xpbd(pli_body* body) {
    const pli_xpbd_def def = pli_xpbd_def_default();
    assert_int_equal(pli_body_enable_xpbd(body, &def), PLI_OK);
    const pli_xpbd_links_def links = pli_xpbd_links_def_default();
    assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
}
static void use_damped_xpbd(pli_body* body) {
    use_xpbd(body);
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = 1e-6f;
    links.damping = 1.0f;
    assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
}
static void use_aero(pli_body* body) {
    pli_aero_def def = pli_aero_def_default();
    def.drag = 0.1f;
    assert_int_equal(pli_body_enable_aero(body, &def), PLI_OK);
}

static void use_rigid_contacts(pli_body* body) {
    assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
}

static void test_nodes_faces_and_links(void** state) {
    (void)state;
    for (int with_bending = 0; with_bending < 2; ++with_bending) {
        const cost c = measure(with_bending == 1, NULL);
        check_bytes(c, base_bytes(c, with_bending == 1), base_bytes(c, with_bending == 1));
    }
    const cost c = measure(false, use_rigid_contacts);
    check_bytes(c, base_bytes(c, false) + 4.0 * NODES, base_bytes(c, false) + 4.0 * NODES);
}

/* A rest length and an index, and the nodes of quads. */
static const double least_slot = 8.0, most_slot = 14.0;

static void test_colored_links(void** state) {
    (void)state;
    for (int with_bending = 0; with_bending < 2; ++with_bending) {
        const cost c = measure(with_bending == 1, use_colored_links);
        const double base = base_bytes(c, with_bending == 1);
        check_bytes(c, base + (4.0 + least_slot) * c.link_count, base + (4.2 + most_slot) * c.link_count);
        assert_true(c.bytes <= 256.0 * NODES);
    }
}

static void test_xpbd(void** state) {
    (void)state;
    for (int is_damped = 0; is_damped < 2; ++is_damped) {
        const cost c = measure(true, is_damped ? use_damped_xpbd : use_xpbd);
        const double base = base_bytes(c, true) + 48.0 * NODES + 8.0 * is_damped * c.link_count;
        check_bytes(c, base + (16.0 + least_slot) * c.link_count, base + (16.8 + most_slot) * c.link_count);
    }
}

static void test_forces_of_air(void** state) {
    (void)state;
    const cost c = measure(true, use_aero);
    const double expected = base_bytes(c, true) + 44.0 * NODES + 4.0 * c.face_count;
    check_bytes(c, expected, expected);
}

static void use_soft_contacts(pli_body* body) {
    const pli_soft_contacts_def def = pli_soft_contacts_def_default();
    assert_int_equal(pli_body_enable_soft_contacts(body, &def), PLI_OK);
}
// ------------------------------------------------------------------------------------------------ room for contacts

/* Bytes that the first step of two patches, with faces and nothing near them, adds. */
static double measure_room(enable_fn* enable, bool with_rigid, bool preallocates) {
    pli_context* context = create_context();
    pli_world_def def = pli_world_def_default();
    def.preallocates = preallocates;
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, &def, &world), PLI_OK);
    pli_mesh* mesh = create_patch(context, false);
    pli_body* bodies[2] = {NULL, NULL};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pli_body_create(world, mesh, NULL, &bodies[i]), PLI_OK);
        pli_transform apart = pli_transform_identity();
        apart.origin.y = (float)i;
        assert_int_equal(pli_body_transform(bodies[i], apart), PLI_OK);
        enable(bodies[i]);
    }
    pli_mesh_destroy(mesh);
    if (with_rigid) {
        pli_rigid_def rigid_def = pli_rigid_def_default();
        pli_rigid* rigid = NULL;
        assert_int_equal(pli_rigid_create(world, &rigid_def, &rigid), PLI_OK);
    }
    const size_t before = pli_context_allocated_bytes(context);
    assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    const double room = (double)(pli_context_allocated_bytes(context) - before);
    const uint64_t count = pli_context_allocation_count(context);
    assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    assert_int_equal(pli_context_allocation_count(context), count);
    pli_world_destroy(world);
    pli_context_destroy(context);
    return room;
}

static void test_room_for_contacts(void** state) {
    (void)state;
    const double nodes = 1024, faces = 2.0 * (SIZE - 1) * (SIZE - 1);
    assert_true(measure_room(use_rigid_contacts, false, true) == 0);
    assert_true(measure_room(use_rigid_contacts, true, false) == 0);
    const double group = 260 + 128, groups = nodes / 8 + 8; /* of eight contacts */
    assert_true(measure_room(use_rigid_contacts, true, true) == 2 * (96 * nodes + group * groups));
    assert_true(measure_room(use_soft_contacts, true, false) == 0);
    const double expected = 2 * (4 * 96 * nodes + 4 * faces) + 16 * NODES + 67 * faces;
    check_near(measure_room(use_soft_contacts, false, true) / expected, 1, 0.001);
}

// --------------------------------------------------------------------------------------- features on and off again

static pli_status disable_xpbd(pli_body* body) {
    assert_int_equal(pli_body_disable_xpbd_links(body), PLI_OK);
    return pli_body_disable_xpbd(body);
}
static void use_implicit(pli_body* body) {
    const pli_implicit_def def = pli_implicit_def_default();
    assert_int_equal(pli_body_enable_implicit(body, &def), PLI_OK);
}
static void use_pressure(pli_body* body) {
    assert_int_equal(pli_body_enable_pressure(body, 10.0f), PLI_OK);
}
static void use_volume(pli_body* body) {
    assert_int_equal(pli_body_enable_volume_conservation(body, 10.0f), PLI_OK);
}
static void use_pose(pli_body* body) {
    assert_int_equal(pli_body_enable_pose_matching(body, 0.1f), PLI_OK);
}
static void use_self_collision(pli_body* body) {
    const pli_self_collision_def def = pli_self_collision_def_default();
    assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
}

static void use_tethers(pli_body* body) {
    const pli_tethers_def def = pli_tethers_def_default();
    assert_int_equal(pli_body_enable_tethers(body, &def), PLI_OK);
}

static void use_step_smoothing(pli_body* body) {
    assert_int_equal(pli_body_enable_step_smoothing(body), PLI_OK);
}

static void use_restitution(pli_body* body) {
    assert_int_equal(pli_body_enable_restitution(body, 0.5f), PLI_OK);
}

typedef struct feature_switch {
    enable_fn* enable;
    pli_status (*disable)(pli_body* body);
} feature_switch;

static const feature_switch switches[] = {
    {use_colored_links, pli_body_disable_colored_links},
    {use_xpbd, disable_xpbd},
    {use_implicit, pli_body_disable_implicit},
    {use_aero, pli_body_disable_aero},
    {use_pressure, pli_body_disable_pressure},
    {use_volume, pli_body_disable_volume_conservation},
    {use_pose, pli_body_disable_pose_matching},
    {use_rigid_contacts, pli_body_disable_rigid_contacts},
    {use_soft_contacts, pli_body_disable_soft_contacts},
    {use_self_collision, pli_body_disable_self_collision},
    {use_tethers, pli_body_disable_tethers},
    {use_step_smoothing, pli_body_disable_step_smoothing},
    {use_restitution, pli_body_disable_restitution},
};

static const int switch_count = (int)(sizeof switches / sizeof *switches);

typedef struct ending {
    uint64_t state_hash;
    size_t body_bytes, all_bytes; /* at the end */
} ending;

/* Five steps; each of the features is switched on and off again before each of them. */
static ending run_with_switches(const feature_switch* list, int count) {
    pli_context* context = create_context();
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_mesh* mesh = create_patch(context, false);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_set_node_velocity(body, 5, pli_vec3_make(0.3f, 1.0f, 0.1f)), PLI_OK);
    for (int step = 0; step < 5; ++step) {
        for (int i = 0; i < count; ++i) {
            const size_t before = pli_body_bytes(body);
            list[i].enable(body);
            assert_true(pli_body_get_features(body, 0, NULL) > 1);
            assert_true(pli_body_bytes(body) > before);
            assert_int_equal(list[i].disable(body), PLI_OK);
            assert_int_equal(pli_body_get_features(body, 0, NULL), 1);
            if (step > 0) { assert_int_equal(pli_body_bytes(body), before); }
        }
        assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    }
    const ending result = {pli_body_state_hash(body), pli_body_bytes(body), pli_context_allocated_bytes(context)};
    pli_world_destroy(world);
    pli_context_destroy(context);
    return result;
}

/* The list of features itself grows when it first holds so many, and keeps its size: 176 bytes a feature. */
static const size_t list_growth = 2112;

static void test_features_on_and_off_leave_nothing(void** state) {
    (void)state;
    const ending untouched = run_with_switches(NULL, 0);
    for (int i = 0; i < switch_count; ++i) {
        const ending switched = run_with_switches(&switches[i], 1);
        assert_true(switched.state_hash == untouched.state_hash);
        assert_in_range(switched.body_bytes, untouched.body_bytes, untouched.body_bytes + list_growth);
        assert_in_range(switched.all_bytes, untouched.all_bytes, untouched.all_bytes + list_growth);
    }
    const ending all = run_with_switches(switches, switch_count);
    assert_true(all.state_hash == untouched.state_hash);
    assert_in_range(all.body_bytes, untouched.body_bytes, untouched.body_bytes + list_growth);
}

static void test_features_are_listed(void** state) {
    (void)state;
    pli_context* context = create_context();
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_mesh* mesh = create_patch(context, false);
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    use_pressure(body);
    pli_feature_cost features[8];
    assert_int_equal(pli_body_get_features(body, 8, features), 5);
    const char* const names[] = {"links", "forces", "normals", "areas", "pressure"};
    for (int i = 0; i < 5; ++i) {
        assert_string_equal(features[i].name, names[i]);
        assert_true(features[i].is_needed == (i > 0 && i < 4));
    }
    assert_true(features[1].bytes >= 12 * NODES && features[1].bytes <= 12 * NODES + 100);
    assert_true(features[2].bytes >= 28 * NODES && features[2].bytes <= 28 * NODES + 100);
    features[1].name = NULL;
    assert_int_equal(pli_body_get_features(body, 1, features), 5);
    assert_null(features[1].name);
    pli_world_destroy(world);
    pli_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nodes_faces_and_links),
        cmocka_unit_test(test_colored_links),
        cmocka_unit_test(test_xpbd),
        cmocka_unit_test(test_forces_of_air),
        cmocka_unit_test(test_room_for_contacts),
        cmocka_unit_test(test_features_on_and_off_leave_nothing),
        cmocka_unit_test(test_features_are_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
