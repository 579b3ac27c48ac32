// A frame ready for drawing: triangles of each material, and what the shaders want to know.

#include "page.h"
#include "render/light.h"
#include "render/shaders.h"

#include <emscripten/emscripten.h>

#include <algorithm>
#include <cstring>

namespace {

constexpr int shadow_size = 2048;

// As renderer.js reads them: numbers one after the other, without gaps.
struct Scene {
    render::Matrix4 view_projection, light_projection;
    pli_vec3 light_direction, eye, right, up, forward, horizon_color, zenith_color, haze_center;
    float haze_distance, shadow_offset;
};

struct Material {
    pli_vec3 front, back;
    float wire, gloss, grid, has_shadow, hollow, is_on_top;
    uint32_t vertices, vertex_count; // address and number
};

static_assert(sizeof(Scene) == 58 * sizeof(float) && sizeof(Material) == 14 * sizeof(float));
static_assert(sizeof(render::Vertex) == 9 * sizeof(float));

struct Frame {
    Scene scene;
    std::vector<render::Batch> batches; // that the materials point into
    std::vector<Material> materials;
};

Frame frame;

} // namespace

extern "C" {

// Makes the frame of a run for a place of that height in pixels; the number of materials.
EMSCRIPTEN_KEEPALIVE int web_make_frame(int run, float aspect, int height) {
    const render::Snapshot& snapshot = web::run(run).snapshot;
    const render::Camera camera = web::page().orbit.camera(aspect);
    std::vector<render::Extent> extents;
    const render::View view = web::view_of_all(extents);
    const render::Extent& extent = extents.at(static_cast<size_t>(run));
    const render::Light light = render::make_light(camera, view, shadow_size);
    const float size = std::max(view.focus.diagonal(), 0.1f);
    frame.scene = {camera.view_projection(0.02f * camera.distance, 200.0f * camera.distance),
                   light.projection,
                   light.direction,
                   camera.eye,
                   pli_vec3_scale(camera.right, camera.tangent_x),
                   pli_vec3_scale(camera.up, camera.tangent_y),
                   camera.forward,
                   render::horizon_color,
                   render::zenith_color,
                   view.focus.center(),
                   3.0f * std::max(size, camera.distance),
                   3.0f * light.texel + 0.002f * size};
    frame.batches = render::make_batches(snapshot, extent, view.soft, camera.pixel_size(height), web::page().look);
    frame.materials.clear();
    for (const render::Batch& batch : frame.batches) {
        const bool is_ground = batch.surface == render::Surface::ground;
        frame.materials.push_back({batch.front, batch.back, batch.wire, batch.gloss,
                                   is_ground ? render::round_spacing(0.1f * camera.distance) : 0.0f,
                                   batch.has_shadow && !is_ground ? 1.0f : 0.0f, batch.is_hollow ? 1.0f : 0.0f,
                                   batch.is_on_top ? 1.0f : 0.0f,
                                   static_cast<uint32_t>(reinterpret_cast<uintptr_t>(batch.vertices.data())),
                                   static_cast<uint32_t>(batch.vertices.size())});
    }
    return static_cast<int>(frame.materials.size());
}

EMSCRIPTEN_KEEPALIVE const void* web_scene() {
    return &frame.scene;
}

EMSCRIPTEN_KEEPALIVE const void* web_materials() {
    return frame.materials.data();
}

// The shaders of the program, whose first line names their OpenGL.
EMSCRIPTEN_KEEPALIVE const char* web_shader(const char* name) {
    static constexpr struct {
        const char *name, *text;
    } shaders[] = {{"depth vertex", render::depth_vertex_shader}, {"depth fragment", render::depth_fragment_shader},
                   {"body vertex", render::body_vertex_shader},   {"body fragment", render::body_fragment_shader},
                   {"sky vertex", render::sky_vertex_shader},     {"sky fragment", render::sky_fragment_shader}};
    for (const auto& shader : shaders) {
        if (std::strcmp(shader.name, name) == 0) { return shader.text; }
    }
    return "";
}
}
