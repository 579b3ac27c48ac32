// Contacts are the same when they have the same members; a node that meets several parts of one rigid body is told
// apart by the normals.

#include "contact_match.h"

#include <pliant/bullet_reference.h>

#include <tuple>

namespace demos {

namespace {

using Contact = ContactMatcher::Contact;
using Members = std::tuple<int, int, int>;

Members members(const Contact& contact) {
    return {contact.node, contact.other, contact.face};
}

struct Matching {
    std::vector<int> order; // of Pliant's contacts
    int lone = 0;
};

Matching match_lists(const std::vector<Contact>& reference, const std::vector<Contact>& pliant) {
    std::multimap<Members, int> unmatched;
    for (size_t i = 0; i < pliant.size(); ++i) {
        unmatched.emplace(members(pliant[i]), static_cast<int>(i));
    }
    Matching matching;
    for (const Contact& contact : reference) {
        const auto distance = [&](std::multimap<Members, int>::iterator place) {
            const Contact& other = pliant[static_cast<size_t>(place->second)];
            return pli_vec3_length(pli_vec3_sub(contact.normal, other.normal)) +
                   pli_vec3_length(pli_vec3_sub(contact.arm, other.arm));
        };
        const auto [first, last] = unmatched.equal_range(members(contact));
        auto best = first;
        for (auto place = first; place != last; ++place) {
            if (distance(place) < distance(best)) { best = place; }
        }
        if (first == last) {
            matching.lone += 1;
        } else {
            matching.order.push_back(best->second);
            unmatched.erase(best);
        }
    }
    for (const auto& rest : unmatched) {
        matching.lone += 1;
        matching.order.push_back(rest.second);
    }
    return matching;
}

} // namespace

ContactMatcher::ContactMatcher(BulletEngine& reference, PliantEngine& pliant) : reference_(reference), pliant_(pliant) {
    for (int i = 0; i < reference.rigids().object_count(); ++i) {
        reference_rigids_[&reference.rigids().object(i)] = i;
        pliant_rigids_[pliant.proxy(i)] = i;
    }
    for (int i = 0; i < pliant.soft_count(); ++i) {
        pliant_bodies_[pliant.body(i)] = i;
    }
    reference.set_before_solve([this] {
        cluster_contacts_.clear();
        for (int i = 0; i < reference_.soft_count(); ++i) {
            cluster_contacts_.push_back(reference_cluster_contacts(i));
        }
    });
}

ContactMatcher::~ContactMatcher() {
    reference_.set_before_solve(nullptr);
}

std::vector<Contact> ContactMatcher::reference_rigid_contacts(int body) const {
    btSoftBody& source = reference_.body(body);
    std::vector<Contact> contacts;
    for (int i = 0; i < source.m_rcontacts.size(); ++i) {
        const btSoftBody::RContact& contact = source.m_rcontacts[i];
        contacts.push_back({static_cast<int>(contact.m_node - &source.m_nodes[0]),
                            reference_rigids_.at(contact.m_cti.m_colObj),
                            -1,
                            from_bullet(contact.m_cti.m_normal),
                            {}});
    }
    return contacts;
}

std::vector<Contact> ContactMatcher::reference_soft_contacts(int body) const {
    btSoftBody& source = reference_.body(body);
    std::vector<Contact> contacts;
    for (int i = 0; i < source.m_scontacts.size(); ++i) {
        const btSoftBody::SContact& contact = source.m_scontacts[i];
        for (int k = 0; k < reference_.soft_count(); ++k) {
            const btSoftBody::tFaceArray& faces = reference_.body(k).m_faces;
            if (faces.size() == 0 || contact.m_face < &faces[0] || contact.m_face > &faces[faces.size() - 1]) {
                continue;
            }
            contacts.push_back({static_cast<int>(contact.m_node - &source.m_nodes[0]),
                                k,
                                static_cast<int>(contact.m_face - &faces[0]),
                                from_bullet(contact.m_normal),
                                {}});
        }
    }
    return contacts;
}

int ContactMatcher::reference_body_of(const btSoftBody::Cluster* cluster) const {
    for (int i = 0; i < reference_.soft_count(); ++i) {
        const auto& clusters = reference_.body(i).m_clusters;
        if (cluster->m_clusterIndex < clusters.size() && clusters[cluster->m_clusterIndex] == cluster) { return i; }
    }
    throw Error("a contact of btSoftBody is with no cluster of the scene");
}

std::vector<Contact> ContactMatcher::reference_cluster_contacts(int body) const {
    const btSoftBody& source = reference_.body(body);
    std::vector<Contact> contacts;
    for (int i = 0; i < source.m_joints.size(); ++i) {
        if (source.m_joints[i]->Type() != btSoftBody::Joint::eType::Contact) { continue; }
        const auto& contact = *static_cast<const btSoftBody::CJoint*>(source.m_joints[i]);
        const btSoftBody::Cluster* other = contact.m_bodies[1].m_soft;
        contacts.push_back(
            {contact.m_bodies[0].m_soft->m_clusterIndex,
             other != nullptr ? reference_body_of(other) : reference_rigids_.at(contact.m_bodies[1].m_collisionObject),
             other != nullptr ? other->m_clusterIndex : -1, from_bullet(contact.m_normal),
             from_bullet(contact.m_rpos[0])});
    }
    return contacts;
}

std::vector<Contact> ContactMatcher::pliant_rigid_contacts(int body) const {
    const pli_body* source = pliant_.body(body);
    std::vector<pli_rigid_contact> found(static_cast<size_t>(pli_body_get_rigid_contacts(source, 0, nullptr)));
    pli_body_get_rigid_contacts(source, static_cast<int>(found.size()), found.data());
    std::vector<Contact> contacts;
    for (const pli_rigid_contact& contact : found) {
        contacts.push_back({contact.node, pliant_rigids_.at(contact.rigid), -1, contact.normal, {}});
    }
    return contacts;
}

std::vector<Contact> ContactMatcher::pliant_soft_contacts(int body) const {
    const pli_body* source = pliant_.body(body);
    std::vector<pli_soft_contact> found(static_cast<size_t>(pli_body_get_soft_contacts(source, 0, nullptr)));
    pli_body_get_soft_contacts(source, static_cast<int>(found.size()), found.data());
    std::vector<Contact> contacts;
    for (const pli_soft_contact& contact : found) {
        contacts.push_back({contact.node, pliant_bodies_.at(contact.face_body), contact.face, contact.normal, {}});
    }
    return contacts;
}

std::vector<Contact> ContactMatcher::pliant_cluster_contacts(int body) const {
    const pli_body* source = pliant_.body(body);
    std::vector<pli_cluster_contact> found(static_cast<size_t>(pli_body_get_cluster_contacts(source, 0, nullptr)));
    pli_body_get_cluster_contacts(source, static_cast<int>(found.size()), found.data());
    std::vector<Contact> contacts;
    for (const pli_cluster_contact& contact : found) {
        pli_cluster_view cluster;
        check(pli_body_get_cluster(source, contact.cluster, &cluster));
        const bool is_rigid = contact.rigid != nullptr;
        contacts.push_back({contact.cluster,
                            is_rigid ? pliant_rigids_.at(contact.rigid) : pliant_bodies_.at(contact.other),
                            is_rigid ? -1 : contact.other_cluster, contact.normal,
                            pli_vec3_sub(contact.witness, cluster.frame.origin)});
    }
    return contacts;
}

void ContactMatcher::check(pli_status status) const {
    if (status != PLI_OK) { throw Error(pli_last_error(pliant_.bridge().context())); }
}

int ContactMatcher::match() {
    int lone = 0;
    for (int i = 0; i < pliant_.soft_count(); ++i) {
        const Matching rigid = match_lists(reference_rigid_contacts(i), pliant_rigid_contacts(i));
        const Matching soft = match_lists(reference_soft_contacts(i), pliant_soft_contacts(i));
        const Matching cluster = match_lists(cluster_contacts_.at(static_cast<size_t>(i)), pliant_cluster_contacts(i));
        lone += rigid.lone + soft.lone + cluster.lone;
        if (!rigid.order.empty()) {
            check(pli_body_reorder_rigid_contacts(pliant_.body(i), rigid.order.data(),
                                                  static_cast<int>(rigid.order.size())));
        }
        if (!soft.order.empty()) {
            check(pli_body_reorder_soft_contacts(pliant_.body(i), soft.order.data(),
                                                 static_cast<int>(soft.order.size())));
        }
        if (!cluster.order.empty()) {
            check(pli_body_reorder_cluster_contacts(pliant_.body(i), cluster.order.data(),
                                                    static_cast<int>(cluster.order.size())));
        }
    }
    return lone;
}

} // namespace demos
