/* Links on velocities, and on positions in the drift solve, matching btSoftBody::VSolve_Links and its preset
   Velocities. Links of pinned nodes or of length zero, for which Bullet divides by zero, are left out. */

#include "body/pipeline.h"

typedef struct velocity_link {
    pli_vec3 direction; /* node b - node a at the start of the step, not normalised */
    float scale;        /* 1 / (|direction|^2 * mass term) */
} velocity_link;

typedef struct velocity_links_state {
    velocity_link* links; /* [link_count] */
} velocity_links_state;

static void velocity_links_prepare(pli_body* body, void* state) {
    velocity_link* links = ((velocity_links_state*)state)->links;
    for (int i = 0; i < body->link_count; ++i) {
        const plii_link* link = &body->links[i];
        const pli_vec3 direction =
            pli_vec3_sub(plii_xyz(body->previous[link->nodes[1]]), plii_xyz(body->previous[link->nodes[0]]));
        const float weight = pli_vec3_length_squared(direction) * plii_link_mass_term(body, i);
        links[i] = (velocity_link){direction, weight > 0.0f ? 1.0f / weight : 0.0f};
    }
}

static void velocity_links_solve(pli_body* body, void* state) {
    const velocity_link* links = ((const velocity_links_state*)state)->links;
    for (int i = 0; i < body->link_count; ++i) {
        const int a = body->links[i].nodes[0], b = body->links[i].nodes[1];
        const pli_vec3 difference = pli_vec3_sub(plii_xyz(body->velocities[a]), plii_xyz(body->velocities[b]));
        const float j = -pli_vec3_dot(links[i].direction, difference) * links[i].scale;
        plii_add_xyz(&body->velocities[a], pli_vec3_scale(links[i].direction, j * body->positions[a].w));
        plii_add_xyz(&body->velocities[b], pli_vec3_scale(links[i].direction, -j * body->positions[b].w));
    }
}

const plii_feature_class plii_velocity_links_class = {
    .name = "velocity links",
    .state_size = sizeof(velocity_links_state),
    .stages[PLII_STAGE_PREPARE] = {velocity_links_prepare, PLII_ORDER_LINKS},
    .stages[PLII_STAGE_VELOCITY] = {velocity_links_solve, PLII_ORDER_LINKS},
    .stages[PLII_STAGE_DRIFT] = {plii_links_run, PLII_ORDER_LINKS},
    /* Each step prepares them anew. */
    .arrays = PLII_ARRAYS({PLII_MEMBER(velocity_links_state, links), PLII_PER_LINK, .snapshot = PLII_LEFT}),
};

static pli_status velocity_links_switch(pli_body* body, const plii_feature_class* enabled,
                                        const plii_feature_class* disabled, const char* function) {
    PLII_TRY(plii_check_body_idle(body, function));
    PLII_TRY(plii_solver_check_change(body, &plii_position_solver, function));
    PLII_TRY(plii_feature_enable(body, enabled, NULL));
    plii_feature_disable(body, disabled);
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_enable_velocity_links(pli_body* body) {
    return velocity_links_switch(body, &plii_velocity_links_class, &plii_links_class, __func__);
}
pli_status pli_body_disable_velocity_links(pli_body* body) {
    return velocity_links_switch(body, &plii_links_class, &plii_velocity_links_class, __func__);
}
