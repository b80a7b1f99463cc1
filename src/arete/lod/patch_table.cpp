#include "arete/lod/patch_table.h"

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

// One record of the segment: 7 int32, then w uniform and 4 w side errors as float (levels 1..w),
// all little-endian. flag 0 = not drawable, and nothing else of the record counts.
struct RecordHead {
  std::int32_t drawable = 0;
  std::int32_t z_min = 0, z_max = 0;  // lattice counts over all posts of the patch
  std::array<std::int32_t, 4> corners{};
};
std::size_t record_size(int w) {
  return sizeof(RecordHead) + static_cast<std::size_t>(5 * w) * sizeof(float);
}

// Rounded up, so that the stored bound still is one.
float rounded_up(double metres) {
  if (metres <= 0) return 0;
  return std::nextafter(static_cast<float>(metres), std::numeric_limits<float>::infinity());
}

class RecordWriter {
 public:
  RecordWriter(const store::Manifest& manifest, int w, std::vector<std::byte>& bytes)
      : manifest_(manifest), w_(w), bytes_(bytes) {}

  void append(const PatchHeights* patch) {
    if (patch == nullptr) return write({}, {});
    const int n = 1 << w_;
    RecordHead head;
    head.drawable = 1;
    head.z_min = std::numeric_limits<std::int32_t>::max();
    head.z_max = std::numeric_limits<std::int32_t>::min();
    for (int r = 0; r <= n; ++r) {
      for (int c = 0; c <= n; ++c) {
        head.z_min = std::min(head.z_min, patch->counts[r * patch->stride + c]);
        head.z_max = std::max(head.z_max, patch->counts[r * patch->stride + c]);
      }
    }
    const std::ptrdiff_t last = n * patch->stride;
    head.corners = {patch->counts[0], patch->counts[n], patch->counts[last],
                    patch->counts[last + n]};
    write(head, patch_errors(*patch));
  }

 private:
  void write(const RecordHead& head, const PatchErrors& errors) {
    const auto metres = [&](const std::vector<double>& counts, std::size_t level) {
      return counts.empty() ? 0.0F : rounded_up(counts[level] * manifest_.quantum_m);
    };
    std::vector<float> values;
    for (std::size_t l = 1; l <= static_cast<std::size_t>(w_); ++l)
      values.push_back(metres(errors.uniform, l));
    for (const auto& side : errors.side) {
      for (std::size_t l = 1; l <= static_cast<std::size_t>(w_); ++l)
        values.push_back(metres(side, l));
    }
    const std::size_t old = bytes_.size();
    bytes_.resize(old + record_size(w_));
    std::memcpy(bytes_.data() + old, &head, sizeof head);
    std::memcpy(bytes_.data() + old + sizeof head, values.data(), values.size() * sizeof(float));
  }

  const store::Manifest& manifest_;
  int w_;
  std::vector<std::byte>& bytes_;
};

}  // namespace

std::string tables_segment(int log2_cells) {
  return fmt::format("tables-{}", (1 << log2_cells) + 1);
}

int default_log2_cells(const store::Manifest& manifest) {
  int w = 4;
  while (w < 7 &&
         std::int64_t{patches_along(manifest.cols, w)} * patches_along(manifest.rows, w) > 16384)
    ++w;
  return w;
}

int parse_patch(std::string_view text, const store::Manifest& manifest) {
  if (text == "auto") return default_log2_cells(manifest);
  for (int w = 3; w <= 7; ++w) {
    if (text == std::to_string((1 << w) + 1)) return w;
  }
  throw Error(
      ErrorCode::Usage,
      fmt::format("patch={}: not a patch size: use auto, 9, 17, 33, 65 or 129 posts", text));
}

void write_patch_table(const store::Terrain& terrain, store::Writers& writers, int w) {
  const store::SegmentPlan named{
      tables_segment(w), fmt::format("patch-tables 1 cells={}", 1 << w), 0, {}};
  write_patch_records(terrain, writers, named, w, [&](std::vector<std::byte>& bytes) {
    auto writer = std::make_shared<RecordWriter>(terrain.manifest(), w, bytes);
    return [writer](const PatchHeights* patch) { writer->append(patch); };
  });
}

PatchTable::PatchTable(const store::Terrain& terrain, int log2_cells)
    : w_(log2_cells),
      cols_(patches_along(terrain.manifest().cols, log2_cells)),
      rows_(patches_along(terrain.manifest().rows, log2_cells)),
      quantum_(terrain.manifest().quantum_m),
      offset_(terrain.manifest().offset_m),
      world_from_post_(terrain.manifest().georef.world_from_post) {
  const std::string segment = tables_segment(w_);
  if (!terrain.has_segment(segment)) {
    throw Error(
        ErrorCode::NotFound,
        fmt::format("{}: has no tables for patches of {} posts: build it again with --patch {}",
                    terrain.name(), cells() + 1, cells() + 1));
  }
  if (cols_ == 0 || rows_ == 0) cols_ = rows_ = 0;
  const auto n = static_cast<std::size_t>(size());
  drawable_.resize(n);
  box_min_.resize(n);
  box_max_.resize(n);
  corners_.resize(n);
  uniform_.resize(n * knots());
  side_.resize(n * kSides * knots());
  read_patch_records(terrain, segment, w_, record_size(w_),
                     [this](int patch, const std::byte* record) { read(patch, record); });
}

void PatchTable::read(int patch, const std::byte* record) {
  const std::size_t p = at(patch);
  RecordHead head;
  std::memcpy(&head, record, sizeof head);
  drawable_[p] = head.drawable != 0 ? 1 : 0;
  corners_[p] = head.corners;
  const std::byte* floats = record + sizeof head;
  const std::size_t levels = static_cast<std::size_t>(w_) * sizeof(float);
  std::memcpy(&uniform_[p * knots() + 1], floats, levels);
  for (std::size_t q = 0; q < kSides; ++q) {
    std::memcpy(&side_[(p * kSides + q) * knots() + 1], floats + (q + 1) * levels, levels);
  }
  const double col = x(patch) * cells();
  const double row = y(patch) * cells();
  const std::array<glm::dvec2, 4> plan{world_from_post_.apply(col, row),
                                       world_from_post_.apply(col + cells(), row),
                                       world_from_post_.apply(col, row + cells()),
                                       world_from_post_.apply(col + cells(), row + cells())};
  glm::dvec2 lo = plan[0];
  glm::dvec2 hi = plan[0];
  for (const glm::dvec2& corner : plan) {
    lo = glm::min(lo, corner);
    hi = glm::max(hi, corner);
  }
  box_min_[p] = {lo, offset_ + quantum_ * head.z_min};
  box_max_[p] = {hi, offset_ + quantum_ * head.z_max};
}

int PatchTable::neighbour(int patch, Side q) const {
  const auto [dx, dy] = step(q);
  const int nx = x(patch) + dx;
  const int ny = y(patch) + dy;
  if (nx < 0 || ny < 0 || nx >= cols_ || ny >= rows_) return -1;
  return drawable(index(nx, ny)) ? index(nx, ny) : -1;
}

std::uint64_t PatchTable::bytes() const {
  return drawable_.size() * (1 + 2 * sizeof(glm::dvec3) + sizeof(corners_[0])) +
         (uniform_.size() + side_.size()) * sizeof(float);
}

}  // namespace arete::lod
