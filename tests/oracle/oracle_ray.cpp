// Ray casts against btSoftBody::rayTest: the same hits at the same fraction, bit for bit.

#include "bullet_twin.hpp"
#include "check.h"

#include <pliant/pliant.h>

namespace {

struct fixture {
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_body* body = nullptr;
    btSoftBodyWorldInfo info = twin::world_info();
    std::unique_ptr<btSoftBody> soft;

    fixture() {
        assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
        pli_world_def def = pli_world_def_default();
        def.reference_mode = true; // tolerances of rays
        assert_int_equal(pli_world_create(context, &def, &world), PLI_OK);
    }
    fixture(const fixture&) = delete;
    fixture& operator=(const fixture&) = delete;
    ~fixture() {
        soft.reset();
        pli_world_destroy(world);
        pli_context_destroy(context);
    }
    void take(pli_mesh* mesh) {
        assert_int_equal(pli_body_create(world, mesh, nullptr, &body), PLI_OK);
        soft = twin::make_soft_body(info, mesh);
        pli_mesh_destroy(mesh);
    }
};

// Bullet finds faces through a tree, so of faces at the same fraction (along edges) it may name another.
int check_rays(fixture& f, int count, float size) {
    twin::random_source random(4711);
    int hits = 0;
    for (int i = 0; i < count; ++i) {
        pli_ray_def def = pli_ray_def_default();
        def.from = random.vector(size);
        def.to = random.vector(size);
        pli_ray_hit hit;
        assert_int_equal(pli_body_cast_ray(f.body, &def, &hit), PLI_OK);
        btSoftBody::sRayCast result;
        const bool is_hit = f.soft->rayTest(twin::to_bullet(def.from), twin::to_bullet(def.to), result);
        assert_int_equal(is_hit, hit.kind != PLI_FEATURE_NONE);
        if (!is_hit) { continue; }
        ++hits;
        assert_true(static_cast<float>(result.fraction) == hit.fraction);
        assert_int_equal(result.feature == btSoftBody::eFeature::Tetra, hit.kind == PLI_FEATURE_TETRA);
        const pli_vec3 direction = pli_vec3_sub(def.to, def.from);
        assert_true(pli_vec3_dot(hit.normal, direction) < 0.0f);
        check_near(pli_vec3_length(hit.normal), 1.0, 1e-6);
    }
    return hits;
}

void test_faces_of_a_closed_surface(void**) {
    fixture f;
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_ellipsoid(f.context, {0.1f, 0.2f, -0.1f}, {1, 2, 1.5f}, 300, &mesh), PLI_OK);
    f.take(mesh);
    assert_true(check_rays(f, 20000, 3.0f) > 4000);
}

void test_faces_of_a_moving_cloth(void**) {
    fixture f;
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = {-2, 0, -2};
    patch.corner_10 = {2, 0, -2};
    patch.corner_01 = {-2, 0, 2};
    patch.corner_11 = {2, 0, 2};
    patch.columns = patch.rows = 20;
    patch.pins = PLI_PATCH_PIN_CORNERS;
    patch.diagonals = true;
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_patch(f.context, &patch, &mesh), PLI_OK);
    f.take(mesh);
    for (int i = 0; i < 40; ++i) {
        twin::step(*f.soft, 1.0f / 60.0f);
    }
    assert_int_equal(twin::copy_state(*f.soft, f.body), PLI_OK);
    assert_true(check_rays(f, 20000, 3.0f) > 2000);
}

void test_tetrahedra(void**) {
    fixture f;
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create(f.context, &mesh), PLI_OK);
    twin::random_source random(5);
    for (int i = 0; i < 200; ++i) {
        const pli_vec3 centre = random.vector(1.5f);
        int nodes[4];
        for (int& node : nodes) {
            assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_add(centre, random.vector(0.5f)), 1.0f, &node),
                             PLI_OK);
        }
        assert_int_equal(pli_mesh_append_tetra(mesh, nodes[0], nodes[1], nodes[2], nodes[3], 0, nullptr), PLI_OK);
    }
    f.take(mesh);
    assert_true(check_rays(f, 5000, 3.0f) > 1000);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_faces_of_a_closed_surface),
        cmocka_unit_test(test_faces_of_a_moving_cloth),
        cmocka_unit_test(test_tetrahedra),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
