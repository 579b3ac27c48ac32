/* Contacts of nodes with faces of other soft bodies: all pairs found, balance of momentum, small faces, nodes on faces,
   life of contacts, errors. */

#include "check.h"
#include "level_sheet.h"
#include "sample_mesh.h"
#include "world_fixture.h"

#include "pliant/bullet_reference.h"
#include "pliant/contact.h"
#include "pliant/generate.h"
#include "pliant/implicit.h"
#include "pliant/limits.h"
#include "pliant/world.h"
#include "pliant/xpbd.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const float dt = 1.0f / 60.0f;

static int setup(void** state) {
    if (setup_fixture(state) != 0) { return -1; }
    const fixture* f = *state;
    return pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)) == PLI_OK ? 0 : -1;
}

static pli_body* make_body(const fixture* f, pli_mesh* mesh, float margin, bool bullet_boxes) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(f->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    contacts.bullet_boxes = bullet_boxes;
    assert_int_equal(pli_body_enable_soft_contacts(body, &contacts), PLI_OK);
    return body;
}

/* One triangle of the given size in the plane y = 0, facing up, and one loose node. */
static pli_body* make_triangle(const fixture* f, float size, float mass, float margin, bool bullet_boxes) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    const pli_vec3 points[3] = {{0, 0, size}, {size, 0, -size}, {-size, 0, -size}};
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, points[i], mass, NULL), PLI_OK);
    }
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 2, 0, NULL), PLI_OK);
    return make_body(f, mesh, margin, bullet_boxes);
}

static pli_body* make_node(const fixture* f, pli_vec3 position, float mass, float margin, bool bullet_boxes) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_append_node(mesh, position, mass, NULL), PLI_OK);
    return make_body(f, mesh, margin, bullet_boxes);
}

static pli_body* make_ball(const fixture* f, pli_vec3 radii, pli_vec3 centre, float margin) {
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_ellipsoid(f->context, radii, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_translate(mesh, centre), PLI_OK);
    return make_body(f, mesh, margin, false);
}

static pli_vec3 xyz(pli_vec4 v) {
    return pli_vec3_make(v.x, v.y, v.z);
}

/* Distance of a point to a triangle by dense sampling of its nearest points along each edge and inside. */
static double brute_distance(pli_vec3 p, pli_vec3 a, pli_vec3 b, pli_vec3 c) {
    const pli_vec3 ab = pli_vec3_sub(b, a), ac = pli_vec3_sub(c, a), ap = pli_vec3_sub(p, a);
    const double aa = (double)pli_vec3_dot(ab, ab), bb = (double)pli_vec3_dot(ac, ac), m = (double)pli_vec3_dot(ab, ac);
    const double u0 = (double)pli_vec3_dot(ab, ap), v0 = (double)pli_vec3_dot(ac, ap);
    const double det = aa * bb - m * m, u = (bb * u0 - m * v0) / det, v = (aa * v0 - m * u0) / det;
    if (u >= 0 && v >= 0 && u + v <= 1) {
        const pli_vec3 n = pli_vec3_cross(ab, ac);
        return fabs((double)pli_vec3_dot(ap, n)) / (double)pli_vec3_length(n);
    }
    const pli_vec3 corners[4] = {a, b, c, a};
    double best = 1e30;
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 e = pli_vec3_sub(corners[i + 1], corners[i]), w = pli_vec3_sub(p, corners[i]);
        const float t = fminf(1, fmaxf(0, pli_vec3_dot(e, w) / pli_vec3_dot(e, e)));
        best = fmin(best, (double)pli_vec3_length(pli_vec3_sub(w, pli_vec3_scale(e, t))));
    }
    return best;
}

enum { MOST_PER_NODE = 3, MOST_NODES = 1024 };

/* Where nodes were predicted, and how far from there they ended. */
typedef struct prediction {
    pli_vec3 predicted[MOST_NODES];
    double missed[MOST_NODES];
} prediction;

static void note_predicted(prediction* p, const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    assert_true(view.node_count <= MOST_NODES);
    for (int i = 0; i < view.node_count; ++i) {
        p->predicted[i] = xyz(view.positions[i]);
    }
}

static void note_missed(prediction* p, const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        p->missed[i] = (double)pli_vec3_length(pli_vec3_sub(xyz(view.positions[i]), p->predicted[i]));
    }
}

/* Checks the contacts of the nodes of one body with the faces of another against all pairs: nodes with a face in reach
   have one to three; the first one is the nearest face, unless it holds the node on the side that it came from. Returns
   how many there are, and adds those that hold. */
static int check_all_pairs(const pli_body* nodes, const prediction* before, const pli_body* faces, float margins,
                           double usual_slack, int* holding) {
    const pli_body_view a = pli_body_get_view(nodes), b = pli_body_get_view(faces);
    const int count = pli_body_get_soft_contacts(nodes, 0, NULL);
    pli_soft_contact* contacts = calloc((size_t)count + 1, sizeof *contacts);
    assert_non_null(contacts);
    pli_body_get_soft_contacts(nodes, count, contacts);
    pli_vec3 common = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < b.node_count; ++i) {
        const pli_vec3 motion = pli_vec3_sub(xyz(b.positions[i]), xyz(b.previous[i]));
        common = pli_vec3_add(common, pli_vec3_scale(motion, 1.0f / (float)b.node_count));
    }
    int next = 0;
    for (int i = 0; i < a.node_count; ++i) {
        const int first = next;
        for (; next < count && contacts[next].node == i; ++next) {}
        const pli_vec3 p = xyz(a.positions[i]);
        const pli_vec3 motion = pli_vec3_sub(pli_vec3_sub(p, xyz(a.previous[i])), common);
        const double held = (double)margins + 2 * (double)pli_vec3_length(motion);
        const double slack = usual_slack + 2 * before->missed[i];
        const double reach = held + fmin(slack, 4 * (double)margins);
        double nearest = 1e30;
        for (int k = 0; k < b.face_count; ++k) {
            const int* face = &b.face_nodes[3 * k];
            nearest = fmin(nearest, brute_distance(p, xyz(b.positions[face[0]]), xyz(b.positions[face[1]]),
                                                   xyz(b.positions[face[2]])));
        }
        if (nearest < reach - 1e-5) { assert_true(next > first); }
        if (nearest > reach + 1e-5) { assert_true(next == first); }
        assert_true(next - first <= MOST_PER_NODE);
        for (int c = first; c < next; ++c) {
            const pli_soft_contact* contact = &contacts[c];
            const int* face = &b.face_nodes[3 * contact->face];
            const float* w = contact->weights;
            pli_vec3 point = pli_vec3_make(0, 0, 0), point_before = point;
            for (int k = 0; k < 3; ++k) {
                point = pli_vec3_add(point, pli_vec3_scale(xyz(b.positions[face[k]]), w[k]));
                point_before = pli_vec3_add(point_before, pli_vec3_scale(xyz(b.previous[face[k]]), w[k]));
            }
            const pli_vec3 offset = pli_vec3_sub(p, point);
            const bool holds = pli_vec3_dot(offset, contact->normal) < 0;
            *holding += holds;
            check_near(w[0] + w[1] + w[2], 1, 1e-5);
            check_near(pli_vec3_length(contact->normal), 1, 1e-5);
            assert_true((double)contact->margin <= held + 1e-6);
            if ((double)contact->margin <
                (double)margins - 1e-6) { /* balls that start overlapped move apart as a whole */
                check_near(contact->margin,
                           pli_vec3_dot(pli_vec3_sub(xyz(a.previous[i]), point_before), contact->normal), 1e-5);
            }
            assert_ptr_equal(contact->face_body, faces);
            if (holds) { continue; }
            check_near(pli_vec3_dot(offset, contact->normal), pli_vec3_length(offset), 2e-5);
            if (c == first) { check_near(pli_vec3_length(offset), nearest, 2e-5); }
        }
    }
    assert_int_equal(next, count);
    free(contacts);
    return count;
}

/* What is not told by velocities moves nodes by as much as falls in some steps: slack is that, in limits of margins. */
static void check_all_pairs_of_balls(const fixture* f, float gravity, double usual_slack) {
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, -gravity, 0)), PLI_OK);
    pli_body* a = make_ball(f, pli_vec3_make(1, 0.7f, 0.9f), pli_vec3_make(0, 0, 0), 0.05f);
    pli_body* b = make_ball(f, pli_vec3_make(0.5f, 1.2f, 0.6f), pli_vec3_make(1.2f, 0.3f, 0.1f), 0.08f);
    pli_body_add_velocity(a, pli_vec3_make(5, 1, 0));
    pli_body_add_velocity(b, pli_vec3_make(-9, 0, 2));
    int contacts = 0, holding = 0;
    static prediction of_a, of_b;
    memset(&of_a, 0, sizeof of_a);
    memset(&of_b, 0, sizeof of_b);
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
        note_predicted(&of_a, a);
        note_predicted(&of_b, b);
        assert_int_equal(pli_world_collide_bodies(f->world, a, b), PLI_OK);
        contacts += check_all_pairs(a, &of_a, b, 0.13f, usual_slack, &holding);
        contacts += check_all_pairs(b, &of_b, a, 0.13f, usual_slack, &holding);
        assert_int_equal(pli_world_solve(f->world), PLI_OK);
        note_missed(&of_a, a);
        note_missed(&of_b, b);
    }
    print_message("gravity %g m/s^2: %d contacts, %d hold\n", (double)gravity, contacts, holding);
    assert_true(contacts > 500);
    assert_true(holding > 5);
    pli_body_destroy(a);
    pli_body_destroy(b);
}

static void test_soft_contacts_finds_all_pairs(void** state) {
    check_all_pairs_of_balls(*state, 0, 0.1 * 0.13);
    check_all_pairs_of_balls(*state, 20, 4 * 20.0 / 3600);
    check_all_pairs_of_balls(*state, 40, 0.25 * 0.13);
}

static void test_soft_contacts_keep_momentum(void** state) {
    fixture* f = *state;
    pli_body* node = make_node(f, pli_vec3_make(0.2f, 0.15f, -0.1f), 1, 0.1f, false);
    pli_body* triangle = make_triangle(f, 1, 2, 0.1f, false);
    assert_int_equal(pli_body_add_velocity(node, pli_vec3_make(2, -3, 1)), PLI_OK);
    const pli_vec3 before = pli_vec3_add(pli_body_momentum(node), pli_body_momentum(triangle));
    int contacts = 0;
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        contacts += pli_body_get_soft_contacts(node, 0, NULL);
        const pli_vec3 now = pli_vec3_add(pli_body_momentum(node), pli_body_momentum(triangle));
        check_at_most(pli_vec3_length(pli_vec3_sub(now, before)), 4e-5); /* of 3.7 */
    }
    assert_true(contacts > 0);
    assert_true(pli_body_momentum(triangle).y < -1);
    assert_true(pli_body_momentum(triangle).x > 0.1f);
}

static void test_soft_contacts_node_on_a_face_gets_a_normal(void** state) {
    fixture* f = *state;
    for (int variant = 0; variant < 4; ++variant) {
        const bool bullet_boxes = variant % 2 == 0;
        const float side = variant < 2 ? 1.0f : -1.0f;
        pli_body* triangle = make_triangle(f, 1, 1, 0.1f, bullet_boxes);
        pli_body* node = make_node(f, pli_vec3_make(0, 0.5f * side, 0), 1, 0.1f, bullet_boxes);
        /* It arrives exactly at y = 0. */
        assert_int_equal(pli_body_set_node_velocity(node, 0, pli_vec3_make(0, -0.5f * side / dt, 0)), PLI_OK);
        assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
        check_near(pli_body_get_view(node).positions[0].y, 0, 0);
        assert_int_equal(pli_world_collide_bodies(f->world, triangle, node), PLI_OK);
        pli_soft_contact contact;
        assert_int_equal(pli_body_get_soft_contacts(node, 1, &contact), 1);
        check_near(contact.normal.x, 0, 0);
        check_near(contact.normal.y, side, 0);
        assert_int_equal(pli_world_solve(f->world), PLI_OK);
        const float height = pli_body_get_view(node).positions[0].y - pli_body_get_view(triangle).positions[0].y;
        print_message("height %g\n", (double)height);
        assert_true(height * side > 0.1f);
        assert_false(pli_body_is_frozen(node));
        pli_body_destroy(node);
        pli_body_destroy(triangle);
    }
}

static void test_soft_contacts_small_faces_count(void** state) {
    fixture* f = *state;
    const float size = 2e-3f; /* squared doubled area 6e-11, far below Bullet's 1.2e-7 */
    for (int bullet_boxes = 0; bullet_boxes < 2; ++bullet_boxes) {
        pli_body* triangle = make_triangle(f, size, 1, size, bullet_boxes != 0);
        pli_body* node = make_node(f, pli_vec3_make(0, 0.5f * size, 0), 1, size, bullet_boxes != 0);
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        assert_int_equal(pli_body_get_soft_contacts(node, 0, NULL), bullet_boxes != 0 ? 0 : 1);
        pli_body_destroy(node);
        pli_body_destroy(triangle);
    }
    /* A face without an area is no face. */
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(f->context, &mesh), PLI_OK);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make((float)i, 0, 0), 1, NULL), PLI_OK);
    }
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 2, 0, NULL), PLI_OK);
    make_body(f, mesh, 0.1f, false);
    pli_body* node = make_node(f, pli_vec3_make(1, 0.05f, 0), 1, 0.1f, false);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_soft_contacts(node, 0, NULL), 0);
}

static void test_soft_contacts_share_by_mass(void** state) {
    fixture* f = *state;
    pli_body* triangle = make_triangle(f, 1, 2, 0.1f, false);
    pli_body* node = make_node(f, pli_vec3_make(0, 0.1f, -1.0f / 3), 1, 0.1f, false);
    assert_int_equal(pli_body_set_node_velocity(node, 0, pli_vec3_make(0, -1, 0)), PLI_OK);
    const float y = 0.1f - dt; /* it goes by dt; half of the margins overlap from before, and go at 1 m/s */
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    /* At the centroid the face has the mass of its nodes, 6 kg. */
    const pli_body_view n = pli_body_get_view(node), t = pli_body_get_view(triangle);
    check_near(n.positions[0].y, y + 2 * dt * (6.0f / 7), 1e-6);
    for (int i = 0; i < 3; ++i) {
        check_near(t.positions[i].y, -2 * dt * (1.0f / 7), 1e-6);
    }
}

/* 5 cm of overlap with nothing that moves. It goes by a share of dt / (dt + 1 / 15 s) in a step or substep, at most at
   the recovery speed, by both in inverse ratio of their masses, and leaves no speed. */
static void check_recovery(const fixture* f, int solver, float recovery_speed, double parted) {
    pli_body* bodies[2] = {make_triangle(f, 1, 2, 0.1f, false),
                           make_node(f, pli_vec3_make(0, 0.15f, -1.0f / 3), 1, 0.1f, false)};
    pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    contacts.recovery_speed = recovery_speed;
    for (int k = 0; k < 2; ++k) {
        assert_int_equal(pli_body_enable_soft_contacts(bodies[k], &contacts), PLI_OK);
        if (solver == 1) { assert_int_equal(pli_body_enable_implicit(bodies[k], NULL), PLI_OK); }
        if (solver == 2) { assert_int_equal(pli_body_enable_xpbd(bodies[k], NULL), PLI_OK); }
    }
    const pli_body_view triangle = pli_body_get_view(bodies[0]), node = pli_body_get_view(bodies[1]);
    for (int step = 0; step < 120; ++step) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        check_at_most(fabs((double)node.velocities[0].y), 1e-4);
        check_at_most(fabs((double)triangle.velocities[0].y), 1e-4);
        if (step > 0) { continue; }
        check_near(node.positions[0].y, 0.15f + (float)parted * 6 / 7, 2e-6);
        check_near(triangle.positions[0].y, -(float)parted / 7, 2e-6);
    }
    check_near(node.positions[0].y - triangle.positions[0].y, 0.2f, 1e-4);
    pli_body_destroy(bodies[0]);
    pli_body_destroy(bodies[1]);
}

static void test_soft_contacts_take_overlaps_back_without_speed(void** state) {
    for (int solver = 0; solver < 3; ++solver) {
        const double share = solver == 2 ? 1 - pow(1 - 1.0 / 41, 10) : 0.2;
        check_recovery(*state, solver, 0, 0.05 * share);
        check_recovery(*state, solver, 0.1f, 0.1 / 60);
    }
}

/* A pinned corner stays, the others yield. */
static void test_soft_contacts_with_a_pinned_corner(void** state) {
    fixture* f = *state;
    pli_body* triangle = make_triangle(f, 1, 2, 0.1f, false);
    assert_int_equal(pli_body_set_node_mass(triangle, 2, 0), PLI_OK);
    pli_body* node = make_node(f, pli_vec3_make(0, 0.1f, -1.0f / 3), 1, 0.1f, false);
    assert_int_equal(pli_body_set_node_velocity(node, 0, pli_vec3_make(0, -1, 0)), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    check_near(pli_body_get_view(node).positions[0].y, 0.1f - dt + 2 * dt * 0.9f, 1e-6);
    for (int i = 0; i < 3; ++i) {
        check_near(pli_body_get_view(triangle).positions[i].y, i == 2 ? 0.0f : -2 * dt * 0.9f * (0.5f / 3), 1e-6);
    }
    /* Two that are both pinned have no contact. */
    assert_int_equal(pli_body_set_node_mass(node, 0, 0), PLI_OK);
    assert_int_equal(pli_body_set_node_mass(triangle, 0, 0), PLI_OK);
    assert_int_equal(pli_body_set_node_mass(triangle, 1, 0), PLI_OK);
    assert_int_equal(pli_body_set_node_position(node, 0, pli_vec3_make(0, 0.1f, 0)), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_soft_contacts(node, 0, NULL), 0);
}

/* A pinned node lies too deep in a face right beside its pinned edge: the third node, which bears next to nothing of
   the point that is touched, does not go far for that point to get away. */
static void test_a_node_that_bears_little_is_not_thrown_away(void** state) {
    fixture* f = *state;
    static const float shares[] = {1e-7f, 1e-5f, 1e-3f};
    for (int i = 0; i < 9; ++i) {
        pli_body* triangle = make_triangle(f, 1, 0.01f, 0.02f, false);
        assert_int_equal(pli_body_set_node_mass(triangle, 1, 0), PLI_OK);
        assert_int_equal(pli_body_set_node_mass(triangle, 2, 0), PLI_OK);
        const pli_vec3 place = pli_vec3_make(0.3f, -0.01f, -1 + 2 * shares[i % 3]);
        pli_body* node = make_node(f, place, 0, 0.02f, false);
        if (i / 3 == 1) { assert_int_equal(pli_body_enable_implicit(triangle, NULL), PLI_OK); }
        if (i / 3 == 2) { assert_int_equal(pli_body_enable_xpbd(triangle, NULL), PLI_OK); }
        double farthest = 0;
        for (int k = 0; k < 30; ++k) {
            assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
            const pli_vec3 apart = pli_vec3_sub(xyz(pli_body_get_view(triangle).positions[0]), pli_vec3_make(0, 0, 1));
            farthest = fmax(farthest, (double)pli_vec3_length(apart));
        }
        print_message("solver %d, share %g: %.3g m\n", i / 3, (double)shares[i % 3], farthest);
        check_at_most(farthest, 6 * (double)shares[i % 3]);
        pli_body_destroy(node);
        pli_body_destroy(triangle);
    }
}

/* Two sheets 38 mm apart, whose margins add up to 40 mm, fly together. Contacts in the first step. */
static int count_contacts_at(fixture* f, pli_vec3 velocity) {
    pli_body* sheets[2];
    for (int i = 0; i < 2; ++i) {
        pli_mesh* mesh = NULL;
        assert_int_equal(sample_create_sheet(f->context, 20, 0, 0, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_translate(mesh, pli_vec3_make(0, 0.038f * (float)i, 0)), PLI_OK);
        sheets[i] = make_body(f, mesh, 0.02f, false);
        assert_int_equal(pli_body_add_velocity(sheets[i], velocity), PLI_OK);
    }
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    const int count = pli_body_get_soft_contacts(sheets[0], 0, NULL) + pli_body_get_soft_contacts(sheets[1], 0, NULL);
    pli_body_destroy(sheets[0]);
    pli_body_destroy(sheets[1]);
    return count;
}

static void test_common_motion_makes_no_contacts(void** state) {
    fixture* f = *state;
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    const int at_rest = count_contacts_at(f, pli_vec3_make(0, 0, 0));
    assert_true(at_rest > 0);
    static const float speeds[] = {5, 10, 100, 300};
    for (int i = 0; i < 4; ++i) {
        check_near(count_contacts_at(f, pli_vec3_make(0, speeds[i], 0)), at_rest, 0.05 * at_rest);
        check_near(count_contacts_at(f, pli_vec3_make(speeds[i], 0, 0)), at_rest, 0.05 * at_rest);
    }
}

/* Six times the volume of a node and a face, m^3: above it when positive. */
static double volume_above(pli_vec3 p, const pli_vec3 face[3]) {
    const pli_vec3 cross = pli_vec3_cross(pli_vec3_sub(face[1], face[0]), pli_vec3_sub(face[2], face[0]));
    return (double)pli_vec3_dot(pli_vec3_sub(p, face[0]), cross);
}

/* Where a straight path meets a face whose corners go straight, by small strides: well inside, or not at all. */
static bool meets_inside(pli_vec3 p, pli_vec3 motion, const pli_vec3 face[3], const pli_vec3 motions[3]) {
    enum { STRIDES = 1000 };
    for (int i = 1; i <= STRIDES; ++i) {
        const float t = (float)i / STRIDES;
        pli_vec3 at[3];
        for (int k = 0; k < 3; ++k) {
            at[k] = pli_vec3_add(face[k], pli_vec3_scale(motions[k], t));
        }
        const pli_vec3 node = pli_vec3_add(p, pli_vec3_scale(motion, t));
        if (volume_above(node, at) > 0) { continue; }
        const pli_vec3 normal = pli_vec3_cross(pli_vec3_sub(at[1], at[0]), pli_vec3_sub(at[2], at[0]));
        for (int k = 0; k < 3; ++k) {
            const pli_vec3 edge = pli_vec3_sub(at[(k + 1) % 3], at[k]), to = pli_vec3_sub(node, at[k]);
            const float share = pli_vec3_dot(pli_vec3_cross(edge, to), normal) / pli_vec3_length_squared(normal);
            if (share < 0.05f) { return false; }
        }
        return true;
    }
    return false;
}

/* A face of 8 cm whose corners go up and down by as much within a step, and a node that goes through it: by the heights
   at both ends alone, the time at which they meet is off by so much that 278 of 283 nodes passed. */
static void test_nodes_do_not_pass_faces_that_turn(void** state) {
    fixture* f = *state;
    uint32_t random = 1;
    int met = 0, passed = 0;
    for (int run = 0; run < 1000; ++run) {
        float r[6];
        for (int i = 0; i < 6; ++i) {
            random = random * 1664525u + 1013904223u;
            r[i] = (float)(random >> 8) / (float)(1 << 23) - 1.0f; /* -1 to 1 */
        }
        pli_body* triangle = make_triangle(f, 0.04f, 100, 0.01f, false);
        const pli_vec3 place = pli_vec3_make(0.04f * r[0], 0.03f, 0.04f * r[1]);
        pli_body* node = make_node(f, place, 0.001f, 0.01f, false);
        pli_vec3 corners[3], motions[3], velocities[3];
        for (int k = 0; k < 3; ++k) {
            corners[k] = xyz(pli_body_get_view(triangle).positions[k]);
            motions[k] = pli_vec3_make(0, 0.08f * r[2 + k], 0);
            velocities[k] = pli_vec3_scale(motions[k], 1.0f / dt);
        }
        const pli_vec3 motion = pli_vec3_make(0.02f * r[5], -0.06f, 0);
        assert_int_equal(pli_body_set_state(triangle, corners, velocities), PLI_OK);
        assert_int_equal(pli_body_add_velocity(node, pli_vec3_scale(motion, 1.0f / dt)), PLI_OK);
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        if (meets_inside(place, motion, corners, motions)) {
            ++met;
            for (int k = 0; k < 3; ++k) {
                corners[k] = xyz(pli_body_get_view(triangle).positions[k]);
            }
            passed += volume_above(xyz(pli_body_get_view(node).positions[0]), corners) <= 0;
        }
        pli_body_destroy(node);
        pli_body_destroy(triangle);
    }
    print_message("%d of %d nodes passed\n", passed, met);
    assert_true(met >= 100);
    check_at_most(passed, 0);
}

static void test_steps_with_soft_contacts_allocate_nothing(void** state) {
    fixture* f = *state;
    pli_mesh* mesh = NULL;
    assert_int_equal(sample_create_sheet(f->context, 12, 0, 15, &mesh), PLI_OK);
    make_body(f, mesh, 0.1f, true);
    pli_body* ball = make_ball(f, pli_vec3_make(0.5f, 0.5f, 0.5f), pli_vec3_make(0, 0.55f, 0), 0.1f);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    }
    assert_int_equal(pli_body_set_solver_settings(ball, &(pli_solver_settings){.position_iterations = 1,
                                                                               .velocity_damping = 1,
                                                                               .drift_correction = 1,
                                                                               .time_scale = 1}),
                     PLI_OK);
    const uint64_t allocations = pli_context_allocation_count(f->context);
    for (int i = 0; i < 8; ++i) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        assert_true(pli_body_get_soft_contacts(ball, 0, NULL) > 0);
    }
    check_near(pli_context_allocation_count(f->context), allocations, 0);
}

static void test_soft_contacts_go_with_the_other_body(void** state) {
    fixture* f = *state;
    pli_body* triangle = make_triangle(f, 1, 1, 0.1f, false);
    pli_body* node = make_node(f, pli_vec3_make(0, 0.05f, 0), 1, 0.1f, false);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_soft_contacts(node, 0, NULL), 1);
    pli_body_destroy(triangle);
    assert_int_equal(pli_body_get_soft_contacts(node, 0, NULL), 0);
    make_triangle(f, 1, 1, 0.1f, false);
    assert_int_equal(pli_body_disable_soft_contacts(node), PLI_OK);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    assert_int_equal(pli_body_get_soft_contacts(node, 0, NULL), 0);
}

static void check_refused(const fixture* f, pli_status got, pli_status expected, const char* message) {
    assert_int_equal(got, expected);
    if (strstr(pli_last_error(f->context), message) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", pli_last_error(f->context), message);
    }
}

static void test_soft_contacts_are_told_to_hosts(void** state) {
    const fixture* f = *state;
    assert_false(pli_body_collides_with_bodies(NULL));
    pli_body* node = make_node(f, pli_vec3_make(0, 0.1f, 0), 1, 0.1f, false);
    assert_true(pli_body_collides_with_bodies(node));
    assert_int_equal(pli_body_disable_soft_contacts(node), PLI_OK);
    const pli_rigid_contacts_def rigid_contacts = pli_rigid_contacts_def_default();
    assert_int_equal(pli_body_enable_rigid_contacts(node, &rigid_contacts), PLI_OK);
    assert_false(pli_body_collides_with_bodies(node));
}

static void test_soft_contacts_refuse_bad_input(void** state) {
    fixture* f = *state;
    pli_body* triangle = make_triangle(f, 1, 1, 0.1f, true);
    pli_body* node = make_node(f, pli_vec3_make(0, 0.05f, 0), 1, 0.1f, false);
    pli_soft_contacts_def def = pli_soft_contacts_def_default();
    assert_int_equal(pli_body_enable_soft_contacts(NULL, &def), PLI_ERROR_NULL_ARGUMENT);
    def.friction = -2;
    check_refused(f, pli_body_enable_soft_contacts(node, &def), PLI_ERROR_INVALID_VALUE, "friction is -2");
    def.friction = NAN;
    check_refused(f, pli_body_enable_soft_contacts(node, &def), PLI_ERROR_NOT_FINITE, "friction");
    def = pli_soft_contacts_def_default();
    def.hardness = 2;
    check_refused(f, pli_body_enable_soft_contacts(node, &def), PLI_ERROR_INVALID_VALUE, "hardness is 2");
    def.hardness = 1;
    def.recovery_speed = -1;
    check_refused(f, pli_body_enable_soft_contacts(node, &def), PLI_ERROR_INVALID_VALUE, "recovery_speed is -1");
    def.recovery_speed = NAN;
    check_refused(f, pli_body_enable_soft_contacts(node, &def), PLI_ERROR_NOT_FINITE, "recovery_speed");
    def.cookie = 7;
    check_refused(f, pli_body_enable_soft_contacts(node, &def), PLI_ERROR_INVALID_DEF, "default");
    assert_int_equal(pli_body_get_soft_contacts(NULL, 1, NULL), 0);
    assert_int_equal(pli_body_disable_soft_contacts(NULL), PLI_ERROR_NULL_ARGUMENT);

    pli_bounds nodes[3] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
    pli_bounds face = {{0, 0, 0}, {1, 1, 1}};
    check_refused(f, pli_body_set_bullet_boxes(node, nodes, &face), PLI_ERROR_WRONG_STATE, "bullet_boxes");
    check_refused(f, pli_body_set_bullet_boxes(triangle, NULL, &face), PLI_ERROR_NULL_ARGUMENT, "node_boxes");
    check_refused(f, pli_body_set_bullet_boxes(triangle, nodes, NULL), PLI_ERROR_NULL_ARGUMENT, "face_boxes");
    nodes[1].max.y = NAN;
    check_refused(f, pli_body_set_bullet_boxes(triangle, nodes, &face), PLI_ERROR_NOT_FINITE, "box of node 1");
    nodes[1].max.y = 1;
    assert_int_equal(pli_body_set_bullet_boxes(triangle, nodes, &face), PLI_OK);

    const int order[1] = {0}, out[1] = {1};
    check_refused(f, pli_body_reorder_soft_contacts(node, order, 1), PLI_ERROR_WRONG_STATE, "between");
    assert_int_equal(pli_world_predict(f->world, dt), PLI_OK);
    assert_int_equal(pli_world_collide_bodies(f->world, triangle, node), PLI_OK);
    check_refused(f, pli_body_reorder_soft_contacts(node, out, 1), PLI_ERROR_INDEX_OUT_OF_RANGE, "order[0] is 1");
    check_refused(f, pli_body_reorder_soft_contacts(node, NULL, 1), PLI_ERROR_NULL_ARGUMENT, "order");
    check_refused(f, pli_body_reorder_soft_contacts(node, order, 0), PLI_ERROR_INVALID_VALUE, "there are 1");
    assert_int_equal(pli_body_reorder_soft_contacts(node, order, 1), PLI_OK);
    assert_int_equal(pli_world_solve(f->world), PLI_OK);
    assert_int_equal(pli_body_disable_soft_contacts(node), PLI_OK);
    check_refused(f, pli_body_reorder_soft_contacts(node, order, 1), PLI_ERROR_WRONG_STATE, "not enabled");
}

/* A level sheet of 1 m, held at its corners, whose free nodes have 10 g each. */
static pli_body* make_sheet(const fixture* f, int columns) {
    pli_patch_def def = level_sheet(0.5f, 0, columns);
    def.pins = PLI_PATCH_PIN_CORNERS;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(f->context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.01f * (float)(columns * columns - 4)), PLI_OK);
    return make_body(f, mesh, 0.02f, false);
}

static double kinetic_energy(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    double energy = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec3 v = xyz(view.velocities[i]);
        if (view.positions[i].w > 0) { energy += 0.5 * (double)(pli_vec3_dot(v, v) / view.positions[i].w); }
    }
    return energy;
}

static void set_iterations(pli_body* const bodies[2], int count) {
    for (int k = 0; k < 2; ++k) {
        pli_solver_settings settings = pli_body_get_solver_settings(bodies[k]);
        settings.position_iterations = count;
        assert_int_equal(pli_body_set_solver_settings(bodies[k], &settings), PLI_OK);
    }
}

/* J, down from y = 0. */
static double work_of_gravity(const pli_body* body, float gravity) {
    const pli_body_view view = pli_body_get_view(body);
    double work = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i];
        if (x.w > 0) { work -= (double)(gravity * x.y / x.w); }
    }
    return work;
}

/* Sheets whose nodes lie on the faces of each other. In 10 s they never have more than gravity gave, and `slack`. */
static void check_same_place(const fixture* f, pli_body* const sheets[2], float gravity, double slack) {
    for (int step = 0; step < 600; ++step) {
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        const double given = work_of_gravity(sheets[0], gravity) + work_of_gravity(sheets[1], gravity);
        check_at_most(kinetic_energy(sheets[0]) + kinetic_energy(sheets[1]), given + slack);
    }
}

static void test_soft_contacts_in_the_same_place(void** state) {
    const fixture* f = *state;
    pli_body* const sheets[2] = {make_sheet(f, 6), make_sheet(f, 7)};
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, -10, 0)), PLI_OK);
    set_iterations(sheets, 10);
    pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    contacts.friction = 0.5f;
    contacts.recovery_speed = 1;
    for (int k = 0; k < 2; ++k) {
        assert_int_equal(pli_body_enable_soft_contacts(sheets[k], &contacts), PLI_OK);
    }
    check_same_place(f, sheets, 10, 0);
}

/* They part, one to each side, and no node is pushed along them. */
static void check_same_place_with_springs(const fixture* f, pli_implicit_method method, int sweeps) {
    pli_body* const sheets[2] = {make_sheet(f, 6), make_sheet(f, 7)};
    pli_implicit_def def = pli_implicit_def_default();
    def.method = method;
    def.sweeps = sweeps;
    for (int k = 0; k < 2; ++k) {
        assert_int_equal(pli_body_enable_implicit(sheets[k], &def), PLI_OK);
    }
    set_iterations(sheets, 10);
    assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
    const pli_body_view a = pli_body_get_view(sheets[0]), b = pli_body_get_view(sheets[1]);
    assert_true(fabsf(a.positions[7].y) > 0.005f);
    assert_true(fabsf(b.positions[8].y) > 0.005f);
    assert_true(a.positions[7].y * b.positions[8].y < 0);
    for (int i = 0; i < a.node_count; ++i) {
        assert_true(hypotf(a.velocities[i].x, a.velocities[i].z) < 1e-3f);
    }
    check_same_place(f, sheets, 0, 0.1);
}

static void test_soft_contacts_in_the_same_place_with_sweeps(void** state) {
    check_same_place_with_springs(*state, PLI_IMPLICIT_JACOBI, 5);
}
static void test_soft_contacts_in_the_same_place_with_gradients(void** state) {
    check_same_place_with_springs(*state, PLI_IMPLICIT_CONJUGATE_GRADIENT, 200);
}

/* An impact changes the velocities of both bodies, whichever is solved first. */
static void test_soft_contacts_with_springs_keep_momentum(void** state) {
    const fixture* f = *state;
    for (int order = 0; order < 2; ++order) {
        pli_body* bodies[2];
        for (int k = 0; k < 2; ++k) {
            const float margin = 0.05f;
            bodies[k] = k == order ? make_triangle(f, 0.5f, 2, margin, false)
                                   : make_node(f, pli_vec3_make(0, 0.11f, 0), 1, margin, false);
            const pli_implicit_def def = pli_implicit_def_default();
            assert_int_equal(pli_body_enable_implicit(bodies[k], &def), PLI_OK);
        }
        pli_body *triangle = bodies[order], *node = bodies[1 - order];
        assert_int_equal(pli_body_set_node_velocity(node, 0, pli_vec3_make(0, -3, 0)), PLI_OK);
        for (int step = 0; step < 10; ++step) {
            assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        }
        double momentum = (double)pli_body_get_view(node).velocities[0].y;
        for (int i = 0; i < 3; ++i) {
            momentum += 2 * (double)pli_body_get_view(triangle).velocities[i].y;
        }
        check_near(momentum, -3.0, 1e-5);
        check_near((double)pli_body_get_view(node).velocities[0].y, -3.0 / 7.0, 0.1);
        pli_body_destroy(triangle);
        pli_body_destroy(node);
    }
}

/* Numbers that took the search over the end of its lists are refused; the largest that are not lead nowhere either.
   The numbers of faces are not multiples of four. */
static void test_soft_contacts_at_the_limits(void** state) {
    const fixture* f = *state;
    for (int k = 0; k < 6; ++k) {
        pli_body *low = make_sheet(f, 4 + k % 2), *high = make_sheet(f, 3 + k);
        assert_int_equal(pli_body_set_node_velocity(low, 3, pli_vec3_make(3e21f, 0, 0)), PLI_ERROR_INVALID_VALUE);
        assert_int_equal(pli_body_set_collision_margin(low, 1e20f), PLI_ERROR_INVALID_VALUE);
        assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, 1e38f, 0)), PLI_ERROR_INVALID_VALUE);
        if (k % 3 == 1) {
            const pli_xpbd_def def = pli_xpbd_def_default();
            assert_int_equal(pli_body_enable_xpbd(low, &def), PLI_OK);
        } else if (k % 3 == 2) {
            const pli_implicit_def def = pli_implicit_def_default();
            assert_int_equal(pli_body_enable_implicit(high, &def), PLI_OK);
        }
        assert_int_equal(pli_body_set_collision_margin(low, k < 3 ? PLI_MAX_COORDINATE : 0.1f), PLI_OK);
        /* Nearly out of the world in one step. */
        assert_int_equal(pli_body_set_node_velocity(high, 3, pli_vec3_make(5e7f, -5e7f, 1e7f)), PLI_OK);
        for (int i = 0; i < 3; ++i) {
            assert_int_equal(pli_world_step(f->world, 1.0f / 60.0f), PLI_OK);
            for (int b = 0; b < 2; ++b) {
                const pli_body_view view = pli_body_get_view(b == 0 ? low : high);
                for (int n = 0; n < view.node_count; ++n) {
                    assert_true(isfinite(pli_vec3_length(xyz(view.positions[n]))));
                    assert_true(isfinite(pli_vec3_length(xyz(view.velocities[n]))));
                }
            }
        }
        pli_body_destroy(low);
        pli_body_destroy(high);
    }
}

/* A sheet falls onto another one whose time goes slower or faster, and comes to lie there: what they push is told in
   the time of each. */
static void test_soft_contacts_of_different_time_scales(void** state) {
    const fixture* f = *state;
    const float scales[][2] = {{0.1f, 1}, {0.5f, 1}, {1, 0.5f}, {3, 1}};
    assert_int_equal(pli_world_set_gravity(f->world, pli_vec3_make(0, -10, 0)), PLI_OK);
    for (int k = 0; k < 8; ++k) {
        pli_body* bodies[2];
        for (int i = 0; i < 2; ++i) {
            const float half = i == 0 ? 0.5f : 0.3f, height = 0.2f * (float)i;
            pli_patch_def sheet = level_sheet(half, height, i == 0 ? 11 : 9);
            sheet.pins = i == 0 ? PLI_PATCH_PIN_CORNERS : 0;
            pli_mesh* mesh = NULL;
            assert_int_equal(pli_mesh_create_patch(f->context, &sheet, &mesh), PLI_OK);
            bodies[i] = make_body(f, mesh, 0.03f, false);
            if (k % 2 == 1) {
                assert_int_equal(pli_body_enable_xpbd(bodies[i], NULL), PLI_OK);
                assert_int_equal(pli_body_enable_xpbd_links(bodies[i], NULL), PLI_OK);
            }
            pli_solver_settings settings = pli_body_get_solver_settings(bodies[i]);
            settings.position_iterations = 8;
            settings.time_scale = scales[k / 2][i];
            assert_int_equal(pli_body_set_solver_settings(bodies[i], &settings), PLI_OK);
        }
        double fastest = 0;
        for (int i = 0; i < 240; ++i) {
            assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
            const pli_body_view view = pli_body_get_view(bodies[1]);
            for (int n = 0; n < view.node_count; ++n) {
                fastest = fmax(fastest, (double)pli_vec3_length(xyz(view.velocities[n])));
            }
        }
        /* 2 m/s are those of the fall. */
        check_at_most(fastest, 4);
        const float below = pli_body_get_view(bodies[0]).positions[60].y; /* the middles */
        check_near(pli_body_get_view(bodies[1]).positions[40].y - below, 0.06, 0.02);
        pli_body_destroy(bodies[0]);
        pli_body_destroy(bodies[1]);
    }
}

/* Four nodes fall on four faces, two of which have a corner in common, in any place of the second: one pushes after the
   other there, and neither face is driven away from its node. */
static void test_soft_contacts_of_faces_with_a_common_corner(void** state) {
    fixture* f = *state;
    for (int slot = 0; slot < 3; ++slot) {
        pli_mesh *faces = NULL, *nodes = NULL;
        assert_int_equal(pli_mesh_create(f->context, &faces), PLI_OK);
        assert_int_equal(pli_mesh_create(f->context, &nodes), PLI_OK);
        const float at[4] = {0, 0, 10, 20};
        int corners[4][3];
        for (int k = 0; k < 4; ++k) {
            const float side = k == 1 ? -1.0f : 1.0f;
            const pli_vec3 points[3] = {{at[k], 0, 0}, {at[k] + side, 0, side}, {at[k] + side, 0, -side}};
            for (int i = 0; i < 3; ++i) {
                corners[k][i] = corners[0][0];
                if (k == 1 && i == 0) { continue; }
                assert_int_equal(pli_mesh_append_node(faces, points[i], 0.1f, &corners[k][i]), PLI_OK);
            }
            const int* c = corners[k];
            const int first = k == 1 ? (3 - slot) % 3 : 0;
            assert_int_equal(pli_mesh_append_face(faces, c[first], c[(first + 1) % 3], c[(first + 2) % 3], 0, NULL),
                             PLI_OK);
            const pli_vec3 above = pli_vec3_make(at[k] + 0.2f * side, 0.101f, 0);
            assert_int_equal(pli_mesh_append_node(nodes, above, 1, NULL), PLI_OK);
        }
        pli_body *sheet = make_body(f, faces, 0.05f, false), *loose = make_body(f, nodes, 0.05f, false);
        assert_int_equal(pli_body_add_velocity(loose, pli_vec3_make(0, -1, 0)), PLI_OK);
        assert_int_equal(pli_world_step(f->world, dt), PLI_OK);
        assert_int_equal(pli_body_get_soft_contacts(loose, 0, NULL), 4);
        const pli_body_view view = pli_body_get_view(sheet);
        for (int k = 0; k < 4; ++k) {
            const int* c = corners[k];
            const float face =
                0.8f * view.velocities[c[0]].y + 0.1f * (view.velocities[c[1]].y + view.velocities[c[2]].y);
            check_at_most(-face, 1.005); /* all at once: 1.71 */
            if (k > 0) { check_near(face, pli_body_get_view(loose).velocities[k].y, 1e-5); }
        }
        pli_body_destroy(sheet);
        pli_body_destroy(loose);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_soft_contacts_finds_all_pairs, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_keep_momentum, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_of_different_time_scales, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_at_the_limits, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_node_on_a_face_gets_a_normal, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_small_faces_count, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_share_by_mass, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_of_faces_with_a_common_corner, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_take_overlaps_back_without_speed, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_with_a_pinned_corner, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_a_node_that_bears_little_is_not_thrown_away, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_common_motion_makes_no_contacts, setup_fixture, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_nodes_do_not_pass_faces_that_turn, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_steps_with_soft_contacts_allocate_nothing, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_go_with_the_other_body, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_in_the_same_place, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_in_the_same_place_with_sweeps, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_in_the_same_place_with_gradients, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_with_springs_keep_momentum, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_are_told_to_hosts, setup, teardown_fixture),
        cmocka_unit_test_setup_teardown(test_soft_contacts_refuse_bad_input, setup, teardown_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
