// pliant stability --soak: random worlds built, stepped, cut, set back and torn down, for as long as is wanted.

#include "commands.h"
#include "description/error.h"
#include "engines/stopwatch.h"
#include "measure/stability/child_process.h"
#include "progress.h"
#include "report/output_file.h"

#include <nlohmann/json.hpp>
#include <random_calls.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <sstream>
#include <vector>

namespace app {

namespace {

constexpr int sequences_per_child = 50;
constexpr double most_seconds = 120.0; // of a child

struct Count {
    const char* name;
    uint64_t random_calls_report::*value;
};
constexpr Count counts[] = {
    {"sequences", &random_calls_report::sequences}, {"long_sequences", &random_calls_report::long_sequences},
    {"calls", &random_calls_report::calls},         {"refused", &random_calls_report::refused},
    {"steps", &random_calls_report::steps},         {"bodies", &random_calls_report::bodies},
    {"rigids", &random_calls_report::rigids},       {"cuts", &random_calls_report::cuts},
    {"frozen", &random_calls_report::events},       {"failed_allocations", &random_calls_report::failed_allocations}};

uint64_t next_random(uint64_t& state) { // splitmix64
    state += 0x9e3779b97f4a7c15u;
    uint64_t z = state;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

std::string sequence_bytes(uint64_t seed, uint64_t index) {
    uint64_t state = seed * 0x2545f4914f6cdd1du + index;
    const size_t size = 64 + static_cast<size_t>(next_random(state) % 960);
    std::string bytes;
    for (size_t i = 0; i < size; ++i) {
        bytes += static_cast<char>(next_random(state) >> 56);
    }
    return bytes;
}

bool run_sequence(uint64_t seed, uint64_t index, random_calls_report& report) {
    const std::string bytes = sequence_bytes(seed, index);
    const unsigned kinds = index % 2 == 0 ? 0u : static_cast<unsigned>(RANDOM_CALLS_ALL); // sensible ones go on longer
    return random_calls_run(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), kinds, &report);
}

// The counts, and where there is a finding its sequence and what it is.
std::string run_block(uint64_t seed, uint64_t first, uint64_t count) {
    random_calls_report report = {};
    std::ostringstream text;
    for (uint64_t i = first; i < first + count; ++i) {
        if (!run_sequence(seed, i, report)) {
            text << "finding " << i << ' ' << report.finding;
            return text.str();
        }
    }
    for (const Count& each : counts) {
        text << report.*each.value << ' ';
    }
    return text.str();
}

struct Finding {
    uint64_t index = 0;
    std::string what; // empty: none
};

std::string end_text(const demos::ChildAnswer& answer) {
    if (answer.end == demos::ChildEnd::timed_out) { return "not done after " + std::to_string(most_seconds) + " s"; }
    return answer.signal != 0 ? "ended by signal " + std::to_string(answer.signal) : "ended with an error";
}

// What a block says; adds to the totals.
Finding run_in_block(uint64_t seed, uint64_t first, uint64_t count, random_calls_report& totals) {
    const auto work = [&] { return run_block(seed, first, count); };
    const demos::ChildAnswer answer = demos::run_in_child(work, most_seconds);
    if (answer.end != demos::ChildEnd::answered) {
        if (count == 1) { return {first, end_text(answer)}; }
        for (uint64_t i = first; i < first + count; ++i) {
            const Finding found = run_in_block(seed, i, 1, totals);
            if (!found.what.empty()) { return found; }
        }
        return {first, end_text(answer) + ", but not by itself"};
    }
    std::istringstream text(answer.text);
    Finding found;
    if (answer.text.rfind("finding ", 0) == 0) {
        std::string word;
        text >> word >> found.index >> std::ws;
        std::getline(text, found.what);
        return found;
    }
    for (const Count& each : counts) {
        uint64_t value = 0;
        text >> value;
        totals.*each.value += value;
    }
    return {};
}

std::string save_bytes(const SoakOptions& options, uint64_t index) {
    if (!options.folder.empty()) { report::make_folder(options.folder); }
    const std::string name = "pliant-finding-" + std::to_string(options.seed) + "-" + std::to_string(index) + ".bin";
    const std::string path = options.folder.empty() ? name : (std::filesystem::path(options.folder) / name).string();
    report::OutputFile(path).write(sequence_bytes(options.seed, index));
    return path;
}

nlohmann::ordered_json to_json(const SoakOptions& options, const random_calls_report& totals, double seconds) {
    nlohmann::ordered_json document{{"seed", options.seed}, {"seconds", seconds}};
    for (const Count& each : counts) {
        document[each.name] = totals.*each.value;
    }
    return document;
}

void print_text(const SoakOptions& options, const random_calls_report& totals, double seconds) {
    std::printf("survived %.1f minutes, seed %llu\n", seconds / 60.0, static_cast<unsigned long long>(options.seed));
    for (const Count& each : counts) {
        std::string name = each.name;
        std::replace(name.begin(), name.end(), '_', ' ');
        std::printf("%20llu %s\n", static_cast<unsigned long long>(totals.*each.value), name.c_str());
    }
}

} // namespace

int run_soak(const SoakOptions& options) {
    random_calls_report totals = {};
    const demos::Stopwatch watch;
    const double wanted = 60.0 * options.minutes;
    {
        Progress progress(options.json);
        progress.start("random worlds");
        uint64_t first = 0;
        do {
            progress.show(static_cast<int>(watch.milliseconds() / 1000.0), std::max(1, static_cast<int>(wanted)));
            const Finding found = run_in_block(options.seed, first, sequences_per_child, totals);
            if (!found.what.empty()) {
                progress.clear();
                throw demos::Error("seed " + std::to_string(options.seed) + ", sequence " +
                                   std::to_string(found.index) + ": " + found.what + "; its bytes are in " +
                                   save_bytes(options, found.index));
            }
            first += sequences_per_child;
        } while (watch.milliseconds() < 1000.0 * wanted);
    }
    const double seconds = watch.milliseconds() / 1000.0;
    if (options.json) {
        std::cout << to_json(options, totals, seconds).dump(2) << '\n';
    } else {
        print_text(options, totals, seconds);
    }
    return 0;
}

} // namespace app
