#pragma once

#include <string>

#include "flags.h"

namespace arete::app {

enum class Format { Text, Json };

/// Runs a paper's own experiment on the terrain and prints its numbers beside the measured ones.
/// Throws: Usage for an unknown paper.
void bench_paper(const FlightFlags& flags, const std::string& name, Format format);

}  // namespace arete::app
