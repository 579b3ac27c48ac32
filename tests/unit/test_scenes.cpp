// The scenes on both engines: sizes, finite runs, the user's meshes, wrong descriptions, momentum.

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "scene_records.h"

#include "measure/measure.h"

#include "check.h" // last: cmocka has macros named like functions of the standard library

using demos::EngineKind;

// ------------------------------------------------------------------------------------------------------- scenes

namespace {

struct Expectation {
    const char* name;
    int nodes, links, faces, clusters;
};

const Expectation expectations[] = {
    {"Cloth", 961, 9778, 1800, 0},
    {"Pressure", 515, 1539, 1026, 0},
    {"Volume", 515, 1539, 1026, 0},
    {"Ropes", 15 * 18, 15 * 17, 0, 0},
    {"RopeAttach", 20, 18, 0, 0},
    {"ClothAttach", 81, 208, 128, 0},
    {"Sticks", 256 * 6, 256 * 10, 0, 0},
    {"Bending", 4, 5, 0, 0},
    {"CapsuleCollision", 400, 1121, 722, 0},
    {"Collide", 3 * 300, 3 * 2700, 3 * 600, 0},
    {"Collide2", 3 * 453, 3 * 4319, 3 * 902, 0},
    {"Collide3", 225 + 49, 616 + 370, 392 + 72, 0},
    {"Impact", 2, 1, 0, 0},
    {"Aero", 50 * 36, 50 * 254, 50 * 50, 0},
    {"Aero2", 5 * 300, 5 * 2794, 5 * 522, 0},
    {"Friction", 20 * 8, 20 * 27, 20 * 12, 0},
    {"Torus", 300, 2700, 600, 0},
    {"TorusMatch", 300, 900, 600, 0},
    {"Bunny", 453, 4319, 902, 0},
    {"BunnyMatch", 453, 1353, 902, 0},
    {"Cutting1", 256, 705, 450, 0},
    {"ClusterDeform", 300, 2700, 600, 9},
    {"ClusterCollide1", 289, 2750, 512, 512},
    {"ClusterCollide2", 3 * 300, 3 * 2700, 3 * 600, 3 * 16},
    {"ClusterSocket", 300, 2700, 600, 26},
    {"ClusterHinge", 300, 2700, 600, 26},
    {"ClusterCombine", 2 * 300, 2 * 2700, 2 * 600, 2 * 30},
    {"ClusterCar", 453 + 4 * 300, 4319 + 4 * 2700, 902 + 4 * 600, 129},
    {"ClusterRobot", 3 * 515, 3 * 1539, 3 * 1026, 3},
    {"ClusterStackSoft", 10 * 300, 10 * 2700, 10 * 600, 261},
    {"ClusterStackMixed", 5 * 300, 5 * 2700, 5 * 600, 130},
    {"TetraBunny", 481, 2325, 902, 1394},
    {"TetraCube", 374, 2196, 432, 16},
};

} // namespace

static void all_scenes_are_listed(void**) {
    assert_int_equal(scene_demo_count, sizeof expectations / sizeof expectations[0]);
    for (int i = 0; i < scene_count; ++i) {
        assert_true(scene_list[i]->is_own == (i >= scene_demo_count));
        if (!scene_list[i]->is_own) { assert_string_equal(scene_list[i]->name, expectations[i].name); }
        assert_non_null(scene_list[i]->summary);
        assert_true(scene_list[i]->picture_frame > 0);
    }
}

static void scenes_are_found_by_name(void**) {
    assert_string_equal(scene_find("rOPEattach")->name, "RopeAttach");
    assert_string_equal(scene_find("Collide")->name, "Collide");
    assert_null(scene_find("Collid"));
    assert_null(scene_find("Collide4"));
    assert_null(scene_find(""));
    assert_null(scene_find(nullptr));
}

// No scene is cut earlier.
static constexpr int frames_before_events = 30;

static void scenes_run_on_both_engines(void**) {
    for (const Expectation& expected : expectations) {
        const DescriptionPointer description = describe(expected.name);
        for (const EngineKind kind : {EngineKind::bullet, EngineKind::pliant}) {
            const auto engine = make_engine(kind, *description, {});
            for (int frame = 0; frame < frames_before_events; ++frame) {
                engine->step();
            }
            const demos::Measures measures = measure(*engine);
            if (!measures.finite || measures.nodes != expected.nodes || measures.links != expected.links ||
                measures.faces != expected.faces || measures.clusters != expected.clusters) {
                fail_msg("%s on %s: %d nodes, %d links, %d faces, %d clusters, finite: %d", expected.name,
                         engine->name().c_str(), measures.nodes, measures.links, measures.faces, measures.clusters,
                         measures.finite);
            }
        }
    }
}

static void a_run_can_be_repeated(void**) {
    const DescriptionPointer description = describe("Collide3");
    uint64_t hashes[2];
    for (uint64_t& hash : hashes) {
        const auto engine = make_engine(EngineKind::pliant, *description, {});
        for (int frame = 0; frame < 100; ++frame) {
            engine->step();
        }
        hash = measure(*engine).state_hash;
    }
    assert_true(hashes[0] == hashes[1]);
}

static void engines_start_alike(void**) {
    for (const Expectation& expected : expectations) {
        const DescriptionPointer description = describe(expected.name);
        const auto bullet = make_engine(EngineKind::bullet, *description, {});
        const auto pliant = make_engine(EngineKind::pliant, *description, {});
        assert_true(measure(*bullet).state_hash == measure(*pliant).state_hash);
        for (size_t i = 0; i < description->softs.size(); ++i) {
            const demos::SoftState a = bullet->soft(static_cast<int>(i)), b = pliant->soft(static_cast<int>(i));
            assert_true(a.link_nodes == b.link_nodes);
            assert_true(a.face_nodes == b.face_nodes);
            assert_true(a.inverse_masses == b.inverse_masses);
            assert_true(a.rest_lengths == b.rest_lengths);
        }
    }
}

// ------------------------------------------------------------------------------------------------------- meshes

namespace {

// A file that goes with its owner.
class TemporaryFile {
public:
    explicit TemporaryFile(const std::string& content) { std::ofstream(path) << content; }
    ~TemporaryFile() { std::remove(path.c_str()); }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const std::string path = "test_scenes.obj";
};

const char* const octahedron = "v 1 0 0\nv -1 0 0\nv 0 2 0\nv 0 -2 0\nv 0 0 3\nv 0 0 -3\n"
                               "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
const char* const two_tetrahedra = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\n"
                                   "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\nf 5 7 6\nf 5 6 8\nf 6 7 8\nf 5 8 7\n";

double diagonal(const pli_bounds& bounds) {
    return static_cast<double>(pli_vec3_length(pli_vec3_sub(bounds.max, bounds.min)));
}

} // namespace

static void a_file_replaces_the_mesh_in_its_place(void**) {
    const TemporaryFile file(octahedron);
    for (int i = 0; i < scene_count; ++i) {
        if (!scene_list[i]->takes_mesh) { continue; }
        const DescriptionPointer own = demos::Description::build(*scene_list[i], {});
        const DescriptionPointer replaced = demos::Description::build(*scene_list[i], {file.path, ""});
        for (size_t k = 0; k < own->softs.size(); ++k) {
            assert_int_equal(pli_mesh_get_view(replaced->softs[k].mesh.get()).node_count, 6);
            const pli_bounds a = pli_mesh_bounds(own->softs[k].mesh.get());
            const pli_bounds b = pli_mesh_bounds(replaced->softs[k].mesh.get());
            // Scenes with wheels stretch their tori along one axis.
            if (own->drives.empty()) { check_near(diagonal(b), diagonal(a), 1e-5 * diagonal(a)); }
            const pli_vec3 shift = pli_vec3_sub(pli_vec3_add(a.min, a.max), pli_vec3_add(b.min, b.max));
            check_at_most(pli_vec3_length(shift), 1e-4);
        }
        for (const EngineKind kind : {EngineKind::bullet, EngineKind::pliant}) {
            const auto engine = make_engine(kind, *replaced, {});
            for (int frame = 0; frame < 60; ++frame) {
                engine->step();
            }
            assert_true(measure(*engine).finite);
        }
    }
}

static void files_replace_tetrahedra(void**) {
    const std::string base = "test_scenes_tetra";
    std::ofstream(base + ".node") << "5 3 0 0\n0 0 0 0\n1 2 0 0\n2 0 2 0\n3 0 0 2\n4 2 2 2\n";
    std::ofstream(base + ".ele") << "2 4 0\n0 0 2 1 3\n1 1 2 3 4\n";
    for (const char* name : {"TetraBunny", "TetraCube"}) {
        const DescriptionPointer description = describe(name, {"", base});
        for (const EngineKind kind : {EngineKind::bullet, EngineKind::pliant}) {
            const auto engine = make_engine(kind, *description, {});
            for (int frame = 0; frame < 60; ++frame) {
                engine->step();
            }
            const demos::Measures measures = measure(*engine);
            assert_true(measures.finite);
            assert_int_equal(measures.nodes, 5);
            assert_int_equal(measures.tetras, 2);
        }
    }
    std::remove((base + ".node").c_str());
    std::remove((base + ".ele").c_str());
    assert_non_null(std::strstr(error_of([&] { describe("TetraCube", {"", base}); }).c_str(), "test_scenes_tetra"));
}

// Discs come off, and nothing is lost with them.
static void a_script_cuts(void**) {
    const DescriptionPointer description = describe("Cutting1");
    const auto engine = make_engine(EngineKind::pliant, *description, {});
    const auto mass = [&] {
        double sum = 0.0;
        for (const float inverse : engine->soft(0).inverse_masses) {
            sum += inverse > 0.0f ? 1.0 / static_cast<double>(inverse) : 0.0;
        }
        return sum;
    };
    const double mass_before = mass();
    int nodes = measure(*engine).nodes;
    assert_int_equal(description->cuts.size(), 3);
    int frame = 0;
    for (const demos::CutRecord& cut : description->cuts) {
        for (; frame < cut.frame; ++frame) {
            engine->step();
        }
        assert_int_equal(measure(*engine).nodes, nodes);
        engine->step();
        ++frame;
        assert_true(measure(*engine).nodes > nodes + 20);
        nodes = measure(*engine).nodes;
        check_near(mass(), mass_before, 1e-5 * mass_before);
    }
}

static void meshes_in_pieces_run_on_pliant_only(void**) {
    const TemporaryFile file(two_tetrahedra);
    const DescriptionPointer pieces = describe("Collide", {file.path, ""});
    const std::string message = error_of([&] { make_engine(EngineKind::bullet, *pieces, {}); });
    assert_string_equal(message.c_str(), "torus: btSoftBody hangs in soft contacts of a mesh that is not in one piece "
                                         "(2 by faces, 2 by links)");
    const auto engine = make_engine(EngineKind::pliant, *pieces, {});
    for (int frame = 0; frame < 60; ++frame) {
        engine->step();
    }
    assert_true(measure(*engine).finite);
    // Without soft contacts Bullet needs no trees.
    const DescriptionPointer torus = describe("Torus", {file.path, ""});
    make_engine(EngineKind::bullet, *torus, {})->step();
}

static void wrong_meshes_are_named(void**) {
    assert_string_equal(error_of([] {
                            describe("Ropes", {"some.obj", ""});
                        }).c_str(),
                        "scene Ropes has no triangle mesh that a file could replace");
    assert_string_equal(error_of([] {
                            describe("Bunny", {"", "some"});
                        }).c_str(),
                        "scene Bunny has no tetrahedral mesh that a file could replace");
    const std::string missing = error_of([] { describe("Bunny", {"no_such_file.obj", ""}); });
    assert_non_null(std::strstr(missing.c_str(), "scene Bunny: "));
    assert_non_null(std::strstr(missing.c_str(), "no_such_file.obj"));
    {
        const TemporaryFile file("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
        assert_non_null(std::strstr(error_of([&] { describe("Torus", {file.path, ""}); }).c_str(), "test_scenes.obj"));
    }
    {
        const TemporaryFile file("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n");
        assert_string_equal(error_of([&] {
                                describe("Torus", {file.path, ""});
                            }).c_str(),
                            "scene Torus: test_scenes.obj: the mesh has no extent");
    }
}

// ------------------------------------------------------------------------------------------ wrong descriptions

namespace {

pli_mesh* one_link(scene_builder* builder) {
    pli_mesh* mesh = nullptr;
    scene_check(builder, pli_mesh_create_rope(scene_context(builder), pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 0,
                                              0, &mesh));
    return mesh;
}

void add_rigid(scene_builder* builder, void (*edit)(scene_rigid_def&)) {
    scene_rigid_def def = scene_rigid_def_default();
    edit(def);
    scene_add_rigid(builder, &def);
}

void add_soft(scene_builder* builder, void (*edit)(scene_soft_def&)) {
    scene_soft_def def = scene_soft_def_default();
    edit(def);
    scene_add_soft(builder, one_link(builder), &def);
}

struct WrongScene {
    void (*build)(scene_builder*);
    const char* message;
};

const pli_vec3 not_finite = {0, NAN, 0};

const WrongScene wrong_scenes[] = {
    {[](scene_builder* b) { scene_add_rigid(b, nullptr); }, "a rigid body needs a definition with a name"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.mass = -1; }); },
     "rigid: the mass must be zero or positive"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.mass = NAN; }); },
     "rigid: the mass must be zero or positive"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.friction = -1; }); },
     "rigid: the friction must not be negative"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.pose.origin = not_finite; }); },
     "rigid: the pose is not finite"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.shape = scene_sphere(0); }); },
     "rigid: the radius must be positive"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) {
                                d.shape = scene_box({1, -1, 1});
                            }); },
     "rigid: half extents must be positive"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.shape.kind = SCENE_SHAPE_CAPSULE; }); },
     "rigid: radius and half height must be positive"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.shape.kind = SCENE_SHAPE_TRIANGLE_MESH; }); },
     "rigid: the triangle mesh is empty"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.shape.kind = SCENE_SHAPE_COMPOUND; }); },
     "rigid: the compound is empty"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.shape.axis = 3; }); },
     "rigid: the axis must be 0, 1 or 2"},
    {[](scene_builder* b) { add_rigid(b, [](scene_rigid_def& d) { d.mass = 1, d.is_collision_only = true; }); },
     "rigid: a plain collision object has no mass"},
    {[](scene_builder* b) { scene_add_soft(b, one_link(b), nullptr); }, "a soft body needs a definition with a name"},
    {[](scene_builder* b) {
         const scene_soft_def def = scene_soft_def_default();
         scene_add_soft(b, nullptr, &def);
     },
     "soft: a soft body needs a mesh with nodes"},
    {[](scene_builder* b) { add_soft(b, [](scene_soft_def& d) { d.collision_margin = -1; }); },
     "soft: the collision margin must not be negative"},
    {[](scene_builder* b) { add_soft(b, [](scene_soft_def& d) { d.solver.position_iterations = -1; }); },
     "soft: iterations must not be negative"},
    {[](scene_builder* b) { add_soft(b, [](scene_soft_def& d) { d.pressure = NAN; }); },
     "soft: pressure, volume conservation and pose matching must be finite"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def& d) { d.has_soft_contacts = true, d.soft_contacts.friction = 0.7f; });
     },
     "soft: btSoftBody knows one friction for rigid and soft contacts"},
    {[](scene_builder* b) { add_soft(b, [](scene_soft_def& d) { d.has_clusters = true, d.cluster_count = -1; }); },
     "soft: the number of clusters must not be negative"},
    {[](scene_builder* b) { add_soft(b, [](scene_soft_def& d) { d.cluster_matching = 2; }); },
     "soft: matching and node damping of a cluster must be between 0 and 1"},
    {[](scene_builder* b) { add_soft(b, [](scene_soft_def& d) { d.has_cluster_contacts = true; }); },
     "soft: cluster contacts need clusters"},
    {[](scene_builder* b) { add_soft(b, [](scene_soft_def& d) { d.has_clusters = d.has_cluster_contacts = true; }); },
     "soft: btSoftBody knows one friction for all contacts"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def&) {});
         const scene_joint joint = scene_joint_to_rigid(0, 0);
         scene_add_linear_joint(b, &joint, {0, 0, 0});
     },
     "soft: a joint needs clusters"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def& d) { d.has_clusters = true, d.cluster_count = 1; });
         const scene_joint joint = scene_joint_to_rigid(0, 0);
         scene_add_linear_joint(b, &joint, {0, 0, 0});
     },
     "there is no rigid body 0, the scene has 0 yet"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def& d) { d.has_clusters = true, d.cluster_count = 1; });
         const scene_angular_joint joint = {scene_joint_to_soft(0, 0), {0, 1, 0}, false, {0, 0, 0}};
         scene_add_angular_joint(b, &joint);
     },
     "a joint needs two bodies"},
    {[](scene_builder* b) {
         scene_drive_at(b, 10, 1, 1, 0);
         scene_drive_at(b, 9, 1, 1, 0);
     },
     "what is driven must come in the order of frames"},
    {[](scene_builder* b) { scene_drive_at(b, 0, 1, -1, 0); }, "speed, change and angle must be finite"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def&) {});
         scene_cut_at(b, 0, 0, 2, 1);
     },
     "soft: node 2 is out of range, the mesh has 2 nodes"},
    {[](scene_builder* b) { scene_cut_at(b, 0, 0, 0, 0); }, "the radius of a cut must be positive"},
    {[](scene_builder* b) {
         const scene_control control = {"wind", 0, 1, 2, SCENE_KEYS_NONE, false, scene_run_steer};
         scene_add_control(b, &control);
     },
     "wind: a control needs a range with its first value in it"},
    {[](scene_builder* b) {
         const scene_control control = {"wind", 0, 1, 0, SCENE_KEYS_NONE, false, nullptr};
         scene_add_control(b, &control);
     },
     "wind: a control needs something to apply"},
    {[](scene_builder* b) { scene_set_control_at(b, 0, 0, 1); }, "there is no control 0, the scene has 0 yet"},
    {[](scene_builder* b) {
         const scene_control control = {"wind", 0, 1, 0, SCENE_KEYS_NONE, false, scene_run_steer};
         scene_set_control_at(b, 0, scene_add_control(b, &control), 2);
     },
     "wind: the value is out of range"},
    {[](scene_builder* b) { scene_tetra_mesh(b, "torus"); }, "there is no tetrahedral mesh \"torus\""},
    {[](scene_builder* b) {
         scene_set_velocity(b, 0, {1, 0, 0});
     },
     "there is no soft body 0, the scene has 0 yet"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def&) {});
         scene_set_velocity(b, 0, not_finite);
     },
     "soft: the velocity is not finite"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def&) {});
         scene_add_first_force(b, 0, 2, {1, 0, 0});
     },
     "soft: node 2 is out of range, the mesh has 2 nodes"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def&) {});
         scene_add_anchor(b, 0, 0, 0, false, 1);
     },
     "there is no rigid body 0, the scene has 0 yet"},
    {[](scene_builder* b) {
         add_soft(b, [](scene_soft_def&) {});
         add_rigid(b, [](scene_rigid_def& d) { d.is_collision_only = true; });
         scene_add_anchor(b, 0, 0, 0, false, 1);
     },
     "soft: an anchor needs a rigid body, not a plain collision object"},
    {[](scene_builder* b) {
         scene_set_camera(b, {{0, 0, 0}, 0, 0, 0});
     },
     "the camera needs a finite target and angles and a positive distance"},
    {[](scene_builder* b) { scene_set_gravity(b, not_finite); }, "the gravity is not finite"},
    {[](scene_builder* b) { scene_triangle_mesh(b, "cube"); }, "there is no mesh \"cube\""},
    {[](scene_builder* b) { scene_triangle_mesh(b, nullptr); }, "a mesh needs a name"},
    {[](scene_builder* b) {
         pli_mesh* mesh = one_link(b);
         scene_check(b, pli_mesh_set_total_mass(mesh, -1));
         const scene_soft_def def = scene_soft_def_default();
         scene_add_soft(b, mesh, &def);
     },
     "a value is outside its allowed range: pli_mesh_set_total_mass"},
};

} // namespace

static void wrong_descriptions_are_named(void**) {
    for (const WrongScene& wrong : wrong_scenes) {
        const scene made = test_scene(wrong.build);
        const std::string message = error_of([&] { demos::Description::build(made, {}); });
        const std::string expected = std::string("scene Test: ") + wrong.message;
        if (message.compare(0, expected.size(), expected) != 0) {
            fail_msg("\"%s\" instead of \"%s\"", message.c_str(), expected.c_str());
        }
    }
}

static void the_first_error_counts(void**) {
    const scene made = test_scene([](scene_builder* builder) {
        scene_set_gravity(builder, not_finite);
        add_rigid(builder, [](scene_rigid_def& def) { def.mass = -1; });
    });
    assert_string_equal(error_of([&] { demos::Description::build(made, {}); }).c_str(),
                        "scene Test: the gravity is not finite");
}

// ------------------------------------------------------------------------------------------------------ momentum

namespace {

struct Vector {
    double x = 0, y = 0, z = 0;
    void add(double factor, pli_vec3 v) {
        x += factor * static_cast<double>(v.x);
        y += factor * static_cast<double>(v.y);
        z += factor * static_cast<double>(v.z);
    }
    double distance(const Vector& b) const {
        return std::sqrt((x - b.x) * (x - b.x) + (y - b.y) * (y - b.y) + (z - b.z) * (z - b.z));
    }
};

// Of all bodies that move.
Vector momentum(const demos::Engine& engine) {
    const demos::Description& description = engine.description();
    Vector sum;
    for (size_t i = 0; i < description.softs.size(); ++i) {
        const demos::SoftState soft = engine.soft(static_cast<int>(i));
        for (size_t k = 0; k < soft.velocities.size(); ++k) {
            sum.add(1.0 / static_cast<double>(soft.inverse_masses[k]), soft.velocities[k]);
        }
    }
    for (size_t i = 0; i < description.rigids.size(); ++i) {
        sum.add(static_cast<double>(description.rigids[i].mass), engine.rigid(static_cast<int>(i)).linear_velocity);
    }
    return sum;
}

// Largest relative change of the momentum in a second; the run lasts that long.
double momentum_change(demos::Engine& engine) {
    const Vector start = momentum(engine);
    double change = 0;
    for (int frame = 0; frame < 60; ++frame) {
        engine.step();
        change = std::fmax(change, momentum(engine).distance(start) / start.distance({}));
    }
    return change;
}

// RopeAttach with nothing that acts from outside: no gravity, no ground, loose ropes that pull at the box.
void loose_ropes_build(scene_builder* builder) {
    scene_set_gravity(builder, {0, 0, 0});
    scene_rigid_def box = scene_rigid_def_default();
    box.shape = scene_box({2, 6, 2});
    box.mass = 50;
    box.pose.origin = {12, 8, 0};
    const int box_index = scene_add_rigid(builder, &box);
    for (int i = 0; i < 2; ++i) {
        const float z = i == 0 ? -1.0f : 1.0f;
        pli_mesh* mesh = nullptr;
        scene_check(builder, pli_mesh_create_rope(scene_context(builder), {0, 8, z}, {10, 8, z}, 8, 0, &mesh));
        scene_check(builder, pli_mesh_set_total_mass(mesh, 50));
        const scene_soft_def def = scene_soft_def_default();
        const int rope = scene_add_soft(builder, mesh, &def);
        scene_set_velocity(builder, rope, {-1, 3, -2});
        scene_add_anchor(builder, rope, 9, box_index, false, 1);
    }
}

// A soft ball flies at a free box.
void ball_and_box_build(scene_builder* builder) {
    scene_set_gravity(builder, {0, 0, 0});
    pli_mesh* mesh = scene_triangle_mesh(builder, "ball");
    scene_check(builder, pli_mesh_append_bending_links(mesh, 2, 0, nullptr));
    scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 10));
    scene_soft_def def = scene_soft_def_default();
    def.solver.position_iterations = 4;
    const int ball = scene_add_soft(builder, mesh, &def);
    scene_set_velocity(builder, ball, {5, 0, 0});
    scene_rigid_def box = scene_rigid_def_default();
    box.shape = scene_box({1, 1, 1});
    box.mass = 10;
    box.pose.origin = {3, 0.3f, 0};
    scene_add_rigid(builder, &box);
}

} // namespace

static void ropes_and_box_keep_their_momentum(void**) {
    const scene made = test_scene(loose_ropes_build);
    const DescriptionPointer description = demos::Description::build(made, {});
    const auto engine = make_engine(EngineKind::pliant, *description, {});
    check_at_most(momentum_change(*engine), 1e-5);
    assert_true(pli_vec3_length(engine->rigid(0).linear_velocity) > 1.0f);
}

static void ball_and_box_keep_their_momentum_in_the_bridge(void**) {
    const scene made = test_scene(ball_and_box_build);
    const DescriptionPointer description = demos::Description::build(made, {});
    const auto engine = make_engine(EngineKind::pliant, *description, {});
    check_at_most(momentum_change(*engine), 1e-5);
    assert_true(engine->rigid(0).linear_velocity.x > 1.0f);
}

static void ball_and_box_keep_their_momentum_in_the_core(void**) {
    pli_context* context = nullptr;
    assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
    pli_world_def world_def = pli_world_def_default();
    world_def.gravity = {0, 0, 0};
    pli_world* world = nullptr;
    assert_int_equal(pli_world_create(context, &world_def, &world), PLI_OK);
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_ellipsoid(context, {0, 0, 0}, {1, 1, 1}, 515, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, nullptr), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass_from_faces(mesh, 10), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 4;
    pli_body* ball = nullptr;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &ball), PLI_OK);
    pli_mesh_destroy(mesh);
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    assert_int_equal(pli_body_enable_rigid_contacts(ball, &contacts), PLI_OK);
    assert_int_equal(pli_body_add_velocity(ball, {5, 0, 0}), PLI_OK);

    pli_shape* shape = nullptr;
    assert_int_equal(pli_shape_create_box(context, {1, 1, 1}, &shape), PLI_OK);
    const float mass = 10, inverse_inertia = 3.0f / (2.0f * mass);
    pli_rigid_def box_def = pli_rigid_def_default();
    box_def.kind = PLI_RIGID_DYNAMIC;
    box_def.state.pose.origin = {3, 0.3f, 0};
    box_def.state.inverse_mass = 1 / mass;
    box_def.state.inverse_inertia_world = {{{inverse_inertia, 0, 0}, {0, inverse_inertia, 0}, {0, 0, inverse_inertia}}};
    box_def.shape_count = 1;
    box_def.shapes = &shape;
    pli_rigid* box = nullptr;
    assert_int_equal(pli_rigid_create(world, &box_def, &box), PLI_OK);
    pli_shape_release(shape);

    const auto momentum_now = [&] {
        Vector sum;
        const pli_body_view view = pli_body_get_view(ball);
        for (int i = 0; i < view.node_count; ++i) {
            const pli_vec4 v = view.velocities[i];
            sum.add(1.0 / static_cast<double>(view.positions[i].w), {v.x, v.y, v.z});
        }
        sum.add(static_cast<double>(mass), pli_rigid_get_state(box).linear_velocity);
        return sum;
    };
    const Vector start = momentum_now();
    double change = 0;
    for (int frame = 0; frame < 60; ++frame) {
        assert_int_equal(pli_world_step(world, demos::frame_seconds), PLI_OK);
        assert_int_equal(pli_rigid_integrate(box, {0, 0, 0}, demos::frame_seconds), PLI_OK);
        change = std::fmax(change, momentum_now().distance(start) / start.distance({}));
    }
    check_at_most(change, 1e-5);
    assert_true(pli_rigid_get_state(box).linear_velocity.x > 1.0f);
    pli_world_destroy(world);
    pli_context_destroy(context);
}

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(all_scenes_are_listed),
        cmocka_unit_test(scenes_are_found_by_name),
        cmocka_unit_test(scenes_run_on_both_engines),
        cmocka_unit_test(a_run_can_be_repeated),
        cmocka_unit_test(engines_start_alike),
        cmocka_unit_test(a_file_replaces_the_mesh_in_its_place),
        cmocka_unit_test(files_replace_tetrahedra),
        cmocka_unit_test(a_script_cuts),
        cmocka_unit_test(meshes_in_pieces_run_on_pliant_only),
        cmocka_unit_test(wrong_meshes_are_named),
        cmocka_unit_test(wrong_descriptions_are_named),
        cmocka_unit_test(the_first_error_counts),
        cmocka_unit_test(ropes_and_box_keep_their_momentum),
        cmocka_unit_test(ball_and_box_keep_their_momentum_in_the_bridge),
        cmocka_unit_test(ball_and_box_keep_their_momentum_in_the_core),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
