#ifndef DEMOS_EXPORT_MESH_H
#define DEMOS_EXPORT_MESH_H

// One body at one moment, as the writers take it.

#include "engines/engine.h"

#include <string>
#include <vector>

namespace exporting {

struct ExportMesh {
    std::string name; // of files: letters, digits, '_' and '-'
    std::vector<pli_vec3> points, velocities;
    std::vector<pli_vec3> normals;      // per point; 0, 0, 0 where no triangle is
    std::vector<int> triangles;         // 3 per triangle; of a body of tetrahedra alone, its surface
    std::vector<int> lines;             // 2 per link with an end in no triangle and no tetrahedron: ropes
    std::vector<int> tetras;            // 4 per tetrahedron
    bool triangles_are_surface = false; // of the tetrahedra
    // length / rest length - 1. Of a line that of its link, of others the mean of the links along their edges.
    std::vector<float> line_stretch, triangle_stretch, tetra_stretch;
};

// `text` with '_' in place of what is not for names of files.
std::string file_name(const std::string& text);

ExportMesh take_soft(const demos::Engine& engine, int index);

} // namespace exporting
#endif
