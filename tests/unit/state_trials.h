#ifndef TESTS_UNIT_STATE_TRIALS_H
#define TESTS_UNIT_STATE_TRIALS_H

/* Worlds with everything that bodies can have, to be saved and gone on with. */

#include "check.h"
#include "hash_mix.h"
#include "solver_choice.h"

#include <pliant/pliant.h>

#include <stdlib.h>
#include <string.h>

#ifndef TRIAL_GRID
#define TRIAL_GRID (PLIANT_CHECKED ? 11 : 15) /* nodes of a side of a sheet; fewer where sanitizers make steps long */
#endif
#ifndef TRIAL_BALL
#define TRIAL_BALL 60 /* nodes of a ball */
#endif

enum { MOST_BODIES = 6, MOST_RIGIDS = 4, BEFORE = 40, AFTER = 40, GRID = TRIAL_GRID };

typedef enum trial_kind {
    TRIAL_CLOTH,      /* what holds and moves cloth */
    TRIAL_SELF_NODES, /* crumples */
    TRIAL_SELF_FACES,
    TRIAL_SELF_GRIDS,
    TRIAL_SOFT, /* sheets on a ball */
    TRIAL_BALLS,
    TRIAL_CLUSTERS,
    TRIAL_KINDS
} trial_kind;

typedef struct trial {
    pli_context* context;
    pli_world* world;
    pli_threads* threads;
    int body_count, rigid_count;
    pli_body* bodies[MOST_BODIES];
    pli_rigid* rigids[MOST_RIGIDS];
    pli_drag_id drag;
    int step;
} trial;

static inline pli_rigid* add_rigid(trial* t, pli_rigid_kind kind, pli_vec3 origin, pli_shape* shape) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.state.pose.origin = origin;
    def.state.inverse_mass = 0.5f;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] = pli_vec3_scale(pli_mat3_identity().rows[i], 2.0f);
    }
    def.shape_count = 1;
    def.shapes = &shape;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(t->world, &def, &rigid), PLI_OK);
    pli_shape_release(shape);
    return t->rigids[t->rigid_count++] = rigid;
}

static inline pli_body* add_body(trial* t, pli_mesh* mesh, float mass, solver_choice solver) {
    assert_int_equal(pli_mesh_set_total_mass(mesh, mass), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = 0.01f;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(t->world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    use_solver(body, solver);
    if (solver == XPBD) {
        pli_xpbd_links_def links = pli_xpbd_links_def_default();
        links.compliance = 1e-3f;
        links.damping = 0.1f;
        assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
    }
    return t->bodies[t->body_count++] = body;
}

static inline pli_body* add_sheet(trial* t, pli_vec3 center, float size, solver_choice solver) {
    pli_patch_def def = pli_patch_def_default();
    const float h = 0.5f * size;
    def.corner_00 = pli_vec3_add(center, pli_vec3_make(-h, 0, -h));
    def.corner_10 = pli_vec3_add(center, pli_vec3_make(h, 0, -h));
    def.corner_01 = pli_vec3_add(center, pli_vec3_make(-h, 0, h));
    def.corner_11 = pli_vec3_add(center, pli_vec3_make(h, 0, h));
    def.columns = def.rows = GRID;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(t->context, &def, &mesh), PLI_OK);
    return add_body(t, mesh, 0.5f, solver);
}

static inline pli_body* add_ball(trial* t, pli_vec3 center, solver_choice solver) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_ellipsoid(t->context, center, pli_vec3_make(0.5f, 0.5f, 0.5f), TRIAL_BALL, &mesh),
                     PLI_OK);
    return add_body(t, mesh, 1, solver);
}

static inline void dress_cloth(trial* t, pli_body* body) {
    pli_aero_def aero = pli_aero_def_default();
    aero.lift = 0.02f;
    aero.drag = 0.03f;
    aero.wind = pli_vec3_make(2, 0.5f, 1);
    assert_int_equal(pli_body_enable_aero(body, &aero), PLI_OK);
    assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
    assert_int_equal(pli_body_enable_rigid_face_contacts(body, NULL), PLI_OK);
    pli_tethers_def tethers = pli_tethers_def_default();
    tethers.slack = 0.02f;
    assert_int_equal(pli_body_enable_tethers(body, &tethers), PLI_OK);
    assert_int_equal(pli_body_enable_contact_events(body, NULL), PLI_OK);
    assert_int_equal(pli_body_enable_normals(body), PLI_OK);
    assert_int_equal(pli_body_enable_step_smoothing(body), PLI_OK);
    assert_int_equal(pli_body_enable_topology_changes(body), PLI_OK);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.rigid = t->rigids[1];
    assert_int_equal(pli_body_add_anchor(body, &anchor, NULL), PLI_OK);
    anchor.rigid = t->rigids[2];
    anchor.node = GRID - 1;
    assert_int_equal(pli_body_add_anchor(body, &anchor, NULL), PLI_OK);
    pli_drag_def drag = pli_drag_def_default();
    drag.node = GRID * GRID / 2;
    assert_int_equal(pli_body_begin_drag(body, &drag, &t->drag), PLI_OK);
}

static inline void start(trial* t, trial_kind kind, solver_choice solver, int threads) {
    *t = (trial){0};
    pli_context_def def = pli_context_def_default();
    if (threads > 1) {
        assert_int_equal(pli_threads_create(threads, &t->threads), PLI_OK);
        def.parallel_for = pli_threads_parallel_for;
        def.parallel_user = t->threads;
    }
    assert_int_equal(pli_context_create(&def, &t->context), PLI_OK);
    assert_int_equal(pli_world_create(t->context, NULL, &t->world), PLI_OK);
    pli_shape *plane = NULL, *box = NULL, *sphere = NULL;
    assert_int_equal(pli_shape_create_plane(t->context, pli_vec3_make(0, 1, 0), 0, &plane), PLI_OK);
    assert_int_equal(pli_shape_create_box(t->context, pli_vec3_make(0.3f, 0.2f, 0.3f), &box), PLI_OK);
    assert_int_equal(pli_shape_create_sphere(t->context, 0.4f, &sphere), PLI_OK);
    add_rigid(t, PLI_RIGID_STATIC, pli_vec3_make(0, 0, 0), plane);
    add_rigid(t, PLI_RIGID_DYNAMIC, pli_vec3_make(-1, 1.3f, -1), box);
    add_rigid(t, PLI_RIGID_KINEMATIC, pli_vec3_make(0.3f, 0.4f, 0.2f), sphere);
    if (kind == TRIAL_CLOTH) { dress_cloth(t, add_sheet(t, pli_vec3_make(0, 1, 0), 2, solver)); }
    if (kind >= TRIAL_SELF_NODES && kind <= TRIAL_SELF_GRIDS) {
        pli_body* body = add_sheet(t, pli_vec3_make(0, 1, 0), 1.2f, solver);
        const pli_transform turn = {pli_mat3_from_euler_zyx(1.5f, 0.1f, 0.2f), pli_vec3_make(0, 0.1f, 0)};
        assert_int_equal(pli_body_transform(body, turn), PLI_OK);
        assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
        pli_self_collision_def nodes = pli_self_collision_def_default();
        pli_self_faces_def faces = pli_self_faces_def_default();
        pli_self_grids_def grids = pli_self_grids_def_default();
        nodes.thickness = 0.05f;
        faces.thickness = 0.02f;
        grids.distance = 0.05f;
        assert_int_equal(kind == TRIAL_SELF_NODES   ? pli_body_enable_self_collision(body, &nodes)
                         : kind == TRIAL_SELF_FACES ? pli_body_enable_self_faces(body, &faces)
                                                    : pli_body_enable_self_grids(body, &grids),
                         PLI_OK);
    }
    for (int i = 0; kind == TRIAL_SOFT && i < 3; ++i) {
        pli_body* body = add_sheet(t, pli_vec3_make(0.1f * (float)i, 1.0f + 0.1f * (float)i, 0), 1.5f, solver);
        assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_soft_contacts(body, NULL), PLI_OK);
    }
    for (int i = 0; kind == TRIAL_BALLS && i < 3; ++i) {
        pli_body* body = add_ball(t, pli_vec3_make(0.2f * (float)i, 0.6f + (float)i, 0), solver);
        assert_int_equal(pli_body_enable_rigid_contacts(body, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_soft_contacts(body, NULL), PLI_OK);
        if (i == 0) { assert_int_equal(pli_body_enable_pressure(body, 5), PLI_OK); }
        if (i == 1) { assert_int_equal(pli_body_enable_volume_conservation(body, 5), PLI_OK); }
        if (i == 2 && solver <= COLORS) { assert_int_equal(pli_body_enable_pose_matching(body, 0.1f), PLI_OK); }
        if (solver == XPBD && i == 2) {
            assert_int_equal(pli_body_enable_xpbd_bending(body, NULL), PLI_OK);
            assert_int_equal(pli_body_enable_xpbd_volume(body, NULL), PLI_OK);
        }
    }
    for (int i = 0; kind == TRIAL_CLUSTERS && i < 4; ++i) {
        pli_body* body = add_ball(t, pli_vec3_make(0.1f * (float)i, 0.6f + 1.02f * (float)i, 0), solver);
        assert_int_equal(pli_body_generate_clusters(body, i == 3 ? 1 : 4, 100, NULL), PLI_OK);
        assert_int_equal(pli_body_enable_cluster_contacts(body, NULL), PLI_OK);
        if (i != 1) { continue; }
        pli_linear_joint_def joint = pli_linear_joint_def_default();
        joint.other.body = t->bodies[0];
        joint.position = pli_vec3_make(0, 1.1f, 0);
        assert_int_equal(pli_body_add_linear_joint(body, &joint, NULL), PLI_OK);
    }
}

static inline void end(trial* t) {
    pli_world_destroy(t->world);
    assert_int_equal(pli_context_allocated_bytes(t->context), 0);
    assert_int_equal(pli_context_destroy(t->context), PLI_OK);
    pli_threads_destroy(t->threads);
}

/* Motions that depend on the number of the step alone. */
static inline void step(trial* t) {
    const float dt = 1.0f / 60.0f;
    const float time = dt * (float)t->step++;
    pli_rigid_state state = pli_rigid_get_state(t->rigids[2]);
    const pli_vec3 at = pli_vec3_make(0.3f + 0.3f * time, 0.4f, 0.2f);
    state.linear_velocity = pli_vec3_scale(pli_vec3_sub(at, state.pose.origin), 1.0f / dt);
    state.pose.origin = at;
    assert_int_equal(pli_rigid_set_state(t->rigids[2], &state), PLI_OK);
    if (t->drag.index1 != 0) {
        const pli_vec3 goal = pli_vec3_make(0.2f * time, 1.0f + 0.3f * time, 0.1f);
        assert_int_equal(pli_body_move_drag(t->bodies[0], t->drag, goal), PLI_OK);
    }
    assert_int_equal(pli_world_step(t->world, t->step % 7 == 0 ? 0.75f * dt : dt), PLI_OK);
    assert_int_equal(pli_rigid_integrate(t->rigids[1], pli_world_get_gravity(t->world), dt), PLI_OK);
}

static inline uint64_t hash_of(const trial* t) {
    uint64_t hash = HASH_START;
    for (int i = 0; i < t->body_count; ++i) {
        const uint64_t state = pli_body_state_hash(t->bodies[i]);
        hash = hash_mix(hash, &state, sizeof state);
        for (int phase = PLI_CONTACT_BEGIN; phase <= PLI_CONTACT_END; ++phase) {
            int count = 0;
            const pli_contact_event* events =
                pli_body_get_contact_events(t->bodies[i], (pli_contact_phase)phase, &count);
            hash = hash_mix(hash, &count, sizeof count);
            for (int k = 0; k < count; ++k) {
                hash = hash_mix(hash, &events[k].impulse, sizeof events[k].impulse);
            }
        }
    }
    for (int i = 0; i < t->rigid_count; ++i) {
        const pli_rigid_state state = pli_rigid_get_state(t->rigids[i]);
        hash = hash_mix(hash, &state, sizeof state);
    }
    return hash;
}

static inline bool has_trial(trial_kind kind, solver_choice solver) {
    return kind != TRIAL_CLUSTERS || solver <= COLORS;
}

#endif
