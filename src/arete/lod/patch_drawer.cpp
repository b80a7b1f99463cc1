#include "arete/lod/patch_drawer.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "arete/lod/culling.h"

namespace arete::lod {
namespace {

// A continuous level as the integer level drawn and the share of the way to the next coarser.
struct Standing {
  int level;
  float t;
  Standing(float lambda, int w)
      : level(std::min(static_cast<int>(lambda), w)), t(lambda - static_cast<float>(level)) {}
};

}  // namespace

PatchDrawer::PatchDrawer(const store::Terrain& terrain, int log2_cells, Topology topology,
                         std::size_t budget_bytes)
    : terrain_(terrain),
      world_from_post_(terrain.manifest().georef.world_from_post),
      table_(terrain, log2_cells),
      field_(table_, terrain.manifest().quantum_m),
      blocks_(terrain, table_, topology, budget_bytes),
      topology_(topology) {
  visible_.reserve(static_cast<std::size_t>(table_.size()));
  keys_.reserve(static_cast<std::size_t>(table_.size()));
  floor_level_.assign(static_cast<std::size_t>(table_.size()), 0);
  box_min_ = glm::dvec3(1e300);
  box_max_ = glm::dvec3(-1e300);
  for (int p = 0; p < table_.size(); ++p) {
    if (!table_.drawable(p)) continue;
    box_min_ = glm::min(box_min_, table_.box_min(p));
    box_max_ = glm::max(box_max_, table_.box_max(p));
  }
}

void PatchDrawer::draw(const View& view, const RefineOptions& options, const ScreenError& error,
                       DrawList& out) {
  blocks_.begin_frame();
  find_visible(view, options, out.stats);
  fetch_blocks(options, out.stats);
  for (std::size_t k = 0; k < visible_.size(); ++k) emit(visible_[k], keys_[k], error, out);
  out.stats.resident_bytes = blocks_.resident_bytes();
}

void PatchDrawer::find_visible(const View& view, const RefineOptions& options, RefineStats& stats) {
  visible_.clear();
  PostRect range{0, 0, table_.cols(), table_.rows()};
  const Culling culling(view, world_from_post_, box_min_, box_max_);
  if (options.cull) {
    const PostRect posts = culling.ground_rect();
    const auto patch_at = [this](std::int32_t post) { return post >> table_.log2_cells(); };
    range = {std::max(0, patch_at(posts.col0)), std::max(0, patch_at(posts.row0)),
             std::min(table_.cols(), patch_at(posts.col1) + 1),
             std::min(table_.rows(), patch_at(posts.row1) + 1)};
    if (posts.empty()) range = {};
  }
  for (int y = range.row0; y < range.row1; ++y) {
    for (int x = range.col0; x < range.col1; ++x) {
      const int p = table_.index(x, y);
      if (!table_.drawable(p)) continue;
      ++stats.visited_nodes;
      if (!options.cull || culling.may_see_box(table_.box_min(p), table_.box_max(p)))
        visible_.push_back(p);
    }
  }
  stats.culled = static_cast<std::uint64_t>(table_.size()) - visible_.size();
}

// One pass suffices unless heights are missing; then levels rise and coarser blocks are asked for,
// at most w times (level w is always there).
void PatchDrawer::fetch_blocks(const RefineOptions& options, RefineStats& stats) {
  wanted_.clear();
  if (fetch_missing(options, stats)) {
    std::ranges::fill(floor_level_, 0.0F);
    do {
      for (std::size_t k = 0; k < visible_.size(); ++k) {
        if (keys_[k] != kOwnBlock) continue;
        const int p = visible_[k];
        floor_level_[static_cast<std::size_t>(p)] = std::floor(field_.level(p)) + 1;
      }
      field_.raise(floor_level_);
    } while (fetch_missing(options, stats));
  }
  if (options.on_missing != OnMissing::Defer) return;
  // Coarse tiles first: they are few, and better the picture soonest.
  std::ranges::sort(wanted_, std::greater{});
  const auto repeats = std::ranges::unique(wanted_);
  wanted_.erase(repeats.begin(), repeats.end());
  terrain_.prefetch(wanted_);
}

bool PatchDrawer::fetch_missing(const RefineOptions& options, RefineStats& stats) {
  bool missing = false;
  keys_.clear();
  const int w = table_.log2_cells();
  for (const int p : visible_) {
    const int level = Standing(field_.level(p), w).level;
    keys_.push_back(blocks_.vertices(p, level, options.on_missing, stats));
    if (keys_.back() != kOwnBlock) continue;
    missing = true;
    ++stats.late_blocks;
    wanted_.push_back(blocks_.tile_of(p, level));
  }
  return missing;
}

// Factors by the edge rule (METHODS S4): a side stands at the coarser of its two patches.
void PatchDrawer::emit(int p, BlockKey vertices, const ScreenError& error, DrawList& out) {
  const int w = table_.log2_cells();
  const float own_lambda = field_.level(p);
  const Standing own(own_lambda, w);
  DrawBatch batch;
  batch.vertices = vertices;
  batch.topology = topology_;
  batch.factor[PatchSlot::kInterior] = own.t;
  unsigned side_mask = 0;
  for (const Side q : kAllSides) {
    const int n = table_.neighbour(p, q);
    const Standing side(n < 0 ? own_lambda : std::max(own_lambda, field_.level(n)), w);
    if (side.level > own.level) {
      side_mask |= 1U << static_cast<unsigned>(q);
      batch.factor[PatchSlot::coarser(q)] = side.t;
      batch.factor[PatchSlot::product(q)] = own.t * side.t;
    } else {
      batch.factor[PatchSlot::own(q)] = side.t;
    }
  }
  batch.indices = blocks_.indices(p, own.level, side_mask);
  batch.index_count = blocks_.index_count(batch.indices);
  batch.error = static_cast<float>(field_.error(p));
  out.batches.push_back(batch);
  out.stats.triangles += blocks_.triangles(own.level, side_mask);
  out.stats.full_triangles += std::uint64_t{2} << (2U * static_cast<unsigned>(w));
  out.stats.achieved_error_px =
      std::max(out.stats.achieved_error_px, error.pixels(batch.error, field_.distance(p)));
}

}  // namespace arete::lod
