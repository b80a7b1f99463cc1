#include "arete/lod/bintree/smart.h"

#include <cmath>

#include "arete/lod/bintree/bin_tree.h"
#include "arete/lod/bintree/engine_parts.h"
#include "arete/lod/params.h"

namespace arete::lod::bintree {
namespace {

struct Options {
  RecordPages::Options pages;
  BinTree::Options tree;
  double tick_m = 1;
  Rounding rounding = Rounding::Exact;
  bool literal = false;
};

class SmartEngine final : public Engine {
 public:
  SmartEngine(const store::Terrain& terrain, const Options& options)
      : ground_(terrain, options.pages),
        options_(options),
        vertices_(ground_),
        odometer_(options.tick_m, options.rounding),
        tree_(ground_, vertices_, odometer_, options.tree) {}

  void refine(const View& view, const RefineOptions& options, DrawList& out) override {
    out.clear();
    if (!ground_.has_cells()) return;
    ground_.pages().begin_frame();
    vertices_.begin_frame(options.on_missing);
    if (tree_.is_full()) tree_.collect();
    const Findings found = drawing_(view, options, out.stats, [&](const ScreenError& error) {
      return refine_by(error, view, options);
    });
    out.batches.push_back({.vertices = vertices_.key(),
                           .indices = kIndices,
                           .index_count = static_cast<std::uint32_t>(tree_.indices().size()),
                           .error = error_m(found, bounded())});
    report(ground_, found, bounded(), out.stats);
    report_vertices(out);
    if (options.on_missing == OnMissing::Defer) ask_for_pages();
  }

  Claims claims(const RefineOptions& options) const override {
    Claims claims = claims_of(options, bounded());
    claims.conforming = is_exact();
    return claims;
  }
  Footprint footprint() const override {
    return {.table_bytes = ground_.pages().table_bytes(), .batches = 1, .least = least_budget()};
  }

  std::span<const Vertex> vertices(BlockKey) const override { return vertices_.drawn(); }
  std::span<const std::uint32_t> indices(BlockKey) const override { return tree_.indices(); }

 private:
  static constexpr BlockKey kIndices = 1;

  Bounded bounded() const {
    return options_.pages.delta == Delta::Exact && is_exact() ? Bounded::Yes : Bounded::No;
  }
  bool is_exact() const { return options_.rounding != Rounding::Floor && !options_.literal; }

  Findings refine_by(const ScreenError& error, const View& view, const RefineOptions& options) {
    const Findings found = refine_once(view, error, options);
    const std::uint64_t bytes =
        vertices_.size() * sizeof(Vertex) + tree_.indices().size() * sizeof(std::uint32_t);
    if (bytes <= options.budget.vertex_bytes || !Need{found.halved}.fits(options.budget))
      return found;
    tree_.collect();
    return refine_once(view, error, options);
  }

  Findings refine_once(const View& view, const ScreenError& error, const RefineOptions& options) {
    const Criterion criterion(view, error);
    const bool holds = odometer_.advance(criterion) && options.cull == culled_;
    culled_ = options.cull;
    if (!holds) tree_.expire();
    const Evaluation evaluation(
        criterion, odometer_,
        {.safe = options_.literal ? SafeDistance::Least : SafeDistance::Status,
         .culling = options.cull});
    const Rule rule{criterion, error, options};
    return tree_.refine({rule, evaluation, options_.literal && odometer_.turned()});
  }

  // What is missing now, then what may be asked for soon.
  void ask_for_pages() { ground_.pages().ask(vertices_.missing_pages(), tree_.pages_ahead()); }

  void report_vertices(DrawList& out) {
    const bool renewed = vertices_.key() != uploaded_key_;
    const auto first = renewed ? 0 : uploaded_;
    uploaded_key_ = vertices_.key();
    uploaded_ = static_cast<std::uint32_t>(vertices_.size());
    const auto indices = static_cast<std::uint32_t>(tree_.indices().size());
    out.uploads.push_back({uploaded_key_, first, uploaded_ - first});
    out.uploads.push_back({kIndices, 0, indices, BlockKind::Indices});
    out.stats.built_blocks = renewed ? 1 : 0;
    out.stats.bytes_built = (uploaded_ - first) * sizeof(Vertex);
    out.stats.resident_bytes = vertices_.size() * sizeof(Vertex) + indices * sizeof(std::uint32_t);
  }

  Ground ground_;
  Options options_;
  VertexArray vertices_;
  Odometer odometer_;
  BinTree tree_;
  FittedDrawing drawing_{ground_};
  bool culled_ = true;
  BlockKey uploaded_key_ = kOwnBlock;
  std::uint32_t uploaded_ = 0;
};

double spacing_m(const store::Terrain& terrain) {
  return std::sqrt(std::abs(terrain.manifest().georef.world_from_post.determinant()));
}

}  // namespace

std::unique_ptr<Engine> open_smart(const store::Terrain& terrain, const Params& params) {
  check_names(params,
              {"delta", "pages", "prefetch", "tick", "ticks", "visit", "capacity", "literal"});
  Options options;
  options.pages = page_options(params);
  options.literal = flag_param(params, "literal");
  options.rounding = choice_param(
      params, "ticks", options.literal ? Rounding::Floor : Rounding::Exact,
      {{"exact", Rounding::Exact}, {"ceil", Rounding::Ceil}, {"floor", Rounding::Floor}});
  options.tree.visit = choice_param(params, "visit", options.literal ? Visit::All : Visit::Ended,
                                    {{"ended", Visit::Ended}, {"all", Visit::All}});
  options.tree.capacity =
      static_cast<std::size_t>(int_param(params, "capacity", 1 << 16, {16, 1 << 28}));
  options.tick_m = 1e-6 * int_param(params, "tick", 100, {1, 1'000'000'000}) * spacing_m(terrain);
  return std::make_unique<SmartEngine>(terrain, options);
}

}  // namespace arete::lod::bintree
