#include "renderer.h"

#include "light.h"
#include "program.h"
#include "shaders.h"
#include "text.h"

#include <algorithm>

namespace render {

struct Programs {
    Program depth{depth_vertex_shader, depth_fragment_shader};
    Program body{body_vertex_shader, body_fragment_shader};
    Program sky{sky_vertex_shader, sky_fragment_shader};
    Program text{text_vertex_shader, text_fragment_shader};
};

static void draw_sky(const Programs& programs, const Camera& camera) {
    programs.sky.use();
    programs.sky.set("right", camera.right * camera.tangent_x);
    programs.sky.set("up", camera.up * camera.tangent_y);
    programs.sky.set("forward", camera.forward);
    programs.sky.set("horizon_color", horizon_color);
    programs.sky.set("zenith_color", zenith_color);
    glDisable(GL_DEPTH_TEST);
    Triangles(std::vector<float>(6)).draw(); // the shader places the three corners itself
    glEnable(GL_DEPTH_TEST);
}

static void draw_bodies(const Programs& programs, const Camera& camera, const View& view, const Light& light,
                        int canvas_scale, int shadow_taps, const std::vector<Batch>& batches,
                        const std::vector<std::unique_ptr<Triangles>>& triangles) {
    const float size = std::max(view.focus.diagonal(), 0.1f);
    const Program& program = programs.body;
    program.use();
    program.set("view_projection", camera.view_projection(0.02f * camera.distance, 200.0f * camera.distance));
    program.set("light_projection", light.projection);
    program.set("light_direction", light.direction);
    program.set("eye", camera.eye);
    program.set("haze_color", horizon_color);
    program.set("haze_center", view.focus.center());
    program.set("haze_distance", 3.0f * std::max(size, camera.distance));
    program.set("line_width", 1.1f * static_cast<float>(canvas_scale));
    program.set("shadow_offset", 3.0f * light.texel + 0.002f * size);
    program.set("shadow_blur", 0.006f);
    program.set("shadow_taps", static_cast<float>(shadow_taps));
    program.set_unit("shadow_map", 0);
    bool is_on_top = false;
    for (size_t i = 0; i < batches.size(); ++i) {
        if (batches[i].is_on_top && !is_on_top) { glClear(GL_DEPTH_BUFFER_BIT); }
        is_on_top = batches[i].is_on_top;
        program.set("front_color", batches[i].front);
        program.set("back_color", batches[i].back);
        program.set("wire", batches[i].wire);
        program.set("hollow", batches[i].is_hollow ? 1.0f : 0.0f);
        program.set("gloss", batches[i].gloss);
        program.set("grid", batches[i].surface == Surface::ground ? round_spacing(0.1f * camera.distance) : 0.0f);
        triangles[i]->draw();
    }
}

static void draw_shadows(const Programs& programs, const Light& light, const ShadowMap& shadows,
                         const std::vector<Batch>& batches, const std::vector<std::unique_ptr<Triangles>>& triangles) {
    shadows.begin();
    programs.depth.use();
    programs.depth.set("view_projection", light.projection);
    glEnable(GL_DEPTH_CLAMP);
    for (size_t i = 0; i < batches.size(); ++i) {
        if (batches[i].surface != Surface::ground && batches[i].has_shadow) { triangles[i]->draw(); }
    }
    glDisable(GL_DEPTH_CLAMP);
}

struct Renderer::Tools {
    explicit Tools(ShadowQuality wanted) : quality(wanted), shadows(wanted.size) {}
    ShadowQuality quality;
    Programs programs;
    ShadowMap shadows;
};

Renderer::Renderer(ShadowQuality shadows) : tools_(std::make_unique<Tools>(shadows)) {}

Renderer::~Renderer() = default;

void Renderer::draw(const Canvas& canvas, const Snapshot& snapshot, const Extent& extent, const View& view,
                    const Camera& camera, const Look& look) const {
    const Light light = make_light(camera, view, tools_->quality.size);
    const std::vector<Batch> batches =
        make_batches(snapshot, extent, view.soft, camera.pixel_size(canvas.height()), look);
    std::vector<std::unique_ptr<Triangles>> triangles;
    for (const Batch& batch : batches) {
        triangles.push_back(std::make_unique<Triangles>(batch.vertices));
    }
    glEnable(GL_DEPTH_TEST);
    draw_shadows(tools_->programs, light, tools_->shadows, batches, triangles);
    canvas.begin();
    tools_->shadows.bind_texture();
    draw_sky(tools_->programs, camera);
    draw_bodies(tools_->programs, camera, view, light, canvas.scale(), tools_->quality.taps, batches, triangles);
}

// Words on a dark, half transparent plate in the top left corner.
void Renderer::draw_caption(const Canvas& canvas, const std::string& title, const std::string& detail) const {
    const Programs& programs = tools_->programs;
    const float title_scale = 3.0f, detail_scale = 2.0f, edge = 16.0f, padding = 10.0f;
    const bool has_detail = !detail.empty();
    const float plate_width = 2 * padding + std::max(text_width(title, title_scale), text_width(detail, detail_scale));
    const float plate_height =
        2 * padding + text_height(title_scale) + (has_detail ? 6.0f + text_height(detail_scale) : 0.0f);
    const float x = edge + padding, y = edge + padding;
    const float left = edge, top = edge, right = edge + plate_width, bottom = edge + plate_height;
    programs.text.use();
    programs.text.set("size", static_cast<float>(canvas.width()), static_cast<float>(canvas.height()));
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    programs.text.set("ink", pli_vec3_make(0.07f, 0.09f, 0.12f));
    programs.text.set("opacity", 0.72f);
    Triangles({left, top, right, top, right, bottom, left, top, right, bottom, left, bottom}).draw();
    programs.text.set("ink", pli_vec3_make(1, 1, 1));
    programs.text.set("opacity", 1.0f);
    Triangles(text_triangles(title, x, y, title_scale)).draw();
    if (has_detail) {
        programs.text.set("ink", pli_vec3_make(0.85f, 0.89f, 0.93f));
        Triangles(text_triangles(detail, x, y + text_height(title_scale) + 6.0f, detail_scale)).draw();
    }
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
}

} // namespace render
