// btSoftBody to pli_mesh and the parameters of the features.

#include "pliant_bullet/import.h"

#include "convert.h"

#include <BulletSoftBody/btSoftBody.h>

#include <cmath>

namespace pliant {

namespace {

// The mass whose reciprocal is `inverse_mass`. Rounding twice may miss it by one unit, so its neighbours are tried.
float mass_of(float inverse_mass) {
    if (!(inverse_mass > 0.0f)) { return 0.0f; }
    const float mass = 1.0f / inverse_mass;
    const float candidates[] = {mass, std::nextafter(mass, 0.0f), std::nextafter(mass, INFINITY)};
    for (const float candidate : candidates) {
        if (1.0f / candidate == inverse_mass) { return candidate; }
    }
    return mass;
}

class IndexOf {
public:
    explicit IndexOf(const btSoftBody& soft) : soft_(soft) {}
    int node(const btSoftBody::Node* n) const { return static_cast<int>(n - &soft_.m_nodes[0]); }
    int material(const btSoftBody::Material* m) const {
        for (int i = 0; i < soft_.m_materials.size(); ++i) {
            if (soft_.m_materials[i] == m) { return i; }
        }
        return 0;
    }

private:
    const btSoftBody& soft_;
};

pli_status append_elements(const btSoftBody& soft, pli_mesh* mesh) {
    const IndexOf index(soft);
    pli_status status = PLI_OK;
    for (int i = 0; i < soft.m_nodes.size() && status == PLI_OK; ++i) {
        const btSoftBody::Node& node = soft.m_nodes[i];
        status = pli_mesh_append_node(mesh, to_pli(node.m_x), mass_of(to_float(node.m_im)), nullptr);
    }
    for (int i = 0; i < soft.m_materials.size() && status == PLI_OK; ++i) {
        const pli_material material = {to_float(soft.m_materials[i]->m_kLST)};
        status =
            i == 0 ? pli_mesh_set_material(mesh, 0, &material) : pli_mesh_append_material(mesh, &material, nullptr);
    }
    for (int i = 0; i < soft.m_links.size() && status == PLI_OK; ++i) {
        const btSoftBody::Link& link = soft.m_links[i];
        status = pli_mesh_append_link(mesh, index.node(link.m_n[0]), index.node(link.m_n[1]),
                                      index.material(link.m_material), nullptr);
    }
    for (int i = 0; i < soft.m_faces.size() && status == PLI_OK; ++i) {
        const btSoftBody::Face& face = soft.m_faces[i];
        status = pli_mesh_append_face(mesh, index.node(face.m_n[0]), index.node(face.m_n[1]), index.node(face.m_n[2]),
                                      index.material(face.m_material), nullptr);
    }
    for (int i = 0; i < soft.m_tetras.size() && status == PLI_OK; ++i) {
        const btSoftBody::Tetra& tetra = soft.m_tetras[i];
        status =
            pli_mesh_append_tetra(mesh, index.node(tetra.m_n[0]), index.node(tetra.m_n[1]), index.node(tetra.m_n[2]),
                                  index.node(tetra.m_n[3]), index.material(tetra.m_material), nullptr);
    }
    return status;
}

// --------------------------------------------------------------------------------------------- clusters and joints

int cluster_index(const btSoftBody& soft, const btSoftBody::Cluster* cluster) {
    for (int i = 0; i < soft.m_clusters.size(); ++i) {
        if (soft.m_clusters[i] == cluster) { return i; }
    }
    return PLI_NULL_INDEX;
}

void read_clusters(const btSoftBody& soft, ImportedBody& body) {
    const IndexOf index(soft);
    body.cluster_iterations = soft.m_cfg.citerations;
    for (int i = 0; i < soft.m_clusters.size(); ++i) {
        const btSoftBody::Cluster& from = *soft.m_clusters[i];
        ImportedCluster cluster{};
        for (int k = 0; k < from.m_nodes.size(); ++k) {
            cluster.nodes.push_back(index.node(from.m_nodes[k]));
            cluster.rest_positions.push_back(to_pli(from.m_framerefs[k]));
        }
        cluster.settings.matching = to_float(from.m_matching);
        cluster.settings.node_damping = to_float(from.m_ndamping);
        cluster.settings.linear_damping = to_float(from.m_ldamping);
        cluster.settings.angular_damping = to_float(from.m_adamping);
        cluster.settings.collides = from.m_collide;
        cluster.settings.max_self_impulse = to_float(from.m_maxSelfCollisionImpulse);
        cluster.settings.self_impulse_factor = to_float(from.m_selfCollisionImpulseFactor);
        body.clusters.push_back(cluster);
    }
}

void read_cluster_contacts(const btSoftBody& soft, ImportedBody& body) {
    using Flags = btSoftBody::fCollision;
    const btSoftBody::Config& config = soft.m_cfg;
    body.cluster_contacts = pli_cluster_contacts_def_default();
    pli_cluster_contacts_def& contacts = body.cluster_contacts;
    contacts.with_rigids = (config.collisions & Flags::RVSmask) == Flags::CL_RS;
    contacts.with_bodies = (config.collisions & (Flags::VF_SS | Flags::CL_SS)) == Flags::CL_SS;
    contacts.with_self = contacts.with_bodies && (config.collisions & Flags::CL_SELF) != 0;
    contacts.friction = to_float(config.kDF);
    contacts.dynamic_hardness = to_float(config.kSRHR_CL);
    contacts.static_hardness = to_float(config.kSKHR_CL);
    contacts.soft_hardness = to_float(config.kSSHR_CL);
    contacts.dynamic_split = to_float(config.kSR_SPLT_CL);
    contacts.static_split = to_float(config.kSK_SPLT_CL);
    contacts.soft_split = to_float(config.kSS_SPLT_CL);
    body.has_cluster_contacts = contacts.with_rigids || contacts.with_bodies;
    const int known = Flags::SDF_RS | Flags::CL_RS | Flags::VF_SS | Flags::CL_SS | Flags::CL_SELF;
    if ((config.collisions & ~known) != 0) {
        body.not_taken.push_back("collision flags of deformable bodies: " + std::to_string(config.collisions & ~known));
    }
}

// Empty, or why it cannot be taken.
std::string read_joint(const btSoftBody& soft, const btSoftBody::Joint& from, ImportedJoint& joint) {
    constexpr btScalar apart = btScalar(0.01); // m, or rad
    const btSoftBody::Body &first = from.m_bodies[0], &second = from.m_bodies[1];
    joint.is_angular = from.Type() == btSoftBody::Joint::eType::Angular;
    joint.cluster = cluster_index(soft, first.m_soft);
    joint.other_cluster = cluster_index(soft, second.m_soft);
    joint.object = const_cast<btCollisionObject*>(second.m_collisionObject);
    if (joint.object == nullptr) { joint.object = second.m_rigid; }
    joint.softness = {to_float(from.m_erp), to_float(from.m_cfm), to_float(from.m_split)};
    if (joint.cluster == PLI_NULL_INDEX) { return "its first end is no cluster of this body"; }
    if (second.m_soft != nullptr && joint.other_cluster == PLI_NULL_INDEX) {
        return "its other end is a cluster of another btSoftBody";
    }
    const btTransform &a = first.xform(), &b = second.xform();
    if (!joint.is_angular) {
        const btVector3 point = a * from.m_refs[0];
        joint.place = to_pli(point);
        return (b * from.m_refs[1] - point).length() > apart ? "its ends are apart" : "";
    }
    const btVector3 axis = a.getBasis() * from.m_refs[0];
    joint.place = to_pli(axis);
    if (static_cast<const btSoftBody::AJoint&>(from).m_icontrol != btSoftBody::AJoint::IControl::Default()) {
        return "it has an IControl, see pli_angular_joint_def::controller";
    }
    return (b.getBasis() * from.m_refs[1]).cross(axis).length() > apart ? "its axes are apart" : "";
}

void read_joints(const btSoftBody& soft, ImportedBody& body) {
    for (int i = 0; i < soft.m_joints.size(); ++i) {
        const btSoftBody::Joint& from = *soft.m_joints[i];
        if (from.Type() == btSoftBody::Joint::eType::Contact) { continue; } // of the step
        ImportedJoint joint{};
        const std::string reason = read_joint(soft, from, joint);
        if (reason.empty()) {
            body.joints.push_back(joint);
        } else {
            body.not_taken.push_back("joint " + std::to_string(i) + ": " + reason);
        }
    }
}

void read_pose(const btSoftBody& soft, ImportedBody& body) {
    const btSoftBody::Pose& pose = soft.m_pose;
    body.volume_conservation = pose.m_bvolume ? to_float(soft.m_cfg.kVC) : 0.0f;
    body.pose_matching = pose.m_bframe ? to_float(soft.m_cfg.kMT) : 0.0f;
    if ((!pose.m_bvolume && !pose.m_bframe) || pose.m_pos.size() != soft.m_nodes.size()) { return; }
    for (int i = 0; i < pose.m_pos.size(); ++i) {
        body.rest_positions.push_back(to_pli(pose.m_pos[i]));
    }
    if (!(body.volume_conservation > 0.0f)) { return; }
    const IndexOf index(soft);
    btScalar volume = 0;
    for (int i = 0; i < soft.m_faces.size(); ++i) {
        const btVector3* x[3];
        for (int k = 0; k < 3; ++k) {
            x[k] = &pose.m_pos[index.node(soft.m_faces[i].m_n[k])];
        }
        volume += x[0]->dot(x[1]->cross(*x[2])) / 6;
    }
    if (!(btFabs(volume - pose.m_volume) <= btScalar(1e-3) * btFabs(pose.m_volume))) {
        body.not_taken.push_back("the rest volume, which is not that of the rest shape");
    }
}

ImportedBody read_parameters(const btSoftBody& soft) {
    const btSoftBody::Config& config = soft.m_cfg;
    const IndexOf index(soft);
    ImportedBody body{};
    body.def = pli_body_def_default();
    body.def.collision_margin = to_float(soft.getCollisionShape()->getMargin());
    body.def.solver.velocity_iterations = config.viterations;
    body.def.solver.position_iterations = config.piterations;
    body.def.solver.drift_iterations = config.diterations;
    body.def.solver.drift_correction = to_float(config.kVCF);
    body.def.solver.velocity_damping = to_float(config.kDP);
    body.def.solver.time_scale = to_float(config.timescale);
    for (int i = 0; i < soft.m_nodes.size(); ++i) {
        body.positions.push_back(to_pli(soft.m_nodes[i].m_x));
        body.velocities.push_back(to_pli(soft.m_nodes[i].m_v));
    }
    for (int i = 0; i < soft.m_links.size(); ++i) {
        body.rest_lengths.push_back(to_float(soft.m_links[i].m_rl));
    }
    body.uses_velocity_links =
        config.m_psequence.findLinearSearch(btSoftBody::ePSolver::Linear) == config.m_psequence.size();

    // Bullet compares the masked bits with one flag, and ignores combinations.
    body.collides_with_rigid_bodies =
        (config.collisions & btSoftBody::fCollision::RVSmask) == btSoftBody::fCollision::SDF_RS;
    body.rigid_contacts = pli_rigid_contacts_def_default();
    body.rigid_contacts.friction = to_float(config.kDF);
    body.rigid_contacts.dynamic_hardness = to_float(config.kCHR);
    body.rigid_contacts.static_hardness = to_float(config.kKHR);
    body.collides_with_soft_bodies =
        (config.collisions & btSoftBody::fCollision::SVSmask) == btSoftBody::fCollision::VF_SS;
    body.soft_contacts = pli_soft_contacts_def_default();
    body.soft_contacts.friction = to_float(config.kDF);
    body.soft_contacts.hardness = to_float(config.kSHR);

    body.has_aero = config.kLF > 0 || config.kDG > 0;
    body.aero = pli_aero_def_default();
    body.aero.model = static_cast<pli_aero_model>(config.aeromodel);
    body.aero.lift = to_float(config.kLF);
    body.aero.drag = to_float(config.kDG);
    body.aero.wind = to_pli(soft.m_windVelocity);
    body.pressure = to_float(config.kPR);
    read_pose(soft, body);
    read_clusters(soft, body);
    read_cluster_contacts(soft, body);
    read_joints(soft, body);

    body.anchor_hardness = to_float(config.kAHR);
    for (int i = 0; i < soft.m_anchors.size(); ++i) {
        const btSoftBody::Anchor& anchor = soft.m_anchors[i];
        body.anchors.push_back(
            {index.node(anchor.m_node), anchor.m_body, to_pli(anchor.m_local), to_float(anchor.m_influence)});
    }
    for (int i = 0; i < soft.m_collisionDisabledObjects.size(); ++i) {
        body.ignored.push_back(const_cast<btCollisionObject*>(soft.m_collisionDisabledObjects[i]));
    }
    return body;
}

// With the nodes where their rest shapes are.
pli_status apply_rest_shapes(pli_body* body, const ImportedBody& from) {
    pli_status status = PLI_OK;
    const auto then = [&status](auto&& call) {
        if (status == PLI_OK) { status = call(); }
    };
    if (!from.rest_positions.empty()) {
        then([&] { return pli_body_set_state(body, from.rest_positions.data(), nullptr); });
    }
    if (from.volume_conservation > 0.0f) {
        then([&] { return pli_body_enable_volume_conservation(body, from.volume_conservation); });
    }
    if (from.pose_matching > 0.0f) {
        then([&] { return pli_body_enable_pose_matching(body, from.pose_matching); });
    }
    if (!from.clusters.empty() || from.has_cluster_contacts) {
        pli_clusters_def def = pli_clusters_def_default();
        def.iterations = from.cluster_iterations;
        then([&] { return pli_body_enable_clusters(body, &def); });
    }
    std::vector<pli_vec3> places = from.positions;
    for (const ImportedCluster& cluster : from.clusters) {
        for (std::size_t i = 0; i < cluster.nodes.size(); ++i) {
            places[static_cast<std::size_t>(cluster.nodes[i])] = cluster.rest_positions[i];
        }
        int made = 0;
        then([&] { return pli_body_set_state(body, places.data(), nullptr); });
        then([&] {
            return pli_body_add_cluster(body, cluster.nodes.data(), static_cast<int>(cluster.nodes.size()), &made);
        });
        then([&] { return pli_body_set_cluster_settings(body, made, &cluster.settings); });
    }
    if (from.has_cluster_contacts) {
        then([&] { return pli_body_enable_cluster_contacts(body, &from.cluster_contacts); });
    }
    then([&] { return pli_body_set_state(body, from.positions.data(), from.velocities.data()); });
    return status;
}

pli_status apply_features(pli_body* body, const ImportedBody& from) {
    pli_status status = apply_rest_shapes(body, from);
    const auto then = [&status](auto&& call) {
        if (status == PLI_OK) { status = call(); }
    };
    if (from.uses_velocity_links) {
        then([&] { return pli_body_disable_colored_links(body); }); // they are of the position solve
        then([&] { return pli_body_enable_velocity_links(body); });
    }
    if (from.has_aero) {
        then([&] { return pli_body_enable_aero(body, &from.aero); });
    }
    if (from.pressure != 0.0f) {
        then([&] { return pli_body_enable_pressure(body, from.pressure); });
    }
    if (from.collides_with_rigid_bodies) {
        then([&] { return pli_body_enable_rigid_contacts(body, &from.rigid_contacts); });
    }
    if (from.collides_with_soft_bodies) {
        then([&] { return pli_body_enable_soft_contacts(body, &from.soft_contacts); });
    }
    for (std::size_t i = 0; i < from.rest_lengths.size(); ++i) {
        then([&] { return pli_body_set_rest_length(body, static_cast<int>(i), from.rest_lengths[i]); });
    }
    return status;
}

constexpr char import_name[] = "pliant::import_soft_body";

pli_status apply_joint(Bridge& bridge, pli_body* body, const ImportedJoint& from) {
    pli_joint_end other{};
    if (from.other_cluster != PLI_NULL_INDEX) {
        other.body = body;
        other.cluster = from.other_cluster;
    } else if (from.object != nullptr) {
        other.rigid = bridge.rigid(*from.object);
        if (other.rigid == nullptr) {
            return pli_context_fail(bridge.context(), PLI_ERROR_WRONG_STATE, import_name,
                                    "the object at the other end of a joint cannot be met");
        }
    }
    if (from.is_angular) {
        pli_angular_joint_def def = pli_angular_joint_def_default();
        def.cluster = from.cluster;
        def.other = other;
        def.axis = from.place;
        def.softness = from.softness;
        return pli_body_add_angular_joint(body, &def, nullptr);
    }
    pli_linear_joint_def def = pli_linear_joint_def_default();
    def.cluster = from.cluster;
    def.other = other;
    def.position = from.place;
    def.softness = from.softness;
    return pli_body_add_linear_joint(body, &def, nullptr);
}

pli_status apply_rigid_relations(Bridge& bridge, pli_body* body, const ImportedBody& from) {
    pli_status status = PLI_OK;
    if (!from.anchors.empty()) { status = pli_body_set_anchor_hardness(body, from.anchor_hardness); }
    for (const ImportedAnchor& anchor : from.anchors) {
        if (status != PLI_OK) { return status; }
        pli_anchor_def def = pli_anchor_def_default();
        def.node = anchor.node;
        def.rigid = bridge.rigid(*anchor.body);
        def.local_pivot = &anchor.local_pivot;
        def.influence = anchor.influence;
        status = pli_body_add_anchor(body, &def, nullptr);
    }
    for (btCollisionObject* object : from.ignored) {
        if (status != PLI_OK) { return status; }
        status = pli_body_ignore_rigid(body, bridge.rigid(*object), true);
    }
    for (const ImportedJoint& joint : from.joints) {
        if (status != PLI_OK) { return status; }
        status = apply_joint(bridge, body, joint);
    }
    return status;
}

} // namespace

pli_status import_soft_body(pli_context* context, const btSoftBody& soft, pli_mesh** mesh, ImportedBody* parameters) {
    if (mesh == nullptr) { return pli_context_fail(context, PLI_ERROR_NULL_ARGUMENT, import_name, "mesh is null"); }
    pli_mesh* made = nullptr;
    pli_status status = pli_mesh_create(context, &made);
    if (status == PLI_OK) { status = append_elements(soft, made); }
    if (status != PLI_OK) {
        pli_mesh_destroy(made);
        return status;
    }
    if (parameters != nullptr) { *parameters = read_parameters(soft); }
    *mesh = made;
    return PLI_OK;
}

pli_status import_soft_body(Bridge& bridge, const btSoftBody& soft, pli_body** body, int group, int mask,
                            std::vector<std::string>* not_taken) {
    if (body == nullptr) {
        return pli_context_fail(bridge.context(), PLI_ERROR_NULL_ARGUMENT, import_name, "body is null");
    }
    pli_mesh* mesh = nullptr;
    ImportedBody parameters{};
    pli_status status = import_soft_body(bridge.context(), soft, &mesh, &parameters);
    if (status != PLI_OK) { return status; }
    if (not_taken != nullptr) { *not_taken = parameters.not_taken; }
    if (!parameters.not_taken.empty()) {
        pli_mesh_destroy(mesh);
        const std::string message = "cannot be taken over: " + parameters.not_taken.front();
        return pli_context_fail(bridge.context(), PLI_ERROR_INVALID_VALUE, import_name, message.c_str());
    }
    pli_body* made = nullptr;
    status = bridge.add_body(mesh, &parameters.def, &made, group, mask);
    pli_mesh_destroy(mesh);
    if (status != PLI_OK) { return status; }
    status = apply_features(made, parameters);
    if (status == PLI_OK) { status = apply_rigid_relations(bridge, made, parameters); }
    if (status != PLI_OK) {
        (void)bridge.remove_body(made);
        return status;
    }
    *body = made;
    return PLI_OK;
}

} // namespace pliant
