#ifndef DEMOS_MEASURE_H
#define DEMOS_MEASURE_H

// Figures of a scene that runs: sizes, stretch, energy, and a hash of the whole state.

#include "engines/engine.h"

namespace demos {

struct Measures {
    int nodes = 0, links = 0, faces = 0, tetras = 0, clusters = 0;
    bool finite = true;
    double max_stretch = 0;    // largest |length / rest - 1|
    double rms_stretch = 0;    // root mean square over the links
    double kinetic_energy = 0; // J, soft bodies
    double rms_speed = 0;      // m/s, over the nodes that are not pinned
    uint64_t state_hash = 0;   // bits of positions and velocities of all soft bodies
};

Measures measure(const Engine& engine);

// Number of parts that hang together by links, faces or tetrahedra; lone nodes are not counted.
int part_count(const SoftState& state);

} // namespace demos
#endif
