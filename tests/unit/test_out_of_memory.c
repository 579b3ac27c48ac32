/* Allocations of many set-ups fail, once and for good: some, spread over all of them, and with PLIANT_ALL_ALLOCATIONS=1
   in the environment every one. */

#include "memory_trial.h"
#include "sample_mesh.h"

#include <pliant/bullet_reference.h>

// ------------------------------------------------------------------------------------------------------------- bodies

/* Takes the mesh. */
static pli_body* add_body(trial* t, pli_mesh* mesh, float margin, int iterations) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = iterations;
    pli_body* body = NULL;
    TRIAL_CALL(t, pli_mesh_set_total_mass(mesh, 1.0f));
    TRIAL_CALL(t, pli_body_create(t->world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    return body;
}

/* nodes x nodes with diagonals, level. */
static pli_mesh* make_sheet(trial* t, int nodes, float spacing, pli_vec3 centre, int pins) {
    const float half = 0.5f * spacing * (float)(nodes - 1);
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_add(centre, pli_vec3_make(-half, 0, -half));
    def.corner_10 = pli_vec3_add(centre, pli_vec3_make(half, 0, -half));
    def.corner_01 = pli_vec3_add(centre, pli_vec3_make(-half, 0, half));
    def.corner_11 = pli_vec3_add(centre, pli_vec3_make(half, 0, half));
    def.columns = def.rows = nodes;
    def.pins = pins;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    TRIAL_CALL(t, pli_mesh_create_patch(t->context, &def, &mesh));
    return mesh;
}

static pli_body* add_sheet(trial* t, int nodes, float spacing, pli_vec3 centre, int pins) {
    return add_body(t, make_sheet(t, nodes, spacing, centre, pins), 0.3f * spacing, 3);
}

/* Two layers, a little less apart than the thickness of self-collision, joined along one side. */
static pli_body* add_fold(trial* t, int nodes, float spacing, float gap) {
    pli_mesh* mesh = make_sheet(t, nodes, spacing, pli_vec3_make(0, 1, 0), 0);
    pli_body* body = add_body(t, mesh, 0.3f * spacing, 3);
    const pli_body_view view = pli_body_get_view(body);
    pli_vec3* x = calloc((size_t)view.node_count, sizeof *x);
    assert_non_null(x);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 p = view.positions[i];
        x[i] = p.x <= 0 ? pli_vec3_make(p.x, p.y, p.z) : pli_vec3_make(-p.x, p.y + gap, p.z + 0.3f * spacing);
    }
    TRIAL_CALL(t, pli_body_set_state(body, x, NULL));
    free(x);
    return body;
}

static pli_body* add_ball(trial* t, pli_vec3 centre, float radius) {
    pli_mesh* mesh = NULL;
    TRIAL_CALL(t, sample_create_ellipsoid(t->context, pli_vec3_make(radius, 0.8f * radius, radius), &mesh));
    TRIAL_CALL(t, pli_mesh_translate(mesh, centre));
    return add_body(t, mesh, 0.1f * radius, 3);
}

static pli_body* add_rope(trial* t, int inner_nodes, float y, int pins) {
    pli_mesh* mesh = NULL;
    TRIAL_CALL(
        t, pli_mesh_create_rope(t->context, pli_vec3_make(0, y, 0), pli_vec3_make(1, y, 0), inner_nodes, pins, &mesh));
    return add_body(t, mesh, 0.05f, 4);
}

/* Five tetrahedra in each of a few cubes, one above the other. */
static pli_body* add_tetras(trial* t, pli_vec3 origin) {
    enum { LAYERS = 3, POINTS = 4 * (LAYERS + 1) };
    static const int cube[2][5][4] = {{{0, 1, 3, 4}, {1, 2, 3, 6}, {4, 6, 5, 1}, {4, 7, 6, 3}, {1, 3, 4, 6}},
                                      {{0, 1, 2, 5}, {0, 2, 3, 7}, {4, 7, 5, 0}, {5, 7, 6, 2}, {0, 2, 7, 5}}};
    pli_vec3 points[POINTS];
    int tetras[LAYERS * 5][4];
    for (int i = 0; i < POINTS; ++i) {
        const int corner = i % 4;
        points[i] = pli_vec3_add(origin, pli_vec3_make(corner == 1 || corner == 2 ? 0.3f : 0.0f, 0.3f * (float)(i / 4),
                                                       corner >= 2 ? 0.3f : 0.0f));
    }
    for (int i = 0; i < LAYERS * 5; ++i) {
        for (int k = 0; k < 4; ++k) {
            tetras[i][k] = cube[i / 5 % 2][i % 5][k] + 4 * (i / 5);
        }
    }
    pli_mesh* mesh = NULL;
    TRIAL_CALL(t, pli_mesh_create_from_tetras(t->context, POINTS, points, LAYERS * 5, tetras[0], &mesh));
    return add_body(t, mesh, 0.03f, 3);
}

// ------------------------------------------------------------------------------------------------------- rigid bodies

/* Takes the shape. */
static pli_rigid* add_rigid(trial* t, pli_rigid_kind kind, pli_shape* shape, pli_vec3 origin) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.state.pose.origin = origin;
    def.state.inverse_mass = 2.0f;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], 50.0f);
    }
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    TRIAL_CALL(t, pli_rigid_create(t->world, &def, &rigid));
    pli_shape_release(shape);
    if (kind == PLI_RIGID_DYNAMIC) {
        assert_in_range(t->rigid_count, 0, TRIAL_MOST_RIGIDS - 1);
        t->rigids[t->rigid_count++] = rigid;
    }
    return rigid;
}

static pli_rigid* add_floor(trial* t, float y) {
    pli_shape* shape = NULL;
    TRIAL_CALL(t, pli_shape_create_plane(t->context, pli_vec3_make(0, 1, 0), 0, &shape));
    return add_rigid(t, PLI_RIGID_STATIC, shape, pli_vec3_make(0, y, 0));
}

static pli_rigid* add_box(trial* t, pli_rigid_kind kind, pli_vec3 half, pli_vec3 origin) {
    pli_shape* shape = NULL;
    TRIAL_CALL(t, pli_shape_create_box(t->context, half, &shape));
    return add_rigid(t, kind, shape, origin);
}

/* As a lattice of 0.25 m, as Bullet sees it. */
static pli_rigid* add_lattice_sphere(trial* t, float radius, pli_vec3 origin) {
    pli_shape *sphere = NULL, *shape = NULL;
    TRIAL_CALL(t, pli_shape_create_sphere(t->context, radius, &sphere));
    TRIAL_CALL(t, pli_shape_create_lattice(t->context, sphere, 0.25f, &shape));
    pli_shape_release(sphere);
    return add_rigid(t, PLI_RIGID_STATIC, shape, origin);
}

static pli_rigid* add_tent(trial* t, float y) {
    const pli_vec3 points[] = {{-2, -0.2f, -2}, {2, -0.2f, -2}, {2, -0.2f, 2}, {-2, -0.2f, 2}, {0, 0, 0}};
    const int triangles[] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0};
    pli_shape* shape = NULL;
    TRIAL_CALL(t, pli_shape_create_triangle_mesh(t->context, 5, points, 4, triangles, 0.3f, &shape));
    return add_rigid(t, PLI_RIGID_STATIC, shape, pli_vec3_make(0, y, 0));
}

static pli_rigid* add_hull(trial* t, pli_vec3 origin) {
    const pli_vec3 points[] = {{-0.3f, -0.2f, -0.3f}, {0.3f, -0.2f, -0.3f}, {0, -0.2f, 0.4f}, {0, 0.2f, 0}};
    pli_shape* shape = NULL;
    TRIAL_CALL(t, pli_shape_create_convex_hull(t->context, 4, points, 0.0f, &shape));
    return add_rigid(t, PLI_RIGID_DYNAMIC, shape, origin);
}

static void anchor(trial* t, pli_body* body, int node, pli_rigid* rigid) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = node;
    def.rigid = rigid;
    def.disable_collision = true;
    TRIAL_CALL(t, pli_body_add_anchor(body, &def, NULL));
}

// ----------------------------------------------------------------------------------------------------------- features

static void enable_rigid_contacts(trial* t, pli_body* body) {
    const pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
    TRIAL_CALL(t, pli_body_enable_rigid_contacts(body, &def));
}

static void enable_rigid_faces(trial* t, pli_body* body) {
    const pli_rigid_face_contacts_def def = pli_rigid_face_contacts_def_default();
    TRIAL_CALL(t, pli_body_enable_rigid_face_contacts(body, &def));
}

static void enable_soft_contacts(trial* t, pli_body* body, bool bullet_boxes) {
    pli_soft_contacts_def def = pli_soft_contacts_def_default();
    def.bullet_boxes = bullet_boxes;
    TRIAL_CALL(t, pli_body_enable_soft_contacts(body, &def));
}

static void enable_tethers(trial* t, pli_body* body) {
    const pli_tethers_def def = pli_tethers_def_default();
    TRIAL_CALL(t, pli_body_enable_tethers(body, &def));
}

static void enable_aero(trial* t, pli_body* body, pli_aero_model model) {
    pli_aero_def def = pli_aero_def_default();
    def.model = model;
    def.lift = def.drag = 0.01f;
    def.wind = pli_vec3_make(1, 0, 0);
    TRIAL_CALL(t, pli_body_enable_aero(body, &def));
}

static void enable_self_nodes(trial* t, pli_body* body, float thickness) {
    pli_self_collision_def def = pli_self_collision_def_default();
    def.thickness = thickness;
    TRIAL_CALL(t, pli_body_enable_self_collision(body, &def));
}

static void enable_self_faces(trial* t, pli_body* body, float thickness) {
    pli_self_faces_def def = pli_self_faces_def_default();
    def.thickness = thickness;
    TRIAL_CALL(t, pli_body_enable_self_faces(body, &def));
}

static void enable_self_grids(trial* t, pli_body* body, float distance) {
    pli_self_grids_def def = pli_self_grids_def_default();
    def.distance = distance;
    TRIAL_CALL(t, pli_body_enable_self_grids(body, &def));
}

static void enable_implicit(trial* t, pli_body* body, pli_implicit_method method) {
    pli_implicit_def def = pli_implicit_def_default();
    def.method = method;
    def.stiffness = 100.0f;
    TRIAL_CALL(t, pli_body_enable_implicit(body, &def));
}

static void enable_xpbd(trial* t, pli_body* body) {
    pli_xpbd_def def = pli_xpbd_def_default();
    def.substeps = 4;
    const pli_xpbd_links_def links = pli_xpbd_links_def_default();
    TRIAL_CALL(t, pli_body_enable_xpbd(body, &def));
    TRIAL_CALL(t, pli_body_enable_xpbd_links(body, &links));
}

static void enable_clusters(trial* t, pli_body* body, bool reference_mode, int count) {
    pli_clusters_def def = pli_clusters_def_default();
    def.reference_mode = reference_mode;
    TRIAL_CALL(t, pli_body_enable_clusters(body, &def));
    if (count > 0) { TRIAL_CALL(t, pli_body_generate_clusters(body, count, 20, NULL)); }
}

static void enable_cluster_contacts(trial* t, pli_body* body, bool with_self) {
    pli_cluster_contacts_def def = pli_cluster_contacts_def_default();
    def.with_self = with_self;
    TRIAL_CALL(t, pli_body_enable_cluster_contacts(body, &def));
}

// ------------------------------------------------------------------------------------------------------------ set-ups

static void run_plain_links(trial* t) {
    add_sheet(t, 6, 0.2f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_CORNERS);
    pli_body* rope = add_rope(t, 10, 1.0f, PLI_ROPE_PIN_FIRST);
    trial_steps(t, 3);
    TRIAL_CALL(t, pli_body_set_node_mass(rope, 3, 2.0f));
    TRIAL_CALL(t, pli_body_add_force(rope, pli_vec3_make(1, 0, 0)));
    trial_steps(t, 3);
    const pli_vec4 pinned = pli_body_get_view(rope).positions[0];
    TRIAL_CALL(t, pli_body_move_node(rope, 0, pli_vec3_make(pinned.x + 0.01f, pinned.y, pinned.z)));
    trial_steps(t, 2);
}

static void run_velocity_links(trial* t) {
    pli_body* sheet = add_sheet(t, 6, 0.2f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_CORNERS);
    pli_solver_settings settings = pli_body_get_solver_settings(sheet);
    settings.velocity_iterations = settings.drift_iterations = 2;
    settings.position_iterations = 0;
    TRIAL_CALL(t, pli_body_set_solver_settings(sheet, &settings));
    TRIAL_CALL(t, pli_body_enable_velocity_links(sheet));
    TRIAL_CALL(t, pli_body_enable_step_smoothing(sheet));
    trial_steps(t, 4);
    TRIAL_CALL(t, pli_body_disable_velocity_links(sheet));
    trial_steps(t, 2);
}

static void run_colored_sheet(trial* t) {
    add_floor(t, 0.9f);
    add_box(t, PLI_RIGID_DYNAMIC, pli_vec3_make(0.2f, 0.1f, 0.2f), pli_vec3_make(0.5f, 1.1f, 0));
    add_lattice_sphere(t, 0.5f, pli_vec3_make(-0.4f, 0.55f, 0));
    pli_body* sheet = add_sheet(t, 12, 0.15f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_00);
    pli_body* rope = add_rope(t, 20, 0.95f, PLI_ROPE_PIN_FIRST);
    TRIAL_CALL(t, pli_body_enable_colored_links(sheet));
    TRIAL_CALL(t, pli_body_enable_colored_links(rope));
    enable_rigid_contacts(t, sheet);
    enable_rigid_contacts(t, rope);
    trial_steps(t, 6);
    trial_steps(t, 3);
}

static pli_rigid* add_sampled_block(trial* t, pli_vec3 origin) {
    const pli_vec3 points[] = {{-0.2f, -0.1f, -0.2f}, {0.2f, -0.1f, -0.2f}, {0, -0.1f, 0.2f}, {0, 0.1f, 0}};
    const int triangles[] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
    pli_sampled_mesh_def def = pli_sampled_mesh_def_default();
    def.cell_size = 0.05f;
    pli_shape* shape = NULL;
    TRIAL_CALL(t, pli_shape_create_sampled_mesh(t->context, 4, points, 4, triangles, &def, &shape));
    return add_rigid(t, PLI_RIGID_STATIC, shape, origin);
}

static void run_shapes(trial* t) {
    pli_shape *capsule = NULL, *cylinder = NULL;
    TRIAL_CALL(t, pli_shape_create_capsule(t->context, pli_vec3_make(0.2f, 0, 0), 0.1f, &capsule));
    TRIAL_CALL(t, pli_shape_create_cylinder(t->context, pli_vec3_make(0, 0.1f, 0), 0.2f, &cylinder));
    pli_rigid* first = add_rigid(t, PLI_RIGID_DYNAMIC, capsule, pli_vec3_make(0.3f, 1.15f, 0.1f));
    add_rigid(t, PLI_RIGID_KINEMATIC, cylinder, pli_vec3_make(-0.3f, 0.9f, 0));
    add_sampled_block(t, pli_vec3_make(0, 0.92f, 0.3f));
    pli_body* sheet = add_sheet(t, 7, 0.2f, pli_vec3_make(0, 1, 0), 0);
    enable_rigid_contacts(t, sheet);
    trial_steps(t, 4);
    pli_shape* boxes[2] = {NULL, NULL};
    for (int i = 0; i < 2; ++i) {
        TRIAL_CALL(t, pli_shape_create_box(t->context, pli_vec3_make(0.2f, 0.1f, 0.1f), &boxes[i]));
    }
    TRIAL_CALL(t, pli_rigid_set_shapes(first, 2, boxes, NULL));
    pli_shape_release(boxes[0]);
    pli_shape_release(boxes[1]);
    trial_steps(t, 2);
    int crossings = 0;
    TRIAL_CALL(t, pli_body_count_crossings(sheet, &crossings));
}

static void run_rigid_faces(trial* t) {
    add_tent(t, 0.9f);
    add_hull(t, pli_vec3_make(0.1f, 1.25f, 0.1f));
    pli_body* sheet = add_sheet(t, 5, 0.4f, pli_vec3_make(0, 1, 0), 0);
    pli_body* rope = add_rope(t, 6, 0.9f, PLI_ROPE_PIN_FIRST);
    enable_rigid_faces(t, sheet);
    enable_rigid_faces(t, rope);
    TRIAL_CALL(t, pli_body_add_velocity(sheet, pli_vec3_make(0, -5, 0)));
    trial_steps(t, 6);
}

static void run_soft_contacts(trial* t) {
    for (int i = 0; i < 3; ++i) {
        pli_body* sheet = add_sheet(t, 6, 0.2f, pli_vec3_make(0.07f * (float)i, 1.0f + 0.1f * (float)i, 0.05f),
                                    i == 0 ? PLI_PATCH_PIN_CORNERS : 0);
        enable_soft_contacts(t, sheet, false);
        TRIAL_CALL(t, pli_body_add_velocity(sheet, pli_vec3_make(0, -(float)i, 0)));
    }
    trial_steps(t, 6);
}

static void run_soft_contacts_of_bullet(trial* t) {
    pli_body* sheets[2] = {add_sheet(t, 5, 0.2f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_CORNERS),
                           add_sheet(t, 5, 0.2f, pli_vec3_make(0.07f, 1.1f, 0.05f), 0)};
    enable_soft_contacts(t, sheets[0], true);
    enable_soft_contacts(t, sheets[1], true);
    trial_steps(t, 5);
}

static void run_clusters(trial* t) {
    add_floor(t, 0.0f);
    add_tent(t, 0.1f);
    pli_rigid* box = add_box(t, PLI_RIGID_DYNAMIC, pli_vec3_make(0.3f, 0.1f, 0.3f), pli_vec3_make(0.2f, 1.75f, 0));
    pli_body* balls[2] = {add_ball(t, pli_vec3_make(0, 0.5f, 0), 0.5f),
                          add_ball(t, pli_vec3_make(0.1f, 1.3f, 0), 0.5f)};
    for (int i = 0; i < 2; ++i) {
        enable_clusters(t, balls[i], false, 6);
        enable_cluster_contacts(t, balls[i], i == 0);
    }
    trial_steps(t, 3);
    pli_linear_joint_def linear = pli_linear_joint_def_default();
    linear.other = (pli_joint_end){.rigid = box};
    linear.position = pli_vec3_make(0.2f, 1.7f, 0);
    pli_joint_id joint;
    TRIAL_CALL(t, pli_body_add_linear_joint(balls[1], &linear, &joint));
    pli_angular_joint_def angular = pli_angular_joint_def_default();
    angular.other = (pli_joint_end){.body = balls[1]};
    angular.axis = pli_vec3_make(0, 0, 1);
    TRIAL_CALL(t, pli_body_add_angular_joint(balls[0], &angular, NULL));
    trial_steps(t, 4);
    TRIAL_CALL(t, pli_body_remove_joint(balls[1], joint));
    const int nodes[] = {0, 1, 2, 3, 20, 30};
    TRIAL_CALL(t, pli_body_add_cluster(balls[1], nodes, 6, NULL));
    trial_steps(t, 3);
}

static void run_clusters_of_bullet(trial* t) {
    add_box(t, PLI_RIGID_STATIC, pli_vec3_make(2, 0.5f, 2), pli_vec3_make(0, -0.5f, 0));
    pli_body* balls[2] = {add_ball(t, pli_vec3_make(0, 0.4f, 0), 0.5f),
                          add_ball(t, pli_vec3_make(0.1f, 1.2f, 0), 0.5f)};
    for (int i = 0; i < 2; ++i) {
        enable_clusters(t, balls[i], true, i == 0 ? 0 : 8);
        enable_cluster_contacts(t, balls[i], i == 1);
    }
    TRIAL_CALL(t, pli_body_generate_clusters_from_elements(balls[0], NULL));
    trial_steps(t, 5);
}

static void run_forces(trial* t) {
    pli_body* ball = add_ball(t, pli_vec3_make(0, 1, 0), 0.5f);
    TRIAL_CALL(t, pli_body_enable_pose_matching(ball, 0.2f));
    TRIAL_CALL(t, pli_body_enable_volume_conservation(ball, 1.0f));
    TRIAL_CALL(t, pli_body_enable_pressure(ball, 1.0f));
    enable_aero(t, ball, PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG);
    pli_body* sheet = add_sheet(t, 6, 0.2f, pli_vec3_make(0, 1, 2), PLI_PATCH_PIN_00);
    enable_aero(t, sheet, PLI_AERO_FACE_TWO_SIDED);
    trial_steps(t, 3);
    assert_int_equal(pli_body_disable_pressure(ball), PLI_OK);
    enable_aero(t, ball, PLI_AERO_FACE_ONE_SIDED);
    TRIAL_CALL(t, pli_body_add_node_force(sheet, 3, pli_vec3_make(0, 5, 0)));
    trial_steps(t, 3);
}

static void run_implicit(trial* t, pli_implicit_method method) {
    add_floor(t, 0.97f);
    pli_rigid* box = add_box(t, PLI_RIGID_DYNAMIC, pli_vec3_make(0.1f, 0.1f, 0.1f), pli_vec3_make(0.5f, 1.2f, 0.5f));
    pli_body* sheet = add_sheet(t, 6, 0.2f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_00);
    pli_body* other = add_sheet(t, 5, 0.15f, pli_vec3_make(0, 1.1f, 0), 0);
    enable_implicit(t, sheet, method);
    enable_implicit(t, other, method);
    enable_rigid_contacts(t, sheet);
    enable_rigid_contacts(t, other);
    enable_soft_contacts(t, sheet, false);
    enable_soft_contacts(t, other, false);
    anchor(t, sheet, 35, box);
    trial_steps(t, 4);
    anchor(t, sheet, 30, box);
    assert_int_equal(pli_body_set_frozen(other, true), PLI_OK);
    assert_int_equal(pli_body_set_frozen(other, false), PLI_OK);
    trial_steps(t, 4);
}
static void run_implicit_jacobi(trial* t) {
    run_implicit(t, PLI_IMPLICIT_JACOBI);
}
static void run_implicit_chebyshev(trial* t) {
    run_implicit(t, PLI_IMPLICIT_CHEBYSHEV);
}
static void run_implicit_gradients(trial* t) {
    run_implicit(t, PLI_IMPLICIT_CONJUGATE_GRADIENT);
}

static void run_xpbd(trial* t) {
    add_floor(t, 0.95f);
    pli_rigid* box = add_box(t, PLI_RIGID_DYNAMIC, pli_vec3_make(0.1f, 0.1f, 0.1f), pli_vec3_make(0.5f, 1.2f, 0.5f));
    pli_body* bodies[3] = {add_sheet(t, 6, 0.2f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_00),
                           add_ball(t, pli_vec3_make(0, 1.45f, 0), 0.4f), add_tetras(t, pli_vec3_make(1, 1, 0))};
    for (int i = 0; i < 3; ++i) {
        enable_xpbd(t, bodies[i]);
        enable_rigid_contacts(t, bodies[i]);
        enable_soft_contacts(t, bodies[i], false);
    }
    const pli_xpbd_bending_def bending = pli_xpbd_bending_def_default();
    TRIAL_CALL(t, pli_body_enable_xpbd_bending(bodies[0], &bending));
    TRIAL_CALL(t, pli_body_enable_xpbd_volume(bodies[1], NULL));
    TRIAL_CALL(t, pli_body_enable_xpbd_tetras(bodies[2], 1e-6f));
    enable_tethers(t, bodies[0]);
    trial_steps(t, 3);
    anchor(t, bodies[0], 35, box);
    trial_steps(t, 3);
    anchor(t, bodies[0], 30, box);
    trial_steps(t, 2);
}

/* From solver to solver and back, with the same contacts. */
static void run_solvers_in_turn(trial* t) {
    add_floor(t, 0.95f);
    pli_body* bodies[2] = {add_sheet(t, 6, 0.15f, pli_vec3_make(0, 1, 0), 0),
                           add_sheet(t, 6, 0.15f, pli_vec3_make(0.04f, 1.06f, 0.03f), 0)};
    for (int i = 0; i < 2; ++i) {
        enable_rigid_contacts(t, bodies[i]);
        enable_soft_contacts(t, bodies[i], false);
    }
    for (int round = 0; round < 2; ++round) {
        for (int i = 0; i < 2; ++i) {
            enable_xpbd(t, bodies[i]);
        }
        trial_steps(t, 3);
        for (int i = 0; i < 2; ++i) {
            TRIAL_CALL(t, pli_body_disable_xpbd(bodies[i]));
        }
        trial_steps(t, 2);
    }
}

typedef enum self_solver { SELF_POSITIONS, SELF_IMPLICIT, SELF_XPBD } self_solver;

static pli_body* add_self_fold(trial* t, self_solver solver) {
    pli_body* body = add_fold(t, 6, 0.1f, 0.05f);
    if (solver == SELF_IMPLICIT) { enable_implicit(t, body, PLI_IMPLICIT_JACOBI); }
    if (solver == SELF_XPBD) { enable_xpbd(t, body); }
    return body;
}

/* The velocities tear the fold about, so that searches do not serve for long. */
static void stir(trial* t, pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; i += 5) {
        const float side = i % 2 == 0 ? 1.0f : -1.0f;
        TRIAL_CALL(t, pli_body_set_node_velocity(body, i, pli_vec3_make(side, -side, 0.5f * side)));
    }
}

static void run_self_nodes(trial* t, self_solver solver) {
    pli_body* body = add_self_fold(t, solver);
    enable_self_nodes(t, body, 0.09f);
    trial_steps(t, 4);
    stir(t, body);
    trial_steps(t, 4);
}
static void run_self_nodes_positions(trial* t) {
    run_self_nodes(t, SELF_POSITIONS);
}
static void run_self_nodes_implicit(trial* t) {
    run_self_nodes(t, SELF_IMPLICIT);
}
static void run_self_nodes_xpbd(trial* t) {
    run_self_nodes(t, SELF_XPBD);
}

static void run_self_faces(trial* t, self_solver solver) {
    pli_body* body = add_self_fold(t, solver);
    enable_self_faces(t, body, 0.06f);
    trial_steps(t, 4);
    stir(t, body);
    trial_steps(t, 3);
}
static void run_self_faces_positions(trial* t) {
    run_self_faces(t, SELF_POSITIONS);
}
static void run_self_faces_implicit(trial* t) {
    run_self_faces(t, SELF_IMPLICIT);
}
static void run_self_faces_xpbd(trial* t) {
    run_self_faces(t, SELF_XPBD);
}

static void run_self_grids(trial* t) {
    for (int i = 0; i <= SELF_XPBD; ++i) {
        pli_body* body = add_self_fold(t, (self_solver)i);
        enable_self_grids(t, body, 0.09f);
    }
    trial_steps(t, 5);
}

static float wall_distance(pli_vec3 point, void* user) {
    (void)user;
    return point.x + 0.3f * point.z - 0.13f;
}

static void cut_first_link(trial* t, pli_body* body) {
    const int* link = pli_body_get_view(body).link_nodes;
    const int nodes[2] = {link[0], link[1]};
    TRIAL_CALL(t, pli_body_cut_link(body, nodes[0], nodes[1], 0.5f));
}

static void cut(trial* t, pli_body* body) {
    pli_refine_def refine = pli_refine_def_default();
    refine.surface = wall_distance;
    TRIAL_CALL(t, pli_body_refine(body, &refine));
    trial_steps(t, 2);
    cut_first_link(t, body);
    TRIAL_CALL(t, pli_body_tear(body, 0.1f, 4, NULL));
    trial_steps(t, 1);
    /* Goes on where the cut before ended. */
    const pli_vec3 blade[3][2] = {
        {{-0.2f, 2, -2}, {-0.2f, -2, -2}}, {{-0.25f, 2, 0}, {-0.25f, -2, 0}}, {{-0.1f, 2, 2}, {-0.1f, -2, 2}}};
    for (int i = 0; i < 2; ++i) {
        TRIAL_CALL(t, pli_body_cut_swept(body, blade[i][0], blade[i][1], blade[i + 1][0], blade[i + 1][1], NULL));
    }
    trial_steps(t, 2);
}

enum { CUT_NODES = 10 };

static pli_body* add_cut_sheet(trial* t, int nodes, bool with_bending) {
    add_floor(t, 0.9f);
    pli_mesh* mesh = make_sheet(t, nodes, 1.0f / (float)(nodes - 1), pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_00);
    /* With so many materials colours are not searched for at length. */
    const pli_material material = {0.9f};
    for (int i = 0; i < 4; ++i) {
        TRIAL_CALL(t, pli_mesh_append_material(mesh, &material, NULL));
    }
    if (with_bending) { TRIAL_CALL(t, pli_mesh_append_bending_links(mesh, 2, 4, NULL)); }
    pli_body* body = add_body(t, mesh, 0.05f, 3);
    pli_body* other = add_sheet(t, 4, 0.15f, pli_vec3_make(0.04f, 1.06f, 0.03f), 0);
    enable_soft_contacts(t, other, false);
    enable_soft_contacts(t, body, false);
    enable_rigid_contacts(t, body);
    return body;
}

static void run_cuts(trial* t) {
    pli_body* body = add_cut_sheet(t, CUT_NODES, true);
    pli_rigid* box = add_box(t, PLI_RIGID_DYNAMIC, pli_vec3_make(0.1f, 0.1f, 0.1f), pli_vec3_make(0.5f, 1.2f, 0.5f));
    TRIAL_CALL(t, pli_body_enable_colored_links(body));
    TRIAL_CALL(t, pli_body_enable_step_smoothing(body));
    TRIAL_CALL(t, pli_body_enable_pose_matching(body, 0.1f));
    enable_aero(t, body, PLI_AERO_VERTEX_TWO_SIDED);
    enable_tethers(t, body);
    anchor(t, body, CUT_NODES * CUT_NODES - 1, box);
    trial_steps(t, 2);
    cut(t, body);
}

static void run_cuts_with_self_collision(trial* t) {
    pli_body* body = add_cut_sheet(t, 6, false);
    enable_rigid_faces(t, body);
    enable_self_nodes(t, body, 0.03f);
    enable_self_grids(t, body, 0.02f);
    enable_self_faces(t, body, 0.02f);
    trial_steps(t, 1);
    cut(t, body);
}

static void run_cuts_of_clusters(trial* t) {
    pli_body* body = add_cut_sheet(t, 6, false);
    enable_clusters(t, body, false, 5);
    enable_cluster_contacts(t, body, true);
    TRIAL_CALL(t, pli_body_enable_volume_conservation(body, 0.1f));
    trial_steps(t, 2);
    cut(t, body);
}

static void run_cuts_under_xpbd(trial* t) {
    pli_body* body = add_cut_sheet(t, CUT_NODES, true);
    enable_xpbd(t, body);
    const pli_xpbd_bending_def bending = pli_xpbd_bending_def_default();
    TRIAL_CALL(t, pli_body_enable_xpbd_bending(body, &bending));
    pli_xpbd_volume_def volume = pli_xpbd_volume_def_default();
    volume.compliance = 1.0f;
    TRIAL_CALL(t, pli_body_enable_xpbd_volume(body, &volume));
    enable_tethers(t, body);
    trial_steps(t, 2);
    cut(t, body);
}

static void run_cuts_under_implicit(trial* t) {
    pli_body* body = add_cut_sheet(t, 6, false);
    enable_implicit(t, body, PLI_IMPLICIT_CONJUGATE_GRADIENT);
    trial_steps(t, 2);
    cut(t, body);
}

static void run_tethers_and_anchors(trial* t) {
    pli_rigid* boxes[3];
    for (int i = 0; i < 3; ++i) {
        boxes[i] = add_box(t, i == 0 ? PLI_RIGID_KINEMATIC : PLI_RIGID_DYNAMIC, pli_vec3_make(0.1f, 0.1f, 0.1f),
                           pli_vec3_make(0.5f * (float)i, 1.1f, 0.2f));
    }
    pli_body* rope = add_rope(t, 12, 1.0f, PLI_ROPE_PIN_FIRST);
    pli_body* sheet = add_sheet(t, 6, 0.2f, pli_vec3_make(0, 1, 2), PLI_PATCH_PIN_00);
    enable_rigid_contacts(t, rope);
    enable_rigid_contacts(t, sheet);
    enable_tethers(t, rope);
    enable_tethers(t, sheet);
    anchor(t, rope, 13, boxes[1]);
    trial_steps(t, 2);
    anchor(t, rope, 6, boxes[2]);
    anchor(t, sheet, 35, boxes[0]);
    TRIAL_CALL(t, pli_body_set_anchor_hardness(sheet, 0.5f));
    trial_steps(t, 2);
    pli_rigid_destroy(boxes[1]);
    t->rigids[0] = t->rigids[1];
    t->rigid_count = 1;
    trial_steps(t, 2);
}

static void run_many_bodies(trial* t) {
    pli_body* bodies[12];
    add_floor(t, 0.9f);
    for (int i = 0; i < 12; ++i) {
        bodies[i] = add_sheet(t, 3, 0.1f, pli_vec3_make(0.02f * (float)i, 0.95f + 0.05f * (float)i, 0), 0);
        enable_rigid_contacts(t, bodies[i]);
        enable_soft_contacts(t, bodies[i], false);
        if (i % 4 == 3) { trial_steps(t, 1); }
    }
    for (int i = 0; i < 12; i += 2) {
        pli_body_destroy(bodies[i]);
        bodies[i] = add_rope(t, 3 + i, 1.0f + 0.1f * (float)i, 0);
        TRIAL_CALL(t, pli_body_enable_colored_links(bodies[i]));
        if (i % 4 == 2) { trial_steps(t, 1); }
    }
}

static void run_large_grid(trial* t) {
    pli_body* body = add_sheet(t, 70, 0.02f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_00 | PLI_PATCH_PIN_01);
    pli_body* other = add_sheet(t, 66, 0.02f, pli_vec3_make(0, 2, 0), PLI_PATCH_PIN_00);
    TRIAL_CALL(t, pli_body_enable_colored_links(body));
    enable_xpbd(t, other);
    trial_steps(t, 2);
    cut_first_link(t, body);
    cut_first_link(t, other);
    trial_steps(t, 2);
}

static const trial_setup setups[] = {
    {"plain links", run_plain_links, false},
    {"velocity links", run_velocity_links, true},
    {"coloured sheet, rigid contacts", run_colored_sheet, true},
    {"shapes", run_shapes, true},
    {"rigid faces", run_rigid_faces, true},
    {"soft contacts", run_soft_contacts, true},
    {"soft contacts of Bullet", run_soft_contacts_of_bullet, false},
    {"clusters, contacts, joints", run_clusters, false},
    {"clusters of Bullet", run_clusters_of_bullet, false},
    {"pose, volume, pressure, air", run_forces, false},
    {"implicit, Jacobi", run_implicit_jacobi, true},
    {"implicit, Chebyshev", run_implicit_chebyshev, true},
    {"implicit, gradients", run_implicit_gradients, true},
    {"XPBD", run_xpbd, false},
    {"solvers in turn", run_solvers_in_turn, true},
    {"self-collision of nodes", run_self_nodes_positions, false},
    {"self nodes, implicit", run_self_nodes_implicit, false},
    {"self nodes, XPBD", run_self_nodes_xpbd, false},
    {"self-collision of faces", run_self_faces_positions, false},
    {"self faces, implicit", run_self_faces_implicit, false},
    {"self faces, XPBD", run_self_faces_xpbd, false},
    {"self-collision by grids", run_self_grids, false},
    {"cuts", run_cuts, true},
    {"cuts with self-collision", run_cuts_with_self_collision, true},
    {"cuts of clusters", run_cuts_of_clusters, true},
    {"cuts, XPBD", run_cuts_under_xpbd, true},
    {"cuts, implicit", run_cuts_under_implicit, true},
    {"tethers, anchors", run_tethers_and_anchors, false},
    {"bodies come and go", run_many_bodies, true},
    {"large grid", run_large_grid, false},
};

/* With all of them once more: 40 s. */
static bool tries_all(void) {
    return getenv("PLIANT_ALL_ALLOCATIONS") != NULL;
}

/* Of the allocations in steps and in calls, each so many-th fails; different ones in each set-up. */
static trial_strides strides_of(size_t setup) {
    if (tries_all()) { return (trial_strides){1, 1, 0}; }
#ifdef NDEBUG
    return (trial_strides){5, 31, (long)setup};
#else
    return (trial_strides){37, 151, (long)setup};
#endif
}

static void nothing_fails_in_silence(void** state) {
    (void)state;
    long places = 0, in_steps = 0, reported = 0;
    for (size_t i = 0; i < sizeof setups / sizeof *setups; ++i) {
        for (int room = 0; room < 2; ++room) {
            const trial_counts counts = trial_run_all(&setups[i], room != 0, strides_of(2 * i + (size_t)room));
            if (tries_all()) {
                print_message("%-32s %s: %4ld allocations, %4ld in steps; %4ld of %4ld failures reported by a step, "
                              "%ld not made\n",
                              setups[i].name, room != 0 ? "with room" : "no room  ", counts.places, counts.in_steps,
                              counts.reported, counts.runs, counts.not_made);
            }
            places += counts.places;
            in_steps += counts.in_steps;
            reported += counts.reported;
            assert_true(!tries_all() || counts.in_steps == 0 || counts.reported > 0);
            assert_true(!tries_all() || 2 * counts.not_made <= counts.runs); /* a fifth was seen */
        }
    }
    print_message("%ld allocations, %ld of them in steps; steps reported %ld failures\n", places, in_steps, reported);
    assert_true(reported > 50);
}

// ------------------------------------------------------------------------------------------------- what a step tells

/* Two sheets that fall on a floor, without room made ahead; the step that is the first with contacts comes next. */
typedef struct landing {
    trial t;
    pli_rigid* floor;
    pli_body* sheets[2];
} landing;

static void landing_begin(landing* l, bool with_contacts) {
    *l = (landing){.t = {.name = "landing"}};
    l->t.context = failing_context(&l->t.allocator);
    pli_world_def def = pli_world_def_default();
    def.preallocates = false;
    assert_int_equal(pli_world_create(l->t.context, &def, &l->t.world), PLI_OK);
    l->floor = add_floor(&l->t, 0.9f);
    for (int i = 0; i < 2; ++i) {
        l->sheets[i] = add_sheet(&l->t, 4, 0.2f, pli_vec3_make(2.0f * (float)i, 0.9605f, 0), 0);
        if (with_contacts || i > 0) { enable_rigid_contacts(&l->t, l->sheets[i]); }
    }
}

static void landing_end(landing* l) {
    pli_world_destroy(l->t.world);
    pli_context_destroy(l->t.context);
    assert_int_equal(l->t.allocator.alive, 0);
}

static uint64_t landing_hash(const landing* l, int sheet) {
    return pli_body_state_hash(l->sheets[sheet]);
}

static void check_told(const landing* l, pli_status status, const char* message) {
    assert_int_equal(status, PLI_ERROR_OUT_OF_MEMORY);
    if (strstr(pli_last_error(l->t.context), message) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", pli_last_error(l->t.context), message);
    }
}

static const float dt = 1.0f / 60.0f;

static void a_body_without_room_for_contacts_is_stepped_without_them_and_others_with_theirs(void** state) {
    (void)state;
    landing landed, free_one, short_one;
    landing_begin(&landed, true);
    assert_int_equal(pli_world_step(landed.t.world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(landed.sheets[0], 0, NULL), 16);
    landing_begin(&free_one, false);
    assert_int_equal(pli_world_step(free_one.t.world, dt), PLI_OK);
    assert_true(landing_hash(&landed, 0) != landing_hash(&free_one, 0));

    landing_begin(&short_one, true);
    short_one.t.allocator.fail_at = 1;
    check_told(&short_one, pli_world_step(short_one.t.world, dt), "pli_world_step: no memory, ");
    check_told(&short_one, PLI_ERROR_OUT_OF_MEMORY, "for rigid contacts of body 0;");
    assert_true(landing_hash(&short_one, 0) == landing_hash(&free_one, 0));
    assert_true(landing_hash(&short_one, 1) == landing_hash(&landed, 1));
    assert_int_equal(pli_world_step(short_one.t.world, dt), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(short_one.sheets[0], 0, NULL), 16);
    landing_end(&landed);
    landing_end(&free_one);
    landing_end(&short_one);
}

static void a_collide_call_tells_of_its_pair_and_the_solve_of_the_step(void** state) {
    (void)state;
    landing l;
    landing_begin(&l, true);
    assert_int_equal(pli_world_predict(l.t.world, dt), PLI_OK);
    assert_int_equal(pli_world_collide_rigid(l.t.world, l.sheets[0], l.floor), PLI_OK);
    l.t.allocator.fail_at = 1;
    check_told(&l, pli_world_collide_rigid(l.t.world, l.sheets[1], l.floor), "pli_world_collide_rigid: no memory");
    assert_int_equal(pli_body_get_rigid_contacts(l.sheets[0], 0, NULL), 16);
    assert_int_equal(pli_body_get_rigid_contacts(l.sheets[1], 0, NULL), 0);
    /* A host may ask again. */
    assert_int_equal(pli_world_collide_rigid(l.t.world, l.sheets[1], l.floor), PLI_OK);
    assert_int_equal(pli_body_get_rigid_contacts(l.sheets[1], 0, NULL), 16);
    const int order[16] = {15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0};
    pli_rigid_contact contact;
    for (int place = 1; place <= 2; ++place) {
        l.t.allocator.fail_at = place;
        check_told(&l, pli_body_reorder_rigid_contacts(l.sheets[1], order, 16), "no memory to reorder 16 contacts");
        assert_int_equal(pli_body_get_rigid_contacts(l.sheets[1], 1, &contact), 16);
        assert_int_equal(contact.node, 0);
    }
    l.t.allocator.fail_at = 0;
    check_told(&l, pli_world_solve(l.t.world), "pli_world_solve: no memory");
    check_told(&l, PLI_ERROR_OUT_OF_MEMORY, "for rigid contacts of body 1;");
    assert_false(pli_world_is_stepping(l.t.world));
    assert_int_equal(pli_world_step(l.t.world, dt), PLI_OK);
    landing_end(&l);
}

static void the_solve_tells_what_the_prediction_had_no_memory_for(void** state) {
    (void)state;
    landing l;
    landing_begin(&l, false);
    enable_clusters(&l.t, l.sheets[0], false, 2);
    enable_cluster_contacts(&l.t, l.sheets[0], false);
    add_box(&l.t, PLI_RIGID_STATIC, pli_vec3_make(1, 0.5f, 1), pli_vec3_make(0, 0.46f, 0));
    /* What the prediction of the next step makes a table of: the pairs of clusters and box. */
    assert_int_equal(pli_world_step(l.t.world, dt), PLI_OK);
    l.t.allocator.fail_at = 1;
    assert_int_equal(pli_world_predict(l.t.world, dt), PLI_OK);
    assert_int_equal(l.t.allocator.failed, 1);
    assert_true(pli_world_is_stepping(l.t.world));
    check_told(&l, pli_world_solve(l.t.world), "for cluster contacts of body 0;");
    assert_int_equal(pli_world_step(l.t.world, dt), PLI_OK);
    landing_end(&l);
}

static void room_that_there_was_no_memory_for_is_made_later(void** state) {
    (void)state;
    landing l;
    landing_begin(&l, true);
    pli_world_destroy(l.t.world);
    assert_int_equal(pli_world_create(l.t.context, NULL, &l.t.world), PLI_OK);
    add_floor(&l.t, 0.0f);
    pli_body* sheet = add_sheet(&l.t, 4, 0.2f, pli_vec3_make(0, 1, 0), 0);
    enable_rigid_contacts(&l.t, sheet);
    l.t.allocator.fail_at = 1;
    assert_int_equal(pli_world_step(l.t.world, dt), PLI_OK);
    assert_int_equal(l.t.allocator.failed, 1);
    assert_int_equal(pli_world_step(l.t.world, dt), PLI_OK);
    const long calls = l.t.allocator.calls;
    for (int i = 0; i < 60; ++i) {
        assert_int_equal(pli_world_step(l.t.world, dt), PLI_OK);
    }
    assert_true(pli_body_get_rigid_contacts(sheet, 0, NULL) > 0);
    assert_int_equal(l.t.allocator.calls, calls);
    landing_end(&l);
}

// ------------------------------------------------------------------------------------------------------------ colours

typedef enum link_order { ORDERED, COLORED, COLORED_WITHOUT_MEMORY } link_order;

/* After the first step after a cut. */
static uint64_t hash_of_a_cut_sheet(link_order order) {
    trial t = {.name = "cloth"};
    t.context = failing_context(&t.allocator);
    assert_int_equal(pli_world_create(t.context, NULL, &t.world), PLI_OK);
    pli_body* body = add_body(&t, make_sheet(&t, 20, 0.02f, pli_vec3_make(0, 1, 0), PLI_PATCH_PIN_00), 0.01f, 2);
    if (order != ORDERED) { assert_int_equal(pli_body_enable_colored_links(body), PLI_OK); }
    assert_int_equal(pli_body_cut_link(body, 100, 101, 0.5f), PLI_OK);
    const bool fails = order == COLORED_WITHOUT_MEMORY;
    t.allocator.fails_for_good = true;
    t.allocator.fail_at = fails ? 1 : 0;
    assert_int_equal(pli_world_step(t.world, dt), fails ? PLI_ERROR_OUT_OF_MEMORY : PLI_OK);
    if (fails) { assert_non_null(strstr(pli_last_error(t.context), "colored links")); }
    t.allocator.fail_at = 0;
    const uint64_t hash = pli_body_state_hash(body);
    assert_int_equal(pli_world_step(t.world, dt), PLI_OK);
    const long calls = t.allocator.calls;
    assert_int_equal(pli_world_step(t.world, dt), PLI_OK);
    assert_int_equal(t.allocator.calls, calls);
    pli_world_destroy(t.world);
    pli_context_destroy(t.context);
    assert_int_equal(t.allocator.alive, 0);
    return hash;
}

static void links_keep_their_order_until_there_is_memory_for_colors(void** state) {
    (void)state;
    const uint64_t ordered = hash_of_a_cut_sheet(ORDERED);
    assert_true(hash_of_a_cut_sheet(COLORED) != ordered);
    assert_true(hash_of_a_cut_sheet(COLORED_WITHOUT_MEMORY) == ordered);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_fails_in_silence),
        cmocka_unit_test(a_body_without_room_for_contacts_is_stepped_without_them_and_others_with_theirs),
        cmocka_unit_test(a_collide_call_tells_of_its_pair_and_the_solve_of_the_step),
        cmocka_unit_test(the_solve_tells_what_the_prediction_had_no_memory_for),
        cmocka_unit_test(room_that_there_was_no_memory_for_is_made_later),
        cmocka_unit_test(links_keep_their_order_until_there_is_memory_for_colors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
