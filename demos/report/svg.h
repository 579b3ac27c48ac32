#ifndef DEMOS_REPORT_SVG_H
#define DEMOS_REPORT_SVG_H

// A picture in SVG, drawn shape by shape, on white.

#include <string>
#include <utility>
#include <vector>

namespace report {

// XML's special characters as entities.
std::string escaped(const std::string& text);

class Svg {
public:
    Svg(double width, double height);

    struct TextStyle {
        double size = 14;
        const char* anchor = "start"; // or "middle" or "end"
        const char* color = "#222";
        bool is_bold = false;
        double turned = 0; // degrees
    };

    void rectangle(double x, double y, double width, double height, const std::string& fill,
                   const std::string& stroke = "none");
    void line(double x1, double y1, double x2, double y2, const std::string& color, double width = 1);
    void polyline(const std::vector<std::pair<double, double>>& points, const std::string& color, double width,
                  const std::string& dashes = "");
    // Closed.
    void polygon(const std::vector<std::pair<double, double>>& points, const std::string& fill,
                 const std::string& stroke);
    void circle(double x, double y, double radius, const std::string& fill, const std::string& stroke,
                double opacity = 1);
    void text(double x, double y, const std::string& words, const TextStyle& style);
    // Shown by browsers while the mouse is on the shapes that follow, until `end_hint`.
    void begin_hint(const std::string& words);
    void end_hint();

    std::string document() const;

private:
    std::string head_, body_;
};

} // namespace report
#endif
