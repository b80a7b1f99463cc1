#include "arete/lod/patch_drawer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "arete/lod/culling.h"
#include "arete/lod/least_fitting.h"

namespace arete::lod {
PatchDrawer::PatchDrawer(const store::Terrain& terrain, int log2_cells,
                         std::unique_ptr<const PatchMesh> mesh)
    : terrain_(terrain),
      world_from_post_(terrain.manifest().georef.world_from_post),
      table_(terrain, log2_cells),
      blocks_(terrain, table_, std::move(mesh)) {
  visible_.reserve(static_cast<std::size_t>(table_.size()));
  at_.reserve(static_cast<std::size_t>(table_.size()));
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

Footprint PatchDrawer::footprint(const PatchField& field) const {
  std::uint64_t drawable = 0;
  for (int p = 0; p < table_.size(); ++p) drawable += table_.drawable(p) ? 1U : 0U;
  const std::uint64_t scratch =
      static_cast<std::uint64_t>(table_.size()) *
      (sizeof(int) + sizeof(PatchStanding) + sizeof(BlockKey) + sizeof(float));
  return {.table_bytes = table_.bytes() + field.bytes() + blocks_.table_bytes() + scratch,
          .index_bytes = blocks_.index_bytes(),
          .batches = drawable,
          .least = {.triangles = 2 * drawable, .vertex_bytes = 4 * sizeof(Vertex) * drawable}};
}

void PatchDrawer::stand(const PatchField& field) {
  at_.clear();
  for (const int p : visible_) at_.push_back(standing(field, p));
}

double PatchDrawer::excess(const Budget& budget) const {
  if (budget == Budget{}) return -1;  // there is room for anything
  Budget need{0, 0};
  for (const PatchStanding& at : at_) {
    need.triangles += blocks_.triangles(at);
    need.vertex_bytes += blocks_.vertex_bytes(at.own.level);
  }
  return lod::excess(need, budget);
}

double PatchDrawer::nearest_m(const PatchField& field) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const int p : visible_) nearest = std::min(nearest, field.distance(p));
  return nearest;
}

void PatchDrawer::draw(PatchField& field, const RefineOptions& options, const ScreenError& error,
                       DrawList& out) {
  fetch_blocks(field, options, out.stats);
  for (std::size_t k = 0; k < visible_.size(); ++k) emit(field, k, error, out);
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
void PatchDrawer::fetch_blocks(PatchField& field, const RefineOptions& options,
                               RefineStats& stats) {
  wanted_.clear();
  blocks_.set_cap(options.budget.vertex_bytes);
  if (fetch_missing(options, stats)) {
    std::ranges::fill(floor_level_, 0.0F);
    do {
      for (std::size_t k = 0; k < visible_.size(); ++k) {
        if (keys_[k] != kOwnBlock) continue;
        const int p = visible_[k];
        floor_level_[static_cast<std::size_t>(p)] = std::floor(field.level(p)) + 1;
      }
      field.raise(floor_level_);
      stand(field);
    } while (fetch_missing(options, stats));
  }
  if (options.on_missing != OnMissing::Defer) return;
  // Coarse tiles first: they are few, and better the picture soonest.
  std::ranges::sort(wanted_, std::greater{});
  wanted_.erase(std::unique(wanted_.begin(), wanted_.end()), wanted_.end());
  terrain_.prefetch(wanted_);
}

bool PatchDrawer::fetch_missing(const RefineOptions& options, RefineStats& stats) {
  bool missing = false;
  keys_.clear();
  // First what is there: it must not make room for what is not.
  blocks_.begin_use();
  for (std::size_t k = 0; k < visible_.size(); ++k) blocks_.use(visible_[k], at_[k].own.level);
  for (std::size_t k = 0; k < visible_.size(); ++k) {
    const int p = visible_[k];
    const PatchStanding& at = at_[k];
    keys_.push_back(blocks_.vertices(p, at, options.on_missing, stats));
    if (keys_.back() != kOwnBlock) continue;
    missing = true;
    ++stats.late_blocks;
    wanted_.push_back(blocks_.tile_of(p, at.own.level));
  }
  return missing;
}

PatchStanding PatchDrawer::standing(const PatchField& field, int p) const {
  const int w = table_.log2_cells();
  const float own = field.level(p);
  PatchStanding at;
  at.own = {own, w};
  at.odd = ((table_.x(p) + table_.y(p)) & 1) != 0;
  for (const Side q : kAllSides) {
    const int n = table_.neighbour(p, q);
    at.side[static_cast<std::size_t>(q)] = field.side(own, n < 0 ? own : field.level(n), w);
  }
  return at;
}

void PatchDrawer::emit(const PatchField& field, std::size_t visible, const ScreenError& error,
                       DrawList& out) {
  const int p = visible_[visible];
  const PatchStanding& at = at_[visible];
  DrawBatch batch;
  batch.vertices = keys_[visible];
  batch.topology = blocks_.mesh().topology();
  blocks_.mesh().set_factors(at, batch.factor);
  batch.indices = blocks_.indices(at);
  batch.index_count = blocks_.index_count(batch.indices);
  batch.error = static_cast<float>(field.error(p));
  out.batches.push_back(batch);
  out.stats.triangles += blocks_.triangles(at);
  out.stats.full_triangles += std::uint64_t{2} << (2U * static_cast<unsigned>(table_.log2_cells()));
  out.stats.achieved_error_px =
      std::max(out.stats.achieved_error_px, error.pixels(batch.error, field.distance(p)));
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
void PatchEngine::refine(const View& view, const RefineOptions& options, DrawList& out) {
  out.clear();
  drawer_.find_visible(view, options, out.stats);
  const ScreenError error = coarsen(view, options, out.stats);
  drawer_.draw(field(), options, error, out);
}

// Sets the field: as asked, or with the least tolerance that fits the budget.
ScreenError PatchEngine::coarsen(const View& view, const RefineOptions& options,
                                 RefineStats& stats) {
  constexpr double kLeastPx = 0x1p-20;  // "every post" has no tolerance to multiply
  const ScreenError asked(view, options.tolerance_px, options.scale);
  double used_px = finest_px(options);
  ScreenError used(view, used_px, options.scale);
  stats.tolerance_px = used_px;
  const double first = std::max(used_px, kLeastPx) / options.tolerance_px;
  const auto excess = [&](double log_times) {
    if (log_times > 0) {
      const double times = first * std::exp(log_times);
      used_px = options.tolerance_px * times;
      used = asked.coarser(times);
    }
    stats.evaluated_vertices += set_levels(view, used, used_px);
    drawer_.stand(field());
    return drawer_.excess(options.budget);
  };
  if (least_fitting(std::ref(excess)) > 0) stats.tolerance_px = kept_px(used, used_px);
  return used;
}

}  // namespace arete::lod
