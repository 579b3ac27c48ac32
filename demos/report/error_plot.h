#ifndef DEMOS_REPORT_ERROR_PLOT_H
#define DEMOS_REPORT_ERROR_PLOT_H

// Error over cost on logarithmic axes: points of several curves, and the front of each.

#include <string>
#include <vector>

namespace report {

struct PlotPoint {
    double cost = 0, error = 0; // cost > 0; error 0 is drawn at the lower edge
    bool is_on_front = false;
    std::string hint;
};

struct PlotCurve {
    std::string name;
    std::vector<PlotPoint> points;
};

// SVG, 1000 by 640 pixels. At most eight curves; one without points is left out.
std::string error_plot(const std::string& title, const std::string& cost_title, const std::string& error_title,
                       const std::vector<PlotCurve>& curves);

} // namespace report
#endif
