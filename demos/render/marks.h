#ifndef DEMOS_RENDER_MARKS_H
#define DEMOS_RENDER_MARKS_H

// What can be drawn on top of soft bodies: normals, contacts, clusters.

#include "geometry.h"
#include "snapshot.h"

namespace render {

// `pixel` as for make_batches.
void append_marks(std::vector<Batch>& batches, const Snapshot& snapshot, float pixel, const Look& look);

} // namespace render
#endif
