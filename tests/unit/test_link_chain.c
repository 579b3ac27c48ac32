/* Links of a chain, even and odd ones in turn: every length against a loop in double precision, with and without
   something to do between sweeps; all iterations at once have the bits of one sweep after the other; what is no chain.
 */

#include "link_chain.h" /* before names of its parameters are variables */

#include "check.h"
#include "failing_allocator.h"
#include "test_world.h"

#include <stdlib.h>

static const float dt = 1.0f / 60.0f;

/* Node 0 is pinned, the others have different masses; behind the chain there is one more node. */
static pli_mesh* make_chain(int link_count, bool is_reversed) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    for (int i = 0; i <= link_count + 1; ++i) {
        const float side = 0.02f * (float)(i * 7 % 5), mass = i == 0 ? 0.0f : 0.1f + 0.05f * (float)(i * 3 % 4);
        assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(0.1f * (float)i, side, -side), mass, NULL), PLI_OK);
    }
    for (int i = 0; i < link_count; ++i) {
        const bool turns = is_reversed && i % 2 == 1;
        assert_int_equal(pli_mesh_append_link(mesh, turns ? i + 1 : i, turns ? i : i + 1, 0, NULL), PLI_OK);
    }
    return mesh;
}

static pli_body* make_body(pli_mesh* mesh, int iterations) {
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = iterations;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static pli_body* make_chain_body(int link_count, int iterations) {
    return make_body(make_chain(link_count, false), iterations);
}

static void set_random_positions(pli_body* body) {
    uint32_t seed = 1;
    for (int i = 0; i < body->node_count; ++i) {
        float shift[3];
        for (int k = 0; k < 3; ++k) {
            seed = seed * 1664525u + 1013904223u;
            shift[k] = 0.04f * ((float)(seed >> 8) / (float)(1 << 24) - 0.5f);
        }
        body->positions[i].x += shift[0];
        body->positions[i].y += shift[1];
        body->positions[i].z += shift[2];
    }
}

// ------------------------------------------------------------------------------------------------ against a loop

static const float pull[3] = {0.003f, -0.002f, 0.001f}; /* what `pull_last` does to the last node of the chain */

static void pull_last(pli_body* body) {
    pli_vec4* node = &body->positions[body->link_count];
    node->x += pull[0];
    node->y += pull[1];
    node->z += pull[2];
}

static void solve_in_doubles(const pli_body* body, double (*x)[3], int link) {
    const double mass_a = (double)body->positions[link].w, mass_b = (double)body->positions[link + 1].w;
    const double rest_squared = (double)body->links[link].rest_length_squared;
    double *a = x[link], *b = x[link + 1], length_squared = 0, delta[3];
    for (int k = 0; k < 3; ++k) {
        delta[k] = b[k] - a[k];
        length_squared += delta[k] * delta[k];
    }
    const double mass_term = (mass_a + mass_b) / (double)body->materials[0].linear_stiffness;
    const double factor = (rest_squared - length_squared) / (mass_term * (rest_squared + length_squared));
    for (int k = 0; k < 3; ++k) {
        a[k] -= delta[k] * factor * mass_a;
        b[k] += delta[k] * factor * mass_b;
    }
}

static void check_against_doubles(pli_body* body, int sweep_count, bool pulls) {
    const int node_count = body->node_count;
    double(*x)[3] = calloc((size_t)node_count, sizeof *x);
    pli_vec4* start = calloc((size_t)node_count, sizeof *start);
    assert_true(x != NULL && start != NULL);
    for (int i = 0; i < node_count; ++i) {
        start[i] = body->positions[i];
        x[i][0] = (double)start[i].x;
        x[i][1] = (double)start[i].y;
        x[i][2] = (double)start[i].z;
    }
    plii_link_chain chain;
    assert_true(plii_link_chain_make(body, &chain));
    assert_true(plii_link_chain_sweep(body, &chain, sweep_count, pulls ? pull_last : NULL));
    plii_link_chain_release(body, &chain);
    for (int sweep = 0; sweep < sweep_count; ++sweep) {
        for (int k = 0; k < 3 && pulls; ++k) {
            x[body->link_count][k] += (double)pull[k];
        }
        for (int color = 0; color < 2; ++color) {
            for (int link = color; link < body->link_count; link += 2) {
                solve_in_doubles(body, x, link);
            }
        }
    }
    for (int i = 0; i < node_count; ++i) {
        const float tolerance = 2e-6f * (1.0f + 0.1f * (float)i);
        check_near(body->positions[i].x, x[i][0], tolerance);
        check_near(body->positions[i].y, x[i][1], tolerance);
        check_near(body->positions[i].z, x[i][2], tolerance);
        assert_true(body->positions[i].w == start[i].w);
        if (i == 0 || i > body->link_count) { assert_memory_equal(&body->positions[i], &start[i], sizeof start[i]); }
    }
    free(x);
    free(start);
}

static void test_every_length_follows_the_loop(void** state) {
    (void)state;
    for (int link_count = 1; link_count <= PLII_LINK_CHAIN_MOST; ++link_count) {
        for (int sweeps = 1; sweeps <= 4; sweeps += 3) {
            for (int pulls = 0; pulls < 2; ++pulls) {
                pli_body* body = make_chain_body(link_count, 1);
                set_random_positions(body);
                check_against_doubles(body, sweeps, pulls == 1);
                pli_body_destroy(body);
            }
        }
    }
}

static void test_masses_rest_lengths_and_stiffness_count(void** state) {
    (void)state;
    pli_mesh* mesh = make_chain(20, true);
    pli_material material = pli_mesh_get_view(mesh).materials[0];
    material.linear_stiffness = 0.4f;
    assert_int_equal(pli_mesh_set_material(mesh, 0, &material), PLI_OK);
    pli_body* body = make_body(mesh, 1);
    set_random_positions(body);
    assert_int_equal(pli_body_set_rest_length(body, 6, 0.2f), PLI_OK);
    assert_int_equal(pli_body_set_node_mass(body, 9, 3.0f), PLI_OK);
    check_against_doubles(body, 5, false);
    pli_body_destroy(body);
}

// ------------------------------------------------------------------------------------------------------- in a world

enum { ROPE_LINKS = 17, ROPE_ITERATIONS = 6 };

static plii_link_chain single_chain;

static void sweep_once(pli_body* body, void* state) {
    (void)state;
    assert_true(plii_link_chain_sweep(body, &single_chain, 1, NULL));
}

static pli_rigid* make_box(float mass, pli_vec3 center) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.pose.origin = center;
    def.state.inverse_mass = 1.0f / mass;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], 100.0f / mass);
    }
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    return rigid;
}

static void add_anchor(pli_body* body, pli_rigid* rigid, int node) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = node;
    def.rigid = rigid;
    assert_int_equal(pli_body_add_anchor(body, &def, NULL), PLI_OK);
}

typedef struct anchored_run {
    int node; /* PLI_NULL_INDEX: nothing hangs on the chain; where that is not its last node, links go by colours */
    bool has_single_sweeps;
    bool changes; /* a mass and a rest length, on the way */
} anchored_run;

static uint64_t hash_of(anchored_run run) {
    pli_body* body = make_chain_body(ROPE_LINKS, ROPE_ITERATIONS);
    assert_int_equal(pli_body_use_colored_links(body, true), PLI_OK);
    assert_non_null(body->iterate_links);
    if (run.has_single_sweeps) {
        body->iterate_links = NULL;
        if (run.node == PLI_NULL_INDEX || run.node == ROPE_LINKS) { body->sweep_links = sweep_once; }
        assert_true(plii_link_chain_make(body, &single_chain));
    }
    pli_rigid* box = NULL;
    if (run.node != PLI_NULL_INDEX) {
        box = make_box(2.0f, plii_xyz(body->positions[run.node]));
        add_anchor(body, box, run.node);
    }
    for (int i = 0; i < 40; ++i) {
        if (run.changes && i == 20) {
            assert_int_equal(pli_body_set_node_mass(body, 4, 2.0f), PLI_OK);
            assert_int_equal(pli_body_set_rest_length(body, 5, 0.3f), PLI_OK);
        }
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    if (run.has_single_sweeps) { plii_link_chain_release(body, &single_chain); }
    uint64_t hash = pli_body_state_hash(body);
    if (box != NULL) {
        const pli_rigid_state box_state = pli_rigid_get_state(box);
        uint32_t bits[3];
        memcpy(bits, &box_state.linear_velocity, sizeof bits);
        hash = hash * 31 + bits[0] + 17 * (uint64_t)bits[1] + 257 * (uint64_t)bits[2];
    }
    pli_body_destroy(body);
    pli_rigid_destroy(box);
    return hash;
}

static void test_iterations_at_once_have_the_bits_of_single_sweeps(void** state) {
    (void)state;
    const anchored_run runs[] = {
        {.node = PLI_NULL_INDEX}, {.node = ROPE_LINKS}, {.node = 5}, {.node = ROPE_LINKS, .changes = true}};
    uint64_t hashes[4];
    for (int i = 0; i < 4; ++i) {
        anchored_run single = runs[i];
        single.has_single_sweeps = true;
        hashes[i] = hash_of(runs[i]);
        assert_true(hashes[i] == hash_of(single));
        for (int k = 0; k < i; ++k) {
            assert_true(hashes[i] != hashes[k]);
        }
    }
}

static void test_a_box_hangs_on_a_long_chain(void** state) {
    (void)state;
    pli_body* body = make_chain_body(24, 60);
    assert_int_equal(pli_body_use_colored_links(body, true), PLI_OK);
    pli_rigid* box = make_box(1.0f, plii_xyz(body->positions[24]));
    add_anchor(body, box, 24);
    for (int i = 0; i < 600; ++i) {
        pli_rigid_state box_state = pli_rigid_get_state(box);
        box_state.linear_velocity.y -= 10.0f * dt;
        box_state.linear_velocity = pli_vec3_scale(box_state.linear_velocity, 0.99f);
        box_state.pose.origin = pli_vec3_add(box_state.pose.origin, pli_vec3_scale(box_state.linear_velocity, dt));
        assert_int_equal(pli_rigid_set_state(box, &box_state), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    float length = 0.0f;
    for (int i = 0; i < body->link_count; ++i) {
        length += sqrtf(body->links[i].rest_length_squared);
    }
    check_near(pli_vec3_length(plii_xyz(body->positions[24])), length, 0.03f * length);
    check_near(body->positions[24].y, -length, 0.05f * length);
    pli_body_destroy(body);
    pli_rigid_destroy(box);
}

// ----------------------------------------------------------------------------------------------- what is no chain

static void test_other_links_are_no_chain(void** state) {
    (void)state;
    pli_body* body = make_chain_body(PLII_LINK_CHAIN_MOST, 1);
    assert_true(plii_link_chain_fits(body));
    pli_body_destroy(body);
    body = make_chain_body(PLII_LINK_CHAIN_MOST + 1, 1);
    assert_false(plii_link_chain_fits(body));
    pli_body_destroy(body);
    body = make_body(make_chain(12, true), 1);
    assert_true(plii_link_chain_fits(body));
    pli_body_destroy(body);
    body = make_body(make_chain(0, false), 1);
    assert_false(plii_link_chain_fits(body));
    pli_body_destroy(body);
    pli_mesh* mesh = make_chain(12, false);
    assert_int_equal(pli_mesh_append_link(mesh, 3, 7, 0, NULL), PLI_OK);
    body = make_body(mesh, 1);
    assert_false(plii_link_chain_fits(body));
    pli_body_destroy(body);
}

/* Solvers leave out a link between pinned nodes, so these go by colours. */
static void test_a_link_between_pinned_nodes_is_left_to_others(void** state) {
    (void)state;
    uint64_t hashes[2];
    for (int is_colored = 0; is_colored < 2; ++is_colored) {
        pli_body* body = make_chain_body(ROPE_LINKS, ROPE_ITERATIONS);
        assert_int_equal(pli_body_set_node_mass(body, 1, 0.0f), PLI_OK);
        assert_int_equal(pli_body_use_colored_links(body, true), PLI_OK);
        if (is_colored) { body->iterate_links = NULL; }
        for (int i = 0; i < 10; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        assert_false(pli_body_is_frozen(body));
        hashes[is_colored] = pli_body_state_hash(body);
        pli_body_destroy(body);
    }
    assert_true(hashes[0] == hashes[1]);
}

/* Ropes of fewer links have the bits of their own order. */
static void test_short_ropes_keep_their_order(void** state) {
    (void)state;
    for (int link_count = 1; link_count < 16; ++link_count) {
        uint64_t hashes[2];
        for (int is_colored = 0; is_colored < 2; ++is_colored) {
            pli_body* body = make_chain_body(link_count, ROPE_ITERATIONS);
            assert_int_equal(pli_body_use_colored_links(body, is_colored == 1), PLI_OK);
            for (int i = 0; i < 10; ++i) {
                assert_int_equal(pli_world_step(world, dt), PLI_OK);
            }
            hashes[is_colored] = pli_body_state_hash(body);
            pli_body_destroy(body);
        }
        assert_true(hashes[0] == hashes[1]);
    }
}

// ---------------------------------------------------------------------------------------------------------- memory

static void test_steps_allocate_nothing_and_bytes_are_given_back(void** state) {
    (void)state;
    pli_body* body = make_chain_body(ROPE_LINKS, ROPE_ITERATIONS);
    assert_int_equal(pli_body_use_colored_links(body, true), PLI_OK);
    const size_t bytes = pli_body_bytes(body);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const uint64_t calls = pli_context_allocation_count(context);
    for (int i = 0; i < 5; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_true(pli_context_allocation_count(context) == calls);
    assert_int_equal(pli_body_use_colored_links(body, false), PLI_OK);
    assert_true(pli_body_bytes(body) <= bytes - 3 * 2 * (ROPE_LINKS + 1) * sizeof(float));
    pli_body_destroy(body);
}

static pli_status make_colored_rope(pli_context* failing, void* user) {
    (void)user;
    pli_world* own_world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    pli_status status = pli_world_create(failing, NULL, &own_world);
    if (status == PLI_OK) {
        status = pli_mesh_create_rope(failing, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 20, PLI_ROPE_PIN_FIRST,
                                      &mesh);
    }
    if (status == PLI_OK) { status = pli_body_create(own_world, mesh, NULL, &body); }
    if (status == PLI_OK) { status = pli_body_use_colored_links(body, true); }
    pli_mesh_destroy(mesh);
    pli_world_destroy(own_world);
    return status;
}
static void test_failing_memory_leaves_nothing_behind(void** state) {
    (void)state;
    assert_true(check_survives_failing_allocator(make_colored_rope, NULL) > 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_every_length_follows_the_loop, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_masses_rest_lengths_and_stiffness_count, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_iterations_at_once_have_the_bits_of_single_sweeps, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_box_hangs_on_a_long_chain, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_other_links_are_no_chain, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_link_between_pinned_nodes_is_left_to_others, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_short_ropes_keep_their_order, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_steps_allocate_nothing_and_bytes_are_given_back, setup_world,
                                        teardown_world),
        cmocka_unit_test(test_failing_memory_leaves_nothing_behind),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
