#include "bench_report.h"

#include <fmt/format.h>

#include "svg_chart.h"

namespace arete::app {
namespace {

constexpr const char* kPage = R"html(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>arete bench</title><style>
body {{ font-family: sans-serif; max-width: 960px; margin: 2em auto; color: #222 }}
table {{ border-collapse: collapse }} td, th {{ padding: 4px 10px; text-align: right }}
td:first-child, th:first-child {{ text-align: left }} tr {{ border-bottom: 1px solid #ddd }}
svg {{ width: 100%; margin-top: 1em }}
</style></head><body>
<h1>arete bench</h1>
<p>{}</p>
<table><tr><th>method</th><th>triangles</th><th>refine p50</th><th>refine p99</th><th>frame p50</th>
<th>frame p99</th><th>read</th><th>uploaded</th><th>changed</th><th>error bound</th></tr>
{}</table>
{}</body></html>
)html";

std::string row(const BenchRun& r) {
  return fmt::format(
      "<tr><td>{}</td><td>{}</td><td>{:.2f} ms</td><td>{:.2f} ms</td><td>{:.2f} ms</td>"
      "<td>{:.2f} ms</td><td>{}</td><td>{}</td><td>{:.2f} %</td><td>{:.3f} px</td></tr>\n",
      html_text(r.method), grouped(static_cast<unsigned long long>(r.mean_triangles)),
      quantile(r.refine_ms, 0.5), quantile(r.refine_ms, 0.99), quantile(r.frame_ms, 0.5),
      quantile(r.frame_ms, 0.99), bytes_text(static_cast<double>(r.bytes_read)),
      bytes_text(static_cast<double>(r.bytes_uploaded)), r.incoherence_percent,
      r.achieved_error_px);
}

std::string chart(std::string_view title, std::string_view unit, std::span<const BenchRun> runs,
                  std::vector<double> BenchRun::*samples) {
  std::vector<Series> series;
  for (const BenchRun& run : runs) {
    series.push_back({run.method, run.*samples});
  }
  return line_chart(title, unit, series);
}

}  // namespace

std::string bench_report(const std::string& heading, std::span<const BenchRun> runs) {
  std::string rows;
  for (const BenchRun& run : runs) {
    rows += row(run);
  }
  const std::string charts = chart("Refinement along the path", "ms", runs, &BenchRun::refine_ms) +
                             chart("Whole frame along the path", "ms", runs, &BenchRun::frame_ms) +
                             chart("Triangles along the path", "", runs, &BenchRun::triangles);
  return fmt::format(kPage, html_text(heading), rows, charts);
}

}  // namespace arete::app
