#pragma once

/* The classes of all features. To be declared is not to be linked; only the reader of files names all. */

#include "body/feature.h"

/* FEATURE(x) for each plii_x_class. */
// clang-format off
#define PLII_ALL_FEATURES(FEATURE) \
    FEATURE(aero_face) FEATURE(aero_vertex) FEATURE(anchor) FEATURE(areas) FEATURE(bullet_boxes) \
    FEATURE(cluster_contacts) FEATURE(clusters) FEATURE(colored_links) FEATURE(contact_events) \
    FEATURE(drag) FEATURE(drawn_normals) FEATURE(face_normals) FEATURE(forces) FEATURE(implicit) \
    FEATURE(iterated_sweeps) FEATURE(joints) FEATURE(link_colors) FEATURE(link_graph) FEATURE(links) \
    FEATURE(node_boxes) FEATURE(node_motion) FEATURE(normals) FEATURE(pose) FEATURE(pressure) \
    FEATURE(restitution) FEATURE(rigid_contacts) FEATURE(rigid_faces) FEATURE(self_faces) \
    FEATURE(self_grids) FEATURE(self_nodes) FEATURE(sleep) FEATURE(soft_contacts) \
    FEATURE(step_smoothing) FEATURE(target) FEATURE(tether) FEATURE(topology_changes) FEATURE(trace) \
    FEATURE(velocity_links) FEATURE(volume) FEATURE(xpbd) FEATURE(xpbd_bending) FEATURE(xpbd_links) \
    FEATURE(xpbd_tetras) FEATURE(xpbd_volume)
// clang-format on

#define PLII_DECLARE_FEATURE(name) extern const plii_feature_class plii_##name##_class;
PLII_ALL_FEATURES(PLII_DECLARE_FEATURE)
#undef PLII_DECLARE_FEATURE
