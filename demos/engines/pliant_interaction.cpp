// What a user sees of a scene on Pliant and touches in it: rays, nodes, contacts and clusters.

#include "pliant_engine.h"

namespace demos {

RayHit PliantEngine::cast_soft_ray(pli_vec3 from, pli_vec3 to, float radius) const {
    RayHit nearest;
    for (int i = 0; i < soft_count(); ++i) {
        const pli_body_view view = pli_body_get_view(body(i));
        pli_ray_def def = pli_ray_def_default();
        def.from = from;
        def.to = to;
        if (view.face_count == 0 && view.tetra_count == 0) { def.targets = PLI_RAY_NODES | PLI_RAY_LINKS; }
        def.radius = radius;
        pli_ray_hit hit;
        check(pli_body_cast_ray(body(i), &def, &hit));
        if (hit.kind == PLI_FEATURE_NONE || hit.fraction >= nearest.fraction) { continue; }
        nearest.soft = i;
        nearest.node = hit.nearest_node;
        nearest.face = hit.kind == PLI_FEATURE_FACE ? hit.index : PLI_NULL_INDEX;
        nearest.point = hit.point;
        nearest.fraction = hit.fraction;
    }
    return nearest;
}

pli_vec3 PliantEngine::node_position(int soft, int node) const {
    const pli_body_view view = pli_body_get_view(body(soft));
    if (node < 0 || node >= view.node_count) { throw Error("there is no node " + std::to_string(node)); }
    return xyz(view.positions[node]);
}

void PliantEngine::grab_soft(const RayHit& hit) {
    pli_drag_def def = pli_drag_def_default();
    def.node = hit.node;
    def.face = hit.face;
    def.point = hit.point;
    check(pli_body_begin_drag(body(hit.soft), &def, &drag_));
}

pli_vec3 PliantEngine::soft_grip(const RayHit& held) const {
    pli_vec3 point{};
    check(pli_body_get_drag(body(held.soft), drag_, &point, nullptr));
    return point;
}

void PliantEngine::drag_soft(const RayHit& held, pli_vec3 goal, float) {
    check(pli_body_move_drag(body(held.soft), drag_, goal));
}

void PliantEngine::let_go_soft(const RayHit& held) {
    check(pli_body_end_drag(body(held.soft), drag_));
}

// All contacts of one kind, by the function that copies them.
template <typename Contact>
static std::vector<Contact> read_contacts(const pli_body* body, int (*read)(const pli_body*, int, Contact*)) {
    std::vector<Contact> contacts(static_cast<size_t>(read(body, 0, nullptr)));
    read(body, static_cast<int>(contacts.size()), contacts.data());
    return contacts;
}

std::vector<ContactMark> PliantEngine::contacts(int soft) const {
    const pli_body* from = body(soft);
    const pli_body_view view = pli_body_get_view(from);
    std::vector<ContactMark> marks;
    for (const pli_rigid_contact& contact : read_contacts(from, pli_body_get_rigid_contacts)) {
        marks.push_back({xyz(view.positions[contact.node]), contact.normal});
    }
    for (const pli_soft_contact& contact : read_contacts(from, pli_body_get_soft_contacts)) {
        marks.push_back({xyz(view.positions[contact.node]), contact.normal});
    }
    for (const pli_cluster_contact& contact : read_contacts(from, pli_body_get_cluster_contacts)) {
        marks.push_back({contact.witness, contact.normal});
    }
    return marks;
}

std::vector<ClusterMark> PliantEngine::clusters(int soft) const {
    std::vector<ClusterMark> marks;
    for (int i = 0; i < pli_body_cluster_count(body(soft)); ++i) {
        pli_cluster_view cluster;
        check(pli_body_get_cluster(body(soft), i, &cluster));
        ClusterMark mark{cluster.frame.origin, {}};
        for (int k = 0; k < cluster.node_count; ++k) {
            mark.nodes.push_back(cluster.nodes[static_cast<ptrdiff_t>(k) * cluster.node_stride]);
        }
        marks.push_back(std::move(mark));
    }
    return marks;
}

} // namespace demos
