/* Springs to the blocks of W and to the right-hand side. Each node gathers from the springs around it in the order of
   links, and forces on both ends of a spring are equal and opposite bit for bit. Linearisation as in Kang, "Efficient
   Methods for Cloth Animation and Collision Handling": a spring shorter than its rest length has the derivative of one
   at rest; or, with filtered compression and where it would burst sideways, the absolute value of the derivative across
   it: Chen and others, "Stabler Neo-Hookean Simulation: Absolute Eigenvalue Filtering". */

#include "math/simd_float4.h"
#include "solver/implicit/implicit_system.h"

/* Springs shorter than this share of their rest length have no direction. */
#define IMPLICIT_MIN_LENGTH 1e-6
/* By how much more than a node is off the line of its springs, they may push it away in a step, before they resist. */
#define IMPLICIT_MOST_BUCKLING 30.0

typedef struct implicit_spring {
    plii_dvec3 impulse; /* h times the force on the node */
    plii_implicit_half half;
    plii_dvec3 unit; /* towards the neighbour */
    double damping;  /* N s/m */
    bool is_collapsed;
} implicit_spring;

/* Of the stiffness of a compressed spring across it: the absolute value, or what of it is beyond
   IMPLICIT_MOST_BUCKLING. `firmness`: h^2 k over the mass of the lighter end. */
static double implicit_across_compressed(const pli_implicit_def* def, double shortening, double firmness) {
    if (def->filter_compression) { return fmin(shortening, 1.0); }
    const bool bursts = shortening * firmness > IMPLICIT_MOST_BUCKLING;
    return bursts ? fmin(shortening - IMPLICIT_MOST_BUCKLING / firmness, 1.0) : 0.0;
}

PLII_SIMD_INLINE implicit_spring implicit_make_spring(const pli_body* body, const pli_implicit_def* def, double h,
                                                      int node, plii_half_link half_link) {
    const plii_dvec3 delta = plii_dvec3_sub(plii_implicit_xyz(&body->positions[half_link.neighbour]),
                                            plii_implicit_xyz(&body->positions[node]));
    const double length = plii_dvec3_length(delta);
    const double rest = sqrt((double)body->links[half_link.link].rest_length_squared);
    const double material = (double)plii_link_stiffness(body, half_link.link);
    const double stiffness = (double)def->stiffness * material;
    implicit_spring spring = {.half = {.neighbour = half_link.neighbour}};
    if (!(length > IMPLICIT_MIN_LENGTH * rest)) {
        /* Without a rest length the force is k delta, which has no need of a direction. */
        if (rest > 0.0) { spring.is_collapsed = true; }
        if (rest == 0.0) { spring.half.isotropic = (float)(h * h * stiffness); }
        return spring;
    }
    const plii_dvec3 unit = plii_dvec3_scale(delta, 1.0 / length);
    double transverse = length > rest ? 1.0 - rest / length : 0.0;
    if (length < rest) {
        const double mobility = fmax((double)body->positions[node].w, (double)body->positions[half_link.neighbour].w);
        transverse = implicit_across_compressed(def, rest / length - 1.0, mobility * h * h * stiffness);
    }
    spring.unit = unit;
    spring.damping = (double)def->damping * material;
    const double axial = h * h * stiffness * (1.0 - transverse) + h * spring.damping;
    spring.impulse = plii_dvec3_scale(unit, h * stiffness * (length - rest));
    spring.half.axis = plii_dvec3_to_float(plii_dvec3_scale(unit, sqrt(axial)));
    spring.half.isotropic = (float)(h * h * stiffness * transverse);
    return spring;
}

/* Without memory it is left out. */
static void implicit_add_hold(const plii_node_spring* spring, void* user) {
    plii_implicit_system* system = user;
    const pli_body* body = system->body;
    plii_implicit_holds* holds = &system->holds;
    const int node = spring->node;
    if (!(body->positions[node].w > 0.0f) || !PLII_GROW(body->context, &holds->items, &holds->capacity, holds->count)) {
        return;
    }
    const double h = (double)body->step.dt;
    plii_implicit_hold hold = {.node = node, .hardness = (double)spring->hardness};
    if (!plii_vec3_is_zero(spring->along)) {
        hold.hardness *= (double)system->def.stiffness * h * h;
        hold.along = plii_dvec3_from(spring->along);
    }
    const plii_dvec3 velocity = plii_implicit_xyz(&body->velocities[node]);
    const plii_dvec3 way = plii_dvec3_scale(plii_dvec3_from(spring->way), 1.0 / h);
    hold.rhs = plii_implicit_hold_mul(&hold, plii_dvec3_sub(way, velocity));
    system->rhs[node] = plii_dvec3_add(system->rhs[node], hold.rhs);
    int place = holds->count++;
    for (; place > 0 && holds->items[place - 1].node > node; --place) {
        holds->items[place] = holds->items[place - 1];
    }
    holds->items[place] = hold;
}

void plii_implicit_gather_holds(pli_body* body, plii_implicit_system* system) {
    system->holds.count = 0;
    for (PLII_EACH_FEATURE(feature, body)) {
        if (feature->klass->visit_springs != NULL) {
            feature->klass->visit_springs(body, feature->state, implicit_add_hold, system);
        }
    }
}

/* Of a node, from hold `first` on. Gives the first one after them. */
static int implicit_add_held(const plii_implicit_holds* holds, int first, int node, double d[6]) {
    int i = first;
    for (; i < holds->count && holds->items[i].node == node; ++i) {
        const plii_dvec3 x = plii_implicit_hold_mul(&holds->items[i], plii_dvec3_make(1, 0, 0)),
                         y = plii_implicit_hold_mul(&holds->items[i], plii_dvec3_make(0, 1, 0)),
                         z = plii_implicit_hold_mul(&holds->items[i], plii_dvec3_make(0, 0, 1));
        d[0] += x.x;
        d[1] += x.y;
        d[2] += x.z;
        d[3] += y.y;
        d[4] += y.z;
        d[5] += z.z;
    }
    return i;
}

/* The velocity that leads from where springs are linearised to where the node would be in free flight. */
PLII_SIMD_INLINE plii_dvec3 implicit_lead(const pli_body* body, const plii_dvec3* leads, int node) {
    return leads != NULL ? leads[node] : plii_implicit_xyz(&body->velocities[node]);
}

PLII_SIMD_INLINE int implicit_assemble_node(const plii_implicit_system* system, double h, int node,
                                            const plii_dvec3* leads, int* hold) {
    const pli_body* body = system->body;
    const plii_link_graph* graph = system->graph;
    const double mass = 1.0 / (double)body->positions[node].w;
    double d[6] = {mass, 0.0, 0.0, mass, 0.0, mass}; /* xx, xy, xz, yy, yz, zz */
    *hold = implicit_add_held(&system->holds, *hold, node, d);
    plii_dvec3 rhs = system->rhs[node];
    const plii_dvec3 velocity = implicit_lead(body, leads, node);
    int collapsed = 0;
    for (int k = graph->begin[node]; k < graph->begin[node + 1]; ++k) {
        const implicit_spring spring = implicit_make_spring(body, &system->def, h, node, graph->halves[k]);
        system->halves[k] = spring.half;
        /* Once per spring: by the end that moves, or by the first of two. */
        const bool is_counted =
            spring.is_collapsed && (node < spring.half.neighbour || !(body->positions[spring.half.neighbour].w > 0.0f));
        collapsed += is_counted ? 1 : 0;
        const plii_dvec3 q = plii_dvec3_from(spring.half.axis);
        const double b = (double)spring.half.isotropic;
        const plii_dvec3 difference = plii_dvec3_sub(implicit_lead(body, leads, spring.half.neighbour), velocity);
        rhs = plii_dvec3_add(rhs, spring.impulse);
        rhs = plii_dvec3_add_scaled(rhs, q, plii_dvec3_dot(q, difference));
        rhs = plii_dvec3_add_scaled(rhs, difference, b);
        if (leads != NULL && spring.damping > 0.0) {
            const plii_dvec3 moved =
                plii_dvec3_sub(plii_implicit_moved(body, spring.half.neighbour), plii_implicit_moved(body, node));
            rhs = plii_dvec3_add_scaled(rhs, spring.unit, spring.damping * plii_dvec3_dot(spring.unit, moved));
        }
        /* rest == 0 and no length: the impulse h k delta is zero too. */
        d[0] += q.x * q.x + b;
        d[1] += q.x * q.y;
        d[2] += q.x * q.z;
        d[3] += q.y * q.y + b;
        d[4] += q.y * q.z;
        d[5] += q.z * q.z + b;
    }
    system->rhs[node] = rhs;
    system->blocks[node] = plii_implicit_factorise(d, mass);
    return collapsed;
}

static double implicit_assemble_block(int begin, int end, const void* data) {
    const plii_implicit_system* system = data;
    const pli_body* body = system->body;
    const plii_link_graph* graph = system->graph;
    const double h = (double)body->step.dt;
    const plii_implicit_holds* holds = &system->holds;
    int collapsed = 0, hold = plii_csr_first(holds->items, sizeof *holds->items, offsetof(plii_implicit_hold, node),
                                             holds->count, begin);
    for (int i = begin; i < end; ++i) {
        if (body->positions[i].w > 0.0f) {
            /* Without leads, as in most calls, a copy of its own. */
            collapsed += system->leads == NULL ? implicit_assemble_node(system, h, i, NULL, &hold)
                                               : implicit_assemble_node(system, h, i, system->leads, &hold);
            continue;
        }
        system->rhs[i] = (plii_dvec3){0};
        system->blocks[i] = (plii_implicit_block){0};
        for (int k = graph->begin[i]; k < graph->begin[i + 1]; ++k) {
            system->halves[k] = (plii_implicit_half){.neighbour = graph->halves[k].neighbour};
        }
    }
    return collapsed;
}

enum { IMPLICIT_ASSEMBLE_NS = 250 }; /* per node */

int plii_implicit_assemble(const plii_implicit_system* system) {
    const pli_body* body = system->body;
    return (int)plii_sum_blocks(body->context, body->node_count, plii_grain(IMPLICIT_ASSEMBLE_NS),
                                implicit_assemble_block, system);
}
