// A curtain hangs from a rod in the wind; a ball is moved through it and back.
#include <math.h>
#include <pliant/pliant.h>
#include <stdio.h>
#include <stdlib.h>

static pli_context* context;

static void check(pli_status status) {
    if (status == PLI_OK) { return; }
    fprintf(stderr, "%s\n", pli_last_error(context));
    exit(1);
}

static pli_mesh* make_mesh(void) {
    pli_mesh* mesh;
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-1, 3, 0);
    patch.corner_10 = pli_vec3_make(1, 3, 0);
    patch.corner_01 = pli_vec3_make(-1, 1, 0);
    patch.corner_11 = pli_vec3_make(1, 1, 0);
    patch.columns = patch.rows = 41; // node (x, y) has the index y * columns + x
    patch.diagonals = true;          // shear links
    check(pli_mesh_create_patch(context, &patch, &mesh));

    int soft;
    const pli_material soft_material = {.linear_stiffness = 0.3f};
    check(pli_mesh_append_material(mesh, &soft_material, &soft));
    check(pli_mesh_append_bending_links(mesh, 2, soft, NULL)); // between nodes two links apart
    check(pli_mesh_set_total_mass(mesh, 0.8f));                // kg
    for (int x = 0; x < patch.columns; x += 4) {
        check(pli_mesh_set_node_mass(mesh, x, 0)); // 0 pins a node: hooks along the rod
    }
    return mesh;
}

static pli_body* make_curtain(pli_world* world) {
    pli_mesh* mesh = make_mesh();
    pli_body* curtain;
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f; // m
    def.solver.position_iterations = 10;
    def.solver.velocity_damping = 0.005f;
    check(pli_body_create(world, mesh, &def, &curtain));
    pli_mesh_destroy(mesh); // the body has a copy

    check(pli_body_enable_colored_links(curtain));
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.friction = 0.3f;
    check(pli_body_enable_rigid_contacts(curtain, &contacts));
    const pli_tethers_def tethers = pli_tethers_def_default();
    check(pli_body_enable_tethers(curtain, &tethers));
    pli_aero_def aero = pli_aero_def_default();
    aero.model = PLI_AERO_FACE_TWO_SIDED;
    aero.drag = 0.02f;
    aero.wind = pli_vec3_make(0, 0, 2); // m/s
    check(pli_body_enable_aero(curtain, &aero));
    return curtain;
}

static pli_rigid* make_ball(pli_world* world) {
    pli_shape* sphere;
    pli_rigid* ball;
    check(pli_shape_create_sphere(context, 0.3f, &sphere));
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_KINEMATIC; // moved by us, not by contacts
    def.shapes = &sphere;
    def.shape_count = 1;
    check(pli_rigid_create(world, &def, &ball));
    pli_shape_release(sphere); // the ball holds a reference
    return ball;
}

static void move_ball(pli_rigid* ball, float time) {
    pli_rigid_state state = pli_rigid_get_state(ball);
    state.pose.origin = pli_vec3_make(0, 1.6f, -1.2f * cosf(1.5f * time));
    state.linear_velocity = pli_vec3_make(0, 0, 1.8f * sinf(1.5f * time));
    check(pli_rigid_set_state(ball, &state));
}

static void print_events(const pli_world* world) {
    int count;
    const pli_event* events = pli_world_get_events(world, &count);
    for (int i = 0; i < count; ++i) {
        if (events[i].kind == PLI_EVENT_BODY_FROZEN) { printf("frozen: node %d left the limits\n", events[i].node); }
    }
}

int main(void) {
    pli_world* world;
    check(pli_context_create(NULL, &context));
    check(pli_world_create(context, NULL, &world));
    pli_body* curtain = make_curtain(world);
    pli_rigid* ball = make_ball(world);

    const float dt = 1.0f / 60.0f;
    for (int step = 0; step < 270; ++step) {
        move_ball(ball, (float)step * dt);
        check(pli_world_step(world, dt));
        print_events(world);
        if (step % 30 == 29) {
            const int contacts = pli_body_get_rigid_contacts(curtain, 0, NULL);
            const pli_vec4 middle = pli_body_get_view(curtain).positions[30 * 41 + 20];
            printf("%.1f s: %3d contacts, stretch %4.1f %%, middle at z = %5.2f m\n", (step + 1) / 60.0, contacts,
                   100.0 * (double)pli_body_max_stretch(curtain), (double)middle.z);
        }
    }
    pli_world_destroy(world); // with the body and the ball
    check(pli_context_destroy(context));
    return 0;
}
