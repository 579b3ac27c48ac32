/* Substeps of XPBD with nodes in planes. No memory of its own: planes of what a step needs lie in the places of records
   that it does not need at that time. Positions take those of the predicted positions, displacements their own,
   accelerations those of what is carried, velocities those of the accelerations, and what is carried those of the
   velocities. */

#include "math/lanes.h"

#include "solver/xpbd/xpbd_impl.h"

#include <string.h>

static plii_planes xpbd_planes_xyz(pli_vec4* place, int node_count) {
    plii_planes planes = plii_planes_at(place, node_count);
    planes.w = NULL;
    return planes;
}

static void xpbd_planes_lay_out(plii_xpbd_plane_nodes* nodes) {
    const pli_body* body = nodes->body;
    const plii_xpbd_records* records = nodes->records;
    const int count = body->node_count;
    nodes->block_count = ((count + 1) / 2 + PLII_LANES - 1) / PLII_LANES;
    nodes->accelerations = xpbd_planes_xyz(records->carried, count);
    nodes->velocities = xpbd_planes_xyz(records->accelerations, count);
    nodes->moving.positions = xpbd_planes_xyz(body->positions, count);
    nodes->moving.displacements = plii_planes_at(records->displacements, count);
    nodes->moving.carried = xpbd_planes_xyz(body->velocities, count);
}

// ------------------------------------------------------------------------------------------------------- there and
// back

static void xpbd_planes_take_accelerations(int begin, int end, void* data) {
    const plii_xpbd_plane_nodes* nodes = data;
    plii_planes_take(&nodes->accelerations, nodes->records->accelerations, begin, end);
}
static void xpbd_planes_take_velocities(int begin, int end, void* data) {
    const plii_xpbd_plane_nodes* nodes = data;
    const plii_planes* displacements = &nodes->moving.displacements;
    plii_planes_take(&nodes->velocities, nodes->body->velocities, begin, end);
    for (int i = begin; i < end; ++i) {
        const ptrdiff_t place = plii_planes_place(displacements, i);
        displacements->w[place] = nodes->body->positions[i].w;
        displacements->x[place] = displacements->y[place] = displacements->z[place] = 0.0f;
    }
}
static void xpbd_planes_take_positions(int begin, int end, void* data) {
    const plii_xpbd_plane_nodes* nodes = data;
    const plii_planes* carried = &nodes->moving.carried;
    plii_planes_take(&nodes->moving.positions, nodes->body->previous, begin, end);
    for (int i = begin; i < end; ++i) {
        const ptrdiff_t place = plii_planes_place(carried, i);
        carried->x[place] = carried->y[place] = carried->z[place] = 0.0f;
    }
}

/* What lies behind the even and the odd nodes stays where it is. */
static void xpbd_planes_fill_plane(const plii_planes* planes, int node_count) {
    for (int node = node_count; node < node_count + 2; ++node) {
        for (ptrdiff_t i = plii_planes_place(planes, node); i % planes->odd != 0; ++i) {
            planes->x[i] = planes->y[i] = planes->z[i] = 0.0f;
            if (planes->w != NULL) { planes->w[i] = 0.0f; }
        }
    }
}

static void xpbd_planes_fill(const plii_xpbd_plane_nodes* nodes) {
    const int count = nodes->body->node_count;
    xpbd_planes_fill_plane(&nodes->accelerations, count);
    xpbd_planes_fill_plane(&nodes->velocities, count);
    xpbd_planes_fill_plane(&nodes->moving.positions, count);
    xpbd_planes_fill_plane(&nodes->moving.displacements, count);
    xpbd_planes_fill_plane(&nodes->moving.carried, count);
}

/* Accelerations are done with: records of the positions go through their place. */
static void xpbd_planes_give_positions(int begin, int end, void* data) {
    const plii_xpbd_plane_nodes* nodes = data;
    plii_planes positions = nodes->moving.positions;
    positions.w = nodes->moving.displacements.w;
    plii_planes_give(&positions, nodes->records->carried, begin, end);
}
static void xpbd_planes_give_velocities(int begin, int end, void* data) {
    const plii_xpbd_plane_nodes* nodes = data;
    plii_planes_give(&nodes->velocities, nodes->body->velocities, begin, end);
    memcpy(&nodes->body->positions[begin], &nodes->records->carried[begin], (size_t)(end - begin) * sizeof(pli_vec4));
}

// ------------------------------------------------------------------------------------------------------------- moving

/* One component; what is done to records in solve_xpbd.c. */
typedef struct xpbd_component {
    float *positions, *displacements, *carried, *velocities;
    const float *accelerations, *inverse_masses;
    plii_float4 dt, inverse_dt;
} xpbd_component;

PLII_SIMD_INLINE void xpbd_component_move(const xpbd_component* c, int node, plii_float4 velocity,
                                          plii_float4 carried) {
    velocity = plii_float4_add(velocity, plii_float4_mul(plii_float4_load(c->accelerations + node), c->dt));
    plii_float4_store(c->velocities + node, velocity);
    plii_float4_store(c->displacements + node, plii_float4_add(carried, plii_float4_mul(velocity, c->dt)));
}

PLII_SIMD_INLINE plii_float4 xpbd_component_finish(const xpbd_component* c, int node, plii_float4* carried) {
    const plii_float4 before = plii_float4_load(c->positions + node);
    const plii_float4 displacement = plii_float4_load(c->displacements + node);
    const plii_float4 velocity = plii_float4_load(c->velocities + node);
    const plii_float4 motion = plii_float4_sub(displacement, plii_float4_load(c->carried + node));
    const plii_float4 change = plii_float4_sub(motion, plii_float4_mul(velocity, c->dt));
    const plii_float4 changed = plii_float4_add(velocity, plii_float4_mul(change, c->inverse_dt));
    const plii_float4 after = plii_float4_add(before, displacement);
    *carried = plii_float4_sub(displacement, plii_float4_sub(after, before));
    plii_float4_store(c->positions + node, after);
    plii_float4_store(c->carried + node, *carried);
    const plii_mask4 is_free = plii_lanes_less(plii_float4_all(0.0f), plii_float4_load(c->inverse_masses + node));
    return plii_lanes_select(is_free, changed, velocity);
}

typedef void xpbd_component_fn(const xpbd_component* component, int begin, int end);

static void xpbd_component_move_nodes(const xpbd_component* component, int begin, int end) {
    const xpbd_component c = *component;
    for (int i = begin; i < end; i += PLII_LANES) {
        xpbd_component_move(&c, i, plii_float4_load(c.velocities + i), plii_float4_load(c.carried + i));
    }
}
static void xpbd_component_finish_nodes(const xpbd_component* component, int begin, int end) {
    const xpbd_component c = *component;
    for (int i = begin; i < end; i += PLII_LANES) {
        plii_float4 carried;
        plii_float4_store(c.velocities + i, xpbd_component_finish(&c, i, &carried));
    }
}
static void xpbd_component_finish_and_move_nodes(const xpbd_component* component, int begin, int end) {
    const xpbd_component c = *component;
    for (int i = begin; i < end; i += PLII_LANES) {
        plii_float4 carried;
        const plii_float4 velocity = xpbd_component_finish(&c, i, &carried);
        xpbd_component_move(&c, i, velocity, carried);
    }
}

static void xpbd_planes_run(const plii_xpbd_plane_nodes* nodes, xpbd_component_fn* run, int begin, int end) {
    const plii_xpbd_planes* moving = &nodes->moving;
    const plii_planes *velocities = &nodes->velocities, *accelerations = &nodes->accelerations;
    const plii_float4 dt = plii_float4_all(nodes->dt), inverse_dt = plii_float4_all(nodes->inverse_dt);
    const xpbd_component components[3] = {{moving->positions.x, moving->displacements.x, moving->carried.x,
                                           velocities->x, accelerations->x, moving->displacements.w, dt, inverse_dt},
                                          {moving->positions.y, moving->displacements.y, moving->carried.y,
                                           velocities->y, accelerations->y, moving->displacements.w, dt, inverse_dt},
                                          {moving->positions.z, moving->displacements.z, moving->carried.z,
                                           velocities->z, accelerations->z, moving->displacements.w, dt, inverse_dt}};
    const int odd = (int)moving->positions.odd, even_begin = PLII_LANES * begin, even_end = PLII_LANES * end;
    for (int k = 0; k < 3; ++k) {
        run(&components[k], even_begin, even_end);
        run(&components[k], odd + even_begin, odd + even_end);
    }
}

static void xpbd_planes_move(int begin, int end, void* nodes) {
    xpbd_planes_run(nodes, xpbd_component_move_nodes, begin, end);
}
static void xpbd_planes_finish(int begin, int end, void* nodes) {
    xpbd_planes_run(nodes, xpbd_component_finish_nodes, begin, end);
}
static void xpbd_planes_finish_and_move(int begin, int end, void* nodes) {
    xpbd_planes_run(nodes, xpbd_component_finish_and_move_nodes, begin, end);
}

const plii_xpbd_plane_moves plii_xpbd_moves_in_planes = {
    .lay_out = xpbd_planes_lay_out,
    .takes = {xpbd_planes_take_accelerations, xpbd_planes_take_velocities, xpbd_planes_take_positions},
    .gives = {xpbd_planes_give_positions, xpbd_planes_give_velocities},
    .fill = xpbd_planes_fill,
    .move = xpbd_planes_move,
    .finish = xpbd_planes_finish,
    .finish_and_move = xpbd_planes_finish_and_move,
};
