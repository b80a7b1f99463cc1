#include "arete/lod/patch_drawer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "arete/lod/culling.h"
#include "arete/lod/least_fitting.h"

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

PatchDrawer::PatchDrawer(const store::Terrain& terrain, int log2_cells, Topology topology)
    : terrain_(terrain),
      world_from_post_(terrain.manifest().georef.world_from_post),
      table_(terrain, log2_cells),
      field_(table_, terrain.manifest().quantum_m),
      blocks_(terrain, table_, topology),
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

Footprint PatchDrawer::footprint() const {
  std::uint64_t drawable = 0;
  for (int p = 0; p < table_.size(); ++p) drawable += table_.drawable(p) ? 1U : 0U;
  const std::uint64_t scratch =
      static_cast<std::uint64_t>(table_.size()) * (sizeof(int) + sizeof(BlockKey) + sizeof(float));
  return {.table_bytes = table_.bytes() + field_.bytes() + blocks_.table_bytes() + scratch,
          .index_bytes = blocks_.index_bytes(),
          .batches = drawable,
          .least = {.triangles = 2 * drawable, .vertex_bytes = 4 * sizeof(Vertex) * drawable}};
}

double PatchDrawer::excess(const Budget& budget) const {
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
  const int w = table_.log2_cells();
  for (const int p : visible_) {
    const int level = Standing(field_.level(p), w).level;
    triangles += blocks_.triangles(level, side_mask(p));
    bytes += blocks_.vertex_bytes(level);
  }
  const auto ratio = [](std::uint64_t need, std::uint64_t cap) {
    return static_cast<double>(need) / static_cast<double>(std::max<std::uint64_t>(cap, 1));
  };
  return std::log(
      std::max({ratio(triangles, budget.triangles), ratio(bytes, budget.vertex_bytes), 1e-300}));
}

double PatchDrawer::nearest_m() const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const int p : visible_) nearest = std::min(nearest, field_.distance(p));
  return nearest;
}

void PatchDrawer::draw(const RefineOptions& options, const ScreenError& error, DrawList& out) {
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
  blocks_.set_cap(options.budget.vertex_bytes);
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
  // First what is there: it must not make room for what is not.
  blocks_.begin_use();
  for (const int p : visible_) blocks_.use(p, Standing(field_.level(p), w).level);
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

// A side stands at the coarser of its two patches.
unsigned PatchDrawer::side_mask(int p) const {
  const int w = table_.log2_cells();
  const int level = Standing(field_.level(p), w).level;
  unsigned mask = 0;
  for (const Side q : kAllSides) {
    const int n = table_.neighbour(p, q);
    if (n >= 0 && Standing(field_.level(n), w).level > level)
      mask |= 1U << static_cast<unsigned>(q);
  }
  return mask;
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

Claims field_claims(const RefineOptions& options, double tolerance_px) {
  // An angle is not a distance in the image: under Angular the bound holds on a sphere only.
  const bool in_pixels = options.scale != ErrorScale::Angular;
  const double none = std::numeric_limits<double>::infinity();
  return {.conforming = true,
          .error_px = in_pixels || tolerance_px == 0 ? tolerance_px : none,
          .pop_px = 2 * tolerance_px * LevelField::kKappa / (LevelField::kKappa - 1),
          .error_angular_px = in_pixels && tolerance_px > 0 ? none : tolerance_px};
}

// "All tessellation levels are calculated first, without creating the resulting geometry, and then
// each patch is informed about its neighbours' levels" [Wagner2003, "Connecting Patches"].
void PatchEngine::set_levels(glm::dvec3 eye, const ScreenError& error) {
  drawer_.field().solve(eye, error);
}

void PatchEngine::refine(const View& view, const RefineOptions& options, DrawList& out) {
  out.clear();
  drawer_.find_visible(view, options, out.stats);
  const ScreenError error = coarsen(view, options, out.stats);
  drawer_.draw(options, error, out);
}

// Sets the field: as asked, or with the least tolerance that fits the budget.
ScreenError PatchEngine::coarsen(const View& view, const RefineOptions& options,
                                 RefineStats& stats) {
  constexpr double kLeastPx = 0x1p-20;  // "every post" has no tolerance to multiply
  const double asked_px = finest_px(options);
  ScreenError used(view, asked_px, options.scale);
  const ScreenError base(view, std::max(asked_px, kLeastPx), options.scale);
  stats.tolerance_px = asked_px;
  const auto excess = [&](double log_times) {
    if (log_times > 0) used = base.coarser(std::exp(log_times));
    set_levels(view.eye, used);
    stats.evaluated_vertices += static_cast<std::uint64_t>(drawer_.table().size());
    return drawer_.excess(options.budget);
  };
  if (least_fitting(std::ref(excess)) > 0)
    stats.tolerance_px = used.tolerance_px(drawer_.nearest_m());
  return used;
}

}  // namespace arete::lod
