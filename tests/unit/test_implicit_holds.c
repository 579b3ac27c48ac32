/* Anchors and contacts in the system of the implicit solver: what hangs and what lies stays where statics wants it,
   momentum is shared with rigid bodies, friction is Coulomb's. */

#include "level_sheet.h"
#include "sample_mesh.h"
#include "test_world.h"

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

static const float dt = 1.0f / 60.0f;

/* Unoptimised programs run the shorter cases only. */
#ifdef NDEBUG
static const bool is_fast = true;
#else
static const bool is_fast = false;
#endif

static pli_implicit_def gradient_def(float stiffness) {
    pli_implicit_def def = pli_implicit_def_default();
    def.stiffness = stiffness;
    def.method = PLI_IMPLICIT_CONJUGATE_GRADIENT;
    def.sweeps = 300;
    def.tolerance = 1e-6f;
    return def;
}

static pli_body* make_body(pli_mesh* mesh, const pli_implicit_def* def, float margin) {
    pli_body* body = NULL;
    pli_body_def made = pli_body_def_default();
    made.collision_margin = margin;
    CHECK_OK(pli_body_create(world, mesh, &made, &body));
    pli_mesh_destroy(mesh);
    CHECK_OK(pli_body_enable_implicit(body, def));
    return body;
}

static pli_mesh* make_rope_mesh(pli_vec3 from, pli_vec3 to, int inner_nodes, int pins) {
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_rope(context, from, to, inner_nodes, pins, &mesh));
    return mesh;
}

/* A sheet of `nodes` x `nodes` nodes, `size` m wide, `mass` kg in all, at height `y`. */
static pli_mesh* make_sheet_mesh(int nodes, float size, float mass, float y) {
    const float half = 0.5f * size;
    pli_patch_def def = level_sheet(half, y, nodes);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &def, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, mass));
    return mesh;
}

static pli_rigid* make_rigid(pli_rigid_kind kind, pli_shape* shape, pli_vec3 origin, float mass, float inertia) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.friction = 1.0f;
    def.shape_count = shape != NULL ? 1 : 0;
    def.shapes = &shape;
    def.state.pose.origin = origin;
    if (kind == PLI_RIGID_DYNAMIC) {
        def.state.inverse_mass = 1.0f / mass;
        def.state.inverse_inertia_world = pli_mat3_identity();
        for (int i = 0; i < 3; ++i) {
            def.state.inverse_inertia_world.rows[i] =
                pli_vec3_scale(def.state.inverse_inertia_world.rows[i], 1.0f / inertia);
        }
    }
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
}

static void add_anchor(pli_body* body, int node, pli_rigid* rigid, float influence) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = node;
    def.rigid = rigid;
    def.influence = influence;
    CHECK_OK(pli_body_add_anchor(body, &def, NULL));
}

static pli_vec3 position(const pli_body* body, int node) {
    const pli_vec4 x = pli_body_get_view(body).positions[node];
    return pli_vec3_make(x.x, x.y, x.z);
}

static pli_vec3 velocity(const pli_body* body, int node) {
    const pli_vec4 v = pli_body_get_view(body).velocities[node];
    return pli_vec3_make(v.x, v.y, v.z);
}

static double top_speed(const pli_body* body) {
    double speed = 0.0;
    for (int i = 0; i < pli_body_get_view(body).node_count; ++i) {
        speed = fmax(speed, (double)pli_vec3_length(velocity(body, i)));
    }
    return speed;
}

/* A rigid body that gets its gravity before the step and moves after it. */
static void push_down(pli_rigid* rigid, float gravity) {
    pli_rigid_state state = pli_rigid_get_state(rigid);
    state.linear_velocity.y -= gravity * dt;
    CHECK_OK(pli_rigid_set_state(rigid, &state));
}

static void move(pli_rigid* rigid) {
    CHECK_OK(pli_rigid_integrate(rigid, pli_vec3_make(0, 0, 0), dt));
}

static void set_damping(pli_body* body, float damping) {
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.velocity_damping = damping;
    CHECK_OK(pli_body_set_solver_settings(body, &settings));
}

// --------------------------------------------------------------------------------------------------------- anchors

/* Rope of n unit masses below a static anchor: link i carries what hangs below it. */
static void test_rope_hangs_from_its_anchor_without_sinking(void** unused) {
    (void)unused;
    pli_rigid* rigid = make_rigid(PLI_RIGID_STATIC, NULL, pli_vec3_make(0, 0, 0), 0, 0);
    pli_implicit_def def = gradient_def(2e4f);
    def.damping = 200.0f;
    pli_body* body = make_body(make_rope_mesh(pli_vec3_make(0, 0, 0), pli_vec3_make(0, -9, 0), 8, 0), &def, 0.01f);
    add_anchor(body, 0, rigid, 1.0f);
    for (int i = 0; i < 1200; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        check_near(position(body, 0).y, 0.0, 1e-5);
    }
    for (int i = 0; i < 9; ++i) {
        check_near(position(body, i).y - position(body, i + 1).y - 1.0f, 10.0 * (9 - i) / 2e4, 2e-5);
    }
    assert_true(pli_rigid_was_touched(rigid));
}

/* With `kind` one box on a rope of 4 links, which is anchored to it and to the ceiling. */
static double hang_box(const pli_implicit_def* def, double* drift) {
    pli_rigid* ceiling = make_rigid(PLI_RIGID_STATIC, NULL, pli_vec3_make(0, 0, 0), 0, 0);
    pli_rigid* box = make_rigid(PLI_RIGID_DYNAMIC, NULL, pli_vec3_make(0, -4.5f, 0), 10.0f, 1.0f);
    pli_mesh* mesh = make_rope_mesh(pli_vec3_make(0, 0, 0), pli_vec3_make(0, -4, 0), 3, 0);
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1.0f));
    pli_body* body = make_body(mesh, def, 0.01f);
    add_anchor(body, 0, ceiling, 1.0f);
    add_anchor(body, 4, box, 1.0f);
    double lowest = 0.0, highest = -10.0;
    for (int i = 0; i < 1200; ++i) {
        push_down(box, 10.0f);
        CHECK_OK(pli_world_step(world, dt));
        move(box);
        const double y = (double)pli_rigid_get_state(box).pose.origin.y;
        if (i >= 1140) {
            lowest = fmin(lowest, y);
            highest = fmax(highest, y);
        }
    }
    *drift = highest - lowest;
    const double off = (double)pli_rigid_get_state(box).pose.origin.y + 4.5;
    const pli_vec3 end = position(body, 4);
    check_near(end.y, pli_rigid_get_state(box).pose.origin.y + 0.5f, 1e-4);
    pli_body_destroy(body);
    pli_rigid_destroy(box);
    pli_rigid_destroy(ceiling);
    return off;
}

/* Links carry the box and the nodes below: sum of elongations. */
static void test_box_hangs_where_the_springs_are_in_balance(void** unused) {
    (void)unused;
    for (double stiffness = 1e3; stiffness < 2e5; stiffness *= 10.0) {
        const double expected = -10.0 * (4 * 10.0 + 0.2 * (4 + 3 + 2 + 1)) / stiffness;
        pli_implicit_def def = gradient_def((float)stiffness);
        def.damping = 100.0f;
        double drift = 0.0;
        const double gradient = hang_box(&def, &drift);
        print_message("k %g: %.6f m, %.6f by statics, moves %.2g m in the last second\n", stiffness, gradient, expected,
                      drift);
        check_near(gradient, expected, 1e-4);
        check_at_most(drift, 1e-5);
    }
}

/* A sheet that is anchored at its corners, by as many anchors as it takes, to the ceiling and to a box of 10 kg that
   hangs from the middle by four nodes. */
static void hang_box_on_sheet(pli_implicit_def def, double limit) {
    pli_rigid* frame = make_rigid(PLI_RIGID_STATIC, NULL, pli_vec3_make(0, 0, 0), 0, 0);
    pli_rigid* box = make_rigid(PLI_RIGID_DYNAMIC, NULL, pli_vec3_make(0, -0.2f, 0), 10.0f, 0.1f);
    pli_body* body = make_body(make_sheet_mesh(10, 1.0f, 0.5f, 0.0f), &def, 0.01f);
    static const int corners[] = {0, 9, 90, 99}, middle[] = {44, 45, 54, 55};
    for (int i = 0; i < 4; ++i) {
        add_anchor(body, corners[i], frame, 1.0f);
        add_anchor(body, middle[i], box, 1.0f);
    }
    set_damping(body, 0.01f);
    double before = 0.0;
    for (int i = 0; i < 1800; ++i) {
        push_down(box, 10.0f);
        CHECK_OK(pli_world_step(world, dt));
        move(box);
        pli_rigid_state state = pli_rigid_get_state(box);
        state.angular_velocity = pli_vec3_scale(state.angular_velocity, 0.99f);
        state.linear_velocity = pli_vec3_scale(state.linear_velocity, 0.99f);
        CHECK_OK(pli_rigid_set_state(box, &state));
        if (i == 1740) { before = (double)state.pose.origin.y; }
    }
    const pli_rigid_state state = pli_rigid_get_state(box);
    /* In balance the springs at the four nodes carry the box: their net force from positions, in double. */
    const pli_body_view view = pli_body_get_view(body);
    double up = 0.0;
    for (int s = 0; s < view.link_count; ++s) {
        const int* nodes = view.link_nodes + s * view.link_node_stride;
        const pli_vec3 a = position(body, nodes[0]), b = position(body, nodes[1]);
        const double d[3] = {(double)b.x - (double)a.x, (double)b.y - (double)a.y, (double)b.z - (double)a.z};
        const double r = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const double force = (double)def.stiffness * (r - (double)pli_body_get_rest_length(body, s)) * d[1] / r;
        for (int i = 0; i < 4; ++i) {
            if (nodes[0] == middle[i]) { up += force; }
            if (nodes[1] == middle[i]) { up -= force; }
        }
    }
    print_message("method %d, %d sweeps: box at %.5f m, moved %.2g m in the last second, force %.4f N\n",
                  (int)def.method, def.sweeps, (double)state.pose.origin.y, (double)state.pose.origin.y - before, up);
    check_near((double)state.pose.origin.y, before, limit);
    for (int i = 0; i < 4; ++i) {
        const double way = (double)state.pose.origin.y + 0.2;
        check_near((double)position(body, middle[i]).y, way, 1e-4);
        check_near((double)position(body, corners[i]).y, 0.0, 1e-5);
    }
    if (def.method == PLI_IMPLICIT_CONJUGATE_GRADIENT) { check_near(up, 100.0 + 0.2, 0.1); }
    pli_body_destroy(body);
    pli_rigid_destroy(box);
    pli_rigid_destroy(frame);
}

static void test_box_hangs_on_an_anchored_sheet(void** unused) {
    (void)unused;
    pli_implicit_def def = gradient_def(1e4f);
    hang_box_on_sheet(def, 1e-5);
    def = pli_implicit_def_default();
    def.stiffness = 1e4f;
    for (def.sweeps = 5; def.sweeps <= (is_fast ? 15 : 5); def.sweeps *= 3) {
        hang_box_on_sheet(def, 1e-3);
    }
    def.method = PLI_IMPLICIT_CHEBYSHEV;
    def.sweeps = is_fast ? 45 : 15;
    hang_box_on_sheet(def, 1e-3);
}

/* A rope swings about a rigid body that is free: momenta of both, and the anchor. */
static void test_anchors_share_momentum(void** unused) {
    (void)unused;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)));
    for (int method = 0; method < 3; ++method) {
        pli_implicit_def def = gradient_def(1e4f);
        def.method = (pli_implicit_method)method;
        if (method < 2) { def.sweeps = 5; }
        pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, NULL, pli_vec3_make(0, 0, 0), 3.0f, 2.0f);
        pli_body* body =
            make_body(make_rope_mesh(pli_vec3_make(0.5f, 0, 0), pli_vec3_make(2.5f, 0, 0), 3, 0), &def, 0.01f);
        add_anchor(body, 0, rigid, 1.0f);
        CHECK_OK(pli_body_set_node_velocity(body, 4, pli_vec3_make(0, 8, 3)));
        for (int i = 0; i < 120; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            const pli_vec3 sum =
                pli_vec3_add(pli_body_momentum(body), pli_vec3_scale(pli_rigid_get_state(rigid).linear_velocity, 3.0f));
            check_near(sum.x, 0.0, 1e-5 * 8.5);
            check_near(sum.y, 8.0, 1e-5 * 8.5);
            check_near(sum.z, 3.0, 1e-5 * 8.5);
            move(rigid);
        }
        const pli_rigid_state state = pli_rigid_get_state(rigid);
        assert_true(pli_vec3_length(state.linear_velocity) > 0.5f);
        const pli_vec3 goal = pli_transform_point(state.pose, pli_vec3_make(0.5f, 0, 0));
        check_at_most(pli_vec3_length(pli_vec3_sub(position(body, 0), goal)), method == 2 ? 1e-3 : 0.02);
        pli_body_destroy(body);
        pli_rigid_destroy(rigid);
    }
}

// -------------------------------------------------------------------------------------------------------- contacts

static void enable_contacts(pli_body* body, float friction) {
    pli_rigid_contacts_def search = pli_rigid_contacts_def_default();
    search.friction = friction;
    CHECK_OK(pli_body_enable_rigid_contacts(body, &search));
}

/* A bridge of 6 m: two ropes of 2 kg in one body or in one each, with tethers; 20 planks of 5 kg, tied to each rope by
   two nodes 0.2 m apart. */
enum { PLANK_COUNT = 20, BRIDGE_NODES = 61 };

static void make_bridge(bool is_split, const pli_implicit_def* def, pli_body* ropes[2],
                        pli_rigid* planks[PLANK_COUNT]) {
    for (int k = 0; k < (is_split ? 2 : 1); ++k) {
        pli_mesh* mesh = NULL;
        CHECK_OK(pli_mesh_create(context, &mesh));
        for (int i = 0; i < (is_split ? 1 : 2) * BRIDGE_NODES; ++i) {
            const int along = i % BRIDGE_NODES;
            const bool is_end = along == 0 || along == BRIDGE_NODES - 1;
            const float z = k + i / BRIDGE_NODES == 0 ? -0.5f : 0.5f;
            const pli_vec3 place = pli_vec3_make(0.1f * (float)along - 3.0f, 2.0f, z);
            CHECK_OK(pli_mesh_append_node(mesh, place, is_end ? 0.0f : 2.0f / BRIDGE_NODES, NULL));
            if (along > 0) { CHECK_OK(pli_mesh_append_link(mesh, i - 1, i, 0, NULL)); }
        }
        ropes[k] = make_body(mesh, def, 0.05f);
    }
    for (int i = 0; i < PLANK_COUNT; ++i) {
        const int node = 1 + 3 * i;
        planks[i] = make_rigid(PLI_RIGID_DYNAMIC, NULL, pli_vec3_make(0.1f * (float)node - 2.9f, 2, 0), 5, 1);
        pli_rigid_state state = pli_rigid_get_state(planks[i]);
        state.inverse_inertia_world.rows[0].x = 1.0f / 0.418f; /* of 0.2 m by 0.06 m by 1 m */
        state.inverse_inertia_world.rows[1].y = 1.0f / 0.433f;
        state.inverse_inertia_world.rows[2].z = 1.0f / 0.018f;
        CHECK_OK(pli_rigid_set_state(planks[i], &state));
        for (int k = 0; k < 4; ++k) {
            const int other = k < 2 || is_split ? 0 : BRIDGE_NODES;
            add_anchor(ropes[is_split ? k / 2 : 0], other + node + 2 * (k % 2), planks[i], 1);
        }
    }
    for (int k = 0; k < (is_split ? 2 : 1); ++k) {
        CHECK_OK(pli_body_enable_tethers(ropes[k], NULL));
    }
}

/* Most in m/s and rad/s, from step `from` on. */
static void run_bridge(pli_rigid* planks[PLANK_COUNT], int steps, int from, double fastest[2]) {
    for (int n = 0; n < steps * PLANK_COUNT; ++n) {
        pli_rigid* plank = planks[n % PLANK_COUNT];
        if (n % PLANK_COUNT == 0) { CHECK_OK(pli_world_step(world, dt)); }
        CHECK_OK(pli_rigid_integrate(plank, pli_vec3_make(0, -10, 0), dt));
        if (n < from * PLANK_COUNT) { continue; }
        fastest[0] = fmax(fastest[0], (double)pli_vec3_length(pli_rigid_get_state(plank).linear_velocity));
        fastest[1] = fmax(fastest[1], (double)pli_vec3_length(pli_rigid_get_state(plank).angular_velocity));
    }
}

/* Taut ropes right a plank stiffly, by arms that turn within a step: by 33 degrees where it is struck. */
static void test_planks_rest_on_ropes(void** unused) {
    (void)unused;
    pli_implicit_def defs[2] = {pli_implicit_def_default(), gradient_def(1e5f)};
    defs[0].stiffness = 1e5f;
    defs[0].finishing_iterations = 50;
    for (int n = 0; n < 4; ++n) {
        const bool is_split = n >= 2;
        pli_body* ropes[2];
        pli_rigid* planks[PLANK_COUNT];
        make_bridge(is_split, &defs[n % 2], ropes, planks);
        double at_rest[2] = {0}, struck[2] = {0};
        run_bridge(planks, 600, 480, at_rest);
        pli_rigid_state state = pli_rigid_get_state(planks[10]);
        state.angular_velocity = pli_vec3_make(35, 0, 0);
        CHECK_OK(pli_rigid_set_state(planks[10], &state));
        run_bridge(planks, 5, 2, struck);
        print_message("%d: at rest %.3g m/s, %.3g rad/s, struck %.3g rad/s\n", n, at_rest[0], at_rest[1], struck[1]);
        check_at_most(at_rest[0], 0.2);
        check_at_most(at_rest[1], 2);
        if (!is_split) { check_at_most(struck[1], 0.6); }
        for (int i = 0; i < PLANK_COUNT; ++i) {
            pli_rigid_destroy(planks[i]);
        }
        pli_body_destroy(ropes[0]);
        if (is_split) { pli_body_destroy(ropes[1]); }
    }
}

/* Two linked nodes on a plane; gravity is turned, not the plane. */
static void test_friction_is_coulombs(void** unused) {
    (void)unused;
    const double slope = 0.5;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(10.0f * sinf((float)slope), -10.0f * cosf((float)slope), 0)));
    pli_shape* plane = NULL;
    CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0.0f, &plane));
    make_rigid(PLI_RIGID_STATIC, plane, pli_vec3_make(0, 0, 0), 0, 0);
    static const float coefficients[] = {0.0f, 0.2f, 0.5f, 0.56f, 1.0f};
    for (int method = 0; method < 3; ++method) {
        for (int i = 0; i < 5; ++i) {
            pli_implicit_def def = gradient_def(method < 2 ? 500.0f : 1e4f);
            def.method = (pli_implicit_method)method;
            if (method < 2) { def.sweeps = 15; } /* uniform friction is slow to spread through stiff springs */
            pli_body* body = make_body(
                make_rope_mesh(pli_vec3_make(0, 0.01f, 0), pli_vec3_make(0.5f, 0.01f, 0.1f), 1, 0), &def, 0.01f);
            enable_contacts(body, coefficients[i]);
            for (int k = 0; k < 60; ++k) {
                CHECK_OK(pli_world_step(world, dt));
            }
            const double expected = fmax(0.0, 10.0 * sin(slope) - (double)coefficients[i] * 10.0 * cos(slope));
            print_message("method %d, friction %g: %.4f m/s, %.4f by Coulomb\n", method, (double)coefficients[i],
                          (double)velocity(body, 0).x, expected);
            for (int node = 0; node < 3; ++node) {
                check_near(velocity(body, node).x, expected, method == PLI_IMPLICIT_CONJUGATE_GRADIENT ? 1e-4 : 1e-2);
                check_near(velocity(body, node).y, 0.0, 1e-5);
                check_near(position(body, node).y, 0.01, 1e-5); /* the margin */
            }
            pli_body_destroy(body);
        }
    }
}

typedef enum support { SUPPORT_PLANE, SUPPORT_BALL, SUPPORT_BOX } support;

enum { REST_NODES = 13 };

/* From a box of 0.6 x 0.4 x 0.6 m, outside. */
static double box_distance(pli_vec3 x) {
    const double a = fabs((double)x.x) - 0.3, b = fabs((double)x.y) - 0.2, c = fabs((double)x.z) - 0.3;
    const double outside = hypot(hypot(fmax(a, 0.0), fmax(b, 0.0)), fmax(c, 0.0));
    return outside > 0.0 ? outside : fmax(fmax(a, b), c);
}

/* A sheet of 1 kg put on a static body for 20 s: after 10 s, how deep it goes in, how fast it is, how far it creeps. */
static void rest_sheet(support kind, pli_implicit_def def) {
    pli_shape* shape = NULL;
    if (kind == SUPPORT_PLANE) {
        CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0.0f, &shape));
    } else if (kind == SUPPORT_BALL) {
        CHECK_OK(pli_shape_create_sphere(context, 1.0f, &shape));
    } else {
        CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.3f, 0.2f, 0.3f), &shape));
    }
    const float top = kind == SUPPORT_PLANE ? 0.0f : kind == SUPPORT_BALL ? 1.0f : 0.2f;
    pli_rigid* rigid = make_rigid(PLI_RIGID_STATIC, shape, pli_vec3_make(0, 0, 0), 0, 0);
    pli_body* body = make_body(make_sheet_mesh(REST_NODES, 0.8f, 1.0f, top + 0.02f), &def, 0.01f);
    enable_contacts(body, 0.5f);
    set_damping(body, 0.01f);
    double deepest = 0.0;
    static pli_vec3 before[REST_NODES * REST_NODES];
    for (int i = 0; i < 1200; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        for (int node = 0; i >= 600 && node < REST_NODES * REST_NODES; ++node) {
            const pli_vec3 x = position(body, node);
            double gap = (double)x.y;
            if (kind == SUPPORT_BALL) { gap = (double)pli_vec3_length(x) - 1.0; }
            if (kind == SUPPORT_BOX) { gap = box_distance(x); }
            deepest = fmax(deepest, 0.01 - gap);
            if (i == 1139) { before[node] = x; }
        }
    }
    double creep = 0.0;
    for (int node = 0; node < REST_NODES * REST_NODES; ++node) {
        creep = fmax(creep, (double)pli_vec3_length(pli_vec3_sub(position(body, node), before[node])));
    }
    print_message("support %d, method %d: %.3g mm deep, %.2g cm/s, creeps %.2g mm/s\n", (int)kind, (int)def.method,
                  1e3 * deepest, 1e2 * top_speed(body), 1e3 * creep);
    check_at_most(deepest, kind == SUPPORT_BOX ? 2e-3 : 1e-3); /* into the margin of 10 mm */
    /* Measured 1.1 cm/s for conjugate gradients on the box, whose flaps swing. */
    check_at_most(top_speed(body), kind == SUPPORT_BOX ? 0.02 : 0.01);
    check_at_most(creep, 1e-3);
    pli_body_destroy(body);
    pli_rigid_destroy(rigid);
}

static void test_sheets_rest_without_sinking_or_creeping(void** unused) {
    (void)unused;
    for (int kind = 0; kind < (is_fast ? 3 : 1); ++kind) {
        for (int method = 0; method < 3; ++method) {
            pli_implicit_def def = pli_implicit_def_default();
            def.stiffness = 200.0f;
            def.damping = 1.0f;
            def.method = (pli_implicit_method)method;
            if (method == PLI_IMPLICIT_CONJUGATE_GRADIENT) { def.sweeps = 50; }
            rest_sheet((support)kind, def);
        }
    }
}

/* A sheet falls on a box that floats. */
static void test_contacts_share_momentum(void** unused) {
    (void)unused;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)));
    for (int method = 0; method < 3; ++method) {
        pli_implicit_def def = gradient_def(1e3f);
        def.method = (pli_implicit_method)method;
        if (method < 2) { def.sweeps = 5; }
        pli_shape* shape = NULL;
        CHECK_OK(pli_shape_create_box(context, pli_vec3_make(1, 0.5f, 1), &shape));
        pli_rigid* box = make_rigid(PLI_RIGID_DYNAMIC, shape, pli_vec3_make(0, 0, 0), 5.0f, 2.0f);
        pli_body* body = make_body(make_sheet_mesh(8, 1.5f, 2.0f, 0.6f), &def, 0.02f);
        enable_contacts(body, 0.3f);
        CHECK_OK(pli_body_add_velocity(body, pli_vec3_make(1, -2, 0)));
        for (int i = 0; i < 90; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            const pli_vec3 sum =
                pli_vec3_add(pli_body_momentum(body), pli_vec3_scale(pli_rigid_get_state(box).linear_velocity, 5.0f));
            check_near(sum.x, 2.0, 1e-5 * 4.5);
            check_near(sum.y, -4.0, 1e-5 * 4.5);
            check_near(sum.z, 0.0, 1e-5 * 4.5);
            move(box);
        }
        const pli_vec3 pushed = pli_rigid_get_state(box).linear_velocity;
        print_message("method %d: box at %g, %g m/s\n", method, (double)pushed.x, (double)pushed.y);
        assert_true(pushed.y < -0.3f && pushed.x > 0.05f);
        pli_body_destroy(body);
        pli_rigid_destroy(box);
    }
}

/* A box of 10 kg put on a sheet that is pinned all round; it comes to rest. */
static void test_box_rests_on_a_pinned_sheet(void** unused) {
    (void)unused;
    pli_implicit_def def = gradient_def(5e3f);
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.2f, 0.1f, 0.2f), &shape));
    pli_rigid* box = make_rigid(PLI_RIGID_DYNAMIC, shape, pli_vec3_make(0, 0.15f, 0), 10.0f, 0.2f);
    pli_mesh* mesh = make_sheet_mesh(17, 1.2f, 0.5f, 0.0f);
    for (int i = 0; i < 17 * 17; ++i) {
        if (i % 17 == 0 || i % 17 == 16 || i / 17 == 0 || i / 17 == 16) {
            CHECK_OK(pli_mesh_set_node_mass(mesh, i, 0.0f));
        }
    }
    pli_body* body = make_body(mesh, &def, 0.01f);
    enable_contacts(body, 0.5f);
    set_damping(body, 0.01f);
    for (int i = 0; i < (is_fast ? 1200 : 300); ++i) {
        push_down(box, 10.0f);
        CHECK_OK(pli_world_step(world, dt));
        move(box);
    }
    const pli_rigid_state state = pli_rigid_get_state(box);
    print_message("box at %g m, %g m/s, %g rad/s\n", (double)state.pose.origin.y,
                  (double)pli_vec3_length(state.linear_velocity), (double)pli_vec3_length(state.angular_velocity));
    check_at_most(pli_vec3_length(state.linear_velocity), 0.01);
    check_at_most(pli_vec3_length(state.angular_velocity), 0.02);
    check_at_most(fabs((double)state.pose.origin.x), 0.05);
    assert_true(state.pose.origin.y < 0.1f && state.pose.origin.y > -0.4f);
    assert_true(pli_rigid_was_touched(box));
}

/* A box of 10 kg that falls by 0.3 m on the pinned end of a rope. */
static void test_box_rests_on_a_pinned_end(void** unused) {
    (void)unused;
    const pli_implicit_def def = gradient_def(5e3f);
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.5f, 0.5f, 0.5f), &shape));
    pli_rigid* box = make_rigid(PLI_RIGID_DYNAMIC, shape, pli_vec3_make(0, 0.8f, 0), 10.0f, 2.0f);
    pli_mesh* mesh = make_rope_mesh(pli_vec3_make(0, 0, 0), pli_vec3_make(0, -1, 0), 0, PLI_ROPE_PIN_FIRST);
    pli_body* body = make_body(mesh, &def, 0.01f);
    enable_contacts(body, 0.5f);
    for (int i = 0; i < 120; ++i) {
        push_down(box, 10.0f);
        CHECK_OK(pli_world_step(world, dt));
        move(box);
    }
    const pli_rigid_state state = pli_rigid_get_state(box);
    check_near(state.pose.origin.y, 0.51, 0.002);
    check_at_most(pli_vec3_length(state.linear_velocity), 1e-3);
    check_near(position(body, 1).y, -1.002, 1e-4); /* 10 N of 5 kN/m */
}

/* From rest to full speed at once. */
static void test_sheets_lie_on_lifts(void** unused) {
    (void)unused;
    const float margin = 0.02f, speeds[] = {0.5f, 3, 8};
    for (int i = 0; i < 6; ++i) {
        pli_shape* shape = NULL;
        CHECK_OK(pli_shape_create_box(context, pli_vec3_make(3, 0.5f, 3), &shape));
        pli_rigid* lift = make_rigid(PLI_RIGID_KINEMATIC, shape, pli_vec3_make(0, -0.5f, 0), 1, 1);
        const pli_implicit_def gradients = gradient_def(500), *def = i < 3 ? NULL : &gradients;
        pli_body* body = make_body(make_sheet_mesh(21, 2, 1, margin), def, margin);
        CHECK_OK(pli_body_enable_rigid_contacts(body, NULL));
        double most = 0.0;
        for (int k = 0; k < 60; ++k) {
            pli_rigid_state state = pli_rigid_get_state(lift);
            state.linear_velocity.y = k < 10 ? 0 : speeds[i % 3];
            CHECK_OK(pli_rigid_set_state(lift, &state));
            CHECK_OK(pli_world_step(world, dt));
            move(lift);
            const float level = pli_rigid_get_state(lift).pose.origin.y + 0.5f + margin;
            for (int n = 0; n < 21 * 21; ++n) {
                most = fmax(most, (double)(level - position(body, n).y));
            }
        }
        check_at_most(most, 1e-5);
        pli_body_destroy(body);
        pli_rigid_destroy(lift);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_rope_hangs_from_its_anchor_without_sinking, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_box_hangs_where_the_springs_are_in_balance, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_box_hangs_on_an_anchored_sheet, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_anchors_share_momentum, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_planks_rest_on_ropes, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_friction_is_coulombs, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_sheets_rest_without_sinking_or_creeping, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_contacts_share_momentum, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_box_rests_on_a_pinned_sheet, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_box_rests_on_a_pinned_end, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_sheets_lie_on_lifts, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
