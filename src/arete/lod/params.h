#pragma once

#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "arete/lod/engine.h"

namespace arete::lod {

/// The value of a parameter, or the default. Lifetime: that of `params`.
std::string_view param(const Params& params, std::string_view name, std::string_view otherwise);
/// A whole number in [low, high]. Throws: Usage.
int int_param(const Params& params, std::string_view name, int otherwise,
              std::pair<int, int> range);
/// The Usage error for a word that is none of the known ones.
[[noreturn]] void refuse_word(std::string_view name, std::string_view word,
                              const std::vector<std::string_view>& known);
/// What the parameter's word stands for. Throws: Usage, listing the words.
template <typename Value>
Value choice_param(const Params& params, std::string_view name, Value otherwise,
                   std::initializer_list<std::pair<std::string_view, Value>> choices) {
  const std::string_view word = param(params, name, "");
  if (word.empty()) return otherwise;
  std::vector<std::string_view> known;
  for (const auto& choice : choices) {
    if (choice.first == word) return choice.second;
    known.push_back(choice.first);
  }
  refuse_word(name, word, known);
}
/// "true" or "false", which is the default. Throws: Usage.
bool flag_param(const Params& params, std::string_view name);
/// Parameter "topology": list or strip. Throws: Usage.
Topology topology_param(const Params& params, Topology otherwise);
/// Throws: Usage when params hold a name that is not known.
void check_names(const Params& params, std::initializer_list<std::string_view> known);

}  // namespace arete::lod
