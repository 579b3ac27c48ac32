#ifndef DEMOS_RENDER_BODIES_H
#define DEMOS_RENDER_BODIES_H

// What the bodies of a snapshot look like.

#include "geometry.h"
#include "snapshot.h"

namespace render {

// Soft nodes, and every rigid body's bounds with whether it is part of the surroundings (ground, walls).
struct Extent {
    Box soft;
    std::vector<pli_vec3> soft_points;
    struct Rigid {
        Box bounds;
        bool is_static;
    };
    std::vector<Rigid> rigids;
};

// Throws demos::Error when a node is not finite.
Extent measure_extent(const Snapshot& snapshot);

// The solids that a rigid body is made of.
void append_shape(Batch& batch, const demos::Shape& shape, const pli_transform& pose);

// The faces that only one tetrahedron has, turned outwards; three nodes each.
std::vector<int> tetra_surface(const demos::SoftState& soft);

// A static body much larger than the soft bodies, drawn as ground.
bool is_ground(const Extent::Rigid& rigid, const Box& soft);
// Of the ground under the soft bodies, m; far below everything where there is none.
float ground_height(const std::vector<Extent>& extents);

// `soft`: bounds of all soft bodies that the picture shows; `pixel`: size of a pixel of the final picture at the
// middle of the scene, m, below which nothing is drawn thin.
std::vector<Batch> make_batches(const Snapshot& snapshot, const Extent& extent, const Box& soft, float pixel,
                                const Look& look);

} // namespace render
#endif
