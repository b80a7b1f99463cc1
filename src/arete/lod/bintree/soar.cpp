#include "arete/lod/bintree/soar.h"

#include "arete/lod/bintree/coarsening.h"
#include "arete/lod/bintree/engine_parts.h"
#include "arete/lod/bintree/strip.h"
#include "arete/lod/params.h"

namespace arete::lod::bintree {
namespace {

/// Two thirds of the tolerance is where morphing begins: what a public port of SOAR takes.
constexpr double kMorphSharper = 1.5;

class SoarEngine final : public Engine {
 public:
  SoarEngine(const store::Terrain& terrain, const RecordPages::Options& options, double sharper)
      : ground_(terrain, options), delta_(options.delta), sharper_(sharper) {}

  void refine(const View& view, const RefineOptions& options, DrawList& out) override {
    clear_but_geometry(out);
    if (!ground_.has_cells()) return out.clear();
    ground_.pages().begin_frame();
    presence_.begin_frame(options.on_missing);
    const Findings found = drawing_(view, options, out.stats, [&](const ScreenError& error) {
      return draw(view, error, options, out);
    });
    report(ground_, found, bounded(), out.stats);
    out.stats.resident_bytes = out.vertices.size() * sizeof(Vertex) +  //
                               out.indices.size() * sizeof(std::uint32_t);
    out.batches.push_back({.index_count = static_cast<std::uint32_t>(out.indices.size()),
                           .error = error_m(found, bounded()),
                           .topology = Topology::Strip});
  }

  Claims claims(const RefineOptions& options) const override {
    return claims_of(options, bounded());
  }
  Footprint footprint() const override {
    return {.table_bytes = ground_.pages().table_bytes(), .batches = 1, .least = least_budget()};
  }

  // Everything that it draws is in the list.
  std::span<const Vertex> vertices(BlockKey) const override { return {}; }
  std::span<const std::uint32_t> indices(BlockKey) const override { return {}; }

 private:
  Bounded bounded() const {
    return delta_ == Delta::Exact && sharper_ == 1 ? Bounded::Yes : Bounded::No;
  }

  // A strip is written over the last one.
  static void clear_but_geometry(DrawList& out) {
    std::vector<Vertex> vertices = std::move(out.vertices);
    std::vector<std::uint32_t> indices = std::move(out.indices);
    out.clear();
    out.vertices = std::move(vertices);
    out.indices = std::move(indices);
  }

  Findings draw(const View& view, const ScreenError& error, const RefineOptions& options,
                DrawList& out) {
    const Criterion outer(view, error);
    const Criterion inner(view, error, sharper_);
    const Rule rule{inner, error, options};
    const Findings found = draw(rule, outer, nullptr, out);
    if (found.late == 0) return found;
    // What hangs on a missing vertex by its other parent goes as well.
    return draw(rule, outer, &presence_, out);
  }

  Findings draw(const Rule& rule, const Criterion& outer, Presence* presence, DrawList& out) {
    if (sharper_ == 1) return lay(Strip(out), rule, presence);
    return lay(MorphingStrip(out, outer, rule.criterion), rule, presence);
  }

  template <typename AnyStrip>
  Findings lay(AnyStrip strip, const Rule& rule, Presence* presence) {
    Walk<AnyStrip> walk(ground_, rule, strip);
    walk.use(presence);
    walk.refine_all();
    strip.finish();
    return walk.findings();
  }

  Ground ground_;
  Presence presence_{ground_};
  Delta delta_;
  double sharper_;
  FittedDrawing drawing_{ground_, sharper_};
};

}  // namespace

std::unique_ptr<Engine> open_soar(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"delta", "morph", "pages", "prefetch"});
  const bool morph = flag_param(params, "morph");
  return std::make_unique<SoarEngine>(terrain, page_options(params), morph ? kMorphSharper : 1);
}

}  // namespace arete::lod::bintree
