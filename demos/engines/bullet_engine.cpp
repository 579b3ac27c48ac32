// Builds btSoftBodies from recorded meshes: nodes, links and faces keep their order, settings map one to one.

#include "bullet_engine.h"

#include "components.h"

#include <BulletSoftBody/btDefaultSoftBodySolver.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <algorithm>
#include <map>
#include <optional>

namespace demos {

// --------------------------------------------------------------------------------- meshes that Bullet cannot take

namespace {

int face_components(const pli_mesh_view& mesh) {
    Components components(mesh.face_count);
    std::map<std::pair<int, int>, int> face_at_edge;
    for (int i = 0; i < mesh.face_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const std::pair<int, int> edge =
                std::minmax(mesh.faces[i].nodes[k], mesh.faces[i].nodes[(k + 1) % 3], std::less<int>());
            components.join(i, face_at_edge.try_emplace(edge, i).first->second);
        }
    }
    return components.count();
}

int link_components(const pli_mesh_view& mesh) {
    Components components(mesh.node_count);
    for (int i = 0; i < mesh.link_count; ++i) {
        components.join(mesh.links[i].nodes[0], mesh.links[i].nodes[1]);
    }
    return components.count();
}

// The trees of soft contacts are built by merging neighbours until one is left; btSoftBody never ends when neighbours
// do not connect everything.
void require_connected(const SoftRecord& record) {
    if (!record.def.has_soft_contacts) { return; }
    const pli_mesh_view mesh = pli_mesh_get_view(record.mesh.get());
    const int faces = face_components(mesh), links = link_components(mesh);
    if (faces > 1 || links > 1) {
        throw Error(record.name + ": btSoftBody hangs in soft contacts of a mesh that is not in one piece (" +
                    std::to_string(faces) + " by faces, " + std::to_string(links) + " by links)");
    }
}

// ------------------------------------------------------------------------------------------------- soft bodies

std::vector<btSoftBody::Material*> append_materials(btSoftBody& body, const pli_mesh_view& mesh) {
    std::vector<btSoftBody::Material*> materials;
    for (int i = 0; i < mesh.material_count; ++i) {
        // A body has one material from the start.
        materials.push_back(i == 0 ? body.m_materials[0] : body.appendMaterial());
        materials.back()->m_kLST = mesh.materials[i].linear_stiffness;
    }
    return materials;
}

std::unique_ptr<btSoftBody> make_body(btSoftBodyWorldInfo& info, const pli_mesh_view& mesh) {
    std::vector<btVector3> positions;
    for (int i = 0; i < mesh.node_count; ++i) {
        positions.push_back(to_bullet(mesh.positions[i]));
    }
    auto body = std::make_unique<btSoftBody>(&info, mesh.node_count, positions.data(), nullptr);
    for (int i = 0; i < mesh.node_count; ++i) {
        body->m_nodes[i].m_im = mesh.inverse_masses[i];
    }
    const std::vector<btSoftBody::Material*> materials = append_materials(*body, mesh);
    const auto material = [&](int index) { return materials[static_cast<size_t>(index)]; };
    for (int i = 0; i < mesh.link_count; ++i) {
        const pli_link& link = mesh.links[i];
        body->appendLink(link.nodes[0], link.nodes[1], material(link.material), false);
        body->m_links[i].m_bbending = link.is_bending ? -1 : 0; // a signed field of one bit
    }
    for (int i = 0; i < mesh.face_count; ++i) {
        const pli_face& face = mesh.faces[i];
        body->appendFace(face.nodes[0], face.nodes[1], face.nodes[2], material(face.material));
    }
    for (int i = 0; i < mesh.tetra_count; ++i) {
        const pli_tetra& tetra = mesh.tetras[i];
        body->appendTetra(tetra.nodes[0], tetra.nodes[1], tetra.nodes[2], tetra.nodes[3], material(tetra.material));
    }
    return body;
}

void configure_clusters(btSoftBody& body, const scene_soft_def& def) {
    if (def.has_cluster_contacts) {
        btSoftBody::Config& config = body.m_cfg;
        const pli_cluster_contacts_def& contacts = def.cluster_contacts;
        config.collisions = btSoftBody::fCollision::CL_RS + btSoftBody::fCollision::CL_SS;
        config.kDF = contacts.friction;
        config.kSRHR_CL = contacts.dynamic_hardness;
        config.kSKHR_CL = contacts.static_hardness;
        config.kSSHR_CL = contacts.soft_hardness;
        config.kSR_SPLT_CL = contacts.dynamic_split;
        config.kSK_SPLT_CL = contacts.static_split;
        config.kSS_SPLT_CL = contacts.soft_split;
    }
    body.generateClusters(def.cluster_count);
    if (body.m_clusters.size() == 0) { throw Error("btSoftBody has made no clusters"); }
    body.m_clusters[0]->m_matching = def.cluster_matching;
    body.m_clusters[0]->m_ndamping = def.cluster_node_damping;
}

void configure(btSoftBody& body, const scene_soft_def& def) {
    btSoftBody::Config& config = body.m_cfg;
    body.getCollisionShape()->setMargin(def.collision_margin);
    if (def.velocity_links) { body.setSolver(btSoftBody::eSolverPresets::Velocities); }
    config.viterations = def.solver.velocity_iterations;
    config.piterations = def.solver.position_iterations;
    config.diterations = def.solver.drift_iterations;
    config.kVCF = def.solver.drift_correction;
    config.kDP = def.solver.velocity_damping;
    config.timescale = def.solver.time_scale;
    config.kDF = def.has_rigid_contacts ? def.rigid_contacts.friction : def.soft_contacts.friction;
    config.kCHR = def.rigid_contacts.dynamic_hardness;
    config.kKHR = def.rigid_contacts.static_hardness;
    config.kSHR = def.soft_contacts.hardness;
    config.kAHR = def.anchor_hardness;
    config.collisions = (def.has_rigid_contacts ? btSoftBody::fCollision::SDF_RS : 0) |
                        (def.has_soft_contacts ? btSoftBody::fCollision::VF_SS : 0);
    config.aeromodel = static_cast<btSoftBody::eAeroModel::_>(def.aero.model); // the same order
    config.kLF = def.aero.lift;
    config.kDG = def.aero.drag;
    body.setWindVelocity(to_bullet(def.aero.wind));
    config.kPR = def.pressure;
    config.kVC = def.volume_conservation;
    config.kMT = def.pose_matching;
    const bool keeps_volume = def.volume_conservation > 0.0f, keeps_pose = def.pose_matching > 0.0f;
    if (keeps_volume || keeps_pose) { body.setPose(keeps_volume, keeps_pose); }
    if (def.has_clusters) { configure_clusters(body, def); }
}

// Cuts along a sphere: negative inside.
struct SphereField final : btSoftBody::ImplicitFn {
    btVector3 center;
    btScalar radius = 0;
    btScalar Eval(const btVector3& point) override { return (point - center).length2() - radius * radius; }
};

} // namespace

void BulletEngine::add_soft(const SoftRecord& record) {
    const SoftClock::Window window(rigids_.clock(), SoftPart::predict); // for memory
    if (!options_.unguarded) { require_connected(record); }
    std::unique_ptr<btSoftBody> body = make_body(info_, pli_mesh_get_view(record.mesh.get()));
    configure(*body, record.def);
    body->m_cfg.piterations = options_.solver.iterations.value_or(body->m_cfg.piterations);
    // Bullet leaves normals at zero until the end of the first step; Pliant has them from the start.
    body->updateNormals();
    // It made its bounds with the default margin, and what is near when a body is added decides the order of pairs. The
    // same holds for the boxes of its nodes, which stay until nodes leave them.
    body->updateBounds();
    const btScalar margin = record.def.collision_margin;
    for (int i = 0; i < body->m_nodes.size(); ++i) {
        btDbvtVolume box = btDbvtVolume::FromCR(body->m_nodes[i].m_x, margin);
        body->m_ndbvt.update(body->m_nodes[i].m_leaf, box);
    }
    body->addVelocity(to_bullet(record.velocity));
    for (const FirstForce& force : record.first_forces) {
        body->addForce(to_bullet(force.force), force.node);
    }
    static_cast<btSoftRigidDynamicsWorld&>(rigids_.world()).addSoftBody(body.get());
    softs_.push_back(std::move(body));
}

// ------------------------------------------------------------------------------------------------------ engine

// Predicts, and closes what on_tick opens: everything of btSoftBody that follows the rigid half of a step.
class BulletEngine::TimedSolver final : public btDefaultSoftBodySolver {
public:
    explicit TimedSolver(SoftClock& clock) : clock_(clock) {}

    void predictMotion(btScalar seconds) override {
        const SoftClock::Window window(clock_, SoftPart::predict);
        btDefaultSoftBodySolver::predictMotion(seconds);
    }
    void begin_solve() { solve_.emplace(clock_, SoftPart::solve); }
    void updateSoftBodies() override {
        btDefaultSoftBodySolver::updateSoftBodies();
        solve_.reset();
    }

private:
    SoftClock& clock_;
    std::optional<SoftClock::Window> solve_;
};

BulletEngine::BulletEngine(const Description& description, const EngineOptions& options)
    : Engine(description, options), rigids_(std::make_unique<btSoftBodyRigidBodyCollisionConfiguration>()) {
    solver_ = std::make_unique<TimedSolver>(rigids_.clock());
    rigids_.adopt(std::make_unique<TimedWorld<btSoftRigidDynamicsWorld>>(rigids_.clock(), &rigids_.dispatcher(),
                                                                         &rigids_.broadphase(), &rigids_.solver(),
                                                                         &rigids_.configuration(), solver_.get()),
                  description.gravity);
    choose_solver(description, EngineKind::bullet, options);
    info_.m_broadphase = &rigids_.broadphase();
    info_.m_dispatcher = &rigids_.dispatcher();
    info_.m_gravity = to_bullet(description.gravity);
    info_.m_sparsesdf.Initialize();
    info_.m_sparsesdf.Reset();

    add_bodies();
    const SoftClock::Window window(rigids_.clock(), SoftPart::predict); // for memory
    for (size_t i = 0; i < softs_.size(); ++i) {
        for (const AnchorRecord& anchor : description.softs[i].anchors) {
            softs_[i]->appendAnchor(anchor.node, rigids_.body(anchor.rigid), anchor.disable_collision,
                                    anchor.influence);
        }
    }
    for (const JointRecord& joint : description.joints) {
        add_joint(joint);
    }
    rigids_.world().setInternalTickCallback(on_tick, this);
}

// --------------------------------------------------------------------------------------------- joints and cuts

struct BulletEngine::JointControl final : btSoftBody::AJoint::IControl {
    JointControl(const Drive& of, const JointRecord& joint) : drive(of), record(joint) {}
    void Prepare(btSoftBody::AJoint* joint) override {
        if (is_steered(record)) { joint->m_refs[0] = to_bullet(drive.axis(record)); }
    }
    btScalar Speed(btSoftBody::AJoint*, btScalar present) override {
        return record.is_driven ? drive.speed(present) : present;
    }

    const Drive& drive;
    const JointRecord& record;
};

static void set_softness(btSoftBody::Joint::Specs& specs, const pli_joint_softness& softness) {
    specs.erp = softness.error_reduction;
    specs.cfm = softness.velocity_factor;
    specs.split = softness.split;
}

void BulletEngine::add_joint(const JointRecord& record) {
    btSoftBody& first = body(record.ends.soft);
    btSoftBody::Body second;
    if (record.ends.other_soft >= 0) {
        second = btSoftBody::Body(body(record.ends.other_soft).m_clusters[0]);
    } else {
        second = btSoftBody::Body(&rigids_.object(record.ends.rigid));
    }
    if (!record.is_angular) {
        btSoftBody::LJoint::Specs specs;
        set_softness(specs, record.ends.softness);
        specs.position = to_bullet(record.position);
        first.appendLinearJoint(specs, first.m_clusters[0], second);
        return;
    }
    btSoftBody::AJoint::Specs specs;
    set_softness(specs, record.ends.softness);
    specs.axis = to_bullet(record.axis);
    if (record.is_driven || is_steered(record)) {
        controls_.push_back(std::make_unique<JointControl>(drive_, record));
        specs.icontrol = controls_.back().get();
    }
    first.appendAngularJoint(specs, first.m_clusters[0], second);
}

// At the end of the rigid half of a step.
void BulletEngine::on_tick(btDynamicsWorld* world, btScalar) {
    const auto* self = static_cast<const BulletEngine*>(world->getWorldUserInfo());
    if (self->before_solve_) { self->before_solve_(); }
    self->solver_->begin_solve();
}

BulletEngine::~BulletEngine() {
    info_.m_sparsesdf.Reset(); // frees its cells
}

// After a cut btSoftBody's clusters point to nodes that are no more, and its trees of soft contacts are never finished.
void BulletEngine::cut_sphere(int soft, pli_vec3 center, float radius) {
    const SoftRecord& record = description_.softs.at(static_cast<size_t>(soft));
    if (record.def.has_clusters || record.def.has_soft_contacts || body(soft).m_tetras.size() > 0) {
        throw Error(record.name + ": btSoftBody does not outlive a cut with clusters, soft contacts or tetrahedra");
    }
    SphereField sphere;
    sphere.center = to_bullet(center);
    sphere.radius = radius;
    const SoftClock::Window window(rigids_.clock(), SoftPart::predict); // for memory: times start after it
    body(soft).refine(&sphere, cut_accuracy, true);
    body(soft).m_rcontacts.clear(); // those of the last step point to nodes that have moved in memory
}

void BulletEngine::cut_swept(const pli_vec3[2], const pli_vec3[2]) {
    throw Error("btSoftBody cannot be cut along a swept ray");
}

void BulletEngine::set_wind(int soft, pli_vec3 wind) {
    body(soft).setWindVelocity(to_bullet(wind));
}

void BulletEngine::set_gravity(pli_vec3 gravity) {
    Engine::set_gravity(gravity);
    info_.m_gravity = to_bullet(gravity);
}

size_t BulletEngine::soft_bytes() const {
    // The cells of the sampled distances do not go through Bullet's allocator.
    const auto cells = static_cast<size_t>(info_.m_sparsesdf.ncells) * sizeof(btSparseSdf<3>::Cell);
    return static_cast<size_t>(std::max<int64_t>(rigids_.clock().live_bytes(), 0)) + cells;
}

SoftState BulletEngine::soft(int index) const {
    const btSoftBody& source = body(index);
    SoftState state;
    const btSoftBody::Node* first = source.m_nodes.size() > 0 ? &source.m_nodes[0] : nullptr;
    const auto node_index = [&](const btSoftBody::Node* node) { return static_cast<int>(node - first); };
    for (int i = 0; i < source.m_nodes.size(); ++i) {
        state.positions.push_back(from_bullet(source.m_nodes[i].m_x));
        state.velocities.push_back(from_bullet(source.m_nodes[i].m_v));
        state.inverse_masses.push_back(source.m_nodes[i].m_im);
    }
    for (int i = 0; i < source.m_links.size(); ++i) {
        state.link_nodes.push_back(node_index(source.m_links[i].m_n[0]));
        state.link_nodes.push_back(node_index(source.m_links[i].m_n[1]));
        state.rest_lengths.push_back(source.m_links[i].m_rl);
    }
    for (int i = 0; i < source.m_faces.size(); ++i) {
        for (const btSoftBody::Node* node : source.m_faces[i].m_n) {
            state.face_nodes.push_back(node_index(node));
        }
    }
    for (int i = 0; i < source.m_tetras.size(); ++i) {
        for (const btSoftBody::Node* node : source.m_tetras[i].m_n) {
            state.tetra_nodes.push_back(node_index(node));
        }
    }
    state.cluster_count = source.m_clusters.size();
    return state;
}

} // namespace demos
