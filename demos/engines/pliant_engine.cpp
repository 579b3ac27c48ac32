// Builds Pliant bodies from recorded meshes and enables what the record asks for, nothing else.

#include "pliant_engine.h"

#include "stopwatch.h"

namespace demos {

PliantEngine::PliantEngine(const Description& description, const EngineOptions& options)
    : description_(description), is_reference_(options.reference),
      rigids_(std::make_unique<btDefaultCollisionConfiguration>()) {
    rigids_.adopt(std::make_unique<btDiscreteDynamicsWorld>(&rigids_.dispatcher(), &rigids_.broadphase(),
                                                            &rigids_.solver(), &rigids_.configuration()),
                  description.gravity);
    pliant::BridgeDef def;
    def.world.gravity = description.gravity;
    def.mode = is_reference_ ? pliant::CollisionMode::reference : pliant::CollisionMode::exact;
    bridge_ = std::make_unique<pliant::Bridge>(rigids_.world(), def);
    check(bridge_->status());

    size_t next_rigid = 0;
    for (const SoftRecord& soft : description.softs) {
        while (next_rigid < static_cast<size_t>(soft.order)) {
            rigids_.add(description.rigids[next_rigid++]);
        }
        add_soft(soft);
    }
    while (next_rigid < description.rigids.size()) {
        rigids_.add(description.rigids[next_rigid++]);
    }
    for (size_t i = 0; i < bodies_.size(); ++i) {
        const SoftRecord& soft = description.softs[i];
        for (const AnchorRecord& anchor : soft.anchors) {
            add_anchor(bodies_[i], anchor);
        }
        if (!soft.anchors.empty()) { check(pli_body_set_anchor_hardness(bodies_[i], soft.def.anchor_hardness)); }
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
    pli_body* body = nullptr;
    check(bridge_->add_body(record.mesh.get(), &def, &body));
    bodies_.push_back(body);
    enable_features(body, record.def);
    check(pli_body_add_velocity(body, record.velocity));
    for (const FirstForce& force : record.first_forces) {
        check(pli_body_add_node_force(body, force.node, force.force));
    }
}

void PliantEngine::enable_features(pli_body* body, const scene_soft_def& def) {
    if (def.velocity_links) { check(pli_body_use_velocity_links(body, true)); }
    if (def.has_rigid_contacts) { check(pli_body_enable_rigid_contacts(body, &def.rigid_contacts)); }
    if (def.has_soft_contacts) {
        pli_soft_contacts_def contacts = def.soft_contacts;
        contacts.bullet_boxes = is_reference_;
        check(pli_body_enable_soft_contacts(body, &contacts));
    }
    if (def.aero.lift > 0.0f || def.aero.drag > 0.0f) { check(pli_body_enable_aero(body, &def.aero)); }
    if (def.pressure < 0.0f || def.pressure > 0.0f) { check(pli_body_enable_pressure(body, def.pressure)); }
    if (def.volume_conservation > 0.0f) { check(pli_body_enable_volume_conservation(body, def.volume_conservation)); }
    if (def.pose_matching > 0.0f) { check(pli_body_enable_pose_matching(body, def.pose_matching)); }
}

void PliantEngine::add_anchor(pli_body* body, const AnchorRecord& record) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = record.node;
    def.rigid = proxy(record.rigid);
    def.influence = record.influence;
    def.disable_collision = record.disable_collision;
    check(pli_body_add_anchor(body, &def, nullptr));
}

pli_rigid* PliantEngine::proxy(int rigid) {
    pli_rigid* made =
        rigids_.body(rigid) != nullptr ? bridge_->rigid(*rigids_.body(rigid)) : bridge_->rigid(rigids_.object(rigid));
    if (made == nullptr) { throw Error("no proxy for rigid body " + std::to_string(rigid)); }
    return made;
}

void PliantEngine::step() {
    const Stopwatch watch;
    rigids_.world().stepSimulation(frame_seconds, 0);
    milliseconds_ = watch.milliseconds();
    check(bridge_->step_status());
}

static pli_vec3 xyz(const pli_vec4& v) {
    return pli_vec3_make(v.x, v.y, v.z);
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
    return state;
}

} // namespace demos
