#include <array>
#include <string>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/proof/papers/paper.h"
#include "arete/proof/papers/smart.h"

namespace arete::proof {

std::span<const Paper> papers() {
  static constexpr std::array<Paper, 1> kPapers{{
      {"smart", "BaoPajarolaShafae2004", smart::kMethods, smart::run},
  }};
  return kPapers;
}

const Paper& find_paper(std::string_view name) {
  std::string names;
  for (const Paper& paper : papers()) {
    if (paper.name == name) return paper;
    names += (names.empty() ? "" : ", ") + std::string(paper.name);
  }
  throw Error(ErrorCode::Usage, fmt::format("{}: no such paper: use one of {}", name, names));
}

}  // namespace arete::proof
