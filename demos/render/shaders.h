#ifndef DEMOS_RENDER_SHADERS_H
#define DEMOS_RENDER_SHADERS_H

// The shaders, in GLSL 3.30. Colours are linear until the last line of each fragment shader.

namespace render {

// ------------------------------------------------------------------------------------------- depth from the light
inline constexpr const char* depth_vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 view_projection;
void main() { gl_Position = view_projection * vec4(position, 1.0); }
)";

inline constexpr const char* depth_fragment_shader = R"(#version 330 core
void main() {}
)";

// -------------------------------------------------------------------------------------------------------- bodies
inline constexpr const char* body_vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 edges;
uniform mat4 view_projection;
out vec3 world;
out vec3 world_normal;
out vec3 edge_distance;
void main() {
    world = position;
    world_normal = normal;
    edge_distance = edges;
    gl_Position = view_projection * vec4(position, 1.0);
}
)";

// Key light with soft shadow, hemisphere light, a little gloss; wire lines or ground grid; haze far away.
inline constexpr const char* body_fragment_shader = R"(#version 330 core
in vec3 world;
in vec3 world_normal;
in vec3 edge_distance;
uniform mat4 light_projection;
uniform vec3 light_direction; // towards the light
uniform vec3 eye;
uniform vec3 front_color;
uniform vec3 back_color;
uniform vec3 haze_color;
uniform vec3 haze_center;
uniform float haze_distance;
uniform float wire;
uniform float hollow; // above 0: nothing but the lines along triangle edges
uniform float line_width; // pixels of the buffer that is drawn to
uniform float gloss;
uniform float grid; // spacing, m; 0: no grid
uniform float shadow_offset;
uniform float shadow_blur; // radius in texture coordinates
uniform float shadow_taps;
uniform sampler2DShadow shadow_map;
out vec4 color;

float lit_share(vec3 normal) {
    vec4 place = light_projection * vec4(world + normal * shadow_offset, 1.0);
    vec3 at = place.xyz * 0.5 + 0.5;
    if (any(lessThan(at.xy, vec2(0.0))) || any(greaterThan(at.xy, vec2(1.0)))) { return 1.0; }
    // A spiral of taps, turned per pixel so that no bands show.
    float turn = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    float sum = 0.0;
    int taps = int(shadow_taps);
    for (int i = 0; i < taps; ++i) {
        float angle = turn + 2.3999632 * float(i);
        float radius = shadow_blur * sqrt((float(i) + 0.5) / float(taps));
        sum += texture(shadow_map, vec3(at.xy + radius * vec2(cos(angle), sin(angle)), min(at.z, 1.0)));
    }
    return sum / float(taps);
}

float grid_line(vec2 at, float spacing, float width) {
    vec2 cell = at / spacing;
    vec2 pixel = max(fwidth(cell), vec2(1e-6));
    vec2 away = abs(fract(cell - 0.5) - 0.5) / pixel;
    vec2 line = clamp(width * 0.5 + 0.5 - away, 0.0, 1.0) * clamp(0.35 / pixel - 0.4, 0.0, 1.0);
    return max(line.x, line.y);
}

void main() {
    vec3 to_eye = normalize(eye - world);
    vec3 normal = normalize(world_normal);
    // Which side is seen comes from the triangle itself; the shading normal is turned to it.
    vec3 flat_normal = normalize(cross(dFdx(world), dFdy(world)));
    if (dot(flat_normal, to_eye) < 0.0) { flat_normal = -flat_normal; }
    bool is_back = !gl_FrontFacing;
    if (is_back) { normal = -normal; }
    if (dot(normal, flat_normal) < 0.0) { normal = flat_normal; }

    vec3 surface = is_back ? back_color : front_color;
    if (grid > 0.0 && flat_normal.y > 0.5) {
        float fine = grid_line(world.xz, grid, line_width), coarse = grid_line(world.xz, 5.0 * grid, 1.5 * line_width);
        surface *= 1.0 - max(0.30 * fine, 0.5 * coarse);
    }
    if (wire > 0.0) {
        vec3 pixel = max(fwidth(edge_distance), vec3(1e-6));
        vec3 away = edge_distance / pixel;
        // Where triangles come down to a few pixels, lines would only darken: they fade.
        float size = 1.0 / max(max(pixel.x, pixel.y), pixel.z);
        float line = clamp(line_width * 0.5 + 0.5 - min(min(away.x, away.y), away.z), 0.0, 1.0);
        bool has_edges = edge_distance.x + edge_distance.y + edge_distance.z < 1.5;
        if (hollow > 0.0 && has_edges && line < 0.5) { discard; }
        surface = mix(surface, surface * 0.22, wire * line * smoothstep(4.0, 16.0, size));
    }

    float toward = dot(normal, light_direction);
    float lit = toward > 0.0 || grid > 0.0 ? lit_share(flat_normal) : 0.0;
    float key = max(toward, 0.0) * lit;
    float wrap = 0.12 * max(-toward, 0.0); // light that shines through
    vec3 sky = mix(vec3(0.36, 0.33, 0.31), vec3(0.56, 0.63, 0.72), normal.y * 0.5 + 0.5);
    vec3 halfway = normalize(light_direction + to_eye);
    float shine = gloss * lit * pow(max(dot(normal, halfway), 0.0), 48.0);
    float rim = 0.25 * gloss * pow(1.0 - max(dot(normal, to_eye), 0.0), 4.0);
    vec3 light = surface * (vec3(1.0, 0.96, 0.88) * 1.05 * (key + wrap) + 0.62 * sky) + vec3(shine) + sky * rim;

    float far = distance(world.xz, haze_center.xz) / haze_distance;
    light = mix(light, haze_color, grid > 0.0 ? 1.0 - exp(-far * far) : 0.0);
    light = light / (1.0 + 0.18 * light); // keeps bright parts from clipping
    color = vec4(pow(light, vec3(1.0 / 2.2)), 1.0);
}
)";

// ----------------------------------------------------------------------------------------------------------- sky
inline constexpr const char* sky_vertex_shader = R"(#version 330 core
out vec2 place;
void main() {
    place = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(place, 1.0, 1.0);
}
)";

inline constexpr const char* sky_fragment_shader = R"(#version 330 core
in vec2 place;
uniform vec3 right;
uniform vec3 up;
uniform vec3 forward;
uniform vec3 horizon_color;
uniform vec3 zenith_color;
out vec4 color;
void main() {
    vec3 direction = normalize(forward + place.x * right + place.y * up);
    float height = smoothstep(0.0, 0.4, max(direction.y, 0.0));
    vec3 light = mix(horizon_color, zenith_color, height);
    light = light / (1.0 + 0.18 * light);
    color = vec4(pow(light, vec3(1.0 / 2.2)), 1.0);
}
)";

// ---------------------------------------------------------------------------------------------------------- text
inline constexpr const char* text_vertex_shader = R"(#version 330 core
layout(location = 0) in vec2 position; // pixels, y down
uniform vec2 size;
void main() { gl_Position = vec4(2.0 * position.x / size.x - 1.0, 1.0 - 2.0 * position.y / size.y, 0.0, 1.0); }
)";

inline constexpr const char* text_fragment_shader = R"(#version 330 core
uniform vec3 ink;
uniform float opacity;
out vec4 color;
void main() { color = vec4(ink, opacity); }
)";

} // namespace render
#endif
