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
    body.volume_conservation = soft.m_pose.m_bvolume ? to_float(config.kVC) : 0.0f;
    body.pose_matching = soft.m_pose.m_bframe ? to_float(config.kMT) : 0.0f;

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

pli_status apply_features(pli_body* body, const ImportedBody& from) {
    pli_status status = PLI_OK;
    const auto then = [&status](auto&& call) {
        if (status == PLI_OK) { status = call(); }
    };
    if (from.uses_velocity_links) {
        then([&] { return pli_body_enable_velocity_links(body); });
    }
    if (from.has_aero) {
        then([&] { return pli_body_enable_aero(body, &from.aero); });
    }
    if (from.pressure != 0.0f) {
        then([&] { return pli_body_enable_pressure(body, from.pressure); });
    }
    if (from.volume_conservation > 0.0f) {
        then([&] { return pli_body_enable_volume_conservation(body, from.volume_conservation); });
    }
    if (from.pose_matching > 0.0f) {
        then([&] { return pli_body_enable_pose_matching(body, from.pose_matching); });
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
    then([&] { return pli_body_set_state(body, from.positions.data(), from.velocities.data()); });
    return status;
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
    return status;
}

} // namespace

pli_status import_soft_body(pli_context* context, const btSoftBody& soft, pli_mesh** mesh, ImportedBody* parameters) {
    if (mesh == nullptr) { return PLI_ERROR_NULL_ARGUMENT; }
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

pli_status import_soft_body(Bridge& bridge, const btSoftBody& soft, pli_body** body, int group, int mask) {
    if (body == nullptr) { return PLI_ERROR_NULL_ARGUMENT; }
    pli_mesh* mesh = nullptr;
    ImportedBody parameters{};
    pli_status status = import_soft_body(bridge.context(), soft, &mesh, &parameters);
    if (status != PLI_OK) { return status; }
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
