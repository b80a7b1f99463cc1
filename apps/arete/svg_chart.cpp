#include "svg_chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace arete::app {
namespace {

constexpr double kWidth = 900, kHeight = 260, kLeft = 70, kTop = 30, kBottom = 30;
constexpr std::array<std::string_view, 9> kColours{"#1f77b4", "#d62728", "#2ca02c",
                                                   "#9467bd", "#ff7f0e", "#17becf",
                                                   "#8c564b", "#e377c2", "#7f7f7f"};

std::string_view colour(std::size_t i) {
  return kColours[i % kColours.size()];
}

/// 1, 2 or 5 times a power of ten: about five of them reach `top`.
double tick_step(double top) {
  const double rough = top / 5;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) {
      return factor * power;
    }
  }
  return 10 * power;
}

double largest(std::span<const Series> series) {
  double top = 1e-3;
  for (const Series& s : series) {
    for (const double v : s.values) {
      top = std::max(top, v);
    }
  }
  return top;
}

double y_of(double value, double top) {
  return kHeight - kBottom - value / top * (kHeight - kTop - kBottom);
}

std::string grid_lines(double top, std::string_view unit) {
  std::string svg;
  const double step = tick_step(top);
  for (int i = 0; i * step <= top; ++i) {
    const double y = y_of(i * step, top);
    svg += fmt::format(
        "<line x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#ddd\"/>"
        "<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:g} {}</text>\n",
        kLeft, kWidth, y, y, kLeft - 6, y + 4, i * step, html_text(unit));
  }
  return svg;
}

std::string polyline(const Series& series, double top, std::string_view stroke) {
  std::string points;
  const double step =
      (kWidth - kLeft) / std::max<double>(1, static_cast<double>(series.values.size()) - 1);
  for (std::size_t i = 0; i < series.values.size(); ++i) {
    points += fmt::format("{:.1f},{:.1f} ", kLeft + static_cast<double>(i) * step,
                          y_of(series.values[i], top));
  }
  return fmt::format("<polyline fill=\"none\" stroke=\"{}\" points=\"{}\"/>\n", stroke, points);
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '&':
        escaped += "&amp;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string line_chart(std::string_view title, std::string_view y_unit,
                       std::span<const Series> series) {
  const double top = largest(series);
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\">\n"
      "<text x=\"0\" y=\"16\" font-size=\"15\">{}</text>\n",
      kWidth, kHeight, html_text(title));
  svg += grid_lines(top, y_unit);
  double x = kLeft;
  for (std::size_t i = 0; i < series.size(); ++i) {
    svg += polyline(series[i], top, colour(i));
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{}\" fill=\"{}\">{}</text>\n", x, kHeight - 6,
                       colour(i), html_text(series[i].name));
    x += 20 + 8 * static_cast<double>(series[i].name.size());
  }
  return svg + "</svg>\n";
}

}  // namespace arete::app
