// Builds Pliant bodies from recorded meshes and enables what the record asks for, nothing else.

#include "pliant_engine.h"

#include "solvers.h"

#include <pliant/bullet_reference.h>
#include <pliant_bullet/cluster_distance.h>

#include <algorithm>

namespace demos {

static pli_threads* create_threads(const EngineOptions& options) {
    pli_threads* threads = nullptr;
    if (options.threads > 1 && !options.parallel_for && pli_threads_create(options.threads, &threads) != PLI_OK) {
        throw Error("no threads");
    }
    return threads;
}

static pli_context* create_context(const EngineOptions& options, pli_threads* threads) {
    pli_context_def def = pli_context_def_default();
    def.simd = options.simd;
    if (options.parallel_for != nullptr) {
        def.parallel_for = options.parallel_for;
        def.parallel_user = options.parallel_user;
    } else if (threads != nullptr) {
        def.parallel_for = pli_threads_parallel_for;
        def.parallel_user = threads;
    }
    pli_context* context = nullptr;
    const pli_status status = pli_context_create(&def, &context);
    if (status != PLI_OK) { throw Error(std::string("no context: ") + pli_status_string(status)); }
    return context;
}

PliantEngine::PliantEngine(const Description& description, const EngineOptions& options)
    : Engine(description, options), run_(choose_solver(description, EngineKind::pliant, options)),
      threads_(create_threads(options)), context_(create_context(options, threads_.get())),
      rigids_(std::make_unique<btDefaultCollisionConfiguration>()) {
    auto world = std::make_unique<TimedWorld<btDiscreteDynamicsWorld>>(
        rigids_.clock(), &rigids_.dispatcher(), &rigids_.broadphase(), &rigids_.solver(), &rigids_.configuration());
    world->set_soft_bounds_first(options_.reference);
    world->getDispatchInfo().m_deterministicOverlappingPairs = options_.ordered_pairs;
    rigids_.adopt(std::move(world), description.gravity);
    rigids_.world().addAction(&start_);
    pliant::BridgeDef def;
    def.context = context_.get();
    def.mode = options_.reference ? pliant::CollisionMode::reference : pliant::CollisionMode::exact;
    bridge_ = std::make_unique<pliant::Bridge>(rigids_.world(), def);
    check(bridge_->status());
    rigids_.world().addAction(&end_);

    add_bodies();
    sample_solids();
    for (size_t i = 0; i < bodies_.size(); ++i) {
        const SoftRecord& soft = description.softs[i];
        for (const AnchorRecord& anchor : soft.anchors) {
            add_anchor(bodies_[i], anchor);
        }
        if (!soft.anchors.empty()) { check(pli_body_set_anchor_hardness(bodies_[i], soft.def.anchor_hardness)); }
    }
    for (const JointRecord& joint : description.joints) {
        add_joint(joint);
    }
}

PliantEngine::~PliantEngine() = default;

void PliantEngine::check(pli_status status) const {
    if (status == PLI_OK) { return; }
    const std::string detail = bridge_->context() != nullptr ? pli_last_error(bridge_->context()) : "";
    throw Error(std::string(pli_status_string(status)) + (detail.empty() ? "" : ": " + detail));
}

void PliantEngine::add_soft(const SoftRecord& record) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = record.def.collision_margin;
    def.solver = record.def.solver;
    if (run_.kind == SolverKind::position_based && options_.solver.iterations.has_value()) {
        def.solver.position_iterations = run_.iterations;
    }
    pli_body* body = nullptr;
    check(bridge_->add_body(record.mesh.get(), &def, &body));
    bodies_.push_back(body);
    const bool in_bullet_order = options_.reference || options_.solver.in_mesh_order ||
                                 run_.kind != SolverKind::position_based || record.def.velocity_links;
    if (in_bullet_order) { check(pli_body_disable_colored_links(body)); }
    enable_features(body, definition_for_solver(record, run_));
    enable_solver(body, record, run_);
    if (!options_.reference) { enable_self_collision(body, record.def, run_); }
    check(pli_body_add_velocity(body, record.velocity));
    for (const FirstForce& force : record.first_forces) {
        check(pli_body_add_node_force(body, force.node, force.force));
    }
}

void PliantEngine::sample_solids() {
    if (options_.reference) { return; } // as btSoftBody
    for (size_t i = 0; i < description_.rigids.size(); ++i) {
        const RigidRecord& record = description_.rigids[i];
        if (record.shape.is_solid) { check(bridge_->use_sampled_mesh(rigids_.object(static_cast<int>(i)))); }
    }
}

void PliantEngine::enable_features(pli_body* body, const scene_soft_def& def) {
    if (def.velocity_links) { check(pli_body_enable_velocity_links(body)); }
    if (def.has_rigid_contacts) {
        check(pli_body_enable_rigid_contacts(body, &def.rigid_contacts));
        if (options_.reference) { check(pli_body_enable_bullet_node_boxes(body)); }
    }
    if (def.has_soft_contacts) {
        pli_soft_contacts_def contacts = def.soft_contacts;
        contacts.bullet_boxes = options_.reference;
        check(pli_body_enable_soft_contacts(body, &contacts));
    }
    if (def.aero.lift > 0.0f || def.aero.drag > 0.0f) { check(pli_body_enable_aero(body, &def.aero)); }
    if (def.pressure < 0.0f || def.pressure > 0.0f) { check(pli_body_enable_pressure(body, def.pressure)); }
    if (def.volume_conservation > 0.0f) { check(pli_body_enable_volume_conservation(body, def.volume_conservation)); }
    if (def.pose_matching > 0.0f) { check(pli_body_enable_pose_matching(body, def.pose_matching)); }
    if (def.has_clusters) { enable_clusters(body, def); }
}

void PliantEngine::enable_clusters(pli_body* body, const scene_soft_def& def) {
    pli_clusters_def clusters = pli_clusters_def_default();
    clusters.reference_mode = options_.reference;
    check(pli_body_enable_clusters(body, &clusters));
    constexpr int most_iterations = 8192; // as in Bullet
    check(def.cluster_count > 0 ? pli_body_generate_clusters(body, def.cluster_count, most_iterations, nullptr)
                                : pli_body_generate_clusters_from_elements(body, nullptr));
    pli_cluster_settings settings;
    check(pli_body_get_cluster_settings(body, 0, &settings));
    settings.matching = def.cluster_matching;
    settings.node_damping = def.cluster_node_damping;
    check(pli_body_set_cluster_settings(body, 0, &settings));
    if (!def.has_cluster_contacts) { return; }
    pli_cluster_contacts_def contacts = def.cluster_contacts;
    if (options_.bullet_witness) {
        contacts.distance = pliant::bullet_cluster_distance;
        contacts.distance_user = bridge_.get();
    }
    check(pli_body_enable_cluster_contacts(body, &contacts));
}

void PliantEngine::add_anchor(pli_body* body, const AnchorRecord& record) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = record.node;
    def.rigid = proxy(record.rigid);
    def.influence = record.influence;
    def.disable_collision = record.disable_collision;
    check(pli_body_add_anchor(body, &def, nullptr));
}

pli_joint_end PliantEngine::second_end(const scene_joint& ends) {
    pli_joint_end end{};
    if (ends.other_soft >= 0) {
        end.body = body(ends.other_soft);
    } else {
        end.rigid = proxy(ends.rigid);
    }
    return end;
}

void PliantEngine::add_joint(const JointRecord& record) {
    if (!record.is_angular) {
        pli_linear_joint_def def = pli_linear_joint_def_default();
        def.other = second_end(record.ends);
        def.softness = record.ends.softness;
        def.position = record.position;
        check(pli_body_add_linear_joint(body(record.ends.soft), &def, nullptr));
        return;
    }
    pli_angular_joint_def def = pli_angular_joint_def_default();
    def.other = second_end(record.ends);
    def.softness = record.ends.softness;
    def.axis = record.axis;
    controls_.push_back(std::make_unique<JointControl>(JointControl{drive_, record}));
    def.controller.user = controls_.back().get();
    if (record.is_driven) {
        def.controller.speed = [](float present, void* user) {
            return static_cast<const JointControl*>(user)->drive.speed(present);
        };
    }
    if (is_steered(record)) {
        def.controller.steer = [](pli_vec3, void* user) {
            const auto* control = static_cast<const JointControl*>(user);
            return control->drive.axis(control->record);
        };
    }
    check(pli_body_add_angular_joint(body(record.ends.soft), &def, nullptr));
}

namespace {

struct Sphere {
    pli_vec3 center;
    float radius;
};

float sphere_surface(pli_vec3 point, void* user) {
    const auto* sphere = static_cast<const Sphere*>(user);
    return pli_vec3_length_squared(pli_vec3_sub(point, sphere->center)) - sphere->radius * sphere->radius;
}

} // namespace

void PliantEngine::cut_sphere(int soft, pli_vec3 center, float radius) {
    Sphere sphere{center, radius};
    pli_refine_def def = pli_refine_def_default();
    def.surface = sphere_surface;
    def.user = &sphere;
    def.accuracy = cut_accuracy;
    def.reset_rest_lengths = options_.reference;
    check(pli_body_refine(body(soft), &def));
}

void PliantEngine::cut_swept(const pli_vec3 first[2], const pli_vec3 second[2]) {
    for (pli_body* each : bodies_) {
        check(pli_body_cut_swept(each, first[0], first[1], second[0], second[1], nullptr));
    }
}

pli_rigid* PliantEngine::proxy(int rigid) {
    pli_rigid* made =
        rigids_.body(rigid) != nullptr ? bridge_->rigid(*rigids_.body(rigid)) : bridge_->rigid(rigids_.object(rigid));
    if (made == nullptr) { throw Error("no proxy for rigid body " + std::to_string(rigid)); }
    return made;
}

void PliantEngine::check_step() const {
    check(bridge_->step_status());
}

void PliantEngine::set_wind(int soft, pli_vec3 wind) {
    const pli_aero_def& def = description_.softs.at(static_cast<size_t>(soft)).def.aero;
    if (def.lift > 0.0f || def.drag > 0.0f) { check(pli_body_set_wind(body(soft), wind)); }
}

size_t PliantEngine::soft_bytes() const {
    size_t bytes = pli_context_allocated_bytes(bridge_->context());
    for (const pli_body* body : bodies_) {
        // Lists that bodies share with their mesh, which is of another context.
        const pli_body_view view = pli_body_get_view(body);
        bytes += static_cast<size_t>(3 * view.face_count + 4 * view.tetra_count) * sizeof(int);
    }
    return bytes + static_cast<size_t>(std::max<int64_t>(rigids_.clock().live_bytes(), 0));
}

uint64_t PliantEngine::soft_allocations() const {
    return pli_context_allocation_count(bridge_->context()) + rigids_.clock().allocations();
}

scene_self_collision PliantEngine::self_collision() const {
    if (options_.reference) { return SCENE_SELF_NONE; }
    for (const SoftRecord& soft : description_.softs) {
        if (soft.def.self_collision != SCENE_SELF_NONE) { return soft.def.self_collision; }
    }
    return SCENE_SELF_NONE;
}

std::optional<int> PliantEngine::crossings() const {
    int sum = 0;
    for (const pli_body* body : bodies_) {
        int count = 0;
        check(pli_body_count_crossings(body, &count));
        sum += count;
    }
    return sum;
}

SoftState PliantEngine::soft(int index) const {
    const pli_body* source = body(index);
    const pli_body_view view = pli_body_get_view(source);
    SoftState state;
    for (int i = 0; i < view.node_count; ++i) {
        state.positions.push_back(xyz(view.positions[i]));
        state.velocities.push_back(xyz(view.velocities[i]));
        state.inverse_masses.push_back(view.positions[i].w);
    }
    for (int i = 0; i < view.link_count; ++i) {
        const int* nodes = view.link_nodes + static_cast<ptrdiff_t>(i) * view.link_node_stride;
        state.link_nodes.insert(state.link_nodes.end(), nodes, nodes + 2);
        state.rest_lengths.push_back(pli_body_get_rest_length(source, i));
    }
    if (view.face_count > 0) { state.face_nodes.assign(view.face_nodes, view.face_nodes + 3 * view.face_count); }
    if (view.tetra_count > 0) { state.tetra_nodes.assign(view.tetra_nodes, view.tetra_nodes + 4 * view.tetra_count); }
    state.cluster_count = pli_body_cluster_count(source);
    return state;
}

} // namespace demos
