/* Closed bodies that are inside of each other where they were put into the world. */

#include "contact/soft_contacts_impl.h"

/* One that parts from others had it when it began to. */
static bool soft_has_inside(const pli_body* body) {
    return body->overlap_steps > 1 || (plii_topology_is_closed(body->topology) && plii_body_volume(body) > 0.0f);
}
bool plii_soft_contacts_may_be_inside(const pli_body* body, const pli_body* other) {
    if (body->overlap_steps + other->overlap_steps == 0) { return false; }
    if (!soft_has_inside(body) || !soft_has_inside(other)) { return false; }
    const pli_bounds a = plii_body_bounds_of(body, body->previous), b = plii_body_bounds_of(other, other->previous);
    return !plii_bounds_contain(a, b) && !plii_bounds_contain(b, a);
}

/* m/s, by which they part as a whole. If contacts drew nodes out, these would strain links, which throw them. */
#define SOFT_CONTACTS_PARTING 0.5f
/* Of the margins; what overlaps less is left to contacts. */
#define SOFT_CONTACTS_OVERLAP 0.1f
/* m: where both are held somewhere contacts draw an overlap out, as if it were so deep: at 4 cm/s. */
#define SOFT_CONTACTS_DRAWN 0.0035f

/* Seen from the sides between which they pass, nodes look outside in between. */
enum { SOFT_CONTACTS_OVERLAP_STEPS = 30 };

/* Of two bodies; `axis` is a unit vector, `out` the sum of overlaps along normals, of what is inside along the axis. */
typedef struct soft_overlap {
    float margin, drawn, deepest; /* m */
    pli_vec3 axis, out;
} soft_overlap;

/* Contacts from `first` on keep overlaps as they are, or take `drawn` of them. */
static void soft_keep_overlaps(const pli_body* body, const plii_soft_contacts_state* state, int first, float sign,
                               soft_overlap* all) {
    for (PLII_EACH(plii_soft_contact, contact, state->contacts + first, state->count - first)) {
        const int* face = contact->face_body->topology->faces[contact->face];
        const pli_vec3 from = plii_contact_blend(contact->face_body->previous, face, contact->weights);
        const float apart = pli_vec3_dot(contact->normal, pli_vec3_sub(plii_xyz(body->previous[contact->node]), from));
        const float depth = plii_max(all->margin - apart, 0.0f);
        contact->margin = plii_min(contact->margin, apart + all->drawn);
        all->deepest = plii_max(all->deepest, depth);
        const pli_vec3 way = apart < 0.0f ? all->axis : pli_vec3_scale(contact->normal, sign);
        all->out = pli_vec3_add(all->out, pli_vec3_scale(way, depth));
    }
}

/* 1/kg of it all, 0 where a node is pinned, or may be held by an anchor or a joint. */
static float soft_whole_weight(const pli_body* body) {
    float mass = plii_body_is_idle(body) || body->may_be_joined ? INFINITY : 0.0f;
    for (PLII_EACH(const pli_vec4, position, body->positions, body->node_count)) {
        mass += 1.0f / position->w;
    }
    return 1.0f / mass;
}

void plii_soft_contacts_part(pli_body* body, plii_soft_contacts_state* state, int first, pli_body* other,
                             plii_soft_contacts_state* other_state, int other_first) {
    const float weight = soft_whole_weight(body), other_weight = soft_whole_weight(other), sum = weight + other_weight;
    const pli_bounds a = plii_body_bounds_of(body, body->previous), b = plii_body_bounds_of(other, other->previous);
    const pli_vec3 axis = pli_vec3_sub(pli_vec3_add(a.min, a.max), pli_vec3_add(b.min, b.max));
    soft_overlap all = {.margin = body->collision_margin + other->collision_margin,
                        .drawn = sum > 0.0f ? 0.0f : SOFT_CONTACTS_DRAWN,
                        .axis = plii_vec3_safe_normalize(axis)};
    soft_keep_overlaps(body, state, first, 1.0f, &all);
    soft_keep_overlaps(other, other_state, other_first, -1.0f, &all);
    if (!(all.deepest > SOFT_CONTACTS_OVERLAP * all.margin)) { return; }
    if (body->overlap_steps > 0) { body->overlap_steps = SOFT_CONTACTS_OVERLAP_STEPS; }
    if (other->overlap_steps > 0) { other->overlap_steps = SOFT_CONTACTS_OVERLAP_STEPS; }
    const float length = plii_min(SOFT_CONTACTS_PARTING * body->step.dt, all.deepest);
    const pli_vec3 by = pli_vec3_scale(plii_vec3_safe_normalize(all.out), sum > 0.0f ? length / sum : 0.0f);
    state->parting = pli_vec3_add(state->parting, pli_vec3_scale(by, weight));
    other_state->parting = pli_vec3_sub(other_state->parting, pli_vec3_scale(by, other_weight));
}
