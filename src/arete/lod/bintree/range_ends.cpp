#include "arete/lod/bintree/range_ends.h"

namespace arete::lod::bintree {

const RangeEnds::Block RangeEnds::kNeverBlock = [] {
  Block block;
  for (auto& lane : block.until) lane.fill(kForever);
  return block;
}();

void RangeEnds::reserve(std::size_t places) {
  for (std::vector<Block>& level : blocks_) {
    places = (places + kFan - 1) / kFan;
    if (level.size() < places) level.resize(places, kNeverBlock);
  }
}

void RangeEnds::clear() {
  for (std::vector<Block>& level : blocks_) std::ranges::fill(level, kNeverBlock);
}

void RangeEnds::set(std::uint32_t place, const Ticks& until) {
  if (place / kFan >= blocks_[0].size()) reserve(2 * (place + std::size_t{1}));
  std::size_t i = place;
  put(blocks_[0][i / kFan], i % kFan, until);
  for (std::size_t level = 1; level < kLevels; ++level) {
    i /= kFan;
    Block& block = blocks_[level][i / kFan];
    for (std::size_t c = 0; c < kClocks; ++c)
      block.until[c][i % kFan] = std::min(block.until[c][i % kFan], until[c]);
  }
}

}  // namespace arete::lod::bintree
