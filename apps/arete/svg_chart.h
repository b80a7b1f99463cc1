#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace arete::app {

struct Series {
  std::string name;
  std::vector<double> values;  ///< one a step, the same number in each series
};

/// An SVG element with a line a series over its steps, y from 0, a legend below.
std::string line_chart(std::string_view title, std::string_view y_unit,
                       std::span<const Series> series);

/// Text with the characters that HTML gives a meaning to escaped.
std::string html_text(std::string_view text);

}  // namespace arete::app
