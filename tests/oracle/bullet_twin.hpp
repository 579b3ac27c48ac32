// A btSoftBody and a Pliant body in the same state, for tests that compare one step of both.
//
//     auto info = twin::world_info();
//     auto soft = twin::make_soft_body(info, mesh);       // the same mesh goes into pli_body_create
//     ... enable the same features on both ...
//     for (...) {
//         twin::step(*soft, dt);  pli_world_step(world, dt);
//         check(twin::compare(*soft, body).is_exact());
//         twin::copy_state(*soft, body);                  // or the other way round
//     }
//
// Works with Bullet in single and in double precision; differences are between floats.
#pragma once

#include <pliant/body.h>
#include <pliant/rigid.h>
#include <pliant/world.h>

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace twin {

inline btScalar to_bullet(float value) {
    return static_cast<btScalar>(value);
}
inline btVector3 to_bullet(pli_vec3 v) {
    return btVector3(to_bullet(v.x), to_bullet(v.y), to_bullet(v.z));
}
inline pli_vec3 xyz(pli_vec4 v) {
    return pli_vec3_make(v.x, v.y, v.z);
}
inline pli_vec3 to_pliant(const btVector3& v) {
    return pli_vec3_make(static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
}
inline pli_mat3 to_pliant(const btMatrix3x3& m) {
    pli_mat3 result;
    for (int i = 0; i < 3; ++i) {
        result.rows[i] = to_pliant(m[i]);
    }
    return result;
}
inline btMatrix3x3 to_bullet(const pli_mat3& m) {
    btMatrix3x3 result;
    for (int i = 0; i < 3; ++i) {
        result[i] = to_bullet(m.rows[i]);
    }
    return result;
}
inline pli_transform to_pliant(const btTransform& t) {
    pli_transform result;
    result.rotation = to_pliant(t.getBasis());
    result.origin = to_pliant(t.getOrigin());
    return result;
}
inline btTransform to_bullet(const pli_transform& t) {
    return btTransform(to_bullet(t.rotation), to_bullet(t.origin));
}

// Fixed pseudo-random numbers (xorshift), the same on every machine.
class random_source {
public:
    explicit random_source(std::uint32_t start) : m_state(start != 0 ? start : 1u) {}
    float uniform(float low, float high) {
        m_state ^= m_state << 13;
        m_state ^= m_state >> 17;
        m_state ^= m_state << 5;
        return low + (high - low) * (static_cast<float>(m_state >> 8) / 16777216.0f);
    }
    pli_vec3 vector(float size) {
        const float x = uniform(-size, size), y = uniform(-size, size), z = uniform(-size, size);
        return pli_vec3_make(x, y, z);
    }

private:
    std::uint32_t m_state;
};

// World info for soft bodies that live outside of a Bullet world, or for the constructor of those inside one (set
// m_broadphase and m_dispatcher then). Gravity (0, -10, 0), air density 1.2: Pliant's defaults too.
inline btSoftBodyWorldInfo world_info() {
    btSoftBodyWorldInfo info;
    info.m_broadphase = nullptr;
    info.m_dispatcher = nullptr;
    info.m_gravity.setValue(0, -10, 0);
    info.m_sparsesdf.Initialize();
    return info;
}

// A btSoftBody with the nodes, links, faces, tetrahedra and materials of a mesh, in their order. Normals, areas and
// link constants are brought up to date and the deferred update is switched off, because it would take the positions of
// the first step as the rest shape; where a face tree is wanted (VF_SS), call initializeFaceTree() on the result.
inline std::unique_ptr<btSoftBody> make_soft_body(btSoftBodyWorldInfo& info, const pli_mesh* mesh) {
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    std::vector<btVector3> positions;
    for (int i = 0; i < view.node_count; ++i) {
        positions.push_back(to_bullet(view.positions[i]));
    }
    auto body = std::make_unique<btSoftBody>(&info, view.node_count, positions.data(), nullptr);
    for (int i = 0; i < view.node_count; ++i) {
        body->m_nodes[i].m_im = to_bullet(view.inverse_masses[i]);
    }
    for (int i = 0; i < view.material_count; ++i) {
        btSoftBody::Material* material = i == 0 ? body->m_materials[0] : body->appendMaterial();
        material->m_kLST = to_bullet(view.materials[i].linear_stiffness);
    }
    for (int i = 0; i < view.link_count; ++i) {
        const pli_link& link = view.links[i];
        body->appendLink(link.nodes[0], link.nodes[1], body->m_materials[link.material], false);
        body->m_links[i].m_bbending = link.is_bending ? -1 : 0; // one signed bit
    }
    for (int i = 0; i < view.face_count; ++i) {
        const pli_face& face = view.faces[i];
        body->appendFace(face.nodes[0], face.nodes[1], face.nodes[2], body->m_materials[face.material]);
    }
    for (int i = 0; i < view.tetra_count; ++i) {
        const pli_tetra& tetra = view.tetras[i];
        body->appendTetra(tetra.nodes[0], tetra.nodes[1], tetra.nodes[2], tetra.nodes[3],
                          body->m_materials[tetra.material]);
    }
    body->updateNormals();
    body->updateConstants();
    body->m_bUpdateRtCst = false;
    return body;
}

// One step of a soft body without collisions, in the order of btSoftRigidDynamicsWorld.
inline void step(btSoftBody& body, float dt) {
    body.predictMotion(to_bullet(dt));
    body.solveConstraints();
    body.integrateMotion();
}

// Positions and velocities, and what follows from them: bounds, normals.
inline pli_status copy_state(const btSoftBody& from, pli_body* to) {
    std::vector<pli_vec3> positions, velocities;
    for (int i = 0; i < from.m_nodes.size(); ++i) {
        positions.push_back(to_pliant(from.m_nodes[i].m_x));
        velocities.push_back(to_pliant(from.m_nodes[i].m_v));
    }
    return pli_body_set_state(to, positions.data(), velocities.data());
}
inline void copy_state(const pli_body* from, btSoftBody& to) {
    const pli_body_view view = pli_body_get_view(from);
    for (int i = 0; i < view.node_count; ++i) {
        btSoftBody::Node& node = to.m_nodes[i];
        node.m_x = node.m_q = to_bullet(xyz(view.positions[i]));
        node.m_v = to_bullet(xyz(view.velocities[i]));
        node.m_f.setZero();
    }
    to.updateBounds();
    to.updateNormals();
}

inline pli_rigid_state rigid_state(const btRigidBody& body) {
    pli_rigid_state state;
    state.pose = to_pliant(body.getWorldTransform());
    state.linear_velocity = to_pliant(body.getLinearVelocity());
    state.angular_velocity = to_pliant(body.getAngularVelocity());
    state.inverse_mass = static_cast<float>(body.getInvMass());
    state.inverse_inertia_world = to_pliant(body.getInvInertiaTensorWorld());
    return state;
}

// Largest distance per component; infinite when one side is not a number.
inline double distance(pli_vec3 a, pli_vec3 b) {
    const double differences[3] = {static_cast<double>(a.x) - static_cast<double>(b.x),
                                   static_cast<double>(a.y) - static_cast<double>(b.y),
                                   static_cast<double>(a.z) - static_cast<double>(b.z)};
    double largest = 0;
    for (const double d : differences) {
        if (std::isnan(d)) { return std::numeric_limits<double>::infinity(); }
        largest = std::fmax(largest, std::fabs(d));
    }
    return largest;
}

struct difference {
    double position = 0;       // m, largest over nodes and axes
    double velocity = 0;       // m/s
    int node = PLI_NULL_INDEX; // where the position or the velocity differs most
    bool is_exact() const { return position == 0 && velocity == 0; }
};

inline difference compare(const btSoftBody& a, const pli_body* b) {
    const pli_body_view view = pli_body_get_view(b);
    difference result;
    if (view.node_count != a.m_nodes.size()) {
        result.position = std::numeric_limits<double>::infinity();
        return result;
    }
    for (int i = 0; i < view.node_count; ++i) {
        const double position = distance(to_pliant(a.m_nodes[i].m_x), xyz(view.positions[i]));
        const double velocity = distance(to_pliant(a.m_nodes[i].m_v), xyz(view.velocities[i]));
        if (position > result.position || velocity > result.velocity) { result.node = i; }
        result.position = std::fmax(result.position, position);
        result.velocity = std::fmax(result.velocity, velocity);
    }
    return result;
}

} // namespace twin
