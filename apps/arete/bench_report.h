#pragma once

#include <span>
#include <string>

#include "bench_run.h"

namespace arete::app {

/// One self-contained HTML page: what was run where, a table of the methods, charts over the path.
std::string bench_report(const std::string& heading, std::span<const BenchRun> runs);

}  // namespace arete::app
