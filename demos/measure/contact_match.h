#ifndef DEMOS_CONTACT_MATCH_H
#define DEMOS_CONTACT_MATCH_H

// Gives Pliant's contacts of a step the order of the reference's. Bullet's order depends on memory addresses, and
// Gauss-Seidel results depend on the order.

#include "engines/bullet_engine.h"
#include "engines/pliant_engine.h"

#include <map>

namespace demos {

class ContactMatcher {
public:
    ContactMatcher(BulletEngine& reference, PliantEngine& pliant);
    ~ContactMatcher();
    ContactMatcher(const ContactMatcher&) = delete;
    ContactMatcher& operator=(const ContactMatcher&) = delete;

    // To be called when the reference has made its step and Pliant has its contacts but has not solved them.
    // Returns the number of contacts that only one of the two has found; in Pliant's lists those come last.
    int match();

    // Contact of a node (or a cluster) with another body, by numbers that mean the same in both engines.
    struct Contact {
        int node, other, face; // face (or cluster of the other body) -1: with a rigid body
        pli_vec3 normal;
        pli_vec3 arm; // of a cluster: from its centre to its nearest point
    };

private:
    std::vector<Contact> reference_rigid_contacts(int body) const;
    std::vector<Contact> reference_soft_contacts(int body) const;
    std::vector<Contact> reference_cluster_contacts(int body) const;
    std::vector<Contact> pliant_rigid_contacts(int body) const;
    std::vector<Contact> pliant_soft_contacts(int body) const;
    std::vector<Contact> pliant_cluster_contacts(int body) const;
    int reference_body_of(const btSoftBody::Cluster* cluster) const;
    void check(pli_status status) const;

    BulletEngine& reference_;
    PliantEngine& pliant_;
    std::map<const btCollisionObject*, int> reference_rigids_;
    std::map<const pli_rigid*, int> pliant_rigids_;
    std::map<const pli_body*, int> pliant_bodies_;
    std::vector<std::vector<Contact>> cluster_contacts_; // of the reference's step: it drops them at the end
};

} // namespace demos
#endif
