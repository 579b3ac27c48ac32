// The meshes that scenes ask for by name: a torus and a ball are made, bunnies and the cube are read, and a file of the
// user takes the place of any of them.

#include "recorder.h"

#include <cmath>
#include <cstdlib>
#include <fstream>

namespace demos {

namespace {

void check(pli_context* context, pli_status status) {
    if (status != PLI_OK) { throw Error(pli_last_error(context)); }
}

// Around the y axis, radii 2 and 0.5: as many nodes as the torus of Bullet's demos has, and in its place.
MeshPointer make_torus(pli_context* context) {
    constexpr int around = 30, across = 10;
    constexpr float turn = 6.2831853f;
    std::vector<pli_vec3> points;
    std::vector<int> triangles;
    for (int i = 0; i < around; ++i) {
        const float a = turn * static_cast<float>(i) / static_cast<float>(around);
        for (int k = 0; k < across; ++k) {
            const float b = turn * static_cast<float>(k) / static_cast<float>(across);
            const float radius = 2.0f + 0.5f * std::cos(b);
            points.push_back({radius * std::cos(a), 0.5f * std::sin(b), radius * std::sin(a)});
            const int here = i * across + k, right = (i + 1) % around * across + k;
            const int up = i * across + (k + 1) % across, up_right = (i + 1) % around * across + (k + 1) % across;
            triangles.insert(triangles.end(), {here, up, right, up, up_right, right});
        }
    }
    pli_mesh* mesh = nullptr;
    check(context,
          pli_mesh_create_from_triangles(context, static_cast<int>(points.size()), points.data(),
                                         static_cast<int>(triangles.size() / 3), triangles.data(), true, &mesh));
    return MeshPointer(mesh);
}

MeshPointer make_ball(pli_context* context) {
    pli_mesh* mesh = nullptr;
    check(context, pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1), 515, &mesh));
    return MeshPointer(mesh);
}

std::string data_path(const std::string& file) {
    const char* chosen = std::getenv("PLIANT_DATA_DIR");
    if (chosen != nullptr) { return std::string(chosen) + "/" + file; }
    const std::string built = std::string(DEMOS_DATA_DIR) + "/" + file;
    if (std::ifstream(built).good()) { return built; }
    const std::string near = "demos/data/" + file;
    if (std::ifstream(near).good()) { return near; }
    throw Error("cannot find " + file + ": set PLIANT_DATA_DIR to the directory demos/data");
}

MeshPointer read_obj(pli_context* context, const std::string& path) {
    pli_mesh* mesh = nullptr;
    check(context, pli_mesh_read_obj(context, path.c_str(), &mesh));
    return MeshPointer(mesh);
}

MeshPointer read_tetgen(pli_context* context, const std::string& base) {
    pli_mesh* mesh = nullptr;
    check(context, pli_mesh_read_tetgen(context, base.c_str(), &mesh));
    return MeshPointer(mesh);
}

MeshPointer make_own(pli_context* context, const std::string& name) {
    if (name == "torus") { return make_torus(context); }
    if (name == "ball") { return make_ball(context); }
    if (name == "bunny") { return read_obj(context, data_path("bunny.obj")); }
    throw Error("there is no mesh \"" + name + "\"");
}

// Centre and size of the bounds become those of the mesh that is replaced.
void fit(pli_context* context, pli_mesh* mesh, const pli_bounds& place, const std::string& file) {
    const pli_bounds bounds = pli_mesh_bounds(mesh);
    const double diagonal = bounds_diagonal(bounds);
    if (!(diagonal > 0.0)) { throw Error(file + ": the mesh has no extent"); }
    const float scale = static_cast<float>(bounds_diagonal(place) / diagonal);
    if (!std::isfinite(scale)) { throw Error(file + ": the mesh is too small"); }
    const pli_vec3 center = pli_vec3_scale(pli_vec3_add(bounds.min, bounds.max), 0.5f);
    const pli_vec3 goal = pli_vec3_scale(pli_vec3_add(place.min, place.max), 0.5f);
    check(context, pli_mesh_translate(mesh, pli_vec3_neg(center)));
    check(context, pli_mesh_scale(mesh, pli_vec3_make(scale, scale, scale)));
    check(context, pli_mesh_translate(mesh, goal));
}

MeshPointer read_own_tetras(pli_context* context, const std::string& name) {
    if (name != "tetra_bunny" && name != "tetra_cube") { throw Error("there is no tetrahedral mesh \"" + name + "\""); }
    const std::string element_file = data_path(name + ".ele");
    return read_tetgen(context, element_file.substr(0, element_file.size() - 4));
}

} // namespace

MeshPointer make_named_tetra_mesh(pli_context* context, const std::string& name, const std::string& base) {
    MeshPointer own = read_own_tetras(context, name);
    if (base.empty()) { return own; }
    MeshPointer replacement = read_tetgen(context, base);
    if (pli_mesh_get_view(replacement.get()).tetra_count == 0) { throw Error(base + ": the mesh has no tetrahedra"); }
    fit(context, replacement.get(), pli_mesh_bounds(own.get()), base);
    return replacement;
}

MeshPointer make_named_mesh(pli_context* context, const std::string& name, const std::string& mesh_file) {
    MeshPointer own = make_own(context, name);
    if (mesh_file.empty()) { return own; }
    MeshPointer replacement = read_obj(context, mesh_file);
    if (pli_mesh_get_view(replacement.get()).face_count == 0) { throw Error(mesh_file + ": the mesh has no faces"); }
    fit(context, replacement.get(), pli_mesh_bounds(own.get()), mesh_file);
    return replacement;
}

} // namespace demos
