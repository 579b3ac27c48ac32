// Choice of a solver, and the material of a scene in its units.

#include "solvers.h"

#include <algorithm>
#include <cmath>

namespace demos {

const char* solver_name(SolverKind kind) {
    return kind == SolverKind::implicit ? "implicit" : kind == SolverKind::xpbd ? "xpbd" : "position-based";
}

// ---------------------------------------------------------------------------------------------------- the choice

namespace {

constexpr int default_sweeps = 5;    // of the implicit solver
constexpr int default_substeps = 10; // of XPBD

// btSoftBody and what is compared with it step by step have no choice.
SolverKind own_solver(const Description& description, EngineKind engine, const EngineOptions& options) {
    if (engine == EngineKind::bullet || options.reference || description.source == nullptr) {
        return SolverKind::position_based;
    }
    switch (description.source->solver) {
    case SCENE_SOLVER_IMPLICIT:
        return SolverKind::implicit;
    case SCENE_SOLVER_XPBD:
        return SolverKind::xpbd;
    case SCENE_SOLVER_POSITION_BASED:
        break;
    }
    return SolverKind::position_based;
}

int own_substeps(const Description& description) {
    const int own = description.source != nullptr ? description.source->substeps : 0;
    return own > 0 ? own : default_substeps;
}

int most_iterations(const Description& description) {
    int most = 0;
    for (const SoftRecord& soft : description.softs) {
        most = std::max(most, soft.def.solver.position_iterations);
    }
    return most;
}

} // namespace

SolverRun choose_solver(const Description& description, EngineKind engine, const EngineOptions& options) {
    const SolverKind own = own_solver(description, engine, options);
    SolverRun run;
    run.kind = options.solver.kind.value_or(own);
    run.is_reference = options.reference;
    if (engine == EngineKind::bullet && run.kind != SolverKind::position_based) {
        throw Error(std::string("btSoftBody has no solver ") + solver_name(run.kind));
    }
    if (options.reference && run.kind != SolverKind::position_based) {
        throw Error(std::string("the reference mode is that of btSoftBody's solver and does not go with --solver ") +
                    solver_name(run.kind));
    }
    if (options.solver.substeps.has_value() && run.kind != SolverKind::xpbd) {
        throw Error(std::string("--substeps are those of --solver xpbd; --solver ") + solver_name(run.kind) +
                    " takes shorter steps by --dt");
    }
    switch (run.kind) {
    case SolverKind::position_based:
        run.iterations = options.solver.iterations.value_or(most_iterations(description));
        if (options.solver.iterations == 0) { throw Error("--iterations 0 would leave links and contacts unsolved"); }
        break;
    case SolverKind::implicit:
        run.iterations = options.solver.iterations.value_or(default_sweeps);
        run.implicit_method = options.solver.implicit_method;
        run.filter_compression = options.solver.filter_compression;
        run.finishing_iterations = options.solver.finishing_iterations;
        break;
    case SolverKind::xpbd:
        run.substeps = options.solver.substeps.value_or(own_substeps(description));
        run.iterations = options.solver.iterations.value_or(1);
        break;
    }
    return run;
}

// --------------------------------------------------------------------------------------------------- the material

namespace {

// Mean mass of the nodes that are not pinned, kg.
double node_mass(const pli_mesh_view& mesh) {
    double mass = 0.0;
    int count = 0;
    for (int i = 0; i < mesh.node_count; ++i) {
        if (!(mesh.inverse_masses[i] > 0.0f)) { continue; }
        mass += 1.0 / static_cast<double>(mesh.inverse_masses[i]);
        ++count;
    }
    return count > 0 ? mass / count : 1.0;
}

} // namespace

// An iteration of btSoftBody that meets a stretch d gives two nodes of mass m a
// velocity of d / (2 h) each, as a spring of m / (2 h^2) in a step h; n iterations, n times that. About half of d is
// left then and can be seen, so the spring that looks alike is twice as stiff.
double link_stiffness(const SoftRecord& record) {
    if (record.def.link_stiffness > 0.0f) { return static_cast<double>(record.def.link_stiffness); }
    const pli_solver_settings& solver = record.def.solver;
    const int iterations =
        std::max(1, solver.position_iterations + solver.drift_iterations + solver.velocity_iterations);
    const double h = static_cast<double>(frame_seconds);
    return iterations * node_mass(pli_mesh_get_view(record.mesh.get())) / (h * h);
}

namespace {

// N s/m of such a link: as much as the integration of btSoftBody, which is like backward Euler, takes from it.
float link_damping(const SoftRecord& record) {
    if (record.def.link_stiffness > 0.0f) { return record.def.link_damping; }
    return static_cast<float>(0.5 * static_cast<double>(frame_seconds) * link_stiffness(record));
}

// Coulomb's coefficient for the share of the sliding that a contact of btSoftBody takes away in a step: both brake a
// node of 1 m/s alike.
float coulomb_friction(float share) {
    constexpr float speed = 1.0f, gravity = 10.0f;
    return share * speed / (gravity * frame_seconds);
}

void check(pli_body* body, pli_status status) {
    if (status == PLI_OK) { return; }
    const std::string detail = pli_last_error(pli_world_get_context(pli_body_get_world(body)));
    throw Error(std::string(pli_status_string(status)) + (detail.empty() ? "" : ": " + detail));
}

void enable_xpbd(pli_body* body, const SoftRecord& record, const SolverRun& run) {
    pli_xpbd_def solver = pli_xpbd_def_default();
    solver.substeps = run.substeps;
    solver.sweeps = run.iterations;
    check(body, pli_body_enable_xpbd(body, &solver));
    const pli_mesh_view mesh = pli_mesh_get_view(record.mesh.get());
    if (mesh.link_count > 0) {
        pli_xpbd_links_def links = pli_xpbd_links_def_default();
        links.compliance = static_cast<float>(1.0 / link_stiffness(record));
        links.bending_compliance = links.compliance;
        links.damping = link_damping(record);
        check(body, pli_body_enable_xpbd_links(body, &links));
    }
    if (mesh.tetra_count > 0) { check(body, pli_body_enable_xpbd_tetras(body, 0.0f)); }
    const scene_soft_def def = definition_for_solver(record, run);
    if (def.volume_conservation > 0.0f) {
        check(body, pli_body_disable_volume_conservation(body)); // a force would be too stiff
        pli_xpbd_volume_def volume = pli_xpbd_volume_def_default();
        volume.compliance = 1.0f / def.volume_conservation;
        check(body, pli_body_enable_xpbd_volume(body, &volume));
    }
}

void enable_implicit(pli_body* body, const SoftRecord& record, const SolverRun& run) {
    pli_implicit_def solver = pli_implicit_def_default();
    solver.stiffness = static_cast<float>(link_stiffness(record));
    if (record.def.link_stiffness > 0.0f) { solver.damping = record.def.link_damping; }
    solver.sweeps = run.iterations;
    solver.method = run.implicit_method;
    solver.filter_compression = run.filter_compression;
    solver.finishing_iterations = run.finishing_iterations;
    check(body, pli_body_enable_implicit(body, &solver));
}

} // namespace

void enable_solver(pli_body* body, const SoftRecord& record, const SolverRun& run) {
    if (run.kind == SolverKind::implicit) { enable_implicit(body, record, run); }
    if (run.kind == SolverKind::xpbd) { enable_xpbd(body, record, run); }
}

void enable_self_collision(pli_body* body, const scene_soft_def& def, const SolverRun& run) {
    switch (def.self_collision) {
    case SCENE_SELF_NONE:
        break;
    case SCENE_SELF_NODES: {
        pli_self_collision_def nodes = pli_self_collision_def_default();
        nodes.thickness = def.thickness;
        nodes.friction = def.self_friction;
        // Whole steps are long: with the default a body would fall in slow motion.
        if (run.kind != SolverKind::xpbd) { nodes.speed_limit_ratio = 0.5f; }
        check(body, pli_body_enable_self_collision(body, &nodes));
        break;
    }
    case SCENE_SELF_GRIDS: {
        pli_self_grids_def grids = pli_self_grids_def_default();
        grids.distance = def.thickness;
        check(body, pli_body_enable_self_grids(body, &grids));
        break;
    }
    case SCENE_SELF_FACES: {
        pli_self_faces_def faces = pli_self_faces_def_default();
        // Nodes do not keep faces apart here, so layers may lie closer; pairs in reach grow with the third power of it.
        faces.thickness = 0.25f * def.thickness;
        faces.max_travel = 1.5f * faces.thickness;
        faces.friction = def.self_friction;
        check(body, pli_body_enable_self_faces(body, &faces));
        break;
    }
    }
}

scene_soft_def definition_for_solver(const SoftRecord& record, const SolverRun& run) {
    scene_soft_def def = record.def;
    if (run.kind != SolverKind::position_based) { def.velocity_links = false; }
    const bool keeps_volumes = run.kind == SolverKind::xpbd && pli_mesh_get_view(record.mesh.get()).tetra_count > 0;
    if (def.has_clusters && keeps_volumes) {
        def.has_rigid_contacts = true;
        def.rigid_contacts.friction = def.cluster_contacts.friction;
        def.has_clusters = def.has_cluster_contacts = false;
    }
    // Of soft contacts the value is the coefficient: Bullet's share acts only where bodies approach, and a sheet slides
    // off another alike.
    if (!run.is_reference) { def.rigid_contacts.friction = coulomb_friction(def.rigid_contacts.friction); }
    if (run.kind != SolverKind::xpbd) { return def; }
    constexpr float recovery_speed = 1.0f; // m/s, whatever the scene wants of btSoftBody's solver
    def.rigid_contacts.recovery_speed = def.soft_contacts.recovery_speed = recovery_speed;
    return def;
}

} // namespace demos
