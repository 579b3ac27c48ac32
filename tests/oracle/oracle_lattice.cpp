// The distance lattice against btSparseSdf<3>, bit for bit, with samples from Bullet's own GJK and EPA.

#include "check.h"

#include "oracle/bullet_shape.hpp"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletSoftBody/btSparseSDF.h>

namespace {

void check_lattice(const btConvexShape& shape, float size) {
    pli_context* context = nullptr;
    assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
    pli_shape* lattice = twin::make_lattice(context, shape);
    assert_non_null(lattice);
    btSparseSdf<3> sdf;
    sdf.Initialize();
    twin::random_source random(5);
    int below = 0;
    for (int i = 0; i < 20000; ++i) {
        const pli_vec3 p = random.vector(size);
        const btScalar margin = btScalar(0.25);
        btVector3 normal;
        const float expected = static_cast<float>(sdf.Evaluate(twin::to_bullet(p), &shape, normal, margin));
        pli_vec3 n;
        const float distance = pli_shape_distance(lattice, p, &n) - 0.25f;
        check_near(distance, expected, 0);
        check_near(twin::distance(n, twin::to_pliant(normal)), 0, 0);
        below += distance < 0;
    }
    assert_true(below > 1000 && below < 19000);
    pli_shape_release(lattice);
    check_near(pli_context_allocated_bytes(context), 0, 0);
    pli_context_destroy(context);
}

void test_lattice_of_a_sphere(void**) {
    check_lattice(btSphereShape(1), 2);
}
void test_lattice_of_a_box(void**) {
    check_lattice(btBoxShape(btVector3(1, btScalar(0.3), btScalar(0.7))), 2);
}
void test_lattice_of_a_capsule(void**) {
    check_lattice(btCapsuleShape(btScalar(0.5), btScalar(1.2)), 2);
}
void test_lattice_of_a_cylinder(void**) {
    check_lattice(btCylinderShape(btVector3(btScalar(0.6), 1, btScalar(0.6))), 2);
}
void test_lattice_of_a_hull(void**) {
    btConvexHullShape hull;
    twin::random_source random(9);
    for (int i = 0; i < 20; ++i) {
        hull.addPoint(twin::to_bullet(random.vector(1)), i == 19);
    }
    check_lattice(hull, 2);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_lattice_of_a_sphere),  cmocka_unit_test(test_lattice_of_a_box),
        cmocka_unit_test(test_lattice_of_a_capsule), cmocka_unit_test(test_lattice_of_a_cylinder),
        cmocka_unit_test(test_lattice_of_a_hull),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
