#include "arete/proof/papers/published.h"

#include <algorithm>
#include <array>

namespace arete::proof {
namespace {

struct Value {
  std::string_view paper, quantity, setting;
  double value;
};

// Every published number that `bench --paper` sets beside a measured one, and nothing else.
constexpr std::array<Value, 10> kPublished{{
    // [BaoPajarolaShafae2004, section 5]: bounds in the text ("less than 10 %", "slightly beyond
    // 20 % in the worst case", "more than 12", "more than 7", "8 and more", "reduced to 6").
    {"smart", "evaluation_share_percent", "tolerance=1px incoherence=0.61%", 10},
    {"smart", "evaluation_share_percent_max", "tolerance=1px incoherence=0.61%", 20},
    {"smart", "total_speedup", "tolerance=1px incoherence=0.61%", 12},
    {"smart", "incoherence_percent", "tolerance=1px incoherence=0.61%", 0.61},
    {"smart", "mesh_speedup", "tolerance=2px incoherence=0.61%", 6},
    {"smart", "mesh_speedup", "tolerance=2px incoherence=1.36%", 8},
    {"smart", "mesh_speedup", "tolerance=2px incoherence=5.29%", 7},
    {"smart", "total_speedup", "tolerance=2px incoherence=0.61%", 6},
    {"smart", "total_speedup", "tolerance=2px incoherence=1.36%", 8},
    {"smart", "total_speedup", "tolerance=2px incoherence=5.29%", 7},
}};

}  // namespace

std::optional<double> published(std::string_view paper, std::string_view quantity,
                                std::string_view setting) {
  const auto found = std::ranges::find_if(kPublished, [&](const Value& v) {
    return v.paper == paper && v.quantity == quantity && v.setting == setting;
  });
  return found == kPublished.end() ? std::nullopt : std::optional(found->value);
}

}  // namespace arete::proof
