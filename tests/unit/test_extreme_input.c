/* Finite numbers of any size, over all calls that make, change and step something: what they leave is finite, whether
   they are accepted or refused. PLIANT_EXTREME_CASES in the environment sets the number of cases, PLIANT_EXTREME_FIRST
   the first one. */

#include "check.h"

#include <pliant/bullet_reference.h>
#include <pliant/pliant.h>

#include <float.h>
#include <stdio.h>
#include <stdlib.h>

enum { DEFAULT_CASES = 500, MAX_BODIES = 2, MAX_RIGIDS = 2 };

static uint64_t seed;
static float wildness; /* share of extreme numbers in this case */
static unsigned long accepted, refused, events_seen;

static pli_context* context;
static pli_world* world;
static pli_body* bodies[MAX_BODIES];
static pli_rigid* rigids[MAX_RIGIDS];
static int body_count, rigid_count, case_number;

// ------------------------------------------------------------------------------------------------------- numbers

static uint32_t random_bits(void) {
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(seed >> 32);
}
static int random_below(int count) {
    return (int)((uint64_t)random_bits() * (uint64_t)count >> 32);
}
static float random_share(void) {
    return (float)(random_bits() >> 8) / 16777216.0f;
}
static bool chance(float share) {
    return random_share() < share;
}

/* Log-uniform, of powers of ten. */
static float random_size(float low, float high) {
    return powf(10.0f, low + (high - low) * random_share());
}

static float extreme_size(void) {
    static const float borders[] = {0.0f,
                                    1e-45f,
                                    FLT_MIN,
                                    FLT_EPSILON,
                                    FLT_MAX,
                                    1.0f,
                                    PLI_MAX_COORDINATE,
                                    PLI_MAX_SPEED,
                                    PLI_MAX_ANGULAR_SPEED,
                                    PLI_MIN_MASS,
                                    PLI_MAX_MASS,
                                    PLI_MAX_INVERSE_INERTIA,
                                    PLI_MIN_TIME_STEP,
                                    PLI_MAX_TIME_STEP,
                                    PLI_MIN_TIME_SCALE,
                                    PLI_MAX_ACCELERATION,
                                    PLI_MAX_FORCE,
                                    PLI_MAX_COEFFICIENT,
                                    PLI_MAX_FACTOR,
                                    PLI_MIN_STIFFNESS};
    switch (random_below(4)) {
    case 0:
        return borders[random_below(sizeof borders / sizeof *borders)];
    case 1:
        return fminf(random_size(-38.0f, 38.5f), FLT_MAX);
    case 2:
        return random_size(-9.0f, 12.0f);
    default:
        return random_size(-6.0f, 6.0f);
    }
}

/* As a caller would give it, or extreme. */
static float number(float usual) {
    if (!chance(wildness)) { return usual * (0.5f + random_share()); }
    return chance(0.3f) ? -extreme_size() : extreme_size();
}
static float positive(float usual) {
    return fabsf(number(usual));
}
static float share(float usual) {
    return chance(wildness) ? (chance(0.5f) ? random_share() : extreme_size()) : usual;
}
static pli_vec3 vector(float usual) {
    const float x = number(usual), y = number(usual), z = number(usual);
    const float s = chance(0.5f) ? -1.0f : 1.0f, t = chance(0.5f) ? -1.0f : 1.0f;
    return pli_vec3_make(s * x, t * y, z);
}
static pli_quat turn(void) {
    return (pli_quat){random_share() - 0.5f, random_share() - 0.5f, random_share() - 0.5f, 0.1f + random_share()};
}
static pli_transform pose(float usual) {
    pli_transform made = pli_transform_make(turn(), vector(usual));
    if (chance(0.3f * wildness)) { made.rotation.rows[random_below(3)] = vector(1); }
    return made;
}

// ------------------------------------------------------------------------------------------------------- checks

static bool is_finite3(pli_vec3 v) {
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}
static bool are_finite(const pli_vec4* records, int count) {
    for (int i = 0; i < count; ++i) {
        if (!isfinite(records[i].x) || !isfinite(records[i].y) || !isfinite(records[i].z) || !isfinite(records[i].w)) {
            return false;
        }
    }
    return true;
}
static bool rigid_is_finite(const pli_rigid* rigid) {
    const pli_rigid_state s = pli_rigid_get_state(rigid);
    bool is_finite = is_finite3(s.pose.origin) && is_finite3(s.linear_velocity) && is_finite3(s.angular_velocity) &&
                     isfinite(s.inverse_mass);
    for (int i = 0; i < 3; ++i) {
        is_finite = is_finite && is_finite3(s.pose.rotation.rows[i]) && is_finite3(s.inverse_inertia_world.rows[i]);
    }
    return is_finite;
}

static void check_states(const char* call) {
    for (int i = 0; i < body_count; ++i) {
        const pli_body_view view = pli_body_get_view(bodies[i]);
        if (!are_finite(view.positions, view.node_count) || !are_finite(view.velocities, view.node_count) ||
            !are_finite(view.previous, view.node_count)) {
            fail_msg("case %d: body %d is not finite after %s", case_number, i, call);
        }
    }
    for (int i = 0; i < rigid_count; ++i) {
        if (!rigid_is_finite(rigids[i])) {
            fail_msg("case %d: rigid body %d is not finite after %s", case_number, i, call);
        }
    }
}

static pli_status checked(pli_status status, const char* call) {
    *(status == PLI_OK ? &accepted : &refused) += 1;
    if (status != PLI_OK && status != PLI_ERROR_NULL_ARGUMENT && pli_last_error(context)[0] == '\0') {
        fail_msg("case %d: %s is refused without a message", case_number, call);
    }
    check_states(call);
    return status;
}
#define TRY(call) checked(call, #call)

// ------------------------------------------------------------------------------------------------------- rigid bodies

/* A ball that reports what nobody would. */
static void odd_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                          pli_vec3* normals) {
    (void)max_distance;
    for (int i = 0; i < count; ++i) {
        const float length = pli_vec3_length(points[i]);
        distances[i] = (length - 1.0f) * *(const float*)user;
        normals[i] = pli_vec3_scale(points[i], 1.0f / (length + 1e-3f));
    }
}
static pli_bounds odd_bounds(const void* user) {
    const float r = *(const float*)user;
    return (pli_bounds){{-r, -r, -r}, {r, r, r}};
}

static float odd_factor;

static float largest_coordinate(int count, const pli_vec3* points) {
    float largest = 0.0f;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = points[i];
        largest = fmaxf(largest, fmaxf(fabsf(p.x), fmaxf(fabsf(p.y), fabsf(p.z))));
    }
    return largest;
}

static pli_status make_shape(pli_shape** shape) {
    static const int tetra[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    pli_vec3 points[8];
    for (int i = 0; i < 8; ++i) {
        points[i] = vector(1);
    }
    const int kind = random_below(10);
    if (kind == 0) { return pli_shape_create_plane(context, vector(1), number(1), shape); }
    if (kind == 1) { return pli_shape_create_sphere(context, number(1), shape); }
    if (kind == 2) { return pli_shape_create_box(context, vector(1), shape); }
    if (kind == 3) { return pli_shape_create_capsule(context, vector(1), number(0.5f), shape); }
    if (kind == 4) { return pli_shape_create_cylinder(context, vector(1), number(0.5f), shape); }
    if (kind == 5) { return pli_shape_create_convex_hull(context, 8, points, positive(0.1f), shape); }
    if (kind == 6) { return pli_shape_create_triangle_mesh(context, 4, points, 4, tetra, number(0.1f), shape); }
    if (kind == 7) {
        pli_sampled_mesh_def def = pli_sampled_mesh_def_default();
        def.cell_size = number(0.5f);
        def.padding = number(0.5f);
        /* Large grids are allowed, and take long; still smaller cells are refused. */
        const double extent = (double)largest_coordinate(4, points) + fabs((double)def.padding);
        const double cells = def.cell_size > 0.0f ? 2.0 * extent / (double)def.cell_size : 64.0;
        if (cells > 16.0 && cells < 1e7) { def.cell_size = def.padding = (float)(extent / 6.0); }
        return pli_shape_create_sampled_mesh(context, 4, points, 4, tetra, &def, shape);
    }
    if (kind == 8) {
        odd_factor = number(1);
        pli_shape_def def = pli_shape_def_default();
        def.user = &odd_factor;
        def.distances = odd_distances;
        def.bounds = odd_bounds;
        def.radius = chance(0.5f) ? 0.0f : number(0.1f);
        return pli_shape_create(context, &def, shape);
    }
    pli_shape* source = NULL;
    pli_status status = pli_shape_create_sphere(context, positive(1), &source);
    if (status == PLI_OK) { status = pli_shape_create_lattice(context, source, number(0.25f), shape); }
    pli_shape_release(source);
    return status;
}

static pli_rigid_state rigid_state(void) {
    pli_rigid_state state = {.pose = chance(wildness) ? pose(1) : pli_transform_make(turn(), vector(1))};
    state.linear_velocity = vector(1);
    state.angular_velocity = vector(1);
    state.inverse_mass = number(1);
    for (int i = 0; i < 3; ++i) {
        float* row = &state.inverse_inertia_world.rows[i].x;
        row[i] = number(2);
    }
    if (chance(0.2f * wildness)) { state.inverse_inertia_world.rows[random_below(3)] = vector(1); }
    return state;
}

static void make_rigid(void) {
    pli_shape* shapes[2] = {NULL, NULL};
    int count = 0;
    while (count < 1 + random_below(2) && TRY(make_shape(&shapes[count])) == PLI_OK) {
        ++count;
    }
    const pli_transform poses[2] = {pose(0.3f), pose(0.3f)};
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = (pli_rigid_kind)random_below(3);
    def.state = rigid_state();
    def.friction = number(0.5f);
    if (chance(0.3f)) { def.linear_factor = vector(1); }
    if (chance(0.3f)) { def.angular_factor = vector(1); }
    def.shape_count = count;
    def.shapes = shapes;
    def.shape_poses = chance(0.5f) ? poses : NULL;
    if (TRY(pli_rigid_create(world, &def, &rigids[rigid_count])) == PLI_OK) { ++rigid_count; }
    for (int i = 0; i < count; ++i) {
        pli_shape_release(shapes[i]);
    }
}

static void change_rigid(pli_rigid* rigid) {
    const pli_rigid_state state = rigid_state();
    switch (random_below(5)) {
    case 0:
        TRY(pli_rigid_set_state(rigid, &state));
        break;
    case 1:
        TRY(pli_rigid_set_friction(rigid, number(0.5f)));
        break;
    case 2:
        TRY(pli_rigid_set_factors(rigid, vector(1), vector(1)));
        break;
    case 3:
        TRY(pli_rigid_set_kind(rigid, (pli_rigid_kind)random_below(3), &state));
        break;
    default:
        TRY(pli_rigid_integrate(rigid, vector(10), number(1.0f / 60.0f)));
        break;
    }
}

// ------------------------------------------------------------------------------------------------------- meshes

static void check_mesh(const pli_mesh* mesh, const char* call) {
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    for (int i = 0; i < view.node_count; ++i) {
        if (!is_finite3(view.positions[i]) || !isfinite(view.inverse_masses[i])) {
            fail_msg("case %d: node %d of a mesh is not finite after %s", case_number, i, call);
        }
    }
}
#define TRY_MESH(call) (checked(call, #call), check_mesh(mesh, #call))

static pli_status make_mesh(pli_mesh** mesh) {
    static const int tetras[8] = {0, 1, 2, 3, 1, 2, 3, 4}, triangles[9] = {0, 1, 2, 2, 1, 3, 3, 4, 2};
    pli_vec3 points[12];
    for (int i = 0; i < 12; ++i) {
        points[i] = vector(1);
    }
    switch (random_below(6)) {
    case 0:
        return pli_mesh_create_rope(context, vector(1), vector(1), 2 + random_below(18), random_below(4), mesh);
    case 1:
        return pli_mesh_create_ellipsoid(context, vector(0.3f), vector(1), 4 + random_below(16), mesh);
    case 2:
        return pli_mesh_create_convex_hull(context, 12, points, share(0), mesh);
    case 3:
        return pli_mesh_create_from_triangles(context, 5, points, 3, triangles, true, mesh);
    case 4:
        return pli_mesh_create_from_tetras(context, 5, points, 2, tetras, mesh);
    default:
        break;
    }
    pli_patch_def def = pli_patch_def_default();
    const float y = number(0.2f), size = positive(1);
    def.corner_00 = pli_vec3_make(-size, y, -size);
    def.corner_10 = pli_vec3_make(size, y, -size);
    def.corner_01 = pli_vec3_make(-size, y, size);
    def.corner_11 = pli_vec3_make(size, y, size);
    if (chance(wildness)) { def.corner_10 = vector(1); }
    def.columns = 2 + random_below(5);
    def.rows = 2 + random_below(5);
    def.pins = random_below(4);
    return chance(0.5f) ? pli_mesh_create_patch(context, &def, mesh)
                        : pli_mesh_create_patch_uv(context, &def, NULL, mesh);
}

static void change_mesh(pli_mesh* mesh) {
    const pli_material material = {share(1)};
    const int node = random_below(pli_mesh_get_view(mesh).node_count);
    switch (random_below(14)) {
    case 0:
        TRY_MESH(pli_mesh_transform(mesh, pose(0.1f)));
        break;
    case 1:
        TRY_MESH(pli_mesh_translate(mesh, vector(0.1f)));
        break;
    case 2:
        TRY_MESH(pli_mesh_scale(mesh, vector(1)));
        break;
    case 3:
        TRY_MESH(pli_mesh_rotate(mesh, (pli_quat){number(1), number(1), number(1), number(1)}));
        break;
    case 4:
        TRY_MESH(pli_mesh_set_total_mass(mesh, number(1)));
        break;
    case 5:
        TRY_MESH(pli_mesh_set_total_mass_from_faces(mesh, number(1)));
        break;
    case 6:
        TRY_MESH(pli_mesh_set_total_mass_from_tetras(mesh, number(1)));
        break;
    case 7:
        TRY_MESH(pli_mesh_set_density_from_faces(mesh, number(1)));
        break;
    case 8:
        TRY_MESH(pli_mesh_set_density_from_tetras(mesh, number(1)));
        break;
    case 9:
        TRY_MESH(pli_mesh_set_node_mass(mesh, node, number(0.1f)));
        break;
    case 10:
        TRY_MESH(pli_mesh_set_node_position(mesh, node, vector(1)));
        break;
    case 11:
        TRY_MESH(pli_mesh_append_node(mesh, vector(1), number(0.1f), NULL));
        break;
    case 12:
        TRY_MESH(pli_mesh_set_material(mesh, 0, &material));
        break;
    default:
        TRY_MESH(pli_mesh_append_bending_links(mesh, 2, 0, NULL));
        break;
    }
}

static pli_solver_settings solver_settings(void) {
    return (pli_solver_settings){.velocity_iterations = random_below(6) == 0,
                                 .position_iterations = random_below(4),
                                 .drift_iterations = random_below(6) == 0,
                                 .drift_correction = number(1),
                                 .velocity_damping = share(0),
                                 .time_scale = chance(0.8f) ? 1.0f : number(1)};
}

static void make_body(void) {
    pli_mesh* mesh = NULL;
    if (TRY(make_mesh(&mesh)) != PLI_OK) { return; }
    check_mesh(mesh, "the generator");
    for (int i = random_below(3); i > 0; --i) {
        change_mesh(mesh);
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = number(0.1f);
    if (chance(0.5f)) { def.solver = solver_settings(); }
    if (TRY(pli_body_create(world, mesh, &def, &bodies[body_count])) == PLI_OK) { ++body_count; }
    pli_mesh_destroy(mesh);
}

// ------------------------------------------------------------------------------------------------------- features

static pli_vec3 steer_anywhere(pli_vec3 local_axis, void* user) {
    (void)user;
    return chance(0.5f) ? local_axis : vector(1);
}
static float any_speed(float present, void* user) {
    (void)user;
    return chance(0.2f) ? present : number(10);
}
static bool any_distance(const pli_body* body, pli_cluster_contact* contact, void* user) {
    (void)body;
    (void)user;
    contact->witness = vector(1);
    contact->other_witness = vector(1);
    contact->normal = chance(wildness) ? vector(1) : pli_vec3_make(0, 1, 0);
    contact->distance = -number(0.1f);
    return true;
}
static float any_plane(pli_vec3 point, void* user) {
    return point.x * *(const float*)user + 0.01f;
}

static void choose_solver(pli_body* body) {
    if (chance(0.4f)) { return; }
    if (chance(0.5f)) {
        pli_implicit_def def = pli_implicit_def_default();
        def.stiffness = number(1000);
        def.damping = chance(0.5f) ? 0.0f : number(1);
        def.sweeps = 1 + random_below(6);
        def.method = (pli_implicit_method)random_below(3);
        def.start = (pli_implicit_start)random_below(2);
        def.tolerance = share(1e-4f);
        def.filter_compression = chance(0.5f);
        TRY(pli_body_enable_implicit(body, &def));
        return;
    }
    pli_xpbd_def def = pli_xpbd_def_default();
    def.substeps = 1 + random_below(4);
    def.sweeps = 1 + random_below(2);
    TRY(pli_body_enable_xpbd(body, &def));
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = chance(0.5f) ? 0.0f : number(1e-3f);
    links.bending_compliance = number(1e-3f);
    links.damping = chance(0.5f) ? 0.0f : number(1);
    TRY(pli_body_enable_xpbd_links(body, &links));
    pli_xpbd_bending_def bending = pli_xpbd_bending_def_default();
    bending.compliance = number(1e-3f);
    bending.damping = chance(0.5f) ? 0.0f : number(1);
    bending.is_flat = chance(0.5f);
    if (chance(0.3f)) { TRY(pli_body_enable_xpbd_bending(body, &bending)); }
    if (chance(0.3f)) { TRY(pli_body_enable_xpbd_tetras(body, number(1e-3f))); }
    pli_xpbd_volume_def volume = pli_xpbd_volume_def_default();
    volume.compliance = number(1e-3f);
    volume.pressure_ratio = number(1);
    if (chance(0.3f)) { TRY(pli_body_enable_xpbd_volume(body, &volume)); }
}

static void enable_contacts(pli_body* body) {
    if (chance(0.6f)) {
        pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
        def.friction = number(0.2f);
        def.dynamic_hardness = share(1);
        def.static_hardness = share(0.1f);
        def.compliance = chance(0.5f) ? 0.0f : number(1e-3f);
        def.recovery_speed = chance(0.5f) ? 0.0f : number(1);
        TRY(pli_body_enable_rigid_contacts(body, &def));
    }
    if (chance(0.3f)) {
        pli_rigid_face_contacts_def def = pli_rigid_face_contacts_def_default();
        def.friction = number(0.2f);
        def.dynamic_hardness = share(1);
        def.static_hardness = share(0.1f);
        TRY(pli_body_enable_rigid_face_contacts(body, &def));
    }
    if (chance(0.6f)) {
        pli_soft_contacts_def def = pli_soft_contacts_def_default();
        def.friction = number(0.2f);
        def.hardness = share(1);
        def.compliance = chance(0.5f) ? 0.0f : number(1e-3f);
        def.recovery_speed = chance(0.5f) ? 0.0f : number(1);
        def.bullet_boxes = chance(0.2f);
        TRY(pli_body_enable_soft_contacts(body, &def));
    }
}

static void enable_self_collision(pli_body* body) {
    switch (random_below(6)) {
    case 0: {
        pli_self_collision_def def = pli_self_collision_def_default();
        def.thickness = number(0.05f);
        def.friction = share(0.1f);
        def.speed_limit_ratio = number(0.2f);
        TRY(pli_body_enable_self_collision(body, &def));
        break;
    }
    case 1: {
        pli_self_faces_def def = pli_self_faces_def_default();
        def.thickness = number(0.05f);
        def.friction = share(0.1f);
        def.max_travel = chance(0.5f) ? 0.0f : number(0.1f);
        TRY(pli_body_enable_self_faces(body, &def));
        break;
    }
    case 2: {
        pli_self_grids_def def = pli_self_grids_def_default();
        def.distance = number(0.05f);
        def.separation = share(0.5f);
        TRY(pli_body_enable_self_grids(body, &def));
        break;
    }
    default:
        break;
    }
}

static void enable_forces(pli_body* body) {
    if (chance(0.3f)) {
        pli_aero_def def = pli_aero_def_default();
        def.model = (pli_aero_model)random_below(7);
        def.lift = number(0.1f);
        def.drag = number(0.1f);
        def.wind = vector(3);
        TRY(pli_body_enable_aero(body, &def));
        if (chance(0.3f)) { TRY(pli_body_set_wind(body, vector(3))); }
    }
    if (chance(0.2f)) { TRY(pli_body_enable_pressure(body, number(10))); }
    if (chance(0.2f)) { TRY(pli_body_enable_volume_conservation(body, number(10))); }
    if (chance(0.2f)) { TRY(pli_body_enable_pose_matching(body, share(0.1f))); }
    if (chance(0.2f)) {
        pli_tethers_def def = pli_tethers_def_default();
        def.slack = number(0.01f);
        TRY(pli_body_enable_tethers(body, &def));
    }
    if (chance(0.2f)) { TRY(pli_body_enable_step_smoothing(body)); }
    if (chance(0.2f)) { TRY(pli_body_enable_colored_links(body)); }
    if (chance(0.1f)) { TRY(pli_body_enable_velocity_links(body)); }
}

static void enable_clusters(pli_body* body) {
    if (chance(0.6f)) { return; }
    pli_clusters_def clusters = pli_clusters_def_default();
    clusters.reference_mode = chance(0.3f);
    TRY(pli_body_enable_clusters(body, &clusters));
    if (chance(0.7f)) {
        TRY(pli_body_generate_clusters(body, 1 + random_below(4), 20, NULL));
    } else {
        TRY(pli_body_generate_clusters_from_elements(body, NULL));
    }
    const int count = pli_body_cluster_count(body);
    if (count == 0) { return; }
    pli_cluster_settings settings;
    assert_int_equal(pli_body_get_cluster_settings(body, 0, &settings), PLI_OK);
    settings.matching = share(0.1f);
    settings.node_damping = share(0);
    settings.linear_damping = share(0);
    settings.angular_damping = share(0);
    settings.max_self_impulse = number(100);
    settings.self_impulse_factor = share(1);
    TRY(pli_body_set_cluster_settings(body, random_below(count), &settings));
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    contacts.with_self = chance(0.3f);
    contacts.friction = number(0.2f);
    contacts.dynamic_hardness = share(0.1f);
    contacts.static_hardness = share(1);
    contacts.soft_hardness = share(0.5f);
    contacts.dynamic_split = share(0.5f);
    contacts.accurate_penetration = chance(0.3f);
    contacts.distance = chance(0.2f) ? any_distance : NULL;
    TRY(pli_body_enable_cluster_contacts(body, &contacts));
    const int other = random_below(body_count);
    pli_joint_end end = {0};
    if (chance(0.4f) && rigid_count > 0) {
        end.rigid = rigids[random_below(rigid_count)];
    } else if (bodies[other] != body && pli_body_cluster_count(bodies[other]) > 0) {
        end.body = bodies[other];
    }
    if (chance(0.5f)) {
        pli_linear_joint_def def = pli_linear_joint_def_default();
        def.cluster = random_below(count);
        def.other = end;
        def.position = vector(1);
        def.softness.error_reduction = share(1);
        def.softness.split = share(1);
        TRY(pli_body_add_linear_joint(body, &def, NULL));
    }
    if (chance(0.5f)) {
        pli_angular_joint_def def = pli_angular_joint_def_default();
        def.cluster = random_below(count);
        def.other = end;
        def.axis = vector(1);
        def.softness.error_reduction = share(1);
        def.softness.velocity_factor = share(1);
        def.controller = (pli_joint_controller){steer_anywhere, any_speed, NULL};
        TRY(pli_body_add_angular_joint(body, &def, NULL));
    }
}

static void add_anchors(pli_body* body) {
    for (int i = random_below(3); i > 0 && rigid_count > 0; --i) {
        const pli_vec3 pivot = vector(0.5f);
        pli_anchor_def def = pli_anchor_def_default();
        def.node = random_below(pli_body_get_view(body).node_count);
        def.rigid = rigids[random_below(rigid_count)];
        def.local_pivot = chance(0.5f) ? &pivot : NULL;
        def.influence = number(1);
        def.compliance = chance(0.5f) ? 0.0f : number(1e-3f);
        def.disable_collision = chance(0.5f);
        TRY(pli_body_add_anchor(body, &def, NULL));
        if (chance(0.5f)) { TRY(pli_body_set_anchor_hardness(body, share(0.7f))); }
    }
}

// ------------------------------------------------------------------------------------------------------- states

static void set_whole_state(pli_body* body) {
    const int count = pli_body_get_view(body).node_count;
    pli_vec3* values = malloc(2 * (size_t)count * sizeof *values);
    assert_non_null(values);
    const float old = wildness;
    wildness *= 0.1f;
    for (int i = 0; i < 2 * count; ++i) {
        values[i] = vector(1);
    }
    wildness = old;
    TRY(pli_body_set_state(body, values, chance(0.5f) ? NULL : values + count));
    free(values);
}

static void change_body(pli_body* body) {
    const int node = random_below(pli_body_get_view(body).node_count);
    const pli_solver_settings settings = solver_settings();
    switch (random_below(16)) {
    case 0:
        TRY(pli_body_set_solver_settings(body, &settings));
        break;
    case 1:
        TRY(pli_body_set_collision_margin(body, number(0.1f)));
        break;
    case 2:
        TRY(pli_body_set_rest_length(body, 0, number(0.3f)));
        break;
    case 3:
        set_whole_state(body);
        break;
    case 4:
        TRY(pli_body_set_node_position(body, node, vector(1)));
        break;
    case 5:
        TRY(pli_body_set_node_velocity(body, node, vector(1)));
        break;
    case 6:
        TRY(pli_body_set_node_mass(body, node, number(0.1f)));
        break;
    case 7:
        TRY(pli_body_transform(body, pose(0.1f)));
        break;
    case 8:
        TRY(pli_body_add_node_force(body, node, vector(1)));
        break;
    case 9:
        TRY(pli_body_add_force(body, vector(1)));
        break;
    case 10:
        TRY(pli_body_add_velocity(body, vector(1)));
        break;
    case 11:
        TRY(pli_world_set_gravity(world, vector(10)));
        break;
    case 12: {
        pli_ray_def def = pli_ray_def_default();
        pli_ray_hit hit;
        def.from = vector(2);
        def.to = vector(2);
        def.targets = 1 + random_below(15);
        def.radius = chance(0.5f) ? 0.0f : number(0.1f);
        if (TRY(pli_body_cast_ray(body, &def, &hit)) == PLI_OK && !is_finite3(hit.point)) {
            fail_msg("case %d: a ray hits nowhere", case_number);
        }
        break;
    }
    case 13: {
        float factor = number(1);
        pli_refine_def def = pli_refine_def_default();
        def.surface = any_plane;
        def.user = &factor;
        def.accuracy = number(1e-4f);
        def.cut = chance(0.5f);
        def.reset_rest_lengths = chance(0.5f);
        TRY(pli_body_refine(body, &def));
        break;
    }
    case 14:
        TRY(pli_body_cut_swept(body, vector(2), vector(2), vector(2), vector(2), NULL));
        break;
    default: {
        const pli_body_view view = pli_body_get_view(body);
        if (view.link_count == 0) { break; }
        TRY(pli_body_cut_link(body, view.link_nodes[0], view.link_nodes[1], share(0.5f)));
        break;
    }
    }
}

// ------------------------------------------------------------------------------------------------------- a case

static bool is_within(pli_vec4 v, float limit) {
    return fabsf(v.x) <= limit && fabsf(v.y) <= limit && fabsf(v.z) <= limit;
}

static void check_limits(void) {
    for (int i = 0; i < body_count; ++i) {
        const pli_body_view view = pli_body_get_view(bodies[i]);
        for (int k = 0; k < view.node_count; ++k) {
            const pli_vec4 x = view.positions[k], v = view.velocities[k];
            if (is_within(x, PLI_MAX_COORDINATE) && is_within(v, PLI_MAX_SPEED)) { continue; }
            fail_msg("case %d: node %d of body %d, frozen %d, is at (%.9g, %.9g, %.9g) with (%g, %g, %g) m/s",
                     case_number, k, i, (int)pli_body_is_frozen(bodies[i]), (double)x.x, (double)x.y, (double)x.z,
                     (double)v.x, (double)v.y, (double)v.z);
        }
    }
}

static void run_case(int number_of_case) {
    static const float kinds[] = {0.0f, 0.01f, 0.03f, 0.1f, 0.3f, 1.0f};
    case_number = number_of_case;
    seed = (uint64_t)number_of_case * UINT64_C(0x9e3779b97f4a7c15) + 1;
    for (int i = 0; i < 4; ++i) {
        (void)random_bits();
    }
    wildness = kinds[number_of_case % 6];
    body_count = rigid_count = 0;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    pli_world_def def = pli_world_def_default();
    def.gravity = pli_vec3_make(0, -number(10), 0);
    def.air_density = number(1.2f);
    def.max_force_displacement = number(1000);
    if (checked(pli_world_create(context, &def, &world), "pli_world_create") != PLI_OK) {
        assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    }
    for (int i = 0; i < MAX_RIGIDS; ++i) {
        make_rigid();
    }
    for (int i = 0; i < MAX_BODIES; ++i) {
        make_body();
    }
    for (int i = 0; i < body_count; ++i) {
        choose_solver(bodies[i]);
        enable_contacts(bodies[i]);
        enable_forces(bodies[i]);
        enable_clusters(bodies[i]);
        enable_self_collision(bodies[i]);
        add_anchors(bodies[i]);
    }
    for (int i = 0; i < 3; ++i) {
        if (body_count > 0) { change_body(bodies[random_below(body_count)]); }
        if (body_count > 0 && chance(0.5f)) { change_body(bodies[random_below(body_count)]); }
        if (rigid_count > 0 && chance(0.5f)) { change_rigid(rigids[random_below(rigid_count)]); }
        TRY(pli_world_step(world, chance(0.7f) ? 1.0f / 60.0f : number(1.0f / 60.0f)));
        check_limits();
        int count = 0;
        (void)pli_world_get_events(world, &count);
        events_seen += (unsigned long)count;
        if (chance(0.1f) && body_count > 0) {
            assert_int_equal(pli_body_set_frozen(bodies[random_below(body_count)], false), PLI_OK);
        }
    }
    pli_world_destroy(world);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
}

static int from_environment(const char* name, int otherwise) {
    const char* text = getenv(name);
    return text != NULL ? atoi(text) : otherwise;
}

static void test_finite_numbers_leave_finite_states(void** state) {
    (void)state;
    const int first = from_environment("PLIANT_EXTREME_FIRST", 0);
    const int count = from_environment("PLIANT_EXTREME_CASES", DEFAULT_CASES);
    accepted = refused = events_seen = 0;
    for (int i = first; i < first + count; ++i) {
        run_case(i);
    }
    print_message("%d cases: %lu calls accepted, %lu refused, %lu events\n", count, accepted, refused, events_seen);
    if (count >= DEFAULT_CASES) {
        assert_true(accepted > 10 * (unsigned long)count);
        assert_true(refused > 0 && events_seen > 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_finite_numbers_leave_finite_states),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
