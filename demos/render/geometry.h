#ifndef DEMOS_RENDER_GEOMETRY_H
#define DEMOS_RENDER_GEOMETRY_H

// Triangles ready for drawing, and the primitive solids.

#include "matrix.h"

#include <vector>

namespace render {

struct Vertex {
    pli_vec3 position, normal;
    pli_vec3 edges; // distance from the three edges of the triangle, 1 at the opposite corner; 1, 1, 1: draw none
};

enum class Surface { plain, ground };

// Triangles of one material.
struct Batch {
    std::vector<Vertex> vertices;
    pli_vec3 front{}, back{}; // colours, linear
    float wire = 0;           // strength of the lines along triangle edges, 0..1
    bool is_hollow = false;   // nothing but these lines
    bool has_shadow = true;
    bool is_on_top = false; // of all that comes before it
    float gloss = 0;
    Surface surface = Surface::plain;
};

// All primitives are in a local frame that `pose` maps to the world, and are appended to `batch`.
void append_triangle(Batch& batch, const pli_vec3 corners[3], const pli_vec3 normals[3], bool with_edges);
void append_box(Batch& batch, pli_vec3 half_extents, const pli_transform& pose);
void append_sphere(Batch& batch, float radius, const pli_transform& pose, int slices);
// Along `axis` (0 x, 1 y, 2 z), from -half_height to half_height; the capsule has its round ends beyond that.
void append_capsule(Batch& batch, float radius, float half_height, int axis, const pli_transform& pose);
void append_cylinder(Batch& batch, float radius, float half_height, int axis, const pli_transform& pose);
// An open tube between two points of the world.
void append_tube(Batch& batch, pli_vec3 from, pli_vec3 to, float radius, int slices = 20);
// A smoothly shaded triangle mesh; its edges are drawn when the batch has wire lines.
void append_mesh(Batch& batch, const std::vector<pli_vec3>& points, const std::vector<int>& triangles,
                 const pli_transform& pose);

// Area-weighted unit normals of the points of a triangle mesh.
std::vector<pli_vec3> smooth_normals(const std::vector<pli_vec3>& points, const std::vector<int>& triangles);

} // namespace render
#endif
