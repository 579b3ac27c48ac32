// A sheet of cloth falls on a ball.
#include <pliant/pliant.h>
#include <stdio.h>
#include <stdlib.h>

static pli_context* context;

static void check(pli_status status) {
    if (status == PLI_OK) { return; }
    fprintf(stderr, "%s\n", pli_last_error(context));
    exit(1);
}

int main(void) {
    pli_world* world;
    check(pli_context_create(NULL, &context));
    check(pli_world_create(context, NULL, &world)); // gravity: 10 m/s^2 downwards

    pli_shape* sphere;
    pli_rigid* ball; // static, at the origin
    pli_rigid_def ball_def = pli_rigid_def_default();
    ball_def.shapes = &sphere;
    ball_def.shape_count = 1;
    check(pli_shape_create_sphere(context, 1, &sphere)); // radius in m
    check(pli_rigid_create(world, &ball_def, &ball));

    pli_mesh* mesh; // 3 m by 3 m, 1.5 m up
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-1.5f, 1.5f, -1.5f);
    patch.corner_10 = pli_vec3_make(1.5f, 1.5f, -1.5f);
    patch.corner_01 = pli_vec3_make(-1.5f, 1.5f, 1.5f);
    patch.corner_11 = pli_vec3_make(1.5f, 1.5f, 1.5f);
    patch.columns = patch.rows = 31;
    check(pli_mesh_create_patch(context, &patch, &mesh));
    check(pli_mesh_set_total_mass(mesh, 0.5f)); // kg

    pli_body* cloth;
    pli_body_def cloth_def = pli_body_def_default();
    cloth_def.collision_margin = 0.02f; // m
    cloth_def.solver.position_iterations = 10;
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    check(pli_body_create(world, mesh, &cloth_def, &cloth));
    check(pli_body_enable_colored_links(cloth)); // several links at once
    check(pli_body_enable_rigid_contacts(cloth, &contacts));

    for (int step = 0; step < 90; ++step) {
        check(pli_world_step(world, 1.0f / 60.0f));
    }
    printf("corner after 1.5 s: y = %.2f m\n", (double)pli_body_get_view(cloth).positions[0].y);
}
