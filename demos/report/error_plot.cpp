#include "error_plot.h"

#include "svg.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace report {

namespace {

constexpr double width = 1000, height = 640, left = 92, right = 740, top = 58, bottom = 566;
constexpr double most_decades = 9; // of errors; smaller ones are drawn at the lower edge

// Told apart by colour and, for those who cannot, by shape.
constexpr const char* colors[] = {"#222222", "#c2410c", "#e69f00", "#7b3294",
                                  "#c77cba", "#2f6fb0", "#1b8a4b", "#777777"};

struct Axis {
    double low = 0, high = 1;     // logarithms of the range
    double first = 0, last = 100; // pixels

    double place(double value) const {
        const double x = value > 0.0 ? std::log10(value) : low;
        return first + (last - first) * (std::clamp(x, low, high) - low) / (high - low);
    }
};

Axis axis_for(const std::vector<double>& values, double first, double last) {
    Axis axis;
    double low = 1e300, high = 0;
    for (const double value : values) {
        if (!(value > 0.0)) { continue; }
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (!(high > 0.0)) { low = high = 1; }
    axis.low = std::floor(std::log10(low) + 1e-9);
    axis.high = std::max(std::ceil(std::log10(high) - 1e-9), axis.low + 1);
    axis.low = std::max(axis.low, axis.high - most_decades);
    axis.first = first;
    axis.last = last;
    return axis;
}

std::string power_text(int exponent) {
    char text[40];
    if (exponent >= -3 && exponent <= 4) {
        std::snprintf(text, sizeof text, "%g", std::pow(10.0, exponent));
    } else {
        std::snprintf(text, sizeof text, "1e%d", exponent);
    }
    return text;
}

void draw_axes(Svg& svg, const Axis& across, const Axis& up) {
    for (int k = static_cast<int>(across.low); k <= static_cast<int>(across.high); ++k) {
        const double x = across.place(std::pow(10.0, k));
        for (int part = 2; part < 10 && k < static_cast<int>(across.high); ++part) {
            const double minor = across.place(part * std::pow(10.0, k));
            svg.line(minor, top, minor, bottom, "#f3f3f3");
        }
        svg.line(x, top, x, bottom, "#d4d4d4");
        svg.text(x, bottom + 22, power_text(k), {15, "middle", "#333", false, 0});
    }
    const int every = up.high - up.low > 6 ? 2 : 1;
    for (int k = static_cast<int>(up.low); k <= static_cast<int>(up.high); ++k) {
        const double y = up.place(std::pow(10.0, k));
        svg.line(left, y, right, y, "#d4d4d4");
        if ((static_cast<int>(up.high) - k) % every == 0) {
            svg.text(left - 8, y + 5, power_text(k), {15, "end", "#333", false, 0});
        }
    }
    svg.rectangle(left, top, right - left, bottom - top, "none", "#555");
}

void draw_mark(Svg& svg, size_t curve, double x, double y, bool is_on_front) {
    const std::string color = colors[curve];
    const double r = is_on_front ? 6 : 3.2;
    const std::string fill = is_on_front ? color : color + "66";
    switch (curve % 4) {
    case 0:
        svg.rectangle(x - r, y - r, 2 * r, 2 * r, fill);
        break;
    case 1:
        svg.polygon({{x, y - 1.3 * r}, {x + 1.2 * r, y + r}, {x - 1.2 * r, y + r}}, fill, "none");
        break;
    case 2:
        svg.polygon({{x, y - 1.35 * r}, {x + 1.35 * r, y}, {x, y + 1.35 * r}, {x - 1.35 * r, y}}, fill, "none");
        break;
    default:
        svg.circle(x, y, r, fill, "none");
    }
}

} // namespace

std::string error_plot(const std::string& title, const std::string& cost_title, const std::string& error_title,
                       const std::vector<PlotCurve>& curves) {
    std::vector<double> costs, errors;
    for (const PlotCurve& curve : curves) {
        for (const PlotPoint& point : curve.points) {
            costs.push_back(point.cost);
            errors.push_back(point.error);
        }
    }
    const Axis across = axis_for(costs, left, right), up = axis_for(errors, bottom, top);
    Svg svg(width, height);
    svg.text(left, 36, title, {19, "start", "#111", true, 0});
    draw_axes(svg, across, up);
    svg.text((left + right) / 2, height - 20, cost_title, {16, "middle", "#222", false, 0});
    svg.text(26, (top + bottom) / 2, error_title, {16, "middle", "#222", false, -90});
    double legend = top + 14;
    for (size_t k = 0; k < curves.size() && k < std::size(colors); ++k) {
        if (curves[k].points.empty()) { continue; }
        std::vector<PlotPoint> points = curves[k].points;
        std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
        std::vector<std::pair<double, double>> front;
        for (const PlotPoint& point : points) {
            if (point.is_on_front) { front.emplace_back(across.place(point.cost), up.place(point.error)); }
        }
        svg.polyline(front, colors[k], 2);
        for (const bool is_on_front : {false, true}) { // fronts above the others
            for (const PlotPoint& point : points) {
                if (point.is_on_front != is_on_front) { continue; }
                svg.begin_hint(curves[k].name + ": " + point.hint);
                draw_mark(svg, k, across.place(point.cost), up.place(point.error), is_on_front);
                svg.end_hint();
            }
        }
        svg.line(right + 20, legend, right + 52, legend, colors[k], 2);
        draw_mark(svg, k, right + 36, legend, true);
        svg.text(right + 62, legend + 5, curves[k].name, {16, "start", "#222", false, 0});
        legend += 27;
    }
    svg.text(right + 20, legend + 14, "large marks and lines: the front,", {13, "start", "#666", false, 0});
    svg.text(right + 20, legend + 31, "nothing of the same solver is", {13, "start", "#666", false, 0});
    svg.text(right + 20, legend + 48, "both faster and better", {13, "start", "#666", false, 0});
    const bool has_zeros =
        std::any_of(errors.begin(), errors.end(), [&](double error) { return error < 0.999 * std::pow(10.0, up.low); });
    if (has_zeros) {
        svg.text(right + 20, legend + 76, "on the lower edge: that or less", {13, "start", "#666", false, 0});
    }
    return svg.document();
}

} // namespace report
