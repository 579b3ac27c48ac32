// The scene builder's joints, and what happens while a scene runs.

#include "recorder_checks.h"

#include <algorithm>

using namespace demos;

static void check_end(scene_builder* builder, int soft) {
    const SoftRecord& record = soft_record(builder, soft);
    require(record.def.has_clusters, record.name + ": a joint needs clusters");
}

static void check_ends(scene_builder* builder, const scene_joint& ends) {
    check_end(builder, ends.soft);
    require((ends.other_soft < 0) != (ends.rigid < 0), "a joint needs a second soft body or a rigid body");
    if (ends.other_soft >= 0) {
        check_end(builder, ends.other_soft);
        require(ends.other_soft != ends.soft, "a joint needs two bodies");
    } else {
        checked_index(ends.rigid, builder->description.rigids.size(), "rigid body");
    }
}

void scene_add_linear_joint(scene_builder* builder, const scene_joint* joint, pli_vec3 position) {
    builder->guard([&] {
        require(joint != nullptr, "a joint needs a definition");
        check_ends(builder, *joint);
        require(is_finite(position), "the position of a joint is not finite");
        JointRecord record{};
        record.ends = *joint;
        record.position = position;
        builder->description.joints.push_back(record);
    });
}

void scene_add_angular_joint(scene_builder* builder, const scene_angular_joint* joint) {
    builder->guard([&] {
        require(joint != nullptr, "a joint needs a definition");
        check_ends(builder, joint->ends);
        require(is_finite(joint->axis) && is_finite(joint->side), "the axis of a joint is not finite");
        JointRecord record{};
        record.is_angular = true;
        record.ends = joint->ends;
        record.axis = joint->axis;
        record.is_driven = joint->is_driven;
        record.side = joint->side;
        builder->description.joints.push_back(record);
    });
}

void scene_drive_at(scene_builder* builder, int frame, float speed, float largest_change, float angle) {
    builder->guard([&] {
        std::vector<DriveRecord>& drives = builder->description.drives;
        require(frame >= (drives.empty() ? 0 : drives.back().frame), "what is driven must come in the order of frames");
        require(std::isfinite(speed) && std::isfinite(angle) && largest_change >= 0.0f && std::isfinite(largest_change),
                "speed, change and angle must be finite, and the change not negative");
        drives.push_back({frame, speed, largest_change, angle});
    });
}

void scene_cut_at(scene_builder* builder, int frame, int soft, int node, float radius) {
    builder->guard([&] {
        require(frame >= 0, "a cut needs a frame that is not negative");
        require(is_positive(radius), "the radius of a cut must be positive");
        builder->description.cuts.push_back({frame, soft, checked_node(soft_record(builder, soft), node), radius});
    });
}

void scene_move_rigid(scene_builder* builder, int rigid, int first_frame, int end_frame, pli_vec3 velocity,
                      pli_vec3 angular_velocity) {
    builder->guard([&] {
        const std::vector<RigidRecord>& rigids = builder->description.rigids;
        const RigidRecord& record = rigids[static_cast<size_t>(checked_index(rigid, rigids.size(), "rigid body"))];
        require(record.is_kinematic, record.name + ": only kinematic bodies are moved");
        require(first_frame >= 0 && end_frame > first_frame, record.name + ": a motion needs a span of frames");
        require(is_finite(velocity) && is_finite(angular_velocity), record.name + ": a velocity is not finite");
        builder->description.motions.push_back({rigid, first_frame, end_frame, velocity, angular_velocity});
    });
}

scene_resolution scene_get_resolution(scene_builder* builder, int columns, int rows) {
    scene_resolution wanted = builder->options.resolution;
    if (wanted.columns <= 0) { return {columns, rows}; }
    if (wanted.rows <= 0) { wanted.rows = std::max(2, (wanted.columns * rows + columns / 2) / columns); }
    return wanted;
}
