#include "arete/lod/params.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "arete/core/error.h"

namespace arete::lod {

std::string_view param(const Params& params, std::string_view name, std::string_view otherwise) {
  const auto it = params.find(name);
  return it == params.end() ? otherwise : std::string_view(it->second);
}

int int_param(const Params& params, std::string_view name, int otherwise,
              std::pair<int, int> range) {
  const std::string_view text = param(params, name, "");
  if (text.empty()) return otherwise;
  int value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || end != text.data() + text.size() || value < range.first ||
      value > range.second) {
    throw Error(ErrorCode::Usage, fmt::format("{}={}: not a whole number from {} to {}: give one",
                                              name, text, range.first, range.second));
  }
  return value;
}

void refuse_word(std::string_view name, std::string_view word,
                 const std::vector<std::string_view>& known) {
  throw Error(ErrorCode::Usage,
              fmt::format("{}={}: unknown: use one of {}", name, word, fmt::join(known, ", ")));
}

bool flag_param(const Params& params, std::string_view name) {
  return choice_param(params, name, false, {{"true", true}, {"false", false}});
}

Topology topology_param(const Params& params, Topology otherwise) {
  return choice_param(params, "topology", otherwise,
                      {{"list", Topology::Triangles}, {"strip", Topology::Strip}});
}

void check_names(const Params& params, std::initializer_list<std::string_view> known) {
  for (const auto& entry : params) {
    if (std::ranges::find(known, entry.first) != known.end()) continue;
    throw Error(ErrorCode::Usage, fmt::format("{}: no such option of this method: use one of {}",
                                              entry.first, fmt::join(known, ", ")));
  }
}

}  // namespace arete::lod
