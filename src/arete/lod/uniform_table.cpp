#include "arete/lod/uniform_table.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/patch_scan.h"

namespace arete::lod {
namespace {

// One level of one patch, little-endian. Columns and rows from the patch's NW corner.
struct Record {
  std::uint8_t col = 0, row = 0;
  std::uint16_t unused = 0;
  std::int32_t count = 0;  // of the post
  float drawn_above = 0;   // mesh - height there, metres
  float bound = 0;
};
static_assert(sizeof(Record) == 16);

// Mesh - height at a post of the closed cell of side s at (col, row), split NW to SE, in counts.
double residual(const PatchHeights& h, Post cell, int s, int i, int j) {
  const std::int32_t* at = h.counts + cell.row * h.stride + cell.col;
  const double nw = at[0];
  const double se = at[s * h.stride + s];
  const double third = i >= j ? at[s] : at[s * h.stride];  // NE above the diagonal, SW below
  const double along = i >= j ? j : i;                     // towards SE from the third corner's leg
  const double apart = std::abs(i - j);
  const double mesh = (nw * (s - apart - along) + third * apart + se * along) / s;
  return mesh - at[j * h.stride + i];
}

class LevelScan {
 public:
  LevelScan(const PatchHeights& heights, int level) : heights_(heights), s_(1 << level) {
    const int n = 1 << heights.log2_cells;
    for (int row = 0; row < n; row += s_) {
      for (int col = 0; col < n; col += s_) scan_cell({col, row});
    }
  }

  Record record(double quantum_m, float least_bound) const {
    Record out;
    out.col = static_cast<std::uint8_t>(worst_.col);
    out.row = static_cast<std::uint8_t>(worst_.row);
    out.count = heights_.counts[worst_.row * heights_.stride + worst_.col];
    out.drawn_above = static_cast<float>(signed_ * quantum_m);
    const auto bound = static_cast<float>(most_ * quantum_m);
    out.bound = most_ > 0 ? std::nextafter(bound, std::numeric_limits<float>::infinity()) : 0;
    out.bound = std::max(out.bound, least_bound);
    return out;
  }

 private:
  void scan_cell(Post cell) {
    PatchHeights all = heights_;
    all.counted = nullptr;
    const double most = cell_residual(all, cell, s_, Diagonal::Falls);
    most_ = std::max(most_, most);
    if (most <= std::abs(signed_)) return;
    if (heights_.counted != nullptr &&
        cell_residual(heights_, cell, s_, Diagonal::Falls) <= std::abs(signed_))
      return;
    for (int j = 0; j <= s_; ++j) {
      for (int i = 0; i <= s_; ++i) {
        const Post post{cell.col + i, cell.row + j};
        if (heights_.counted != nullptr &&
            heights_.counted[post.row * heights_.stride + post.col] == 0)
          continue;
        const double r = residual(heights_, cell, s_, i, j);
        if (std::abs(r) <= std::abs(signed_)) continue;
        signed_ = r;
        worst_ = post;
      }
    }
  }

  const PatchHeights& heights_;
  int s_;
  Post worst_{0, 0};
  double signed_ = 0, most_ = 0;
};

void append(const PatchHeights* patch, int w, double quantum_m, std::vector<std::byte>& bytes) {
  float bound = 0;
  for (int level = 1; level <= w; ++level) {
    Record record;
    if (patch != nullptr) record = LevelScan(*patch, level).record(quantum_m, bound);
    bound = record.bound;
    const auto* raw = reinterpret_cast<const std::byte*>(&record);
    bytes.insert(bytes.end(), raw, raw + sizeof record);
  }
}

}  // namespace

std::string uniform_segment(int log2_cells) {
  return fmt::format("maxerror-{}", (1 << log2_cells) + 1);
}

void write_uniform_tables(const store::Terrain& terrain, store::Writers& writers, int w) {
  write_patch_table(terrain, writers, w);
  const store::SegmentPlan named{
      uniform_segment(w), fmt::format("max-error-vertices 1 cells={}", 1 << w), 0, {}};
  const double quantum_m = terrain.manifest().quantum_m;
  write_patch_records(terrain, writers, named, w, [w, quantum_m](std::vector<std::byte>& bytes) {
    return
        [w, quantum_m, &bytes](const PatchHeights* patch) { append(patch, w, quantum_m, bytes); };
  });
}

UniformTable::UniformTable(const store::Terrain& terrain, const PatchTable& patches)
    : levels_(static_cast<std::size_t>(patches.log2_cells())) {
  const std::string segment = uniform_segment(patches.log2_cells());
  if (!terrain.has_segment(segment)) {
    throw Error(ErrorCode::NotFound,
                fmt::format("{}: has no max-error vertices for patches of {} posts: build it again "
                            "with --methods all --patch {}",
                            terrain.name(), patches.cells() + 1, patches.cells() + 1));
  }
  records_.resize(static_cast<std::size_t>(patches.size()) * levels_);
  read_patch_records(terrain, segment, patches.log2_cells(), levels_ * sizeof(Record),
                     [&](int patch, const std::byte* bytes) {
                       for (std::size_t l = 0; l < levels_; ++l) {
                         Record record;
                         std::memcpy(&record, bytes + l * sizeof record, sizeof record);
                         const double z = terrain.z_of(record.count);
                         records_[static_cast<std::size_t>(patch) * levels_ + l] = {
                             {patches.x(patch) * patches.cells() + record.col,
                              patches.y(patch) * patches.cells() + record.row},
                             static_cast<float>(z),
                             static_cast<float>(z + record.drawn_above),
                             record.bound};
                       }
                     });
}

}  // namespace arete::lod
