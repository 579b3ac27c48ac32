#ifndef DEMOS_RECORDING_H
#define DEMOS_RECORDING_H

// A scene on Pliant that can be played again: what it was run with, a hash of each frame, and the whole state at some
// (keyframes). Everything else follows from the scene's script.

#include "engines/pliant_engine.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace demos {

// As on the command line.
struct RecordedSettings {
    std::string scene, self_collision = "on", resolution;
    std::string solver;                            // that it ran with
    int substeps = 1, iterations = 0, threads = 1; // iterations 0: the scene's own
    float step_seconds = frame_seconds;
    bool is_reference = false;
};

struct Keyframe {
    int frame = 0; // the state after so many
    std::vector<unsigned char> state;
};

struct Recording {
    RecordedSettings settings;
    std::vector<uint64_t> hashes; // of frames 1, 2, ...
    std::vector<Keyframe> keyframes;

    int frame_count() const { return static_cast<int>(hashes.size()); }
    // The last one up to the frame; null: the start of the scene.
    const Keyframe* keyframe_before(int frame) const;
    std::string to_bytes() const;
    // Throw Error for what is no recording, is damaged or of a newer version.
    static Recording from_bytes(const std::string& bytes, const std::string& name);
    static Recording read(const std::filesystem::path& path);
};

// Positions and velocities of all soft and rigid bodies.
uint64_t hash_frame(const PliantEngine& engine);

// The whole state but for the script, the user's hand and the number of balls. Throw Error, where it cannot be written
// or does not fit.
std::vector<unsigned char> write_state(PliantEngine& engine);
void read_state(PliantEngine& engine, const std::vector<unsigned char>& state);

// Takes down the frames of an engine that stands at its start.
class Recorder {
public:
    static constexpr int usual_interval = 600; // frames from a keyframe to the next
    // 0: keyframes only where they are added.
    Recorder(RecordedSettings settings, int interval) : interval_(interval) {
        recording_.settings = std::move(settings);
    }
    void add_frame(PliantEngine& engine);
    void add_keyframe(PliantEngine& engine);
    const Recording& recording() const { return recording_; }

private:
    Recording recording_;
    int interval_;
};

// A recording that is played: the scene is made anew, and brought to a frame by the keyframe before it.
class Player {
public:
    // Throws Error where the state of the keyframe does not fit what this build makes of the scene.
    Player(const Recording& recording, const Description& description, int frame);
    PliantEngine& engine() { return *engine_; }
    int frame() const { return frame_; } // that it is at
    // One frame on. False: it is another than was recorded.
    bool step();

private:
    const Recording& recording_;
    std::unique_ptr<PliantEngine> engine_;
    int frame_ = 0;
};

// Where two runs part, at a frame at which they have; or which part will make them, while all bodies are equal yet.
struct Difference {
    int body = -1; // soft ones, then rigid ones; -1: none
    bool is_rigid = false;
    int node = -1;
    std::string part; // of the state that differs first, as "joints"; empty: none
};
Difference find_difference(const PliantEngine& a, const PliantEngine& b);

} // namespace demos
#endif
