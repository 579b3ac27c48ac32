#ifndef PLIANT_IO_H
#define PLIANT_IO_H

/// Readers of mesh files. Errors name the file, the line and what is wrong there.

#include "mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Triangles read from a file; release with pli_triangles_destroy.
typedef struct pli_triangles {
    pli_context* context; ///< that they were read in
    int point_count;      ///< of `points`
    int triangle_count;   ///< of `indices`, in threes
    pli_vec3* points;     ///< [point_count], in the unit of the file
    int* indices;         ///< [3 * triangle_count]
} pli_triangles;

/// Reads a Wavefront OBJ: `v` and `f` lines (polygons become fans, negative indices count from the end), all else is
/// skipped. Points, and the nodes of pli_mesh_read_obj, are in the order of the `v` lines.
/// @param triangles receives the points and triangles; what was in it is not released
/// @return PLI_ERROR_FILE_OPEN, PLI_ERROR_FILE_FORMAT
PLI_API pli_status pli_triangles_read_obj(pli_context* context, const char* path, pli_triangles* triangles);

/// Releases the memory of pli_triangles_read_obj and zeroes the struct. NULL and a zeroed struct are allowed.
PLI_API void pli_triangles_destroy(pli_triangles* triangles);

/// Reads a surface: pli_triangles_read_obj, then pli_mesh_create_from_triangles with shuffled links.
/// @return PLI_ERROR_FILE_OPEN, PLI_ERROR_FILE_FORMAT
PLI_API pli_status pli_mesh_read_obj(pli_context* context, const char* path, pli_mesh** mesh);

/// Reads a tetrahedral mesh of TetGen: `base`.node and `base`.ele, and `base`.face when it is there (its triangles
/// become the faces, those on the boundary turned outwards; else the mesh has none). Indices may start at 0 or 1. A
/// link per edge of a tetrahedron. Bullet name: CreateFromTetGenData
/// @return PLI_ERROR_FILE_OPEN, PLI_ERROR_FILE_FORMAT
PLI_API pli_status pli_mesh_read_tetgen(pli_context* context, const char* base, pli_mesh** mesh);

#ifdef __cplusplus
}
#endif
#endif
