#include "arete/lod/uniform_field.h"

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::lod {
namespace {

double mix(double a, double b, double share) {
  return (1 - share) * a + share * b;
}

// How far a side's factor is from the inside's, as a share of the way to 0 or 1.
double apart(double inside, double side) {
  if (side == inside) return 0;
  return side > inside ? (side - inside) / (1 - inside) : (inside - side) / inside;
}

}  // namespace

UniformField::UniformField(const PatchTable& patches, const UniformTable& table, Sides sides)
    : patches_(patches),
      table_(table),
      sides_(sides),
      level_(static_cast<std::size_t>(patches.size())),
      distance_(patches) {}

Standing UniformField::side(float own, float other, int w) const {
  Standing at = PatchField::side(own, other, w);
  const bool equals = Standing(own, w).level == Standing(other, w).level;
  if (sides_ == Sides::StillButBetweenEquals && !equals) at.t = 0;
  return at;
}

double UniformField::error(int p) const {
  const int w = patches_.log2_cells();
  const auto bound = [&](int level) { return table_.bound(p, std::min(level, w)); };
  const Standing own(level(p), w);
  const double uniform = mix(bound(own.level), bound(own.level + 1), own.t);
  int coarsest = own.level;
  std::array<Standing, kSides> sides;
  for (const Side q : kAllSides) {
    const int n = patches_.neighbour(p, q);
    Standing& at = sides[static_cast<std::size_t>(q)];
    at = side(level(p), n < 0 ? level(p) : level(n), w);
    coarsest = std::max(coarsest, at.level);
  }
  // Share of the mix in which any of the coarsest sides stands at its upper knot: a post beside two
  // sides depends on both. Where no side is adapted, as far as they part from the inside.
  const bool adapted = coarsest > own.level;
  double lower = 1;
  for (const Standing& at : sides) {
    if (at.level == coarsest) lower *= 1 - (adapted ? double{at.t} : apart(own.t, at.t));
  }
  const double below = adapted ? 2 * bound(coarsest) : uniform;
  const double worst = std::max(uniform, mix(below, 2 * bound(coarsest + 1), 1 - lower));
  if (worst == 0) return 0;  // as stored, or flat
  // What four roundings of half an ulp may add while a vertex stage in float morphs.
  return worst +
         std::max(std::abs(patches_.box_min(p).z), std::abs(patches_.box_max(p).z)) * 0x1p-22;
}

void UniformField::raise(std::span<const float> floor_level) {
  for (std::size_t i = 0; i < level_.size(); ++i) level_[i] = std::max(level_[i], floor_level[i]);
}

int parse_uniform_patch(std::string_view text, const store::Manifest& manifest) {
  const int w = parse_patch(text, manifest);
  if (w <= UniformMesh::kMostLog2Cells) return w;
  if (text == "auto") return UniformMesh::kMostLog2Cells;
  throw Error(ErrorCode::Usage,
              fmt::format("patch={}: too large for sides of any level: use at most {} posts", text,
                          (1 << UniformMesh::kMostLog2Cells) + 1));
}

}  // namespace arete::lod
