#include "svg.h"

#include <cstdio>

namespace report {

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
        case '&':
            result += "&amp;";
            break;
        case '<':
            result += "&lt;";
            break;
        case '>':
            result += "&gt;";
            break;
        case '"':
            result += "&quot;";
            break;
        default:
            result += c;
        }
    }
    return result;
}

static std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.2f", value);
    return text;
}

static std::string attribute(const char* name, double value) {
    return std::string(" ") + name + "=\"" + number(value) + "\"";
}

static std::string attribute(const char* name, const std::string& value) {
    return std::string(" ") + name + "=\"" + escaped(value) + "\"";
}

static std::string list(const std::vector<std::pair<double, double>>& points) {
    std::string text;
    for (const auto& [x, y] : points) {
        text += (text.empty() ? "" : " ") + number(x) + "," + number(y);
    }
    return text;
}

Svg::Svg(double width, double height) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\" "
                  "font-family=\"sans-serif\">\n",
                  width, height, width, height);
    head_ = text;
    rectangle(0, 0, width, height, "#ffffff");
}

void Svg::rectangle(double x, double y, double width, double height, const std::string& fill,
                    const std::string& stroke) {
    body_ += "<rect" + attribute("x", x) + attribute("y", y) + attribute("width", width) + attribute("height", height) +
             attribute("fill", fill) + attribute("stroke", stroke) + "/>\n";
}

void Svg::line(double x1, double y1, double x2, double y2, const std::string& color, double width) {
    body_ += "<line" + attribute("x1", x1) + attribute("y1", y1) + attribute("x2", x2) + attribute("y2", y2) +
             attribute("stroke", color) + attribute("stroke-width", width) + "/>\n";
}

void Svg::polyline(const std::vector<std::pair<double, double>>& points, const std::string& color, double width,
                   const std::string& dashes) {
    body_ += "<polyline" + attribute("points", list(points)) + attribute("fill", std::string("none")) +
             attribute("stroke", color) + attribute("stroke-width", width) +
             (dashes.empty() ? "" : attribute("stroke-dasharray", dashes)) + "/>\n";
}

void Svg::polygon(const std::vector<std::pair<double, double>>& points, const std::string& fill,
                  const std::string& stroke) {
    body_ +=
        "<polygon" + attribute("points", list(points)) + attribute("fill", fill) + attribute("stroke", stroke) + "/>\n";
}

void Svg::circle(double x, double y, double radius, const std::string& fill, const std::string& stroke,
                 double opacity) {
    body_ += "<circle" + attribute("cx", x) + attribute("cy", y) + attribute("r", radius) + attribute("fill", fill) +
             attribute("stroke", stroke) + attribute("opacity", opacity) + "/>\n";
}

void Svg::text(double x, double y, const std::string& words, const TextStyle& style) {
    body_ += "<text" + attribute("x", x) + attribute("y", y) + attribute("font-size", style.size) +
             attribute("text-anchor", std::string(style.anchor)) + attribute("fill", std::string(style.color));
    if (style.is_bold) { body_ += " font-weight=\"bold\""; }
    if (style.turned < 0.0 || style.turned > 0.0) {
        body_ += " transform=\"rotate(" + number(style.turned) + " " + number(x) + " " + number(y) + ")\"";
    }
    body_ += ">" + escaped(words) + "</text>\n";
}

void Svg::begin_hint(const std::string& words) {
    body_ += "<g><title>" + escaped(words) + "</title>\n";
}

void Svg::end_hint() {
    body_ += "</g>\n";
}

std::string Svg::document() const {
    return head_ + body_ + "</svg>\n";
}

} // namespace report
