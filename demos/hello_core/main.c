/* The core alone: a sheet of cloth falls on a ball that lies on the ground. */

#include <pliant/pliant.h>

#include <stdio.h>
#include <stdlib.h>

static pli_context* context;

static void check(pli_status status) {
    if (status == PLI_OK) { return; }
    fprintf(stderr, "%s: %s\n", pli_status_string(status), pli_last_error(context));
    exit(1);
}

static void add_static_body(pli_world* world, pli_shape* shape, pli_vec3 position) {
    pli_rigid_def def = pli_rigid_def_default();
    def.state.pose.origin = position;
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid;
    check(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape); // the rigid body holds it now
}

int main(void) {
    check(pli_context_create(NULL, &context));
    pli_world* world;
    const pli_world_def world_def = pli_world_def_default();
    check(pli_world_create(context, &world_def, &world));

    pli_shape *ground, *ball;
    check(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &ground));
    check(pli_shape_create_sphere(context, 1, &ball));
    add_static_body(world, ground, pli_vec3_make(0, 0, 0));
    add_static_body(world, ball, pli_vec3_make(0, 1, 0));

    pli_patch_def sheet = pli_patch_def_default();
    sheet.corner_00 = pli_vec3_make(-2, 3, -2), sheet.corner_10 = pli_vec3_make(2, 3, -2);
    sheet.corner_01 = pli_vec3_make(-2, 3, 2), sheet.corner_11 = pli_vec3_make(2, 3, 2);
    sheet.columns = sheet.rows = 21;
    sheet.diagonals = true;
    pli_mesh* mesh;
    pli_body* cloth;
    check(pli_mesh_create_patch(context, &sheet, &mesh));
    check(pli_mesh_set_total_mass(mesh, 1));
    check(pli_body_create(world, mesh, NULL, &cloth));
    check(pli_body_enable_rigid_contacts(cloth, NULL));
    pli_mesh_destroy(mesh); // the body has a copy

    for (int i = 0; i < 120; ++i) {
        check(pli_world_step(world, 1.0f / 60.0f));
    }

    const pli_body_view view = pli_body_get_view(cloth);
    int lowest = 0;
    for (int i = 1; i < view.node_count; ++i) {
        lowest = view.positions[i].y < view.positions[lowest].y ? i : lowest;
    }
    const pli_vec4 p = view.positions[lowest];
    printf("after 2 s node %d is the lowest, at (%.2f, %.2f, %.2f) m\n", lowest, (double)p.x, (double)p.y, (double)p.z);
    pli_world_destroy(world);
    pli_context_destroy(context);
}
