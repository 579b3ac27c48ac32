#ifndef DEMOS_EXPORT_RIGID_MESH_H
#define DEMOS_EXPORT_RIGID_MESH_H

// Rigid bodies as meshes of their shapes.

#include "export_mesh.h"

namespace exporting {

// The mesh of a shape in the frame of its body; round shapes are made of flat pieces.
class RigidMesh {
public:
    RigidMesh(const demos::Engine& engine, int index);
    // Where the body is now.
    ExportMesh take(const demos::Engine& engine) const;

private:
    int index_;
    ExportMesh local_;
};

} // namespace exporting
#endif
