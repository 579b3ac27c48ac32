/* What a caller may get wrong: each case has its own status and a message that says what and where, and leaves the
   mesh and the world as they were. Readers of files, shapes, contacts and anchors have such tests of their own too. */

#include "check.h"

#include <pliant/pliant.h>

#include <stdio.h>
#include <string.h>

static pli_context* context;
static pli_world* world;
static pli_mesh* mesh; /* a pinned patch of 5 x 4 nodes */
static pli_body* body; /* made from it, with rigid contacts */
static pli_rigid* rigid;
static pli_shape* ball;

#define CHECK_OK(expression) assert_int_equal(expression, PLI_OK)

static int setup(void** unused) {
    (void)unused;
    CHECK_OK(pli_context_create(NULL, &context));
    CHECK_OK(pli_world_create(context, NULL, &world));
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(0, 0, 0);
    patch.corner_10 = pli_vec3_make(1, 0, 0);
    patch.corner_01 = pli_vec3_make(0, 0, 1);
    patch.corner_11 = pli_vec3_make(1, 0, 1);
    patch.columns = 5;
    patch.rows = 4;
    patch.pins = PLI_PATCH_PIN_00;
    patch.diagonals = true;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_body_create(world, mesh, NULL, &body));
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    CHECK_OK(pli_body_enable_rigid_contacts(body, &contacts));
    CHECK_OK(pli_shape_create_sphere(context, 0.5f, &ball));
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = 1;
    def.shapes = &ball;
    def.state.pose.origin = pli_vec3_make(0.5f, -0.6f, 0.5f);
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    for (int i = 0; i < 5; ++i) {
        CHECK_OK(pli_world_step(world, 1.0f / 60.0f));
    }
    return 0;
}

static int teardown(void** unused) {
    (void)unused;
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_shape_release(ball);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
    return 0;
}

/* ---------------------------------------------------------------------------------------------------- the cases */

static const pli_vec3 not_a_number = {0, NAN, 0};
static const pli_vec3 up = {0, 1, 0};

static pli_status node_at_nan(void) {
    return pli_mesh_append_node(mesh, not_a_number, 1.0f, NULL);
}
static pli_status node_of_negative_mass(void) {
    return pli_mesh_append_node(mesh, up, -2.0f, NULL);
}
static pli_status node_of_nan_mass(void) {
    return pli_mesh_append_node(mesh, up, NAN, NULL);
}
static pli_status link_out_of_range(void) {
    return pli_mesh_append_link(mesh, 3, 20, 0, NULL);
}
static pli_status link_to_itself(void) {
    return pli_mesh_append_link(mesh, 3, 3, 0, NULL);
}
static pli_status link_of_unknown_material(void) {
    return pli_mesh_append_link(mesh, 3, 4, 7, NULL);
}
static pli_status face_out_of_range(void) {
    return pli_mesh_append_face(mesh, 0, -1, 2, 0, NULL);
}
static pli_status face_with_a_node_twice(void) {
    return pli_mesh_append_face(mesh, 4, 5, 4, 0, NULL);
}
static pli_status tetra_out_of_range(void) {
    return pli_mesh_append_tetra(mesh, 0, 1, 2, 999, 0, NULL);
}
static pli_status material_too_stiff(void) {
    return pli_mesh_append_material(mesh, &(pli_material){1.5f}, NULL);
}
static pli_status material_of_nan(void) {
    return pli_mesh_set_material(mesh, 0, &(pli_material){NAN});
}
static pli_status mass_of_unknown_node(void) {
    return pli_mesh_set_node_mass(mesh, 20, 1.0f);
}
static pli_status total_mass_of_zero(void) {
    return pli_mesh_set_total_mass(mesh, 0.0f);
}
static pli_status volume_mass_without_tetras(void) {
    return pli_mesh_set_total_mass_from_tetras(mesh, 1.0f);
}
static pli_status bending_distance_of_one(void) {
    return pli_mesh_append_bending_links(mesh, 1, 0, NULL);
}
static pli_status scale_by_infinity(void) {
    return pli_mesh_scale(mesh, pli_vec3_make(1, INFINITY, 1));
}
static pli_status transform_by_nan(void) {
    pli_transform transform = pli_transform_identity();
    transform.origin.x = NAN;
    return pli_mesh_transform(mesh, transform);
}
static pli_status patch_of_one_column(void) {
    pli_patch_def def = pli_patch_def_default();
    def.columns = 1;
    def.rows = 4;
    pli_mesh* made = NULL;
    const pli_status status = pli_mesh_create_patch(context, &def, &made);
    assert_null(made);
    return status;
}
static pli_status patch_from_a_zeroed_def(void) {
    pli_patch_def def;
    memset(&def, 0, sizeof def);
    pli_mesh* made = NULL;
    return pli_mesh_create_patch(context, &def, &made);
}
static pli_status rope_of_negative_nodes(void) {
    pli_mesh* made = NULL;
    return pli_mesh_create_rope(context, up, up, -5, 0, &made);
}
static pli_status hull_of_a_plane(void) {
    const pli_vec3 points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}};
    pli_mesh* made = NULL;
    return pli_mesh_create_convex_hull(context, 4, points, 0.0f, &made);
}
static pli_status missing_obj_file(void) {
    pli_mesh* made = NULL;
    return pli_mesh_read_obj(context, "there/is/no/such.obj", &made);
}
static pli_status obj_file_cut_off(void) {
    const char* path = "cut_off.obj";
    FILE* file = fopen(path, "w");
    assert_non_null(file);
    fputs("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2", file);
    fclose(file);
    pli_mesh* made = NULL;
    const pli_status status = pli_mesh_read_obj(context, path, &made);
    assert_null(made);
    remove(path);
    return status;
}
static pli_status missing_tetgen_files(void) {
    pli_mesh* made = NULL;
    return pli_mesh_read_tetgen(context, "there/is/no/such", &made);
}

static pli_status body_of_an_empty_mesh(void) {
    pli_mesh* empty = NULL;
    CHECK_OK(pli_mesh_create(context, &empty));
    pli_body* made = NULL;
    const pli_status status = pli_body_create(world, empty, NULL, &made);
    assert_null(made);
    pli_mesh_destroy(empty);
    return status;
}
static pli_status body_from_a_zeroed_def(void) {
    pli_body_def def;
    memset(&def, 0, sizeof def);
    pli_body* made = NULL;
    return pli_body_create(world, mesh, &def, &made);
}
static pli_status body_of_negative_margin(void) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = -0.1f;
    pli_body* made = NULL;
    return pli_body_create(world, mesh, &def, &made);
}
static pli_status body_without_a_mesh(void) {
    pli_body* made = NULL;
    return pli_body_create(world, NULL, NULL, &made);
}
static pli_status settings_of_negative_iterations(void) {
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.position_iterations = -1;
    return pli_body_set_solver_settings(body, &settings);
}
static pli_status settings_that_damp_twice(void) {
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.velocity_damping = 2.0f;
    return pli_body_set_solver_settings(body, &settings);
}
static pli_status time_scale_of_zero(void) {
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.time_scale = 0.0f;
    return pli_body_set_solver_settings(body, &settings);
}
static pli_status position_of_unknown_node(void) {
    return pli_body_set_node_position(body, 20, up);
}
static pli_status position_of_nan(void) {
    return pli_body_set_node_position(body, 3, not_a_number);
}
static pli_status transform_out_of_range(void) {
    return pli_body_transform(
        body, (pli_transform){{{{3e38f, 3e38f, 3e38f}, {3e38f, 3e38f, 3e38f}, {3e38f, 3e38f, 3e38f}}}, {0, 0, 0}});
}
static pli_status velocity_of_infinity(void) {
    return pli_body_set_node_velocity(body, 3, pli_vec3_make(INFINITY, 0, 0));
}
static pli_status body_mass_negative(void) {
    return pli_body_set_node_mass(body, 3, -1.0f);
}
static pli_status force_of_nan(void) {
    return pli_body_add_node_force(body, 3, not_a_number);
}
static pli_status force_on_unknown_node(void) {
    return pli_body_add_node_force(body, -1, up);
}
static pli_status rest_length_of_unknown_link(void) {
    return pli_body_set_rest_length(body, 10000, 1.0f);
}
static pli_status rest_length_negative(void) {
    return pli_body_set_rest_length(body, 0, -1.0f);
}
static pli_status state_with_a_nan(void) {
    pli_vec3 positions[20];
    for (int i = 0; i < 20; ++i) {
        positions[i] = up;
    }
    positions[13].z = NAN;
    return pli_body_set_state(body, positions, NULL);
}
static pli_status step_of_nan(void) {
    return pli_world_step(world, NAN);
}
static pli_status step_backwards(void) {
    return pli_world_step(world, -0.01f);
}
static pli_status solve_before_predict(void) {
    return pli_world_solve(world);
}
static pli_status collide_before_predict(void) {
    return pli_world_collide_rigid(world, body, rigid);
}
static pli_status gravity_of_nan(void) {
    return pli_world_set_gravity(world, not_a_number);
}
static pli_status rigid_without_mass(void) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    pli_rigid* made = NULL;
    return pli_rigid_create(world, &def, &made);
}
static pli_status rigid_with_a_null_shape(void) {
    pli_shape* none = NULL;
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = 1;
    def.shapes = &none;
    pli_rigid* made = NULL;
    return pli_rigid_create(world, &def, &made);
}
static pli_status rigid_state_of_nan(void) {
    pli_rigid_state state = pli_rigid_get_state(rigid);
    state.pose.rotation.rows[1].x = NAN;
    return pli_rigid_set_state(rigid, &state);
}
/* Nobody would tell the body of its end. */
static pli_status ignored_rigid_elsewhere(void) {
    pli_world* other = NULL;
    pli_rigid* made = NULL;
    const pli_rigid_def def = pli_rigid_def_default();
    CHECK_OK(pli_world_create(context, NULL, &other));
    CHECK_OK(pli_rigid_create(other, &def, &made));
    const pli_status status = pli_body_ignore_rigid(body, made, true);
    pli_world_destroy(other);
    return status;
}
static pli_status sphere_of_negative_radius(void) {
    pli_shape* made = NULL;
    return pli_shape_create_sphere(context, -1.0f, &made);
}
static pli_status plane_without_normal(void) {
    pli_shape* made = NULL;
    return pli_shape_create_plane(context, pli_vec3_make(0, 0, 0), 0.0f, &made);
}
static pli_status pressure_of_nan(void) {
    return pli_body_enable_pressure(body, NAN);
}
static pli_status matching_above_one(void) {
    return pli_body_enable_pose_matching(body, 1.5f);
}
static pli_status anchor_to_nothing(void) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = 2;
    return pli_body_add_anchor(body, &def, NULL);
}
static pli_status anchor_that_is_gone(void) {
    return pli_body_remove_anchor(body, (pli_anchor_id){5, 1});
}

typedef struct bad_case {
    pli_status (*call)(void);
    pli_status status;
    const char* where; /* parts that the message must have */
    const char* what;
} bad_case;

static const bad_case bad_cases[] = {
    {node_at_nan, PLI_ERROR_NOT_FINITE, "pli_mesh_append_node", "nan"},
    {node_of_negative_mass, PLI_ERROR_INVALID_VALUE, "pli_mesh_append_node", "-2"},
    {node_of_nan_mass, PLI_ERROR_NOT_FINITE, "pli_mesh_append_node", "nan"},
    {link_out_of_range, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_mesh_append_link", "20"},
    {link_to_itself, PLI_ERROR_INVALID_VALUE, "pli_mesh_append_link", "3"},
    {link_of_unknown_material, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_mesh_append_link", "material 7"},
    {face_out_of_range, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_mesh_append_face", "-1"},
    {face_with_a_node_twice, PLI_ERROR_INVALID_VALUE, "pli_mesh_append_face", "4"},
    {tetra_out_of_range, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_mesh_append_tetra", "999"},
    {material_too_stiff, PLI_ERROR_INVALID_VALUE, "pli_mesh_append_material", "1.5"},
    {material_of_nan, PLI_ERROR_NOT_FINITE, "pli_mesh_set_material", "nan"},
    {mass_of_unknown_node, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_mesh_set_node_mass", "20"},
    {total_mass_of_zero, PLI_ERROR_INVALID_VALUE, "pli_mesh_set_total_mass", "0"},
    {volume_mass_without_tetras, PLI_ERROR_INVALID_MESH, "pli_mesh_set_total_mass_from_tetras", "tetra"},
    {bending_distance_of_one, PLI_ERROR_INVALID_VALUE, "pli_mesh_append_bending_links", "1"},
    {scale_by_infinity, PLI_ERROR_NOT_FINITE, "pli_mesh_scale", "inf"},
    {transform_by_nan, PLI_ERROR_NOT_FINITE, "pli_mesh_transform", ""},
    {patch_of_one_column, PLI_ERROR_INVALID_VALUE, "pli_mesh_create_patch", "1"},
    {patch_from_a_zeroed_def, PLI_ERROR_INVALID_DEF, "pli_mesh_create_patch", "default"},
    {rope_of_negative_nodes, PLI_ERROR_INVALID_VALUE, "pli_mesh_create_rope", "-5"},
    {hull_of_a_plane, PLI_ERROR_INVALID_MESH, "pli_mesh_create_convex_hull", "plane"},
    {missing_obj_file, PLI_ERROR_FILE_OPEN, "pli_mesh_read_obj", "there/is/no/such.obj"},
    {obj_file_cut_off, PLI_ERROR_FILE_FORMAT, "pli_mesh_read_obj", "cut_off.obj:5"},
    {missing_tetgen_files, PLI_ERROR_FILE_OPEN, "pli_mesh_read_tetgen", "there/is/no/such.node"},
    {body_of_an_empty_mesh, PLI_ERROR_INVALID_MESH, "pli_body_create", "no nodes"},
    {body_from_a_zeroed_def, PLI_ERROR_INVALID_DEF, "pli_body_create", "pli_body_def_default"},
    {body_of_negative_margin, PLI_ERROR_INVALID_VALUE, "pli_body_create", "-0.1"},
    {body_without_a_mesh, PLI_ERROR_NULL_ARGUMENT, "pli_body_create", "mesh"},
    {settings_of_negative_iterations, PLI_ERROR_INVALID_VALUE, "pli_body_set_solver_settings", "-1"},
    {settings_that_damp_twice, PLI_ERROR_INVALID_VALUE, "pli_body_set_solver_settings", "velocity_damping is 2"},
    {time_scale_of_zero, PLI_ERROR_INVALID_VALUE, "pli_body_set_solver_settings", "time_scale is 0"},
    {position_of_unknown_node, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_body_set_node_position", "node 20"},
    {transform_out_of_range, PLI_ERROR_INVALID_VALUE, "pli_body_transform", "node 1 would be at"},
    {position_of_nan, PLI_ERROR_NOT_FINITE, "pli_body_set_node_position", "nan"},
    {velocity_of_infinity, PLI_ERROR_NOT_FINITE, "pli_body_set_node_velocity", "inf"},
    {body_mass_negative, PLI_ERROR_INVALID_VALUE, "pli_body_set_node_mass", "-1"},
    {force_of_nan, PLI_ERROR_NOT_FINITE, "pli_body_add_node_force", "nan"},
    {force_on_unknown_node, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_body_add_node_force", "node -1"},
    {rest_length_of_unknown_link, PLI_ERROR_INDEX_OUT_OF_RANGE, "pli_body_set_rest_length", "link 10000"},
    {rest_length_negative, PLI_ERROR_INVALID_VALUE, "pli_body_set_rest_length", "-1"},
    {state_with_a_nan, PLI_ERROR_NOT_FINITE, "pli_body_set_state", "node 13"},
    {step_of_nan, PLI_ERROR_NOT_FINITE, "pli_world_step", "nan"},
    {step_backwards, PLI_ERROR_INVALID_VALUE, "pli_world_step", "-0.01"},
    {solve_before_predict, PLI_ERROR_WRONG_STATE, "pli_world_solve", "predicted"},
    {collide_before_predict, PLI_ERROR_WRONG_STATE, "pli_world_collide_rigid", "between"},
    {gravity_of_nan, PLI_ERROR_NOT_FINITE, "pli_world_set_gravity", "gravity"},
    {rigid_without_mass, PLI_ERROR_INVALID_VALUE, "pli_rigid_create", "inverse_mass is 0"},
    {rigid_with_a_null_shape, PLI_ERROR_NULL_ARGUMENT, "pli_rigid_create", "shape 0"},
    {rigid_state_of_nan, PLI_ERROR_NOT_FINITE, "pli_rigid_set_state", "pose"},
    {ignored_rigid_elsewhere, PLI_ERROR_INVALID_VALUE, "pli_body_ignore_rigid", "another world"},
    {sphere_of_negative_radius, PLI_ERROR_INVALID_VALUE, "pli_shape_create_sphere", "-1"},
    {plane_without_normal, PLI_ERROR_INVALID_VALUE, "pli_shape_create_plane", "normal"},
    {pressure_of_nan, PLI_ERROR_NOT_FINITE, "pli_body_enable_pressure", "nan"},
    {matching_above_one, PLI_ERROR_INVALID_VALUE, "pli_body_enable_pose_matching", "1.5"},
    {anchor_to_nothing, PLI_ERROR_NULL_ARGUMENT, "pli_body_add_anchor", "rigid"},
    {anchor_that_is_gone, PLI_ERROR_STALE_ID, "pli_body_remove_anchor", "5"},
};

enum { BAD_CASE_COUNT = (int)(sizeof bad_cases / sizeof bad_cases[0]) };

/* Bits of everything that a wrong call could have touched. */
typedef struct everything {
    uint64_t hash;
    size_t bytes;
    pli_mesh_view view;
    pli_vec3 positions[20];
    float inverse_masses[20];
    pli_solver_settings settings;
    pli_rigid_state rigid;
    int bodies;
} everything;

static everything take_everything(void) {
    everything all;
    memset(&all, 0, sizeof all);
    all.hash = pli_body_state_hash(body);
    all.bytes = pli_body_bytes(body);
    all.view = pli_mesh_get_view(mesh);
    memcpy(all.positions, all.view.positions, sizeof all.positions);
    memcpy(all.inverse_masses, all.view.inverse_masses, sizeof all.inverse_masses);
    all.settings = pli_body_get_solver_settings(body);
    all.rigid = pli_rigid_get_state(rigid);
    all.bodies = pli_world_body_count(world);
    return all;
}

static void test_bad_input_has_its_own_message_and_changes_nothing(void** unused) {
    (void)unused;
    char messages[BAD_CASE_COUNT][512];
    for (int i = 0; i < BAD_CASE_COUNT; ++i) {
        const everything before = take_everything();
        const size_t allocated = pli_context_allocated_bytes(context);
        const pli_status status = bad_cases[i].call();
        const char* message = pli_last_error(context);
        if (status != bad_cases[i].status || strstr(message, bad_cases[i].where) == NULL ||
            strstr(message, bad_cases[i].what) == NULL) {
            fail_msg("case %d (%s, %s): status %d, expected %d, message \"%s\"", i, bad_cases[i].where,
                     bad_cases[i].what, (int)status, (int)bad_cases[i].status, message);
        }
        const everything after = take_everything();
        if (memcmp(&before, &after, sizeof before) != 0 || pli_context_allocated_bytes(context) != allocated) {
            fail_msg("case %d (%s) left something behind", i, bad_cases[i].where);
        }
        strncpy(messages[i], message, sizeof messages[i] - 1);
        messages[i][sizeof messages[i] - 1] = '\0';
        for (int k = 0; k < i; ++k) {
            if (strcmp(messages[i], messages[k]) == 0) { fail_msg("cases %d and %d say the same", k, i); }
        }
    }
    assert_true(BAD_CASE_COUNT >= 30);
    /* And the world goes on. */
    CHECK_OK(pli_world_step(world, 1.0f / 60.0f));
}

static void test_null_handles_are_harmless(void** unused) {
    (void)unused;
    assert_int_equal(pli_world_step(NULL, 0.01f), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_world_collide_rigid(world, NULL, rigid), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_set_node_mass(NULL, 0, 1.0f), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_enable_pressure(NULL, 1.0f), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_rigid_set_friction(NULL, 1.0f), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_append_node(NULL, up, 1.0f, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_mesh_create(NULL, &mesh), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_get_view(NULL).node_count, 0);
    assert_int_equal(pli_world_body_count(NULL), 0);
    assert_null(pli_world_get_body(world, 1));
    assert_null(pli_body_get_world(NULL));
    pli_body_destroy(NULL);
    pli_world_destroy(NULL);
    pli_rigid_destroy(NULL);
    pli_mesh_destroy(NULL);
    pli_shape_release(NULL);
    pli_context_destroy(NULL);
}

static void test_edits_while_stepping_are_refused(void** unused) {
    (void)unused;
    CHECK_OK(pli_world_predict(world, 0.01f));
    assert_true(pli_world_is_stepping(world));
    pli_body* made = NULL;
    assert_int_equal(pli_world_predict(world, 0.01f), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_body_create(world, mesh, NULL, &made), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_body_set_node_position(body, 0, up), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_body_transform(body, pli_transform_identity()), PLI_ERROR_WRONG_STATE);
    pli_body_destroy(body);
    assert_int_equal(pli_world_body_count(world), 1);
    CHECK_OK(pli_world_solve(world));
    assert_false(pli_world_is_stepping(world));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bad_input_has_its_own_message_and_changes_nothing),
        cmocka_unit_test(test_null_handles_are_harmless),
        cmocka_unit_test(test_edits_while_stepping_are_refused),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
