#include "lanes.h"

#include "link_chain.h"

enum {
    CHAIN_COLORS = 2,
    CHAIN_ROWS = 3,
    CHAIN_VECTORS = (PLII_LINK_CHAIN_MOST + 1) / (CHAIN_COLORS * PLII_LANES) /* of eight nodes */
};

// --------------------------------------------------------------------------------------------------------------- rows

bool plii_link_chain_fits(const pli_body* body) {
    if (body->link_count == 0 || body->link_count > PLII_LINK_CHAIN_MOST) { return false; }
    for (int i = 0; i < body->link_count; ++i) {
        const int *nodes = body->links[i].nodes, first = nodes[0] < nodes[1] ? nodes[0] : nodes[1];
        if (first != i || nodes[0] + nodes[1] != 2 * i + 1) { return false; }
    }
    return true;
}

/* Vectors for the even nodes; there are as many for the odd ones. */
static int chain_vector_count(int link_count) {
    return link_count / (CHAIN_COLORS * PLII_LANES) + 1;
}
static ptrdiff_t chain_row_length(int link_count) {
    return chain_vector_count(link_count) * PLII_LANES;
}

size_t plii_link_chain_bytes(const plii_link_chain* chain) {
    const size_t row_bytes = (size_t)chain_row_length(chain->link_count) * sizeof *chain->rows;
    return chain->link_count > 0 ? CHAIN_COLORS * CHAIN_ROWS * row_bytes : 0;
}

bool plii_link_chain_make(const pli_body* body, plii_link_chain* chain) {
    *chain = (plii_link_chain){.link_count = body->link_count, .is_stale = true};
    chain->rows = plii_allocate(body->context, plii_link_chain_bytes(chain));
    if (chain->rows == NULL) { chain->link_count = 0; }
    return chain->rows != NULL;
}

void plii_link_chain_release(const pli_body* body, plii_link_chain* chain) {
    plii_release(body->context, chain->rows, plii_link_chain_bytes(chain));
    *chain = (plii_link_chain){0};
}

/* Bullet leaves out links between two pinned nodes, and without length. */
static bool chain_fill(const pli_body* body, plii_link_chain* chain) {
    const ptrdiff_t length = chain_row_length(chain->link_count);
    for (int i = 0; i < CHAIN_COLORS * (int)length; ++i) {
        float* row = chain->rows + CHAIN_ROWS * length * (i % CHAIN_COLORS) + i / CHAIN_COLORS;
        if (i >= chain->link_count) {
            row[0] = 1.0f; /* a lane without a link, whose nodes are in one place */
            row[length] = row[2 * length] = 0.0f;
            continue;
        }
        const float mass_term = plii_link_mass_term(body, i), rest_squared = body->links[i].rest_length_squared;
        if (!(mass_term > 0.0f) || !(rest_squared > PLII_EPSILON)) { return false; }
        row[0] = rest_squared;
        row[length] = body->positions[i].w / mass_term;
        row[2 * length] = body->positions[i + 1].w / mass_term;
    }
    return true;
}

// ------------------------------------------------------------------------------------------------------------- sweeps

/* Every other node of eight. */
typedef struct chain_nodes {
    plii_vec3x4 positions;
    plii_float4 inverse_masses;
} chain_nodes;

/* Eight nodes: the even ones, and the odd ones. */
typedef struct chain_vectors {
    chain_nodes even, odd;
} chain_vectors;

/* Four records by their places after the first one, ascending. Where the last ones are one and the same, the first of
   them counts. */
typedef struct chain_places {
    ptrdiff_t second, third, fourth;
} chain_places;

PLII_SIMD_INLINE void chain_load(chain_nodes* nodes, const pli_vec4* first, chain_places at) {
    plii_float4 r[4] = {plii_float4_from(first), plii_float4_from(first + at.second),
                        plii_float4_from(first + at.third), plii_float4_from(first + at.fourth)};
    plii_float4_turn(r);
    *nodes = (chain_nodes){{r[0], r[1], r[2]}, r[3]};
}
PLII_SIMD_INLINE void chain_store(const chain_nodes* nodes, pli_vec4* first, chain_places at) {
    plii_float4 r[4] = {nodes->positions.x, nodes->positions.y, nodes->positions.z, nodes->inverse_masses};
    plii_float4_turn(r);
    plii_float4_to(first + at.fourth, r[3]);
    plii_float4_to(first + at.third, r[2]);
    plii_float4_to(first + at.second, r[1]);
    plii_float4_to(first, r[0]);
}
PLII_SIMD_INLINE void chain_set(chain_nodes* nodes, int lane, const pli_vec4* record) {
    const plii_float4 lanes = plii_lanes_xyzw(0.0f, 1.0f, 2.0f, 3.0f), own = plii_float4_all((float)lane);
    const plii_mask4 is_own = plii_lanes_both(plii_lanes_at_most(lanes, own), plii_lanes_at_most(own, lanes));
    plii_vec3x4* positions = &nodes->positions;
    positions->x = plii_lanes_select(is_own, plii_float4_all(record->x), positions->x);
    positions->y = plii_lanes_select(is_own, plii_float4_all(record->y), positions->y);
    positions->z = plii_lanes_select(is_own, plii_float4_all(record->z), positions->z);
}

/* The links between nodes a and b of each lane. */
PLII_SIMD_INLINE void chain_solve(plii_vec3x4* a, plii_vec3x4* b, const float* row, ptrdiff_t row_length) {
    const plii_vec3x4 delta = plii_vec3x4_sub(*b, *a);
    const plii_float4 length_squared = plii_vec3x4_dot(delta, delta), rest_squared = plii_float4_load(row);
    const plii_float4 k =
        plii_float4_div(plii_float4_sub(rest_squared, length_squared), plii_float4_add(rest_squared, length_squared));
    /* In this order only one product waits for the quotient. */
    const plii_vec3x4 way_a = plii_vec3x4_scale(delta, plii_float4_load(row + row_length));
    const plii_vec3x4 way_b = plii_vec3x4_scale(delta, plii_float4_load(row + 2 * row_length));
    *a = plii_vec3x4_sub(*a, plii_vec3x4_scale(way_a, k));
    *b = plii_vec3x4_add(*b, plii_vec3x4_scale(way_b, k));
}

static void chain_solve_even_links(chain_vectors* vectors, int count, const float* rows) {
    const ptrdiff_t row_length = (ptrdiff_t)PLII_LANES * count;
    for (int v = 0; v < count; ++v) {
        chain_solve(&vectors[v].even.positions, &vectors[v].odd.positions, rows + (ptrdiff_t)PLII_LANES * v,
                    row_length);
    }
}

PLII_SIMD_INLINE plii_vec3x4 chain_next(const plii_vec3x4* own, const plii_vec3x4* next) {
    return (plii_vec3x4){plii_lanes_next(own->x, next->x), plii_lanes_next(own->y, next->y),
                         plii_lanes_next(own->z, next->z)};
}
PLII_SIMD_INLINE plii_vec3x4 chain_before(const plii_vec3x4* before, const plii_vec3x4* own) {
    return (plii_vec3x4){plii_lanes_before(before->x, own->x), plii_lanes_before(before->y, own->y),
                         plii_lanes_before(before->z, own->z)};
}

/* They end at even nodes one lane further. */
static void chain_solve_odd_links(chain_vectors* vectors, int count, const float* rows) {
    const ptrdiff_t row_length = (ptrdiff_t)PLII_LANES * count;
    const plii_vec3x4* first = &vectors[0].even.positions;
    plii_vec3x4 before = {plii_lanes_all_x(first->x), plii_lanes_all_x(first->y), plii_lanes_all_x(first->z)};
    for (int v = 0; v < count; ++v) {
        plii_vec3x4* own = &vectors[v].even.positions;
        plii_vec3x4 ends = chain_next(own, v + 1 < count ? &vectors[v + 1].even.positions : own);
        chain_solve(&vectors[v].odd.positions, &ends, rows + (ptrdiff_t)PLII_LANES * v, row_length);
        *own = chain_before(&before, &ends);
        before = ends;
    }
}

static const chain_places chain_all_places = {2, 4, 6};

/* Behind the last one, counted from the first, there are more of it. */
static chain_places chain_places_up_to(int last) {
    return (chain_places){last < 2 ? last : 2, last < 4 ? last : 4, last < 6 ? last : 6};
}

static void chain_sweep(pli_body* body, const plii_link_chain* chain, int sweep_count,
                        plii_link_chain_before_fn* before) {
    const int last = chain->link_count, count = chain_vector_count(last), stride = CHAIN_COLORS * PLII_LANES;
    const float *even_rows = chain->rows, *odd_rows = even_rows + CHAIN_ROWS * chain_row_length(last);
    chain_vectors vectors[CHAIN_VECTORS], *end_vectors = &vectors[count - 1];
    pli_vec4 *records = body->positions, *end_records = records + (ptrdiff_t)stride * (count - 1);
    /* The last vectors hold nodes 0 to 7 of these, or fewer; without an odd one they hold node -1. */
    const int end_last = last - stride * (count - 1);
    const bool ends_even = end_last % 2 == 0;
    const int first_odd = end_last > 0 ? 1 : -1;
    const chain_places even_places = chain_places_up_to(ends_even ? end_last : end_last - 1);
    const chain_places odd_places = chain_places_up_to((ends_even ? end_last - 1 : end_last) - first_odd);
    for (int v = 0; v < count - 1; ++v) {
        chain_load(&vectors[v].even, records + (ptrdiff_t)stride * v, chain_all_places);
        chain_load(&vectors[v].odd, records + (ptrdiff_t)stride * v + 1, chain_all_places);
    }
    chain_load(&end_vectors->even, end_records, even_places);
    chain_load(&end_vectors->odd, end_records + first_odd, odd_places);

    chain_nodes* end = ends_even ? &end_vectors->even : &end_vectors->odd;
    for (int sweep = 0; sweep < sweep_count; ++sweep) {
        if (before != NULL) {
            if (sweep > 0) {
                chain_store(end, end_records + (ends_even ? 0 : first_odd), ends_even ? even_places : odd_places);
            }
            before(body);
            if (!ends_even) { chain_set(end, end_last / 2, &records[last]); }
        }
        chain_solve_even_links(vectors, count, even_rows);
        /* These did not need it, and so did not wait for it. */
        if (before != NULL && ends_even) { chain_set(end, end_last / 2, &records[last]); }
        chain_solve_odd_links(vectors, count, odd_rows);
    }
    chain_store(&end_vectors->even, end_records, even_places);
    chain_store(&end_vectors->odd, end_records + first_odd, odd_places);
    for (int v = 0; v < count - 1; ++v) {
        chain_store(&vectors[v].even, records + (ptrdiff_t)stride * v, chain_all_places);
        chain_store(&vectors[v].odd, records + (ptrdiff_t)stride * v + 1, chain_all_places);
    }
}

bool plii_link_chain_sweep(pli_body* body, plii_link_chain* chain, int sweep_count, plii_link_chain_before_fn* before) {
    if (chain->is_stale || chain->revision != body->link_revision) {
        chain->has_all_links = chain_fill(body, chain);
        chain->revision = body->link_revision;
        chain->is_stale = false;
    }
    if (chain->has_all_links) { chain_sweep(body, chain, sweep_count, before); }
    return chain->has_all_links;
}
