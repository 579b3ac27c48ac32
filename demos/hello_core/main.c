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

int main(void) {
    pli_world* world;
    check(pli_context_create(NULL, &context));
    check(pli_world_create(context, NULL, &world));

    pli_shape* shapes[2];
    check(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), -1, &shapes[0]));
    check(pli_shape_create_sphere(context, 1, &shapes[1]));
    pli_rigid_def obstacle = pli_rigid_def_default(); // static, at the origin
    obstacle.shape_count = 2;
    obstacle.shapes = shapes;
    pli_rigid* rigid;
    check(pli_rigid_create(world, &obstacle, &rigid));

    pli_patch_def sheet = pli_patch_def_default();
    sheet.corner_00 = pli_vec3_make(-2, 2, -2);
    sheet.corner_10 = pli_vec3_make(2, 2, -2);
    sheet.corner_01 = pli_vec3_make(-2, 2, 2);
    sheet.corner_11 = pli_vec3_make(2, 2, 2);
    sheet.columns = sheet.rows = 21;
    pli_mesh* mesh;
    pli_body* cloth;
    check(pli_mesh_create_patch(context, &sheet, &mesh));
    check(pli_mesh_set_total_mass(mesh, 1));
    check(pli_body_create(world, mesh, NULL, &cloth));
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    check(pli_body_enable_rigid_contacts(cloth, &contacts));
    pli_mesh_destroy(mesh); // the body has its own copy

    for (int i = 0; i < 120; ++i) {
        check(pli_world_step(world, 1.0f / 60.0f));
    }

    const pli_body_view view = pli_body_get_view(cloth);
    pli_vec4 low = view.positions[0];
    for (int i = 1; i < view.node_count; ++i) {
        low = view.positions[i].y < low.y ? view.positions[i] : low;
    }
    printf("lowest node after 2 s: (%.2f, %.2f, %.2f) m\n", (double)low.x, (double)low.y, (double)low.z);

    pli_shape_release(shapes[0]);
    pli_shape_release(shapes[1]);
    pli_world_destroy(world);
    pli_context_destroy(context);
}
