#pragma once

/* Soft bodies on soft bodies: six sheets that fall onto each other, the lowest held at its corners, and a hundred balls
   that overlap at the start. */

#include <pliant/contact.h>
#include <pliant/generate.h>
#include <pliant/implicit.h>
#include <pliant/tether.h>
#include <pliant/world.h>
#include <pliant/xpbd.h>

#include <math.h>
#include <string.h>

enum {
    PILE_SHEETS = 6,
    PILE_SIDE = 26,
    PILE_BALLS = 100,
    PILE_BALL_NODES = 20,
    PILE_MAX_BODIES = 128,
    PILE_MAX_CONTACTS = 8192
};

typedef enum pile_solver { PILE_POSITION_BASED, PILE_IMPLICIT, PILE_XPBD, PILE_SWEEPS } pile_solver;

typedef struct pile_def {
    pile_solver solver;
    float margin;         /* m, of each body */
    int iterations;       /* under XPBD substeps; as many sweeps, or one more, where these solve */
    float recovery_speed; /* m/s */
    bool colored;         /* links; position-based solver */
    bool has_tethers;
    bool may_sleep;
    float damping; /* share of the velocity lost per step */
} pile_def;

typedef struct pile {
    pli_world* world;
    int count;
    pli_body* bodies[PILE_MAX_BODIES];
} pile;

static inline pli_status pile_add(pile* all, const pile_def* def, pli_mesh* mesh) {
    pli_body_def body_def = pli_body_def_default();
    body_def.collision_margin = def->margin;
    body_def.solver.position_iterations = def->iterations;
    body_def.solver.velocity_damping = def->damping;
    pli_body* body = NULL;
    pli_status status = pli_body_create(all->world, mesh, &body_def, &body);
    pli_mesh_destroy(mesh);
    if (status == PLI_OK && def->solver == PILE_POSITION_BASED && def->colored) {
        status = pli_body_enable_colored_links(body);
    }
    if (status == PLI_OK && (def->solver == PILE_IMPLICIT || def->solver == PILE_SWEEPS)) {
        pli_implicit_def implicit = pli_implicit_def_default();
        implicit.stiffness = 5000;
        implicit.sweeps = def->iterations | 1;
        implicit.filter_compression = true; /* what buckles under a load flutters in sweeps */
        if (def->solver == PILE_IMPLICIT) {
            implicit.method = PLI_IMPLICIT_CONJUGATE_GRADIENT;
            implicit.sweeps = 50;
            implicit.filter_compression = false;
        }
        status = pli_body_enable_implicit(body, &implicit);
    }
    if (status == PLI_OK && def->solver == PILE_XPBD) {
        pli_xpbd_def xpbd = pli_xpbd_def_default();
        xpbd.substeps = def->iterations;
        status = pli_body_enable_xpbd(body, &xpbd);
        if (status == PLI_OK) { status = pli_body_enable_xpbd_links(body, NULL); }
    }
    if (status == PLI_OK && def->has_tethers) { status = pli_body_enable_tethers(body, NULL); }
    pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    contacts.recovery_speed = def->recovery_speed;
    if (status == PLI_OK) { status = pli_body_enable_soft_contacts(body, &contacts); }
    if (status == PLI_OK && def->may_sleep) { status = pli_body_enable_sleep(body, NULL); }
    all->bodies[all->count++] = body;
    return status;
}

/* 2 m by 2 m, 2 kg, 25 cm apart; cells of 8 cm. */
static inline pli_status pile_make_sheets(pli_world* world, const pile_def* def, pile* all) {
    memset(all, 0, sizeof *all);
    all->world = world;
    for (int k = 0; k < PILE_SHEETS; ++k) {
        const float y = 0.25f * (float)k;
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = pli_vec3_make(-1, y, -1);
        patch.corner_10 = pli_vec3_make(1, y, -1);
        patch.corner_01 = pli_vec3_make(-1, y, 1);
        patch.corner_11 = pli_vec3_make(1, y, 1);
        patch.columns = patch.rows = PILE_SIDE;
        patch.pins = k == 0 ? PLI_PATCH_PIN_CORNERS : 0;
        pli_mesh* mesh = NULL;
        pli_status status = pli_mesh_create_patch(pli_world_get_context(world), &patch, &mesh);
        if (status == PLI_OK) { status = pli_mesh_set_total_mass(mesh, 2); }
        if (status == PLI_OK) { status = pile_add(all, def, mesh); }
        if (status != PLI_OK) { return status; }
    }
    return PLI_OK;
}

/* Radius 10 cm, 0.1 kg, on a grid whose cells are 0.14 m, so that each overlaps its neighbours by 6 cm. */
static inline pli_status pile_make_balls(pli_world* world, const pile_def* def, pile* all) {
    memset(all, 0, sizeof *all);
    all->world = world;
    for (int k = 0; k < PILE_BALLS; ++k) {
        const pli_vec3 center = pli_vec3_make(0.14f * (float)(k % 5) + 0.01f * (float)(k % 3),
                                              0.5f + 0.14f * (float)(k / 25), 0.14f * (float)(k / 5 % 5));
        pli_mesh* mesh = NULL;
        pli_status status = pli_mesh_create_ellipsoid(pli_world_get_context(world), center,
                                                      pli_vec3_make(0.1f, 0.1f, 0.1f), PILE_BALL_NODES, &mesh);
        if (status == PLI_OK) { status = pli_mesh_set_total_mass(mesh, 0.1f); }
        if (status == PLI_OK) { status = pile_add(all, def, mesh); }
        if (status != PLI_OK) { return status; }
    }
    return PLI_OK;
}

// ---------------------------------------------------------------------------------------------------------- measures

/* Contacts of all bodies. */
static inline int pile_contacts(const pile* all) {
    int count = 0;
    for (int k = 0; k < all->count; ++k) {
        count += pli_body_get_soft_contacts(all->bodies[k], 0, NULL);
    }
    return count;
}

/* Contacts of the node that has most. */
static inline int pile_most_contacts_of_node(const pile* all) {
    static pli_soft_contact contacts[PILE_MAX_CONTACTS];
    int most = 0;
    for (int k = 0; k < all->count; ++k) {
        int of_node[PILE_SIDE * PILE_SIDE] = {0};
        const int count = pli_body_get_soft_contacts(all->bodies[k], PILE_MAX_CONTACTS, contacts);
        for (int i = 0; i < count && i < PILE_MAX_CONTACTS; ++i) {
            const int found = ++of_node[contacts[i].node];
            most = found > most ? found : most;
        }
    }
    return most;
}

static inline bool pile_is_asleep(const pile* all) {
    for (int k = 0; k < all->count; ++k) {
        if (!pli_body_is_asleep(all->bodies[k])) { return false; }
    }
    return true;
}

static inline int pile_nodes(const pile* all) {
    int count = 0;
    for (int k = 0; k < all->count; ++k) {
        count += pli_body_get_view(all->bodies[k]).node_count;
    }
    return count;
}

/* Root mean square of length / rest - 1 of the links. */
static inline double pile_stretch(const pile* all) {
    double sum = 0;
    int count = 0;
    for (int k = 0; k < all->count; ++k) {
        const pli_body_view view = pli_body_get_view(all->bodies[k]);
        for (int i = 0; i < view.link_count; ++i) {
            const int* nodes = view.link_nodes + (ptrdiff_t)i * view.link_node_stride;
            const pli_vec4 a = view.positions[nodes[0]], b = view.positions[nodes[1]];
            const double x = (double)a.x - (double)b.x, y = (double)a.y - (double)b.y, z = (double)a.z - (double)b.z;
            const double ratio = sqrt(x * x + y * y + z * z) / (double)pli_body_get_rest_length(all->bodies[k], i) - 1;
            sum += ratio * ratio;
            ++count;
        }
    }
    return sqrt(sum / count);
}

/* J, of what is not pinned. */
static inline double pile_kinetic_energy(const pile* all) {
    double energy = 0;
    for (int k = 0; k < all->count; ++k) {
        const pli_body_view view = pli_body_get_view(all->bodies[k]);
        for (int i = 0; i < view.node_count; ++i) {
            const pli_vec4 v = view.velocities[i];
            const double w = (double)view.positions[i].w;
            if (w > 0) { energy += 0.5 / w * ((double)(v.x * v.x + v.y * v.y + v.z * v.z)); }
        }
    }
    return energy;
}

/* m/s */
static inline double pile_rms_speed(const pile* all) {
    double sum = 0;
    for (int k = 0; k < all->count; ++k) {
        const pli_body_view view = pli_body_get_view(all->bodies[k]);
        for (int i = 0; i < view.node_count; ++i) {
            const pli_vec4 v = view.velocities[i];
            sum += (double)(v.x * v.x + v.y * v.y + v.z * v.z);
        }
    }
    return sqrt(sum / pile_nodes(all));
}

/* A node is more than `slack` below a face of the sheet, and not above another face of it. */
static inline bool pile_is_below(pli_vec4 p, const pli_body* sheet, float slack) {
    const pli_body_view faces = pli_body_get_view(sheet);
    bool is_below = false;
    for (int m = 0; m < faces.face_count; ++m) {
        const int* face = &faces.face_nodes[3 * m];
        const pli_vec4 a = faces.positions[face[0]], b = faces.positions[face[1]], c = faces.positions[face[2]];
        const float det = (b.x - a.x) * (c.z - a.z) - (c.x - a.x) * (b.z - a.z);
        if (fabsf(det) < 1e-9f) { continue; }
        const float u = ((p.x - a.x) * (c.z - a.z) - (c.x - a.x) * (p.z - a.z)) / det;
        const float v = ((b.x - a.x) * (p.z - a.z) - (p.x - a.x) * (b.z - a.z)) / det;
        if (u < 0 || v < 0 || u + v > 1) { continue; }
        if (p.y - (a.y + u * (b.y - a.y) + v * (c.y - a.y)) >= -slack) { return false; }
        is_below = true;
    }
    return is_below;
}

/* Nodes of the sheets that are below the sheet that was below theirs. */
static inline int pile_nodes_below(const pile* all, float slack) {
    int below = 0;
    for (int k = 1; k < all->count; ++k) {
        const pli_body_view nodes = pli_body_get_view(all->bodies[k]);
        for (int i = 0; i < nodes.node_count; ++i) {
            below += pile_is_below(nodes.positions[i], all->bodies[k - 1], slack);
        }
    }
    return below;
}

/* The faces of a body go round a point: their solid angle is that of a sphere and not zero. */
static inline bool pile_is_inside(pli_vec4 p, const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    double angle = 0;
    for (int m = 0; m < view.face_count; ++m) {
        pli_vec3 d[3];
        double length[3];
        for (int k = 0; k < 3; ++k) {
            const pli_vec4 x = view.positions[view.face_nodes[3 * m + k]];
            d[k] = pli_vec3_make(x.x - p.x, x.y - p.y, x.z - p.z);
            length[k] = (double)pli_vec3_length(d[k]);
        }
        const double volume = (double)pli_vec3_dot(d[0], pli_vec3_cross(d[1], d[2]));
        angle += 2 * atan2(volume, length[0] * length[1] * length[2] + (double)pli_vec3_dot(d[0], d[1]) * length[2] +
                                       (double)pli_vec3_dot(d[1], d[2]) * length[0] +
                                       (double)pli_vec3_dot(d[2], d[0]) * length[1]);
    }
    return fabs(angle) > 6;
}

/* Nodes that are inside of another body. */
static inline int pile_nodes_inside(const pile* all) {
    int inside = 0;
    for (int k = 0; k < all->count * all->count; ++k) {
        const pli_body *body = all->bodies[k / all->count], *other = all->bodies[k % all->count];
        const pli_bounds a = pli_body_get_bounds(body), b = pli_body_get_bounds(other);
        const bool is_near = a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y &&
                             a.min.z < b.max.z && b.min.z < a.max.z;
        const pli_body_view nodes = pli_body_get_view(body);
        for (int i = 0; body != other && is_near && i < nodes.node_count; ++i) {
            inside += pile_is_inside(nodes.positions[i], other);
        }
    }
    return inside;
}
