#include "conclusions.h"

#include "table.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace report {

using nlohmann::json;

namespace {

std::string times(double ratio) {
    return fixed(ratio, ratio < 10.0 ? 1 : 0) + " times";
}

std::string count_of(size_t count, const char* singular, const char* plural) {
    return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

std::string joined(const std::vector<std::string>& words, const char* last = " and ") {
    std::string text;
    for (size_t i = 0; i < words.size(); ++i) {
        text += (i == 0 ? "" : i + 1 == words.size() ? last : ", ") + words[i];
    }
    return text;
}

/// A figure of each scene that has one.
struct Figure {
    std::string scene;
    double value;
};

double geometric_mean(const std::vector<Figure>& figures) {
    double sum = 0;
    for (const Figure& figure : figures) {
        sum += std::log(figure.value);
    }
    return std::exp(sum / static_cast<double>(figures.size()));
}

bool is_less(const Figure& a, const Figure& b) {
    return a.value < b.value;
}

std::vector<Figure> figures_of(const json& scenes, const char* key) {
    std::vector<Figure> figures;
    for (const json& each : scenes) {
        if (each.at(key).is_number() && each.at(key).get<double>() > 0.0) {
            figures.push_back({each.at("scene"), each.at(key)});
        }
    }
    return figures;
}

/// Of a figure of Pliant over that of btSoftBody.
std::vector<Figure> shares_of(const json& scenes, const char* key) {
    std::vector<Figure> figures;
    for (const json& each : scenes) {
        const json &pliant = each.at("pliant"), &bullet = each.at("bullet");
        if (!pliant.is_object() || !bullet.is_object()) { continue; }
        const double own = pliant.at(key), other = bullet.at(key);
        if (own > 0.0 && other > 0.0) { figures.push_back({each.at("scene"), own / other}); }
    }
    return figures;
}

std::string named(const Figure& figure) {
    return fixed(figure.value, 2) + " in " + figure.scene;
}

// ------------------------------------------------------------------------------------------------ btSoftBody

void add_speed(const json& speed, ConclusionGroup& better, ConclusionGroup& dearer) {
    const json& scenes = speed.at("scenes");
    const std::vector<Figure> touching = figures_of(scenes, "touching_ratio");
    if (!touching.empty()) {
        const auto [least, most] = std::minmax_element(touching.begin(), touching.end(), is_less);
        better.sentences.push_back("While bodies touch, a step of the soft bodies is " +
                                   times(geometric_mean(touching)) + " as fast as btSoftBody's (geometric mean of " +
                                   count_of(touching.size(), "scene", "scenes") + ", one thread; least " +
                                   named(*least) + ", most " + named(*most) + ").");
    }
    const std::vector<Figure> whole = figures_of(scenes, "world_step_ratio");
    if (!whole.empty()) {
        better.sentences.push_back("With Bullet's rigid bodies, which are the same in both, a whole step is " +
                                   times(geometric_mean(whole)) + " as fast.");
    }
    const std::vector<Figure> reference = figures_of(scenes, "reference_ratio");
    if (!reference.empty()) {
        const double mean = geometric_mean(reference);
        (mean >= 1.0 ? better : dearer)
            .sentences.push_back("In reference mode, with btSoftBody's own results, a step is " + times(mean) +
                                 " as fast.");
    }
    std::vector<std::string> slower;
    for (const Figure& figure : touching) {
        if (figure.value < 1.0) { slower.push_back(figure.scene + " (" + fixed(figure.value, 2) + " times as fast)"); }
    }
    if (!slower.empty()) {
        dearer.sentences.push_back("Slower than btSoftBody while bodies touch: " + joined(slower) + ".");
    }

    const struct {
        const char *key, *what;
        double noticed; // a share that is worth a word
    } costs[] = {{"bytes_per_node", "memory of a node", 1.0},
                 {"setup_ms", "time to make the scene", 1.0},
                 {"rms_stretch", "stretch of the links", 1.1}};
    for (const auto& cost : costs) {
        const std::vector<Figure> shares = shares_of(scenes, cost.key);
        if (shares.empty()) { continue; }
        const double mean = geometric_mean(shares);
        const auto most = std::max_element(shares.begin(), shares.end(), is_less);
        const auto more = static_cast<size_t>(std::count_if(
            shares.begin(), shares.end(), [&](const Figure& figure) { return figure.value > cost.noticed; }));
        if (mean < 1.0) {
            better.sentences.push_back("The " + std::string(cost.what) + " is " + fixed(mean, 2) +
                                       " of btSoftBody's (geometric mean).");
        }
        if (more > 0) {
            dearer.sentences.push_back("The " + std::string(cost.what) + " is more than " +
                                       (cost.noticed > 1.0 ? fixed(cost.noticed, 1) + " times " : "") +
                                       "btSoftBody's in " + std::to_string(more) + " of " +
                                       count_of(shares.size(), "scene", "scenes") + ": at most " +
                                       fixed(most->value, 2) + " times as much, in " + most->scene + ".");
        }
    }
}

void add_agreement(const json& comparison, ConclusionGroup& group) {
    long long frames = 0, unexplained = 0, equal_scenes = 0;
    for (const json& each : comparison.at("scenes")) {
        const json& step = each.at("one_step");
        frames += step.at("frames").get<long long>();
        unexplained += step.at("unexplained_frames").get<long long>();
        equal_scenes += step.at("maximum").get<double>() > 0.0 ? 0 : 1;
    }
    group.sentences.push_back(
        "In reference mode every step of " + std::to_string(equal_scenes) + " of " +
        count_of(comparison.at("scenes").size(), "scene", "scenes") + " equals btSoftBody's bit for bit; in " +
        std::to_string(unexplained) + " of " + std::to_string(frames) +
        " frames it differs by more than 1e-5 of the body's size without a contact that only one of them made.");
}

// --------------------------------------------------------------------------------------------------- solvers

// At equal error, per scene and measure of error.
void add_precision(const json& precision, ConclusionGroup& group) {
    std::map<std::string, int> best_of;
    int measures = 0;
    for (const json& scene : precision.at("scenes")) {
        for (const json& metric : scene.at("metrics")) {
            std::vector<json> ratios;
            for (const json& ratio : scene.at("time_ratios")) {
                if (ratio.at("metric") == metric.at("id")) { ratios.push_back(ratio); }
            }
            if (ratios.size() < 2) { continue; }
            std::sort(ratios.begin(), ratios.end(), [](const json& a, const json& b) {
                return a.at("median").get<double>() > b.at("median").get<double>();
            });
            ++measures;
            ++best_of[ratios[0].at("solver")];
            group.sentences.push_back(
                scene.at("scene").get<std::string>() + ", " + metric.at("title").get<std::string>() +
                ": at equal error " + ratios[0].at("solver").get<std::string>() + " is the fastest, " +
                times(ratios[0].at("median")) + " as fast as btSoftBody (" + fixed(ratios[0].at("least"), 1) + " to " +
                fixed(ratios[0].at("most"), 1) + " over the errors that both reach); next is " +
                ratios[1].at("solver").get<std::string>() + ", " + times(ratios[1].at("median")) + ".");
        }
    }
    if (best_of.empty()) { return; }
    int most = 0;
    for (const auto& [solver, count] : best_of) {
        most = std::max(most, count);
    }
    std::vector<std::string> best;
    for (const auto& [solver, count] : best_of) {
        if (count == most) { best.push_back(solver); }
    }
    group.sentences.insert(group.sentences.begin(), "For accuracy in little time take " + joined(best, " or ") +
                                                        ": the fastest at equal error in " + std::to_string(most) +
                                                        " of " + std::to_string(measures) + " measures" +
                                                        (best.size() > 1 ? " each." : "."));
}

void add_stability(const json& stability, ConclusionGroup& group) {
    std::map<std::string, std::pair<int, int>> counts; // survived, of
    for (const json& cell : stability.at("cells")) {
        auto& [survived, cases] = counts[cell.at("solver")];
        survived += cell.at("survives").get<bool>() ? 1 : 0;
        ++cases;
    }
    if (counts.empty()) { return; }
    std::vector<std::string> words;
    for (const auto& [solver, count] : counts) {
        words.push_back(solver + " " + std::to_string(count.first) + " of " + std::to_string(count.second));
    }
    group.sentences.push_back("Extreme cases survived: " + joined(words) + ".");
    std::map<std::string, std::vector<std::string>> failing; // by group of cases
    for (const json& cell : stability.at("cells")) {
        std::vector<std::string>& solvers = failing[cell.at("group")];
        const std::string solver = cell.at("solver");
        const bool is_new = std::find(solvers.begin(), solvers.end(), solver) == solvers.end();
        if (!cell.at("survives").get<bool>() && is_new) { solvers.push_back(solver); }
    }
    for (const auto& [cases, solvers] : failing) {
        if (solvers.empty() || solvers.size() == counts.size()) { continue; }
        std::vector<std::string> safe;
        for (const auto& [solver, count] : counts) {
            if (std::find(solvers.begin(), solvers.end(), solver) == solvers.end()) { safe.push_back(solver); }
        }
        group.sentences.push_back("For extremes of " + cases + " take " + joined(safe) + ", which survive" +
                                  (safe.size() == 1 ? "s" : "") + " every case; " + joined(solvers) +
                                  (solvers.size() == 1 ? " does not." : " do not."));
    }
}

// Of the time of all steps, which features take it.
void add_costs(const std::vector<json>& documents, ConclusionGroup& group) {
    double all = 0;
    std::map<std::string, double> shares;
    for (const json& each : documents) {
        const double step = each.at("costs").at("microseconds");
        if (!(step > 0.0)) { continue; }
        all += 1;
        for (const json& feature : each.at("costs").at("features")) {
            shares[feature.at("feature")] += feature.at("microseconds").get<double>() / step;
        }
    }
    std::vector<std::pair<double, std::string>> dearest;
    for (const auto& [feature, share] : shares) {
        dearest.emplace_back(share / all, feature);
    }
    std::sort(dearest.rbegin(), dearest.rend());
    if (dearest.size() < 3) { return; }
    std::vector<std::string> words;
    for (size_t i = 0; i < 3; ++i) {
        words.push_back(dearest[i].second + " " + fixed(100.0 * dearest[i].first, 0) + " %");
    }
    group.sentences.push_back("Of the time of a step, in the mean of the scenes, the dearest are " + joined(words) +
                              ".");
}

} // namespace

std::vector<ConclusionGroup> conclusions(const ReportContent& content) {
    ConclusionGroup better{"Better than btSoftBody", {}}, dearer{"What costs more", {}},
        solvers{"Which solver for what", {}};
    if (!content.speed.is_null()) { add_speed(content.speed, better, dearer); }
    if (!content.comparison.is_null()) { add_agreement(content.comparison, better); }
    if (!content.costs.empty()) { add_costs(content.costs, dearer); }
    if (!content.precision.is_null()) { add_precision(content.precision, solvers); }
    if (!content.stability.is_null()) { add_stability(content.stability, solvers); }
    std::vector<ConclusionGroup> groups;
    for (const ConclusionGroup& group : {better, dearer, solvers}) {
        if (!group.sentences.empty()) { groups.push_back(group); }
    }
    return groups;
}

} // namespace report
