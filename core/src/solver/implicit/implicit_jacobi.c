/* Solutions of the implicit system: Jacobi sweeps and the same with Chebyshev weights. */

#include "solver/implicit/implicit_system.h"

/* Sum over the neighbours of h^2 J_ij x_j. */
static plii_dvec3 implicit_gather(const plii_implicit_system* system, int node, const plii_dvec3* x) {
    plii_dvec3 sum = {0};
    for (int k = system->graph->begin[node]; k < system->graph->begin[node + 1]; ++k) {
        const plii_implicit_half* half = &system->halves[k];
        const plii_dvec3 q = plii_dvec3_from(half->axis), other = x[half->neighbour];
        sum = plii_dvec3_add_scaled(sum, q, plii_dvec3_dot(q, other));
        sum = plii_dvec3_add_scaled(sum, other, (double)half->isotropic);
    }
    return sum;
}

plii_dvec3 plii_implicit_swept(const plii_implicit_system* system, int node) {
    const plii_dvec3 b = plii_dvec3_add(system->rhs[node], implicit_gather(system, node, system->solution));
    return plii_implicit_block_solve(&system->blocks[node], b);
}

enum { IMPLICIT_SOLVE_NS = 5, IMPLICIT_SWEEP_NS = 40 }; /* per node */

static void implicit_solve_range(int begin, int end, void* data) {
    const plii_implicit_pass* pass = data;
    for (int i = begin; i < end; ++i) {
        pass->to[i] = plii_implicit_block_solve(&pass->system->blocks[i], pass->a[i]);
    }
}

void plii_implicit_solve_blocks(const plii_implicit_system* system, const plii_dvec3* from, plii_dvec3* to) {
    plii_implicit_pass pass = {.system = system, .a = from, .to = to};
    plii_body_run_nodes(system->body, implicit_solve_range, &pass, plii_grain(IMPLICIT_SOLVE_NS));
}

static void implicit_sweep_range(int begin, int end, void* data) {
    const plii_implicit_pass* pass = data;
    for (int i = begin; i < end; ++i) {
        pass->to[i] = plii_implicit_swept(pass->system, i);
    }
}

static void implicit_run_sweep(const plii_implicit_system* system, plii_dvec3* swept) {
    plii_implicit_pass pass = {.system = system, .to = swept};
    plii_body_run_nodes(system->body, implicit_sweep_range, &pass, plii_grain(IMPLICIT_SWEEP_NS));
}

/* Friction of what nothing moves on each node as if it were alone. A sweep passes on little of it where springs are
   stiffer along the surface than across, as of a sheet that lies: what turned would go on turning. */
static void implicit_start_friction(plii_implicit_system* system) {
    const plii_implicit_constraints* constraints = &system->constraints;
    for (PLII_EACH(const plii_implicit_constraint, constraint, constraints->items, constraints->node_bound_count)) {
        if (constraint->is_anchor || constraints->rigids[constraint->rigid].is_dynamic) { continue; }
        const plii_dvec3 n = constraint->normal;
        plii_dvec3* x = &system->solution[constraint->nodes[0]];
        const plii_dvec3 off = plii_dvec3_sub(constraint->target, *x);
        const double pressing = plii_dvec3_dot(n, off);
        const plii_dvec3 across = plii_dvec3_add_scaled(off, n, -pressing);
        const double sliding = plii_dvec3_length(across), most = constraint->friction * pressing;
        if (most > 0.0) { *x = plii_dvec3_add_scaled(*x, across, sliding > most ? most / sliding : 1.0); }
    }
}

/* One more than `sweeps` from a given solution, so that the square that makes odd counts safe stays one. */
void plii_implicit_jacobi(plii_implicit_system* system, int sweeps, bool is_warm) {
    if (is_warm) {
        implicit_start_friction(system);
    } else {
        plii_implicit_solve_blocks(system, system->rhs, system->solution);
        plii_implicit_project(&system->constraints, system->solution);
    }
    for (int s = is_warm ? 0 : 1; s <= sweeps; ++s) {
        implicit_run_sweep(system, system->spare);
        PLII_SWAP(plii_dvec3*, system->solution, system->spare);
        plii_implicit_project(&system->constraints, system->solution);
    }
}

static void implicit_blend_range(int begin, int end, void* data) {
    const plii_implicit_pass* pass = data;
    for (int i = begin; i < end; ++i) {
        const plii_dvec3 way = plii_dvec3_sub(pass->a[i], pass->to[i]);
        pass->to[i] = plii_dvec3_add_scaled(pass->to[i], way, pass->factor);
    }
}

/* solution = before + weight (swept and projected solution - before), for rigid bodies too. */
static void implicit_extrapolate(plii_implicit_system* system, double weight) {
    plii_implicit_constraints* constraints = &system->constraints;
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        memcpy(rigid->product, rigid->change, sizeof rigid->product);
    }
    plii_implicit_project(constraints, system->residual);
    plii_implicit_pass pass = {system, system->residual, NULL, system->spare, weight};
    plii_body_run_nodes(system->body, implicit_blend_range, &pass, plii_grain(IMPLICIT_SOLVE_NS));
    for (PLII_EACH(plii_implicit_rigid, rigid, constraints->rigids, constraints->rigid_count)) {
        for (int k = 0; k < 6; ++k) {
            const double before = rigid->direction[k];
            rigid->direction[k] = rigid->product[k];
            rigid->change[k] = before + weight * (rigid->change[k] - before);
        }
    }
    PLII_SWAP(plii_dvec3*, system->solution, system->spare);
}

/* Two runs of half the length, because the square of a residual polynomial is never negative: no mode gets more than
   the exact answer, which would make stiff springs unstable. One run would be more accurate by a factor of 2 only. */
void plii_implicit_chebyshev(plii_implicit_system* system, int sweeps, bool is_warm) {
    const double radius_squared = system->spectral_radius * system->spectral_radius;
    const int restart = (sweeps + 1) / 2;
    double weight = 1.0;
    /* Iterates that meet the anchors stay so under all weights. */
    if (!is_warm) { plii_implicit_solve_blocks(system, system->rhs, system->solution); }
    plii_implicit_project(&system->constraints, system->solution);
    memset(system->spare, 0, plii_implicit_vector_size(system->body)); /* the iterate before the start */
    for (PLII_EACH(plii_implicit_rigid, rigid, system->constraints.rigids, system->constraints.rigid_count)) {
        memset(rigid->direction, 0, sizeof rigid->direction);
    }
    for (int s = is_warm ? 0 : 1; s <= sweeps; ++s) {
        const int run = s < restart ? s : s - restart;
        weight = run == 0 ? 1.0 : run == 1 ? 2.0 / (2.0 - radius_squared) : 4.0 / (4.0 - radius_squared * weight);
        implicit_run_sweep(system, system->residual);
        implicit_extrapolate(system, weight);
    }
}

enum { IMPLICIT_POWER_ITERATIONS = 24 };

/* x^T W_ii x. */
static double implicit_square_of_solution(int begin, int end, const void* data) {
    const plii_implicit_system* system = data;
    double sum = 0.0;
    for (int i = begin; i < end; ++i) {
        const plii_implicit_block* block = &system->blocks[i];
        const plii_dvec3 x = system->solution[i];
        if (plii_implicit_block_is_pinned(block)) { continue; }
        const double y0 = x.x + block->l10 * x.y + block->l20 * x.z, y1 = x.y + block->l21 * x.z;
        sum += y0 * y0 / block->inverse_d[0] + y1 * y1 / block->inverse_d[1] + x.z * x.z / block->inverse_d[2];
    }
    return sum;
}

static double implicit_norm(const plii_implicit_system* system) {
    return sqrt(plii_implicit_sum(system, implicit_square_of_solution, system));
}

static void implicit_power_range(int begin, int end, void* data) {
    const plii_implicit_pass* pass = data;
    for (int i = begin; i < end; ++i) {
        const plii_dvec3 b = plii_dvec3_scale(implicit_gather(pass->system, i, pass->a), pass->factor);
        pass->to[i] = plii_implicit_block_solve(&pass->system->blocks[i], b);
    }
}

/* In [-1, 1], the same in every run. */
static double implicit_noise(uint32_t seed) {
    uint32_t x = seed * 0x9e3779b9u + 0x7f4a7c15u;
    x = (x ^ (x >> 16)) * 0x85ebca6bu;
    x = (x ^ (x >> 13)) * 0xc2b2ae35u;
    return (double)(x ^ (x >> 16)) / 2147483648.0 - 1.0;
}

/* In the product x^T D y the iteration matrix is symmetric, so the growth of a vector rises up to the radius. */
double plii_implicit_spectral_radius(plii_implicit_system* system) {
    for (int i = 0; i < system->body->node_count; ++i) {
        const uint32_t seed = 3 * (uint32_t)i;
        const bool is_pinned = plii_implicit_block_is_pinned(&system->blocks[i]);
        system->solution[i] =
            is_pinned ? (plii_dvec3){0}
                      : plii_dvec3_make(implicit_noise(seed), implicit_noise(seed + 1), implicit_noise(seed + 2));
    }
    double radius = 0.0;
    for (int s = 0; s < IMPLICIT_POWER_ITERATIONS; ++s) {
        const double norm = implicit_norm(system);
        if (!(norm > 0.0)) { break; }
        plii_implicit_pass pass = {system, system->solution, NULL, system->spare, 1.0 / norm};
        plii_body_run_nodes(system->body, implicit_power_range, &pass, plii_grain(IMPLICIT_SWEEP_NS));
        PLII_SWAP(plii_dvec3*, system->solution, system->spare);
        radius = implicit_norm(system);
    }
    return fmin(radius, 1.0 - 1e-9);
}
