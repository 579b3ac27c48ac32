/* What hosts see and set of sleep; the rest is a feature (features/sleep.c). */

#include "body/pipeline.h"

uint32_t plii_world_next_sleep_group(pli_world* world) {
    world->sleep_group += world->sleep_group == UINT32_MAX ? 2 : 1;
    return world->sleep_group;
}

void plii_body_fall_asleep(pli_body* body, uint32_t group) {
    body->is_asleep = true;
    body->is_woken = false;
    body->sleep_group = group;
    const size_t bytes = (size_t)body->node_count * sizeof(pli_vec4);
    memset(body->velocities, 0, bytes);
    memcpy(body->previous, body->positions, bytes);
}

PLII_DEFINE_GET(bool, pli_body_is_asleep, body, body->is_asleep && !body->is_woken, false)
PLII_DEFINE_GET(bool, pli_body_is_resting, body, body->is_resting, false)
PLII_DEFINE_GET(bool, pli_rigid_is_asleep, rigid, rigid->is_asleep, false)

typedef struct held_rigids {
    pli_rigid** rigids;
    int count, capacity;
} held_rigids;

static void held_rigids_add(pli_body* body, pli_rigid* rigid, void* user) {
    held_rigids* held = user;
    if (rigid == NULL) { return; }
    if (held->count < held->capacity) { held->rigids[held->count] = rigid; }
    held->count += 1;
}

int pli_body_get_held_rigids(const pli_body* body, int capacity, pli_rigid** rigids) {
    if (plii_check_body(body, __func__) != PLI_OK || !body->may_be_joined) { return 0; }
    held_rigids held = {rigids, 0, rigids != NULL ? capacity : 0};
    plii_features_visit_joined(body, held_rigids_add, &held);
    return held.count;
}

pli_status pli_body_set_asleep(pli_body* body, bool asleep) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    if (!body->can_sleep) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "the body has no sleep enabled"); }
    body->is_woken = !asleep;
    if (asleep && !body->is_asleep) { plii_body_fall_asleep(body, plii_world_next_sleep_group(body->world)); }
    return PLI_OK;
}
