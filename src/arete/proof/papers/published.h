#pragma once

#include <optional>
#include <string_view>

namespace arete::proof {

/// What a paper prints for a quantity at a setting; nothing where it prints nothing.
std::optional<double> published(std::string_view paper, std::string_view quantity,
                                std::string_view setting);

}  // namespace arete::proof
