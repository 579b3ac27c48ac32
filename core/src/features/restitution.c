/* Restitution: what meets a rigid body fast leaves it with a share of the speed. After the solve, which stops what
   comes near, as in Müller and others, "Detailed Rigid Body Simulation with Extended Position Based Dynamics" (2020),
   section 3.6. Contacts of nodes and faces are asked for what they report, before and after. */

#include "body/contact_report.h"
#include "body/pipeline.h"
#include "body/substep_rigid.h"
#include "pliant/contact.h"

/* Of what gravity gives in a step: slower approach is that of what lies. */
#define RESTITUTION_LEAST_STEPS 2.0f
/* Of the margin, how far from the surface a contact still counts as touching. */
#define RESTITUTION_REACH 0.1f
/* Of a node in the point of a contact, that it counts: each is sent back by its own speed, lest one gets more than it
   had. */
#define RESTITUTION_LEAST_WEIGHT 0.2f
/* Features that make contacts. */
enum { RESTITUTION_MOST_KINDS = 8 };

typedef struct restitution_state {
    float restitution;
    float* approaches; /* m/s, of the contacts in the order of reports, before the solve; < 0: towards each other */
    int count, capacity;
    int ends[RESTITUTION_MOST_KINDS]; /* of the approaches of each kind; the solve may add contacts to it */
    int index, end;                   /* of the next report, and of its kind */
} restitution_state;

/* Of a node along the normal, from the surface. */
static float restitution_speed(const pli_body* body, const plii_contact_report* report, int k) {
    const pli_vec3 arm = pli_vec3_sub(report->point, report->rigid->state.pose.origin);
    const pli_vec3 surface = plii_rigid_pace_at(body, report->rigid, arm);
    return pli_vec3_dot(report->normal, pli_vec3_sub(plii_xyz(body->velocities[report->nodes[k]]), surface));
}

static void restitution_note(pli_body* body, const plii_contact_report* report, void* data) {
    restitution_state* state = data;
    for (int k = 0; k < report->node_count; ++k) {
        if (!(report->weights[k] > RESTITUTION_LEAST_WEIGHT)) { continue; }
        if (!PLII_GROW(body->context, &state->approaches, &state->capacity, state->count)) { return; }
        state->approaches[state->count++] = restitution_speed(body, report, k);
    }
}

static void restitution_push(pli_body* body, const plii_contact_report* report, int k, float lacking) {
    const pli_vec3 arm = pli_vec3_sub(report->point, report->rigid->state.pose.origin);
    const plii_substep_rigid_point touched = {report->rigid, arm};
    const float own = body->positions[report->nodes[k]].w,
                weight = own + plii_substep_rigid_point_weight(&touched, report->normal);
    const pli_vec3 impulse = pli_vec3_scale(report->normal, lacking / weight);
    if (!(lacking > 0.0f) || !plii_vec3_is_finite(impulse)) { return; }
    plii_add_xyz(&body->velocities[report->nodes[k]], pli_vec3_scale(impulse, own));
    if (report->rigid->state.inverse_mass > 0.0f) {
        plii_rigid_push_at(body, report->rigid, pli_vec3_neg(impulse), arm);
    }
}

static void restitution_return(pli_body* body, const plii_contact_report* report, void* data) {
    restitution_state* state = data;
    const float slow = RESTITUTION_LEAST_STEPS * pli_vec3_length(body->world->def.gravity) * body->step.dt;
    const bool touches = report->gap < RESTITUTION_REACH * body->collision_margin;
    for (int k = 0; k < report->node_count; ++k) {
        if (!(report->weights[k] > RESTITUTION_LEAST_WEIGHT)) { continue; }
        if (state->index == state->end) { return; } /* the solve has found it itself */
        const float approach = state->approaches[state->index++];
        if (!(approach < -slow) || !touches) { continue; }
        const float wanted = -state->restitution * report->rigid->restitution * approach;
        restitution_push(body, report, k, wanted - restitution_speed(body, report, k));
    }
}

static void restitution_visit_contacts(pli_body* body, restitution_state* state, bool is_solved) {
    int kind = 0;
    for (PLII_EACH_FEATURE(feature, body)) {
        if (feature->klass->visit_contacts == NULL || kind == RESTITUTION_MOST_KINDS) { continue; }
        state->end = is_solved ? state->ends[kind] : 0;
        feature->klass->visit_contacts(body, feature->state, is_solved ? restitution_return : restitution_note, state);
        state->ends[kind] = is_solved ? state->ends[kind] : state->count;
        state->index = state->ends[kind++];
    }
}

static void restitution_prepare(pli_body* body, void* data) {
    restitution_state* state = data;
    state->count = 0;
    restitution_visit_contacts(body, state, false);
}

static void restitution_finish(pli_body* body, void* data) {
    restitution_state* state = data;
    state->index = 0;
    if (state->count > 0) { restitution_visit_contacts(body, state, true); }
}

static void restitution_reserve(pli_body* body, void* data) {
    restitution_state* state = data;
    if (body->world->rigid_count == 0) { return; }
    (void)PLII_RESERVE(body->context, &state->approaches, &state->capacity, plii_body_contact_bound(body));
}

/* Before all that solves; after contacts of faces and before what holds nodes. */
enum { RESTITUTION_ORDER = 0, RESTITUTION_FINISH_ORDER = 90 };
const plii_feature_class plii_restitution_class = {
    .name = "restitution",
    .state_size = sizeof(restitution_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(restitution_state, restitution, PLII_SAVED, "f"),
                                    PLII_STATE_SPAN(restitution_state, ends, end, PLII_LEFT, NULL)),
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(restitution_state, restitution, 0, 1)),
    .stages = {[PLII_STAGE_PREPARE] = {restitution_prepare, RESTITUTION_ORDER},
               [PLII_STAGE_FINISH] = {restitution_finish, RESTITUTION_FINISH_ORDER}},
    .substepped = PLII_SUBSTEPPED(.order = RESTITUTION_ORDER, .begin = restitution_prepare),
    .reserve = restitution_reserve,
    /* Of a step; cuts are between steps. */
    .arrays =
        PLII_ARRAYS({PLII_LIST_OF(restitution_state, approaches, capacity), .is_kept = true, .snapshot = PLII_LEFT}),
};

pli_status pli_body_enable_restitution(pli_body* body, float restitution) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_limits(body->context, &restitution, &plii_restitution_class.settings, __func__));
    return plii_feature_enable_with(body, &plii_restitution_class, &restitution, sizeof restitution, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_restitution, plii_check_body_change, plii_restitution_class)
