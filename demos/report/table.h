#ifndef DEMOS_REPORT_TABLE_H
#define DEMOS_REPORT_TABLE_H

// Text in columns, and numbers as text.

#include <string>
#include <vector>

namespace report {

class Table {
public:
    // The first column is aligned to the left, the others to the right.
    explicit Table(std::vector<std::string> headings);
    void add(std::vector<std::string> cells);
    std::string text() const;

    const std::vector<std::vector<std::string>>& rows() const { return rows_; } // the headings first

private:
    std::vector<std::vector<std::string>> rows_;
};

// "0.123": fixed, for times and ratios.
std::string fixed(double value, int decimals);
// "0", "1.2e-07": for errors; "-" when negative, that is, not measured.
std::string short_error(double value);
// All digits, for files.
std::string exact(double value);

} // namespace report
#endif
