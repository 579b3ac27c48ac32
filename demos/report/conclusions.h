#ifndef DEMOS_REPORT_CONCLUSIONS_H
#define DEMOS_REPORT_CONCLUSIONS_H

// What the measurements of a report say, in sentences made from their figures.

#include "report_content.h"

#include <string>
#include <vector>

namespace report {

struct ConclusionGroup {
    std::string heading;
    std::vector<std::string> sentences;
};

// Of those parts that were measured; none: no groups.
std::vector<ConclusionGroup> conclusions(const ReportContent& content);

} // namespace report
#endif
