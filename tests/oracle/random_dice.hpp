// Random choices that have names, so that one of them can be switched off and all others stay as they were.
#pragma once

#include <pliant/math.h>

#include <cstdint>
#include <set>
#include <string>

class Dice {
public:
    // What is `off` is never there; what is there is noted. Both must outlive the dice.
    Dice(std::uint64_t start, const std::set<std::string>& off, std::set<std::string>& noted)
        : m_seed(start), m_off(&off), m_noted(&noted) {}

    // The same dice for a part of the case.
    Dice part(const std::string& name) const {
        Dice result = *this;
        result.m_prefix = m_prefix + name + ".";
        return result;
    }
    Dice part(const char* name, int index) const { return part(name + std::to_string(index)); }

    // Whether a feature is there.
    bool has(const std::string& feature, double probability) const {
        const std::string name = m_prefix + feature;
        if (m_off->count(name) != 0 || !(share(feature) < probability)) { return false; }
        m_noted->insert(name);
        return true;
    }
    // For the report.
    void note(const std::string& fact) const { m_noted->insert(m_prefix + "(" + fact + ")"); }
    double share(const std::string& name) const { return static_cast<double>(bits(name) >> 11) / 9007199254740992.0; }
    float uniform(const std::string& name, float low, float high) const {
        return low + (high - low) * static_cast<float>(share(name));
    }
    int integer(const std::string& name, int low, int high) const { // both included
        return low + static_cast<int>(share(name) * (high - low + 1));
    }
    pli_vec3 vector(const std::string& name, float size) const {
        return pli_vec3_make(uniform(name + "x", -size, size), uniform(name + "y", -size, size),
                             uniform(name + "z", -size, size));
    }
    pli_quat turn(const std::string& name) const {
        return pli_quat_from_yaw_pitch_roll(uniform(name + "yaw", -3, 3), uniform(name + "pitch", -3, 3),
                                            uniform(name + "roll", -3, 3));
    }

private:
    // FNV-1a of the name, mixed as in SplitMix64.
    std::uint64_t bits(const std::string& name) const {
        std::uint64_t hash = 14695981039346656037u ^ (m_seed * 0x9e3779b97f4a7c15u);
        for (const std::string* part : {&m_prefix, &name}) {
            for (const char letter : *part) {
                hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211u;
            }
        }
        hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9u;
        hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebu;
        return hash ^ (hash >> 31);
    }

    std::uint64_t m_seed;
    const std::set<std::string>* m_off;
    std::set<std::string>* m_noted;
    std::string m_prefix;
};
