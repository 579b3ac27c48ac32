// Cases of degenerate shapes: collapsed, inside out, faces without area, parts that do not hang together, spin.

#include "case_parts.h"

#include <cmath>

namespace demos {

namespace {

StabilityCase shape_case(const std::string& name, std::function<void(scene_builder*)> build) {
    StabilityCase made;
    made.group = "shape";
    made.name = name;
    made.figure_name = "rms stretch";
    made.build = std::move(build);
    return made;
}

// Moves each node of the first soft body before the first step.
std::function<void(Engine&)> moved(std::function<pli_vec3(pli_vec3, int)> place) {
    return [place](Engine& engine) {
        std::vector<pli_vec3> positions = positions_of(engine, 0);
        for (size_t i = 0; i < positions.size(); ++i) {
            positions[i] = place(positions[i], static_cast<int>(i));
        }
        set_state(engine, 0, positions, {});
    };
}

void build_free_sheet(scene_builder* builder) {
    scene_set_gravity(builder, pli_vec3_make(0, 0, 0));
    add_sheet(builder, SheetDef{}, 0.02f);
}

void build_free_ball(scene_builder* builder) {
    scene_set_gravity(builder, pli_vec3_make(0, 0, 0));
    const scene_soft_def def = case_def("ball");
    scene_add_soft(builder, make_ball(builder, pli_vec3_make(0, 0, 0), 0.5f, 100, 1), &def);
}

void build_pressed_ball(scene_builder* builder) {
    scene_set_gravity(builder, pli_vec3_make(0, 0, 0));
    scene_soft_def def = case_def("ball");
    def.pressure = 5;
    scene_add_soft(builder, make_ball(builder, pli_vec3_make(0, 0, 0), 0.5f, 100, 1), &def);
}

void build_free_cube(scene_builder* builder) {
    scene_set_gravity(builder, pli_vec3_make(0, 0, 0));
    const scene_soft_def def = case_def("cube");
    scene_add_soft(builder, make_cube(builder, 1), &def);
}

// XPBD puts rigid volumes right in a substep of 1/600 s: half the cube's mass of 1 kg times the square of an edge of
// 0.3 m over that.
constexpr double rigid_tetra_energy = 0.5 * 180 * 180;

void add_collapsed(std::vector<StabilityCase>& cases) {
    const auto point = moved([](pli_vec3, int) { return pli_vec3_make(0, 0, 0); });
    const auto plane = moved([](pli_vec3 p, int) { return pli_vec3_make(p.x, 0, p.z); });
    cases.push_back(shape_case("sheet, all nodes at one point", build_free_sheet));
    cases.back().prepare = point;
    cases.push_back(shape_case("ball, all nodes in a plane", build_free_ball));
    cases.back().prepare = plane;
    cases.push_back(shape_case("ball under pressure, all nodes in a plane", build_pressed_ball));
    cases.back().prepare = plane;
    cases.back().given_energy = 1000;
    cases.push_back(shape_case("cube of tetrahedra, all nodes at one point", build_free_cube));
    cases.back().prepare = point;
    cases.push_back(shape_case("cube of tetrahedra, in a plane", build_free_cube));
    cases.back().prepare = plane;
    cases.push_back(shape_case("cube of tetrahedra, inside out", build_free_cube));
    cases.back().prepare = moved([](pli_vec3 p, int) { return pli_vec3_make(p.x, -p.y, p.z); });
    cases.back().given_energy = rigid_tetra_energy;
    cases.push_back(shape_case("cube of tetrahedra, nodes anywhere in it", build_free_cube));
    cases.back().prepare = moved([](pli_vec3, int node) {
        // The same places in every run.
        const auto part = [node](int k) {
            const float x = 0.5f + static_cast<float>(std::fmod(0.6180339887 * (node + 1) * (2 * k + 1), 1.0));
            return 2 * (x - std::floor(x)) - 1;
        };
        return pli_vec3_make(part(0), part(1), part(3));
    });
    cases.back().given_energy = rigid_tetra_energy;
}

// A ball whose faces are there twice, with faces without area in between.
pli_mesh* make_faulty_ball(scene_builder* builder, pli_vec3 center) {
    pli_mesh* mesh = make_ball(builder, center, 0.5f, 60, 1);
    if (mesh == nullptr) { return nullptr; }
    const int faces = pli_mesh_get_view(mesh).face_count;
    for (int i = 0; i < faces; ++i) {
        const pli_face face = pli_mesh_get_view(mesh).faces[i];
        scene_check(builder, pli_mesh_append_face(mesh, face.nodes[0], face.nodes[1], face.nodes[2], 0, nullptr));
        // On the middle of an edge: three nodes in a line.
        if (i % 10 != 0) { continue; }
        const pli_mesh_view view = pli_mesh_get_view(mesh);
        const pli_vec3 middle =
            pli_vec3_scale(pli_vec3_add(view.positions[face.nodes[0]], view.positions[face.nodes[1]]), 0.5f);
        int node = 0;
        scene_check(builder, pli_mesh_append_node(mesh, middle, 0.01f, &node));
        scene_check(builder, pli_mesh_append_face(mesh, face.nodes[0], node, face.nodes[1], 0, nullptr));
        scene_check(builder, pli_mesh_append_link(mesh, face.nodes[0], node, 0, nullptr));
        scene_check(builder, pli_mesh_append_link(mesh, node, face.nodes[1], 0, nullptr));
    }
    return mesh;
}

void add_faulty_faces(std::vector<StabilityCase>& cases) {
    cases.push_back(shape_case("ball, faces twice and without area, pressure", [](scene_builder* builder) {
        add_ground(builder);
        pli_mesh* mesh = make_faulty_ball(builder, pli_vec3_make(0, 1, 0));
        scene_soft_def def = case_def("ball");
        def.pressure = 5;
        def.aero.model = PLI_AERO_FACE_TWO_SIDED;
        def.aero.lift = def.aero.drag = 0.05f;
        scene_add_soft(builder, mesh, &def);
    }));
    cases.back().given_energy = 100;
    cases.push_back(shape_case("two such balls in contact", [](scene_builder* builder) {
        add_ground(builder);
        for (const float height : {0.7f, 1.9f}) {
            pli_mesh* mesh = make_faulty_ball(builder, pli_vec3_make(0, height, 0));
            scene_soft_def def = case_def("ball");
            def.has_soft_contacts = true;
            scene_add_soft(builder, mesh, &def);
        }
    }));
}

// Two squares beside each other in one mesh.
void add_parts(std::vector<StabilityCase>& cases) {
    cases.push_back(shape_case("two parts in one mesh, soft contacts", [](scene_builder* builder) {
        add_ground(builder);
        const pli_vec3 points[8] = {{0, 1, 0}, {0.5f, 1, 0}, {0, 1, 0.5f}, {0.5f, 1, 0.5f},
                                    {1, 1, 0}, {1.5f, 1, 0}, {1, 1, 0.5f}, {1.5f, 1, 0.5f}};
        const int triangles[12] = {0, 2, 1, 1, 2, 3, 4, 6, 5, 5, 6, 7};
        for (int i = 0; i < 2; ++i) {
            pli_mesh* mesh = nullptr;
            scene_check(builder,
                        pli_mesh_create_from_triangles(scene_context(builder), 8, points, 4, triangles, true, &mesh));
            scene_check(builder, pli_mesh_translate(mesh, pli_vec3_make(0, 0.5f * static_cast<float>(i), 0)));
            scene_soft_def def = case_def("parts");
            def.has_soft_contacts = true;
            scene_add_soft(builder, mesh, &def);
        }
    }));
    cases.back().seconds = 2;
}

pli_mesh* make_rope_along(scene_builder* builder, int inner_nodes, int pins) {
    pli_mesh* mesh = nullptr;
    scene_check(builder, pli_mesh_create_rope(scene_context(builder), pli_vec3_make(0, 1, 0), pli_vec3_make(2, 1, 0),
                                              inner_nodes, pins, &mesh));
    return mesh;
}

void add_clusters(std::vector<StabilityCase>& cases) {
    const struct {
        const char* name;
        int nodes;
    } sizes[] = {{"clusters of one node", 1}, {"clusters of two nodes", 2}};
    for (const auto& size : sizes) {
        cases.push_back(shape_case(size.name, [nodes = size.nodes](scene_builder* builder) {
            add_ground(builder);
            SheetDef sheet;
            sheet.center = pli_vec3_make(0, 1, 0);
            sheet.columns = 4;
            scene_soft_def def = case_def("sheet");
            def.has_rigid_contacts = false;
            def.has_clusters = def.has_cluster_contacts = true;
            def.cluster_count = 16 / nodes;
            scene_add_soft(builder, make_sheet(builder, sheet), &def);
        }));
        cases.back().seconds = 3;
        cases.back().reach = 1e3; // what has no hull to collide with falls
    }
}

void add_few_nodes(std::vector<StabilityCase>& cases) {
    cases.push_back(shape_case("one link between pinned nodes", [](scene_builder* builder) {
        const scene_soft_def def = case_def("link");
        scene_add_soft(builder, make_rope_along(builder, 0, PLI_ROPE_PIN_FIRST | PLI_ROPE_PIN_LAST), &def);
    }));
    cases.push_back(shape_case("node in a rope of pinned nodes", [](scene_builder* builder) {
        pli_mesh* mesh = make_rope_along(builder, 1, PLI_ROPE_PIN_FIRST | PLI_ROPE_PIN_LAST);
        scene_check(builder, pli_mesh_append_link(mesh, 0, 2, 0, nullptr));
        const scene_soft_def def = case_def("link");
        scene_add_soft(builder, mesh, &def);
    }));
    cases.push_back(shape_case("lone node on the ground", [](scene_builder* builder) {
        add_ground(builder);
        pli_mesh* mesh = nullptr;
        scene_check(builder, pli_mesh_create(scene_context(builder), &mesh));
        scene_check(builder, pli_mesh_append_node(mesh, pli_vec3_make(0, 1, 0), 1, nullptr));
        const scene_soft_def def = case_def("node");
        scene_add_soft(builder, mesh, &def);
    }));
    cases.back().figure_name = "";
}

void add_spin(std::vector<StabilityCase>& cases) {
    cases.push_back(shape_case("ball turning at 100 rad/s", build_free_ball));
    cases.back().prepare = [](Engine& engine) {
        const std::vector<pli_vec3> positions = positions_of(engine, 0);
        std::vector<pli_vec3> velocities;
        for (const pli_vec3 p : positions) {
            velocities.push_back(pli_vec3_cross(pli_vec3_make(0, 100, 0), p));
        }
        set_state(engine, 0, positions, velocities);
    };
}

} // namespace

void add_shape_cases(std::vector<StabilityCase>& cases) {
    add_collapsed(cases);
    add_faulty_faces(cases);
    add_parts(cases);
    add_clusters(cases);
    add_few_nodes(cases);
    add_spin(cases);
}

} // namespace demos
