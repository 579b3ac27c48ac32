// Refining and cutting against btSoftBody: nodes, links, faces, their order, masses and velocities bit for bit, and the
// steps after it.

#include "bullet_twin.hpp"
#include "check.h"

#include <pliant/pliant.h>

namespace {

constexpr float time_step = 1.0f / 60.0f;
constexpr float accuracy = 1e-4f;

struct sphere {
    pli_vec3 centre;
    float radius;
};

// Bullet's order of operations.
float sphere_value(pli_vec3 point, void* user) {
    const sphere* s = static_cast<const sphere*>(user);
    const pli_vec3 d = pli_vec3_sub(point, s->centre);
    return d.x * d.x + d.y * d.y + d.z * d.z - s->radius * s->radius;
}

struct bullet_surface : btSoftBody::ImplicitFn {
    float (*surface)(pli_vec3, void*);
    void* user;
    bullet_surface(float (*the_surface)(pli_vec3, void*), void* the_user) : surface(the_surface), user(the_user) {}
    btScalar Eval(const btVector3& x) override { return twin::to_bullet(surface(twin::to_pliant(x), user)); }
};

struct pair {
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_body* body = nullptr;
    btSoftBodyWorldInfo info = twin::world_info();
    std::unique_ptr<btSoftBody> soft;

    // Takes the mesh, which `context` made.
    explicit pair(pli_context* the_context, pli_mesh* mesh) : context(the_context) {
        pli_world_def world_def = pli_world_def_default();
        world_def.reference_mode = true; // cuts leave links that are too short for btSoftBody to solve
        assert_int_equal(pli_world_create(context, &world_def, &world), PLI_OK);
        pli_body_def def = pli_body_def_default();
        def.solver.position_iterations = 1; // as in Bullet
        assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
        soft = twin::make_soft_body(info, mesh);
        pli_mesh_destroy(mesh);
    }
    pair(const pair&) = delete;
    pair& operator=(const pair&) = delete;
    ~pair() {
        soft.reset();
        pli_world_destroy(world);
        assert_int_equal(pli_context_allocated_bytes(context), 0);
        pli_context_destroy(context);
    }

    void step(int count) {
        for (int i = 0; i < count; ++i) {
            twin::step(*soft, time_step);
            assert_int_equal(pli_world_step(world, time_step), PLI_OK);
        }
    }
    void refine(float (*surface)(pli_vec3, void*), void* user, bool cut) {
        pli_refine_def def = pli_refine_def_default();
        def.surface = surface;
        def.user = user;
        def.accuracy = accuracy;
        def.cut = cut;
        def.reset_rest_lengths = true;
        assert_int_equal(pli_body_refine(body, &def), PLI_OK);
        bullet_surface bullet(surface, user);
        soft->refine(&bullet, twin::to_bullet(accuracy), cut);
    }
    int bullet_node(const btSoftBody::Node* node) const { return static_cast<int>(node - &soft->m_nodes[0]); }

    void check_topology() const {
        const pli_body_view view = pli_body_get_view(body);
        assert_int_equal(view.node_count, soft->m_nodes.size());
        assert_int_equal(view.link_count, soft->m_links.size());
        assert_int_equal(view.face_count, soft->m_faces.size());
        for (int i = 0; i < view.link_count; ++i) {
            const int* nodes = view.link_nodes + i * view.link_node_stride;
            assert_int_equal(nodes[0], bullet_node(soft->m_links[i].m_n[0]));
            assert_int_equal(nodes[1], bullet_node(soft->m_links[i].m_n[1]));
        }
        for (int i = 0; i < 3 * view.face_count; ++i) {
            assert_int_equal(view.face_nodes[i], bullet_node(soft->m_faces[i / 3].m_n[i % 3]));
        }
    }
    void check_exact() const {
        check_topology();
        assert_true(twin::compare(*soft, body).is_exact());
        const pli_body_view view = pli_body_get_view(body);
        for (int i = 0; i < view.node_count; ++i) {
            assert_true(view.positions[i].w == static_cast<float>(soft->m_nodes[i].m_im));
        }
    }
};

pli_mesh* make_cloth(pli_context* context) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = {6, 2, -6};
    patch.corner_10 = {-6, 2, -6};
    patch.corner_01 = {6, 2, 6};
    patch.corner_11 = {-6, 2, 6};
    patch.columns = patch.rows = 16;
    patch.pins = PLI_PATCH_PIN_CORNERS;
    patch.diagonals = true;
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_patch(context, &patch, &mesh), PLI_OK);
    return mesh;
}

void add_bending_links(pli_mesh* mesh) {
    int material = 0, added = 0;
    const pli_material soft{0.3f};
    assert_int_equal(pli_mesh_append_material(mesh, &soft, &material), PLI_OK);
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, material, &added), PLI_OK);
    assert_true(added > 0);
    assert_int_equal(pli_mesh_shuffle_links(mesh), PLI_OK);
}

pli_context* make_context() {
    pli_context* context = nullptr;
    assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
    return context;
}

pli_vec3 node_position(const pair& p, int node) {
    return twin::xyz(pli_body_get_view(p.body).positions[node]);
}

void cut_three_times(pair& p, bool cut) {
    p.soft->m_cfg.piterations = 1;
    // The spheres of a click in the scene; the second and third meet parts that the one before has made.
    const int around[3] = {16 * 7 + 8, 16 * 9 + 9, 16 * 3 + 4};
    const pli_vec3 beside[3] = {{0.1f, 0.0f, 0.2f}, {-0.3f, 0.05f, 0.1f}, {0, 0, 0}};
    for (int i = 0; i < 3; ++i) {
        p.step(20);
        sphere s{pli_vec3_add(node_position(p, around[i]), beside[i]), 1.0f};
        const int nodes_before = pli_body_get_view(p.body).node_count;
        p.refine(sphere_value, &s, cut);
        assert_true(pli_body_get_view(p.body).node_count > nodes_before + 10);
        p.check_exact();
        p.step(1);
        p.check_exact();
    }
    p.step(60);
    p.check_exact();
}

void test_cutting_scene_is_exact_after_each_cut(void**) {
    pli_context* context = make_context();
    pair p(context, make_cloth(context));
    cut_three_times(p, true);
}

void test_refining_without_cut_is_exact(void**) {
    pli_context* context = make_context();
    pair p(context, make_cloth(context));
    cut_three_times(p, false);
}

void test_cutting_with_bending_links_is_exact(void**) {
    pli_context* context = make_context();
    pli_mesh* mesh = make_cloth(context);
    add_bending_links(mesh);
    pair p(context, mesh);
    cut_three_times(p, true);
}

// Faces on the surface, whole edges on it, links that Bullet removes as loose.
float plane_value(pli_vec3 point, void* user) {
    return point.x - *static_cast<const float*>(user);
}

void test_cut_through_nodes_is_exact(void**) {
    pli_context* context = make_context();
    pli_mesh* mesh = make_cloth(context);
    add_bending_links(mesh);
    pair p(context, mesh);
    float x = node_position(p, 5).x;
    p.refine(plane_value, &x, true);
    p.check_exact();
    p.step(30);
    p.check_exact();
    x = 6.0f; // the edge of the cloth, which touches the surface
    p.refine(plane_value, &x, true);
    p.check_exact();
}

void test_cut_of_a_rope_is_exact(void**) {
    pli_context* context = make_context();
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_rope(context, {0, 0, 0}, {4, 0, 0}, 14, PLI_ROPE_PIN_FIRST, &mesh), PLI_OK);
    pair p(context, mesh);
    p.step(5);
    float x = 2.1f;
    p.refine(plane_value, &x, true);
    p.check_exact();
}

void test_cut_of_a_closed_surface_is_exact(void**) {
    pli_context* context = make_context();
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_ellipsoid(context, {0, 0, 0}, {1, 2, 1.5f}, 100, &mesh), PLI_OK);
    pair p(context, mesh);
    p.step(3);
    float x = 0.3f;
    p.refine(plane_value, &x, true);
    p.check_exact();
    x = -0.4f;
    p.refine(plane_value, &x, true);
    p.check_exact();
    p.step(30);
    p.check_exact();
}

// Masses differ: Bullet's new nodes weigh 1 kg each.
void test_cut_links_have_the_same_topology(void**) {
    pli_context* context = make_context();
    pli_mesh* mesh = make_cloth(context);
    add_bending_links(mesh);
    pair p(context, mesh);
    p.step(10);
    // Both directions of a link, at the border, a diagonal, next to a cut, a bending link.
    const int links[6][2] = {{100, 101}, {85, 69}, {3, 4}, {17, 34}, {101, 102}, {200, 202}};
    for (const auto& link : links) {
        const bool is_cut = p.soft->cutLink(link[0], link[1], 0.3f);
        assert_int_equal(pli_body_cut_link(p.body, link[0], link[1], 0.3f), is_cut ? PLI_OK : PLI_ERROR_INVALID_VALUE);
        p.check_topology();
        assert_true(twin::compare(*p.soft, p.body).is_exact());
    }
    assert_true(pli_body_get_view(p.body).node_count >= 256 + 2 * 5);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_cutting_scene_is_exact_after_each_cut),
        cmocka_unit_test(test_refining_without_cut_is_exact),
        cmocka_unit_test(test_cutting_with_bending_links_is_exact),
        cmocka_unit_test(test_cut_through_nodes_is_exact),
        cmocka_unit_test(test_cut_of_a_rope_is_exact),
        cmocka_unit_test(test_cut_of_a_closed_surface_is_exact),
        cmocka_unit_test(test_cut_links_have_the_same_topology),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
