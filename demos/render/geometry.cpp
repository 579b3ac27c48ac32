#include "geometry.h"

#include <cmath>

namespace render {

static constexpr float pi = 3.14159265f;

void append_triangle(Batch& batch, const pli_vec3 corners[3], const pli_vec3 normals[3], bool with_edges) {
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 edges = with_edges
                                   ? pli_vec3_make(i == 0 ? 1.0f : 0.0f, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f)
                                   : pli_vec3_make(1, 1, 1);
        batch.vertices.push_back({corners[i], normals[i], edges});
    }
}

// A point of a solid of revolution about z with its normal, in the solid's frame.
struct ProfilePoint {
    float radius, height;
    float normal_radial, normal_axial;
};

static pli_vec3 along_axis(pli_vec3 v, int axis) {
    switch (axis) {
    case 0:
        return pli_vec3_make(v.z, v.x, v.y);
    case 1:
        return pli_vec3_make(v.y, v.z, v.x);
    default:
        return v;
    }
}

// Turns each stretch of the profile around the axis; two points in one place make a sharp edge.
static void append_revolution(Batch& batch, const std::vector<ProfilePoint>& profile, int axis,
                              const pli_transform& pose, int slices) {
    const auto at = [&](const ProfilePoint& point, int slice, pli_vec3& normal) {
        const float angle = 2.0f * pi * static_cast<float>(slice % slices) / static_cast<float>(slices);
        const float c = std::cos(angle), s = std::sin(angle);
        normal = pli_mat3_mul_vec3(
            pose.rotation,
            along_axis(pli_vec3_make(c * point.normal_radial, s * point.normal_radial, point.normal_axial), axis));
        return pli_transform_point(pose,
                                   along_axis(pli_vec3_make(c * point.radius, s * point.radius, point.height), axis));
    };
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        const ProfilePoint &low = profile[i], &high = profile[i + 1];
        if (low.radius == high.radius && low.height == high.height) { continue; }
        for (int slice = 0; slice < slices; ++slice) {
            pli_vec3 p[4], n[4];
            p[0] = at(low, slice, n[0]);
            p[1] = at(low, slice + 1, n[1]);
            p[2] = at(high, slice + 1, n[2]);
            p[3] = at(high, slice, n[3]);
            const pli_vec3 first[3] = {p[0], p[1], p[2]}, first_normals[3] = {n[0], n[1], n[2]};
            const pli_vec3 second[3] = {p[0], p[2], p[3]}, second_normals[3] = {n[0], n[2], n[3]};
            if (low.radius > 0.0f) { append_triangle(batch, first, first_normals, false); }
            if (high.radius > 0.0f) { append_triangle(batch, second, second_normals, false); }
        }
    }
}

void append_box(Batch& batch, pli_vec3 half, const pli_transform& pose) {
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            const float s = static_cast<float>(side);
            const auto corner = [&](float u, float v) {
                const pli_vec3 unit = along_axis(pli_vec3_make(s * u, v, s), axis);
                return pli_transform_point(pose, pli_vec3_mul(unit, half));
            };
            const pli_vec3 normal = pli_mat3_mul_vec3(pose.rotation, along_axis(pli_vec3_make(0, 0, s), axis));
            const pli_vec3 normals[3] = {normal, normal, normal};
            const pli_vec3 p[4] = {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
            const pli_vec3 first[3] = {p[0], p[1], p[2]}, second[3] = {p[0], p[2], p[3]};
            append_triangle(batch, first, normals, false);
            append_triangle(batch, second, normals, false);
        }
    }
}

void append_capsule(Batch& batch, float radius, float half_height, int axis, const pli_transform& pose) {
    const int rings = 12;
    std::vector<ProfilePoint> profile;
    for (int end = -1; end <= 1; end += 2) {
        for (int i = 0; i <= rings; ++i) {
            const float quarter = 0.5f * pi * static_cast<float>(end < 0 ? i - rings : i) / static_cast<float>(rings);
            const bool is_pole = end < 0 ? i == 0 : i == rings;
            const float c = is_pole ? 0.0f : std::cos(quarter), s = std::sin(quarter);
            profile.push_back({radius * c, radius * s + static_cast<float>(end) * half_height, c, s});
        }
    }
    append_revolution(batch, profile, axis, pose, 40);
}

void append_sphere(Batch& batch, float radius, const pli_transform& pose, int slices) {
    std::vector<ProfilePoint> profile;
    const int rings = slices / 2;
    for (int i = 0; i <= rings; ++i) {
        const float angle = pi * (static_cast<float>(i) / static_cast<float>(rings) - 0.5f);
        const float c = i == 0 || i == rings ? 0.0f : std::cos(angle), s = std::sin(angle);
        profile.push_back({radius * c, radius * s, c, s});
    }
    append_revolution(batch, profile, 1, pose, slices);
}

void append_cylinder(Batch& batch, float radius, float half_height, int axis, const pli_transform& pose) {
    append_revolution(batch,
                      {{0, -half_height, 0, -1},
                       {radius, -half_height, 0, -1},
                       {radius, -half_height, 1, 0},
                       {radius, half_height, 1, 0},
                       {radius, half_height, 0, 1},
                       {0, half_height, 0, 1}},
                      axis, pose, 40);
}

void append_tube(Batch& batch, pli_vec3 from, pli_vec3 to, float radius, int slices) {
    const float length = pli_vec3_length(to - from);
    if (!(length > 0.0f)) { return; }
    const pli_vec3 direction = (to - from) * (1.0f / length);
    const pli_vec3 other = std::fabs(direction.y) < 0.9f ? pli_vec3_make(0, 1, 0) : pli_vec3_make(1, 0, 0);
    const pli_vec3 side = normalized(pli_vec3_cross(direction, other));
    pli_transform pose;
    pose.rotation.rows[0] = side; // the columns are side, direction x side, direction
    pose.rotation.rows[1] = pli_vec3_cross(direction, side);
    pose.rotation.rows[2] = direction;
    pose.rotation = pli_mat3_transpose(pose.rotation);
    pose.origin = (from + to) * 0.5f;
    append_revolution(batch, {{radius, -0.5f * length, 1, 0}, {radius, 0.5f * length, 1, 0}}, 2, pose, slices);
}

std::vector<pli_vec3> smooth_normals(const std::vector<pli_vec3>& points, const std::vector<int>& triangles) {
    std::vector<pli_vec3> normals(points.size(), pli_vec3_make(0, 0, 0));
    for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
        const auto a = static_cast<size_t>(triangles[i]), b = static_cast<size_t>(triangles[i + 1]),
                   c = static_cast<size_t>(triangles[i + 2]);
        const pli_vec3 area = pli_vec3_cross(points[b] - points[a], points[c] - points[a]);
        for (const size_t corner : {a, b, c}) {
            normals[corner] = normals[corner] + area;
        }
    }
    for (pli_vec3& normal : normals) {
        normal = normalized(normal);
    }
    return normals;
}

void append_mesh(Batch& batch, const std::vector<pli_vec3>& points, const std::vector<int>& triangles,
                 const pli_transform& pose) {
    std::vector<pli_vec3> placed;
    placed.reserve(points.size());
    for (const pli_vec3 point : points) {
        placed.push_back(pli_transform_point(pose, point));
    }
    const std::vector<pli_vec3> normals = smooth_normals(placed, triangles);
    for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
        pli_vec3 corners[3], corner_normals[3];
        for (size_t k = 0; k < 3; ++k) {
            corners[k] = placed[static_cast<size_t>(triangles[i + k])];
            corner_normals[k] = normals[static_cast<size_t>(triangles[i + k])];
        }
        append_triangle(batch, corners, corner_normals, batch.wire > 0.0f);
    }
}

} // namespace render
