// Soft bodies with clusters on both engines, rigid bodies, and one step of all of them in the order of
// btSoftRigidDynamicsWorld. Pliant's clusters are in reference mode; distances of cluster contacts come from Bullet's
// GJK and EPA, their order from m_joints. Single precision.
#pragma once

#include "check.h"

#include "oracle/bullet_shape.hpp"

#include <pliant/bullet_reference.h>
#include <pliant/cluster.h>
#include <pliant/joint.h>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletSoftBody/btSoftBodyInternals.h>

#include <cstring>
#include <map>
#include <utility>

namespace twin {

// A rigid body on both sides, of one convex shape or of a compound.
struct rigid_twin {
    std::unique_ptr<btRigidBody> bullet;
    pli_rigid* pliant = nullptr;
    std::vector<const btConvexShape*> shapes;
    std::vector<btTransform> local;

    btTransform world_transform(int shape) const {
        const auto index = static_cast<std::size_t>(shape);
        const bool is_compound = bullet->getCollisionShape()->isCompound();
        return is_compound ? bullet->getWorldTransform() * local[index] : bullet->getWorldTransform();
    }
    void copy_state() const {
        const pli_rigid_state state = rigid_state(*bullet);
        assert_int_equal(pli_rigid_set_state(pliant, &state), PLI_OK);
    }
    // From one step to the next, as a world without contacts between rigid bodies does it.
    void move(float dt) const {
        if (bullet->isStaticObject()) { return; }
        if (!bullet->isKinematicObject()) {
            bullet->setLinearVelocity(bullet->getLinearVelocity() + btVector3(0, -10, 0) * to_bullet(dt));
        }
        btTransform next;
        bullet->predictIntegratedTransform(to_bullet(dt), next);
        bullet->setWorldTransform(next);
        bullet->updateInertiaTensor();
        copy_state();
    }
};

struct soft_twin {
    std::unique_ptr<btSoftBody> bullet;
    pli_body* pliant = nullptr;

    int cluster_index(const btSoftBody::Cluster* cluster) const {
        return bullet->m_clusters.findLinearSearch(const_cast<btSoftBody::Cluster*>(cluster));
    }
};

namespace detail {

inline pli_vec3 core_support(const void* user, pli_vec3 direction) {
    return to_pliant(
        static_cast<const btConvexShape*>(user)->localGetSupportingVertexWithoutMargin(to_bullet(direction)));
}

inline void check_same(pli_vec3 ours, const btVector3& theirs, const char* what) {
    const pli_vec3 expected = to_pliant(theirs);
    if (distance(ours, expected) == 0) { return; }
    fail_msg("%s is (%.9g, %.9g, %.9g), expected (%.9g, %.9g, %.9g)", what, static_cast<double>(ours.x),
             static_cast<double>(ours.y), static_cast<double>(ours.z), static_cast<double>(expected.x),
             static_cast<double>(expected.y), static_cast<double>(expected.z));
}

} // namespace detail

// Members in their order, masses, frames and velocities of all clusters, bit for bit.
inline void check_clusters(const btSoftBody& bullet, const pli_body* body) {
    const int count = pli_body_cluster_count(body);
    assert_int_equal(count, bullet.m_clusters.size());
    for (int i = 0; i < count; ++i) {
        const btSoftBody::Cluster& theirs = *bullet.m_clusters[i];
        pli_cluster_view ours;
        pli_cluster_settings settings;
        assert_int_equal(pli_body_get_cluster(body, i, &ours), PLI_OK);
        assert_int_equal(pli_body_get_cluster_settings(body, i, &settings), PLI_OK);
        assert_int_equal(settings.collides, theirs.m_collide);
        assert_int_equal(ours.contains_pinned_node, theirs.m_containsAnchor);
        assert_int_equal(ours.node_count, theirs.m_nodes.size());
        for (int k = 0; k < ours.node_count; ++k) {
            const int node = static_cast<int>(theirs.m_nodes[k] - &bullet.m_nodes[0]);
            assert_int_equal(ours.nodes[k * ours.node_stride], node);
        }
        check_near(ours.inverse_mass, theirs.m_imass, 0);
        detail::check_same(ours.frame.origin, theirs.m_framexform.getOrigin(), "centre of mass");
        for (int r = 0; r < 3; ++r) {
            detail::check_same(ours.frame.rotation.rows[r], theirs.m_framexform.getBasis()[r], "rotation");
        }
        detail::check_same(ours.linear_velocity, theirs.m_lv, "linear velocity");
        // Bullet inverts the inertia of nodes in a line all the same.
        if (std::isnan(theirs.m_invwi[0].x())) { continue; }
        for (int r = 0; r < 3; ++r) {
            detail::check_same(ours.inverse_inertia_world.rows[r], theirs.m_invwi[r], "inverse inertia");
        }
        detail::check_same(ours.angular_velocity, theirs.m_av, "angular velocity");
    }
}

class cluster_scene {
public:
    static constexpr float dt = 1.0f / 60.0f;

    cluster_scene() : m_info(world_info()) {
        assert_int_equal(pli_context_create(nullptr, &m_context), PLI_OK);
        assert_int_equal(pli_world_create(m_context, nullptr, &m_world), PLI_OK);
    }
    ~cluster_scene() {
        pli_world_destroy(m_world);
        pli_context_destroy(m_context);
    }
    cluster_scene(const cluster_scene&) = delete;
    cluster_scene& operator=(const cluster_scene&) = delete;

    pli_context* context() const { return m_context; }

    // Takes the mesh. `clusters` as in generateClusters: 0 makes one per element.
    soft_twin& add(pli_mesh* mesh, int clusters, int position_iterations = 1) {
        m_soft.push_back(std::make_unique<soft_twin>());
        soft_twin& made = *m_soft.back();
        made.bullet = make_soft_body(m_info, mesh);
        made.bullet->m_cfg.piterations = position_iterations;
        made.bullet->m_cfg.collisions = 0;
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.25f; // Bullet's
        def.solver.position_iterations = position_iterations;
        assert_int_equal(pli_body_create(m_world, mesh, &def, &made.pliant), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_clusters_def cluster_def = pli_clusters_def_default();
        cluster_def.reference_mode = true;
        assert_int_equal(pli_body_enable_clusters(made.pliant, &cluster_def), PLI_OK);
        made.bullet->generateClusters(clusters);
        if (clusters > 0) {
            assert_int_equal(pli_body_generate_clusters(made.pliant, clusters, 8192, nullptr), PLI_OK);
        } else {
            assert_int_equal(pli_body_generate_clusters_from_elements(made.pliant, nullptr), PLI_OK);
        }
        if (compares_clusters) { check_clusters(*made.bullet, made.pliant); }
        return made;
    }

    // `shape` must live as long as the scene. mass 0: static.
    rigid_twin& add_rigid(btCollisionShape& shape, float mass, const btTransform& pose, float friction = 0.5f) {
        m_rigids.push_back(std::make_unique<rigid_twin>());
        rigid_twin& made = *m_rigids.back();
        btVector3 inertia(0, 0, 0);
        if (mass > 0) { shape.calculateLocalInertia(to_bullet(mass), inertia); }
        btRigidBody::btRigidBodyConstructionInfo info(to_bullet(mass), nullptr, &shape, inertia);
        info.m_startWorldTransform = pose;
        info.m_friction = to_bullet(friction);
        made.bullet = std::make_unique<btRigidBody>(info);
        if (shape.isCompound()) {
            const auto& compound = static_cast<const btCompoundShape&>(shape);
            for (int i = 0; i < compound.getNumChildShapes(); ++i) {
                made.shapes.push_back(static_cast<const btConvexShape*>(compound.getChildShape(i)));
                made.local.push_back(compound.getChildTransform(i));
            }
        } else {
            made.shapes.push_back(static_cast<const btConvexShape*>(&shape));
            made.local.push_back(btTransform::getIdentity());
        }
        std::vector<pli_shape*> shapes;
        std::vector<pli_transform> poses;
        for (std::size_t i = 0; i < made.shapes.size(); ++i) {
            pli_shape_def def = pli_shape_def_default();
            def.user = const_cast<btConvexShape*>(made.shapes[i]);
            def.distances = detail::convex_distances;
            def.bounds = detail::convex_bounds;
            def.support = detail::core_support;
            def.radius = static_cast<float>(made.shapes[i]->getMargin());
            pli_shape* one = nullptr;
            assert_int_equal(pli_shape_create(m_context, &def, &one), PLI_OK);
            shapes.push_back(one);
            poses.push_back(to_pliant(made.local[i]));
        }
        pli_rigid_def def = pli_rigid_def_default();
        def.kind = mass > 0 ? PLI_RIGID_DYNAMIC : PLI_RIGID_STATIC;
        def.state = rigid_state(*made.bullet);
        def.friction = friction;
        def.shape_count = static_cast<int>(shapes.size());
        def.shapes = shapes.data();
        def.shape_poses = poses.data();
        assert_int_equal(pli_rigid_create(m_world, &def, &made.pliant), PLI_OK);
        for (pli_shape* one : shapes) {
            pli_shape_release(one);
        }
        return made;
    }

    static void set_cluster(soft_twin& soft, int cluster, const pli_cluster_settings& settings) {
        btSoftBody::Cluster& theirs = *soft.bullet->m_clusters[cluster];
        theirs.m_matching = to_bullet(settings.matching);
        theirs.m_ndamping = to_bullet(settings.node_damping);
        theirs.m_ldamping = to_bullet(settings.linear_damping);
        theirs.m_adamping = to_bullet(settings.angular_damping);
        theirs.m_collide = settings.collides;
        assert_int_equal(pli_body_set_cluster_settings(soft.pliant, cluster, &settings), PLI_OK);
    }

    // Contacts with rigid bodies (CL_RS) and with other soft bodies (CL_SS), as the definition says.
    void enable_contacts(soft_twin& soft, pli_cluster_contacts_def def) {
        btSoftBody::Config& config = soft.bullet->m_cfg;
        config.collisions = (def.with_rigids ? btSoftBody::fCollision::CL_RS : 0) +
                            (def.with_bodies ? btSoftBody::fCollision::CL_SS : 0);
        config.kDF = to_bullet(def.friction);
        config.kSRHR_CL = to_bullet(def.dynamic_hardness);
        config.kSKHR_CL = to_bullet(def.static_hardness);
        config.kSSHR_CL = to_bullet(def.soft_hardness);
        config.kSR_SPLT_CL = to_bullet(def.dynamic_split);
        config.kSK_SPLT_CL = to_bullet(def.static_split);
        config.kSS_SPLT_CL = to_bullet(def.soft_split);
        def.distance = measure;
        def.distance_user = this;
        assert_int_equal(pli_body_enable_cluster_contacts(soft.pliant, &def), PLI_OK);
    }

    void set_velocity(soft_twin& soft, pli_vec3 velocity, float noise, std::uint32_t start) {
        random_source random(start);
        for (int i = 0; i < soft.bullet->m_nodes.size(); ++i) {
            if (!(soft.bullet->m_nodes[i].m_im > 0)) { continue; }
            soft.bullet->m_nodes[i].m_v = to_bullet(pli_vec3_add(velocity, random.vector(noise)));
        }
        assert_int_equal(copy_state(*soft.bullet, soft.pliant), PLI_OK);
    }

    // Frames and velocities of clusters too; not where Bullet's are no numbers.
    bool compares_clusters = true;

    // Steps both engines; every step must be exact. `synchronize`: Pliant starts each step from Bullet's state.
    // Returns the number of contacts.
    int run(int steps, bool synchronize = false) {
        int contacts = 0;
        for (int i = 0; i < steps; ++i) {
            if (synchronize) {
                for (const auto& soft : m_soft) {
                    assert_int_equal(copy_state(*soft->bullet, soft->pliant), PLI_OK);
                }
            }
            contacts += step();
            check_step(i);
        }
        return contacts;
    }

private:
    int step() {
        btAlignedObjectArray<btSoftBody*> all;
        for (const auto& soft : m_soft) {
            all.push_back(soft->bullet.get());
            soft->bullet->predictMotion(to_bullet(dt));
        }
        assert_int_equal(pli_world_predict(m_world, dt), PLI_OK);
        for (const auto& soft : m_soft) {
            if (compares_clusters) { check_clusters(*soft->bullet, soft->pliant); }
        }
        collide();
        int contacts = 0;
        for (const auto& soft : m_soft) {
            contacts += order_contacts(*soft);
        }
        for (const auto& rigid : m_rigids) {
            rigid->move(dt);
        }
        btSoftBody::solveClusters(all);
        for (const auto& soft : m_soft) {
            soft->bullet->solveConstraints();
        }
        for (const auto& soft : m_soft) {
            soft->bullet->integrateMotion();
        }
        assert_int_equal(pli_world_solve(m_world), PLI_OK);
        return contacts;
    }

    void collide() {
        for (const auto& soft : m_soft) {
            for (const auto& rigid : m_rigids) {
                for (std::size_t i = 0; i < rigid->shapes.size(); ++i) {
                    // The wrapper keeps a reference to the transform.
                    const btTransform transform = rigid->world_transform(static_cast<int>(i));
                    const btCollisionObjectWrapper wrapper(nullptr, rigid->shapes[i], rigid->bullet.get(), transform,
                                                           -1, -1);
                    soft->bullet->defaultCollisionHandler(&wrapper);
                }
                assert_int_equal(pli_world_collide_rigid(m_world, soft->pliant, rigid->pliant), PLI_OK);
            }
        }
        for (std::size_t i = 0; i < m_soft.size(); ++i) {
            for (std::size_t k = i + 1; k < m_soft.size(); ++k) {
                m_soft[i]->bullet->defaultCollisionHandler(m_soft[k]->bullet.get());
                assert_int_equal(pli_world_collide_bodies(m_world, m_soft[i]->pliant, m_soft[k]->pliant), PLI_OK);
            }
        }
    }

    const soft_twin* find(const pli_body* body) const {
        for (const auto& soft : m_soft) {
            if (soft->pliant == body) { return soft.get(); }
        }
        return nullptr;
    }
    const rigid_twin* find(const pli_rigid* rigid) const {
        for (const auto& twin : m_rigids) {
            if (twin->pliant == rigid) { return twin.get(); }
        }
        return nullptr;
    }

    static bool measure(const pli_body* body, pli_cluster_contact* contact, void* user) {
        const auto* self = static_cast<const cluster_scene*>(user);
        const btSoftBody::Cluster* cluster = self->find(body)->bullet->m_clusters[contact->cluster];
        const btSoftClusterCollisionShape shape(cluster);
        btGjkEpaSolver2::sResults results;
        bool found;
        if (contact->rigid != nullptr) {
            const rigid_twin* rigid = self->find(contact->rigid);
            found = btGjkEpaSolver2::SignedDistance(
                &shape, btTransform::getIdentity(), rigid->shapes[static_cast<std::size_t>(contact->shape)],
                rigid->world_transform(contact->shape), btVector3(1, 0, 0), results);
        } else {
            const btSoftBody::Cluster* other = self->find(contact->other)->bullet->m_clusters[contact->other_cluster];
            const btSoftClusterCollisionShape other_shape(other);
            found = btGjkEpaSolver2::SignedDistance(&shape, btTransform::getIdentity(), &other_shape,
                                                    btTransform::getIdentity(), cluster->m_com - other->m_com, results);
        }
        contact->witness = to_pliant(results.witnesses[0]);
        contact->other_witness = to_pliant(results.witnesses[1]);
        contact->normal = to_pliant(results.normal);
        contact->distance = static_cast<float>(results.distance);
        return found;
    }

    // The same contacts on both sides; ours come into the order of m_joints. Returns their number.
    int order_contacts(const soft_twin& soft) const {
        const int count = pli_body_get_cluster_contacts(soft.pliant, 0, nullptr);
        std::vector<pli_cluster_contact> ours(static_cast<std::size_t>(count));
        pli_body_get_cluster_contacts(soft.pliant, count, ours.data());
        std::vector<int> order;
        for (int i = 0; i < soft.bullet->m_joints.size(); ++i) {
            if (soft.bullet->m_joints[i]->Type() != btSoftBody::Joint::eType::Contact) { continue; }
            const auto& theirs = *static_cast<const btSoftBody::CJoint*>(soft.bullet->m_joints[i]);
            for (int k = 0; k < count; ++k) {
                if (is_same(ours[static_cast<std::size_t>(k)], theirs, soft)) { order.push_back(k); }
            }
        }
        assert_int_equal(order.size(), count);
        if (count > 0) {
            assert_int_equal(pli_body_reorder_cluster_contacts(soft.pliant, order.data(), count), PLI_OK);
        }
        return count;
    }

    bool is_same(const pli_cluster_contact& ours, const btSoftBody::CJoint& theirs, const soft_twin& soft) const {
        const btSoftBody::Cluster* cluster = theirs.m_bodies[0].m_soft;
        if (ours.cluster != soft.cluster_index(cluster)) { return false; }
        if (ours.rigid != nullptr) {
            if (find(ours.rigid)->bullet.get() != theirs.m_bodies[1].m_collisionObject) { return false; }
        } else {
            const soft_twin* other = find(ours.other);
            if (other->bullet->m_clusters[ours.other_cluster] != theirs.m_bodies[1].m_soft) { return false; }
        }
        const btVector3 arm = to_bullet(ours.witness) - cluster->m_framexform.getOrigin();
        return (arm - theirs.m_rpos[0]).length2() == 0;
    }

    void check_step(int step) const {
        for (std::size_t i = 0; i < m_soft.size(); ++i) {
            const difference apart = compare(*m_soft[i]->bullet, m_soft[i]->pliant);
            if (!apart.is_exact()) {
                fail_msg("step %d, body %d: node %d apart by %g m and %g m/s", step, static_cast<int>(i), apart.node,
                         apart.position, apart.velocity);
            }
        }
        for (const auto& rigid : m_rigids) {
            const pli_rigid_state state = pli_rigid_get_state(rigid->pliant);
            detail::check_same(state.linear_velocity, rigid->bullet->getLinearVelocity(), "velocity of a rigid body");
            detail::check_same(state.angular_velocity, rigid->bullet->getAngularVelocity(), "spin of a rigid body");
        }
    }

    btSoftBodyWorldInfo m_info;
    pli_context* m_context = nullptr;
    pli_world* m_world = nullptr;
    std::vector<std::unique_ptr<soft_twin>> m_soft;
    std::vector<std::unique_ptr<rigid_twin>> m_rigids;
};

} // namespace twin
