#ifndef DEMOS_HEAVY_CHECKS_H
#define DEMOS_HEAVY_CHECKS_H

// What the group `heavy` of the stability map checks after each step. Checks see bodies, not engines, so tests can make
// up what they see.

#include "stability.h"

namespace demos {

inline double dot(pli_vec3 a, pli_vec3 b) {
    return static_cast<double>(a.x) * static_cast<double>(b.x) + static_cast<double>(a.y) * static_cast<double>(b.y) +
           static_cast<double>(a.z) * static_cast<double>(b.z);
}

// What does not change while a case runs.
struct CheckedRigid {
    double mass = 0; // kg, 0: does not move, or is moved by the scene
    pli_vec3 inertia{};
    scene_shape_kind shape = SCENE_SHAPE_SPHERE; // or a box
    pli_vec3 half_extents{};                     // of a sphere: three times its radius
};

struct CheckedBodies {
    double step_seconds = 0;
    pli_vec3 gravity{0, -10, 0};
    std::vector<CheckedRigid> rigids;
    std::vector<double> link_stiffness; // N/m by soft body, 0: the solver has no springs
    // Of XPBD with one sweep in each, else 0. A stretched link of two nodes gives back what a spring with the
    // compliance 1/k + (w_a + w_b) h^2 would, however stiff it should be.
    double substep_seconds = 0;
};

struct CheckedState {
    std::vector<SoftState> softs;
    std::vector<RigidState> rigids;
};

// A step: the states around it and the time at its end, s.
struct CheckedStep {
    const CheckedState& before;
    const CheckedState& now;
    double seconds;
};

class Check {
public:
    virtual ~Check() = default;
    virtual void start(const CheckedState&) {}
    virtual void after_step(const CheckedStep& step) = 0;
    // The run need not go on.
    virtual bool is_decided() const { return false; }
    virtual Finding finding() const = 0;
};

using CheckPointer = std::unique_ptr<Check>;

// Kinetic energy of the motion of a step, rotation included, and energy of gravity and springs halfway through it, may
// exceed what was there at the start by 2 % of the most that gravity has done so far, and by what lifts all by 0.1 mm.
CheckPointer check_energy(const CheckedBodies& bodies);
// The centre of a rigid body never gets higher than where it started.
CheckPointer check_height(int rigid);
// No node is deep inside a rigid body, by half of its smallest half width or 15 cm. `lying`: a rigid body whose centre
// is not below all nodes near it; < 0: none.
CheckPointer check_passage(const CheckedBodies& bodies, int lying);
// No rigid body gets farther from where it started.
CheckPointer check_reach(double distance);
// During the last of `seconds` the root mean square speed of each body that moves is at most 1 mm/s.
CheckPointer check_rest(const CheckedBodies& bodies, double seconds);

// What has to stay where it is: a rigid body, or the centre of a soft body.
struct Lasting {
    int rigid = -1, soft = -1;
};
// From `seconds` on it moves by at most 1 cm, which is the figure, in mm.
CheckPointer check_place(const Lasting& what, double seconds);
// Anchored nodes are at most 1 mm from their points; the largest distance is the figure, in mm.
CheckPointer check_anchors(const std::vector<AnchorRecord>& anchors);
// Keeps nothing; the largest stretch of a link from `seconds` on is the figure, in %.
CheckPointer measure_stretch(double seconds);

// All that apply: the verdict is that of the first one which fails, the note has all, the figure is the first one.
Finding sum_up(const std::vector<CheckPointer>& checks);

} // namespace demos
#endif
