// What a user sees of a scene on btSoftBody and touches in it: rays, nodes, contacts and clusters.

#include "bullet_engine.h"

namespace demos {

static int node_index(const btSoftBody& body, const btSoftBody::Node* node) {
    return static_cast<int>(node - &body.m_nodes[0]);
}

// The node nearest to the ray, when it is nearer than the radius: btSoftBody's rays meet no ropes.
static void cast_at_nodes(const btSoftBody& body, const btVector3& from, const btVector3& to, btScalar radius,
                          btScalar& fraction, int& node) {
    const btVector3 way = to - from;
    for (int i = 0; i < body.m_nodes.size(); ++i) {
        const btVector3 offset = body.m_nodes[i].m_x - from;
        const btScalar share = way.dot(offset) / way.length2();
        const bool is_near = (offset - way * share).length2() < radius * radius;
        if (is_near && share > 0 && share < fraction) {
            fraction = share;
            node = i;
        }
    }
}

static int nearest_of(const btSoftBody& body, btSoftBody::Node* const* nodes, int count, const btVector3& point) {
    const btSoftBody::Node* nearest = nodes[0];
    for (int i = 1; i < count; ++i) {
        if ((nodes[i]->m_x - point).length2() < (nearest->m_x - point).length2()) { nearest = nodes[i]; }
    }
    return node_index(body, nearest);
}

RayHit BulletEngine::cast_soft_ray(pli_vec3 from, pli_vec3 to, float radius) const {
    const btVector3 start = to_bullet(from), end = to_bullet(to);
    RayHit nearest;
    for (int i = 0; i < soft_count(); ++i) {
        btSoftBody& soft = body(i);
        btScalar fraction = nearest.fraction;
        int node = -1;
        if (soft.m_faces.size() == 0 && soft.m_tetras.size() == 0) {
            cast_at_nodes(soft, start, end, radius, fraction, node);
        } else {
            // Unlike the short form of rayTest this makes no tree, which would never end for a body in pieces.
            btSoftBody::eFeature::_ feature = btSoftBody::eFeature::None;
            int index = -1;
            if (soft.rayTest(start, end, fraction, feature, index, false) == 0 || index < 0) { continue; }
            const btVector3 point = start + (end - start) * fraction;
            node = feature == btSoftBody::eFeature::Tetra ? nearest_of(soft, soft.m_tetras[index].m_n, 4, point)
                                                          : nearest_of(soft, soft.m_faces[index].m_n, 3, point);
        }
        if (node < 0) { continue; }
        nearest.soft = i;
        nearest.node = node;
        nearest.fraction = fraction;
        nearest.point = from_bullet(start + (end - start) * fraction);
    }
    return nearest;
}

pli_vec3 BulletEngine::node_position(int soft, int node) const {
    const btSoftBody& from = body(soft);
    if (node < 0 || node >= from.m_nodes.size()) { throw Error("there is no node " + std::to_string(node)); }
    return from_bullet(from.m_nodes[node].m_x);
}

// A held node gets the velocity that brings it to the goal in one step, but none that would tear at its links.
static pli_vec3 velocity_towards(pli_vec3 goal, pli_vec3 position, float seconds) {
    constexpr float fastest = 60.0f; // m/s
    const pli_vec3 velocity = pli_vec3_scale(pli_vec3_sub(goal, position), 1.0f / seconds);
    const float speed = pli_vec3_length(velocity);
    return speed > fastest ? pli_vec3_scale(velocity, fastest / speed) : velocity;
}

void BulletEngine::drag_soft(const RayHit& held, pli_vec3 goal, float seconds) {
    btSoftBody::Node& node = body(held.soft).m_nodes[held.node];
    if (node.m_im > 0) { node.m_v = to_bullet(velocity_towards(goal, from_bullet(node.m_x), seconds)); }
}

std::vector<ContactMark> BulletEngine::contacts(int soft) const {
    const btSoftBody& from = body(soft);
    std::vector<ContactMark> marks;
    for (int i = 0; i < from.m_rcontacts.size(); ++i) {
        const btSoftBody::RContact& contact = from.m_rcontacts[i];
        marks.push_back({from_bullet(contact.m_node->m_x), from_bullet(contact.m_cti.m_normal)});
    }
    for (int i = 0; i < from.m_scontacts.size(); ++i) {
        const btSoftBody::SContact& contact = from.m_scontacts[i];
        marks.push_back({from_bullet(contact.m_node->m_x), from_bullet(contact.m_normal)});
    }
    return marks;
}

std::vector<ClusterMark> BulletEngine::clusters(int soft) const {
    const btSoftBody& from = body(soft);
    std::vector<ClusterMark> marks;
    for (int i = 0; i < from.m_clusters.size(); ++i) {
        const btSoftBody::Cluster& cluster = *from.m_clusters[i];
        ClusterMark mark{from_bullet(cluster.m_com), {}};
        for (int k = 0; k < cluster.m_nodes.size(); ++k) {
            mark.nodes.push_back(node_index(from, cluster.m_nodes[k]));
        }
        marks.push_back(std::move(mark));
    }
    return marks;
}

} // namespace demos
